/* davar tests - loaded in front of the C library (LD_PRELOAD): the n-th call of one function fails, is cut short or comes with a
 * signal. FAULT is "function:kind:n", kind an errno, "short" or "signal<number>"; the file FAULT_MARK says that it has happened. */
#define _GNU_SOURCE /* NOLINT: for RTLD_NEXT */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/types.h>
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

/* True when this call of `name` is the one. A signal comes before the call, which then goes on. */
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
        (void)raise(atoi(kind + 6));
        return false;
    }
    errno = atoi(kind);
    return true;
}

static bool is_short(void)
{
    return strcmp(kind, "short") == 0;
}

__attribute__((constructor)) static void start(void)
{
    const char *fault = getenv("FAULT");
    const char *where = getenv("FAULT_MARK");
    if ((fault != NULL) && (where != NULL)) {
        (void)snprintf(mark, sizeof mark, "%s", where);
        long n = 0;
        if (sscanf(fault, "%31[^:]:%31[^:]:%ld", function, kind, &n) == 3) {
            left = n;
        }
    }
    (void)unsetenv("LD_PRELOAD"); /* the device of davar-sim is another program */
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
    return is_short() ? ((write_t)real("write"))(descriptor, from, (bytes + 6U) / 7U) : -1;
}

ssize_t pread64(int descriptor, void *to, size_t bytes, off64_t offset)
{
    if (!is_the_one("pread")) {
        return ((pread_t)real("pread64"))(descriptor, to, bytes, offset);
    }
    return is_short() ? ((pread_t)real("pread64"))(descriptor, to, (bytes + 6U) / 7U, offset) : -1;
}

int open64(const char *path, int flags, ...)
{
    va_list rest;
    va_start(rest, flags);
    const int mode = ((flags & O_CREAT) != 0) ? va_arg(rest, int) : 0;
    va_end(rest);
    return is_the_one("open") ? -1 : ((open_t)real("open64"))(path, flags, mode);
}

int mkstemp64(char *path)
{
    return is_the_one("mkstemp") ? -1 : ((mkstemp_t)real("mkstemp64"))(path);
}

int unlink(const char *path)
{
    return is_the_one("unlink") ? -1 : ((unlink_t)real("unlink"))(path);
}

/* Once per cell of the output. */
int snprintf(char *text, size_t size, const char *format, ...)
{
    (void)is_the_one("snprintf");
    va_list values;
    va_start(values, format);
    const int length = vsnprintf(text, size, format, values);
    va_end(values);
    return length;
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
