/* davar - selects the active mutant. Included before every source of the build of
 * tools/davar-mutants. The sources there contain every mutant of lib/, and the environment selects
 * one. */
#ifndef DAVAR_TESTS_MUTANT_H
#define DAVAR_TESTS_MUTANT_H

#include <stdio.h>
#include <stdlib.h>

#define DAVAR_MUTANTS_MAX 65536U

__attribute__((weak)) unsigned davar_mutant; /* 0: none */
__attribute__((weak)) unsigned char davar_mutants_reached[DAVAR_MUTANTS_MAX];
__attribute__((weak)) int davar_mutants_told;

/* True if one of the mutants first .. first + count - 1 is active. They share one place, which has
 * now been reached. */
#define DAVAR_SITE(first, count)                                                                   \
    (davar_mutants_reached[first] = 1, (davar_mutant - (first)) < (count))

__attribute__((constructor(101))) static void davar_mutant_choose(void)
{
    const char *const text = getenv("DAVAR_MUTANT");
    davar_mutant = text ? (unsigned)strtoul(text, NULL, 10) : 0U;
}

/* At the end, on request: a byte for each mutant, 1 at the first one of each place that was
 * reached. */
__attribute__((destructor)) static void davar_mutants_tell(void)
{
    const char *const name = getenv("DAVAR_MUTANTS_REACHED");
    FILE *const file = (name && !davar_mutants_told) ? fopen(name, "wb") : NULL;
    if (file) {
        davar_mutants_told = 1;
        (void)fwrite(davar_mutants_reached, 1, sizeof davar_mutants_reached, file);
        (void)fclose(file);
    }
}

#endif
