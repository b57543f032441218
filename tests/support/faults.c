/* davar tests - preloaded (LD_PRELOAD) to make the n-th call of one function fail, return short, or
 * receive a signal. FAULT is "function:kind:n". kind is an errno, "short", "torn" (short because
 * the disk is full), "signal<number>", "signal<number>+<number>" (two), "spin<number>" or
 * "pause<number>" (a signal in a call that never returns, while it works or waits). The file
 * FAULT_MARK exists after the fault has happened. */
#define _GNU_SOURCE /* NOLINT: for RTLD_NEXT */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <termios.h>
#include <unistd.h>

static char function[32];
static char kind[32];
static long left;
static char mark[512];

static void mark_it(void)
{
    const long descriptor = syscall(SYS_openat, AT_FDCWD, mark, O_CREAT | O_WRONLY, 0600);
    (void)syscall(SYS_close, descriptor);
}

/* "<number>" or "<number>+<number>". */
static void raise_all(const char *numbers)
{
    const char *const second = strchr(numbers, '+');
    (void)raise(atoi(numbers));
    if (second != NULL) {
        (void)raise(atoi(second + 1));
    }
}

/* True if this call of `name` is the chosen one. A signal comes before the call, which then
 * continues. */
static bool is_the_one(const char *name)
{
    if ((left == 0) || (strcmp(function, name) != 0)) {
        return false;
    }
    left--;
    if (left > 0) {
        return false;
    }
    mark_it();
    if (strncmp(kind, "signal", 6U) == 0) {
        raise_all(kind + 6);
        return false;
    }
    if (strncmp(kind, "spin", 4U) == 0) {
        (void)raise(atoi(kind + 4));
        for (volatile unsigned n = 0U;; n++) {
        }
    }
    if (strncmp(kind, "pause", 5U) == 0) {
        (void)raise(atoi(kind + 5));
        for (;;) {
            (void)pause();
        }
    }
    errno = atoi(kind);
    return true;
}

static bool is_short(void)
{
    return strcmp(kind, "short") == 0;
}

/* Starts counting now, for a program that is already running and calls this through ctypes. */
void arm_fault(const char *fault)
{
    long n = 0;
    left = (sscanf(fault, "%31[^:]:%31[^:]:%ld", function, kind, &n) == 3) ? n : 0;
}

__attribute__((constructor)) static void start(void)
{
    const char *fault = getenv("FAULT");
    const char *where = getenv("FAULT_MARK");
    if ((fault != NULL) && (where != NULL)) {
        (void)snprintf(mark, sizeof mark, "%s", where);
        arm_fault(fault);
    }
    (void)unsetenv("LD_PRELOAD"); /* the device of davar-sim is another program */
}

/* The next call of the same function fails too. */
static void next_is(const char *what)
{
    (void)strncpy(kind, what, sizeof kind - 1U);
    left = 1;
}

static void *real(const char *name)
{
    return dlsym(RTLD_NEXT, name);
}

typedef ssize_t (*read_t)(int, void *, size_t);
typedef ssize_t (*write_t)(int, const void *, size_t);
typedef ssize_t (*pread_t)(int, void *, size_t, off64_t);
typedef int (*open_t)(const char *, int, ...);
typedef int (*mkstemp_t)(char *);
typedef int (*unlink_t)(const char *);

ssize_t read(int descriptor, void *to, size_t bytes)
{
    if (!is_the_one("read")) {
        return ((read_t)real("read"))(descriptor, to, bytes);
    }
    return is_short() ? ((read_t)real("read"))(descriptor, to, (bytes + 6U) / 7U) : -1;
}

ssize_t write(int descriptor, const void *from, size_t bytes)
{
    if (!is_the_one("write")) {
        return ((write_t)real("write"))(descriptor, from, bytes);
    }
    if (strcmp(kind, "torn") == 0) {
        next_is("full");
        return ((write_t)real("write"))(descriptor, from, (bytes + 6U) / 7U);
    }
    if (strcmp(kind, "full") == 0) {
        next_is("5"); /* EIO */
        errno = EAGAIN;
        return -1;
    }
    return is_short() ? ((write_t)real("write"))(descriptor, from, (bytes + 6U) / 7U) : -1;
}

ssize_t pread64(int descriptor, void *to, size_t bytes, off64_t offset)
{
    if (!is_the_one("pread")) {
        return ((pread_t)real("pread64"))(descriptor, to, bytes, offset);
    }
    return is_short() ? ((pread_t)real("pread64"))(descriptor, to, (bytes + 6U) / 7U, offset) : -1;
}

static int open_or_not(const char *name, const char *path, int flags, va_list rest)
{
    const int mode = ((flags & O_CREAT) != 0) ? va_arg(rest, int) : 0;
    return is_the_one("open") ? -1 : ((open_t)real(name))(path, flags, mode);
}

int open64(const char *path, int flags, ...)
{
    va_list rest;
    va_start(rest, flags);
    const int descriptor = open_or_not("open64", path, flags, rest);
    va_end(rest);
    return descriptor;
}

int open(const char *path, int flags, ...)
{
    va_list rest;
    va_start(rest, flags);
    const int descriptor = open_or_not("open", path, flags, rest);
    va_end(rest);
    return descriptor;
}

ssize_t pread(int descriptor, void *to, size_t bytes, off_t offset)
{
    return pread64(descriptor, to, bytes, offset);
}

/* Functions that only fail. */
#define FAILS(type, name, failure, parameters, arguments)                                          \
    type name parameters                                                                           \
    {                                                                                              \
        return is_the_one(#name) ? (failure) : ((type(*) parameters)real(#name))arguments;         \
    }

FAILS(int, dup, -1, (int descriptor), (descriptor))
FAILS(int, fstat, -1, (int descriptor, struct stat *what), (descriptor, what))
FAILS(int, fstat64, -1, (int descriptor, struct stat64 *what), (descriptor, what))
FAILS(int, posix_openpt, -1, (int flags), (flags))
FAILS(int, grantpt, -1, (int descriptor), (descriptor))
FAILS(int, unlockpt, -1, (int descriptor), (descriptor))
FAILS(int, tcgetattr, -1, (int descriptor, struct termios *how), (descriptor, how))
FAILS(int, tcsetattr, -1, (int descriptor, int when, const struct termios *how),
      (descriptor, when, how))
FAILS(int, poll, -1, (struct pollfd * list, nfds_t count, int ms), (list, count, ms))
FAILS(int, ftruncate64, -1, (int descriptor, off64_t size), (descriptor, size))
FAILS(off64_t, lseek64, -1, (int descriptor, off64_t offset, int whence),
      (descriptor, offset, whence))
FAILS(char *, mkdtemp, NULL, (char *path), (path))
FAILS(FILE *, fopen64, NULL, (const char *path, const char *mode), (path, mode))
FAILS(size_t, fread, 0, (void *to, size_t size, size_t count, FILE *file), (to, size, count, file))
FAILS(int, fclose, EOF, (FILE * file), (file))
FAILS(int, fflush, EOF, (FILE * file), (file))
FAILS(int, system, -1, (const char *command), (command))

int mkstemp64(char *path)
{
    return is_the_one("mkstemp") ? -1 : ((mkstemp_t)real("mkstemp64"))(path);
}

int unlink(const char *path)
{
    return is_the_one("unlink") ? -1 : ((unlink_t)real("unlink"))(path);
}

int snprintf(char *text, size_t size, const char *format, ...)
{
    (void)is_the_one("snprintf");
    va_list values;
    va_start(values, format);
    const int length = vsnprintf(text, size, format, values);
    va_end(values);
    return length;
}

/* Called for every absent cell of the output. */
size_t strlen(const char *text)
{
    (void)is_the_one("strlen");
    return strnlen(text, PTRDIFF_MAX);
}

#ifdef ALLOCATIONS
extern void *__libc_malloc(size_t bytes);
extern void *__libc_calloc(size_t count, size_t bytes);
extern void *__libc_realloc(void *old, size_t bytes);

void *malloc(size_t bytes)
{
    return is_the_one("malloc") ? NULL : __libc_malloc(bytes);
}

void *calloc(size_t count, size_t bytes)
{
    return is_the_one("malloc") ? NULL : __libc_calloc(count, bytes);
}

void *realloc(void *old, size_t bytes)
{
    return is_the_one("malloc") ? NULL : __libc_realloc(old, bytes);
}
#endif
