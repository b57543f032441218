/* Runs a program as on a processor whose state (XSTATE) has BYTES: PTRACE_SETREGSET with fewer
 * bytes is rejected, and PTRACE_GETREGSET returns BYTES. Parts that the real processor lacks read
 * as zero. usage: wide_processor BYTES PROGRAM [ARGUMENT...]. x86-64 Linux. BYTES: at least the
 * real size, and at most 128 KiB. */
#define _GNU_SOURCE /* process_vm_readv */
#include <elf.h>
#include <errno.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <signal.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <sys/user.h>
#include <sys/wait.h>
#include <unistd.h>

#define BYTES_MAX 131072
#define EVENT(status) ((status) >> 16)

/* Only these calls stop the program; all others cost nothing. */
static void watch_calls(void)
{
    struct sock_filter filter[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_ptrace, 0, 3),
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, args[0])),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, PTRACE_GETREGSET, 2, 0),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, PTRACE_SETREGSET, 1, 0),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRACE),
    };
    const struct sock_fprog program = {.len = sizeof filter / sizeof filter[0], .filter = filter};
    if ((prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) ||
        (prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) != 0)) {
        _exit(126);
    }
}

static void copy(pid_t child, void *ours, unsigned long long theirs, size_t size, int write)
{
    const struct iovec here = {ours, size};
    const struct iovec there = {(void *)theirs, size};
    const ssize_t done = write ? process_vm_writev(child, &here, 1, &there, 1, 0)
                               : process_vm_readv(child, &here, 1, &there, 1, 0);
    if (done != (ssize_t)size) {
        _exit(125);
    }
}

/* The kernel has filled the part of the real processor: writes zeros after it while there is
 * room. */
static void widen(pid_t child, const struct user_regs_struct *before, struct iovec asked,
                  size_t bytes)
{
    static char zeros[BYTES_MAX];
    const size_t room = (asked.iov_len < bytes) ? asked.iov_len : bytes;
    struct iovec got;
    copy(child, &got, before->r10, sizeof got, 0);
    if (room > got.iov_len) {
        copy(child, zeros, (unsigned long long)asked.iov_base + got.iov_len, room - got.iov_len, 1);
    }
    got.iov_len = room;
    copy(child, &got, before->r10, sizeof got, 1);
}

/* A ptrace call of the program is about to begin. */
static void judge(pid_t child, size_t bytes)
{
    struct user_regs_struct call;
    struct iovec asked;
    int status;
    ptrace(PTRACE_GETREGS, child, 0, &call);
    if (call.rdx != NT_X86_XSTATE) {
        ptrace(PTRACE_CONT, child, 0, 0);
        return;
    }
    copy(child, &asked, call.r10, sizeof asked, 0);
    const int refused = (call.rdi == PTRACE_SETREGSET) && (asked.iov_len < bytes);
    if (refused) {
        struct user_regs_struct none = call;
        none.orig_rax = (unsigned long long)-1;
        ptrace(PTRACE_SETREGS, child, 0, &none);
    }
    ptrace(PTRACE_SYSCALL, child, 0, 0);
    waitpid(child, &status, 0);
    ptrace(PTRACE_GETREGS, child, 0, &call);
    if (refused) {
        call.rax = (unsigned long long)-EFAULT;
        ptrace(PTRACE_SETREGS, child, 0, &call);
    } else if ((call.rdi == PTRACE_GETREGSET) && (call.rax == 0U)) {
        widen(child, &call, asked, bytes);
    }
    ptrace(PTRACE_CONT, child, 0, 0);
}

int main(int argc, char **argv)
{
    const size_t bytes = (argc > 2) ? strtoul(argv[1], NULL, 10) : 0;
    if ((bytes == 0U) || (bytes > BYTES_MAX)) {
        return 125;
    }
    const pid_t child = fork();
    if (child == 0) {
        ptrace(PTRACE_TRACEME, 0, 0, 0);
        raise(SIGSTOP);
        watch_calls();
        execv(argv[2], &argv[2]);
        _exit(127);
    }
    int status;
    waitpid(child, &status, 0);
    ptrace(PTRACE_SETOPTIONS, child, 0,
           PTRACE_O_TRACESECCOMP | PTRACE_O_EXITKILL | PTRACE_O_TRACEEXEC);
    ptrace(PTRACE_CONT, child, 0, 0);
    while (waitpid(child, &status, 0) == child) {
        if (WIFEXITED(status) || WIFSIGNALED(status)) {
            return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        }
        if (EVENT(status) == PTRACE_EVENT_SECCOMP) {
            judge(child, bytes);
        } else {
            ptrace(PTRACE_CONT, child, 0, (EVENT(status) != 0) ? 0 : WSTOPSIG(status));
        }
    }
    return 125;
}
