/* davar - selects the active mutant. Included before every source of the build of
 * tools/davar-mutants. The sources there contain every mutant of a part, and the environment
 * selects one. System calls are direct, because tests replace those of the C library; further headers
 * of it would declare names that a source uses itself. */
#ifndef DAVAR_TESTS_MUTANT_H
#define DAVAR_TESTS_MUTANT_H

#include <stdlib.h>
#include <sys/syscall.h>

#define DAVAR_MUTANTS_MAX 131072U
#define DAVAR_AT_FDCWD (-100)
#define DAVAR_O_RDWR 2
#define DAVAR_PROT_READ_WRITE 3
#define DAVAR_MAP_SHARED 1

long syscall(long number, ...);

__attribute__((weak)) unsigned davar_mutant; /* 0: none */
__attribute__((weak)) unsigned char davar_mutants_own[DAVAR_MUTANTS_MAX];
__attribute__((weak)) unsigned char *davar_mutants_reached = davar_mutants_own;

/* True if one of the mutants first .. first + count - 1 is active. They share one place, which has
 * now been reached. */
#define DAVAR_SITE(first, count)                                                                   \
    (davar_mutants_reached[first] = 1, (davar_mutant - (first)) < (count))

/* The file DAVAR_MUTANTS_REACHED has a byte for each mutant, 1 at the first one of each place that
 * was reached. */
__attribute__((constructor(101))) static void davar_mutant_choose(void)
{
    const char *const text = getenv("DAVAR_MUTANT");
    const char *const name = getenv("DAVAR_MUTANTS_REACHED");
    const int file = name ? (int)syscall(SYS_openat, DAVAR_AT_FDCWD, name, DAVAR_O_RDWR, 0) : -1;
    davar_mutant = text ? (unsigned)strtoul(text, NULL, 10) : 0U;
    if (file >= 0 && davar_mutants_reached == davar_mutants_own) {
        davar_mutants_reached = (unsigned char *)syscall(
            SYS_mmap, NULL, DAVAR_MUTANTS_MAX, DAVAR_PROT_READ_WRITE, DAVAR_MAP_SHARED, file, 0L);
    }
    if (file >= 0) {
        (void)syscall(SYS_close, file);
    }
}

#endif
