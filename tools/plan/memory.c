/* davar-promise - the memory of a setup on the core that it is for. The macros of the library are
 * the only formulas; on another core, they differ by the size of a pointer alone. */
#include "memory.h"

#include "davar/cascade.h"
#include "davar/glr.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ARGUMENTS 4U

static size_t pointer_bytes;

/* From here on, the macros take this size of a pointer. A macro that needs the size of another type
 * does not compile: that size has to come from a compiler for the core. */
#ifdef __clang__
#pragma clang diagnostic ignored "-Wkeyword-macro"
#endif
#define sizeof(type) _Generic((type){0}, void * : pointer_bytes)

#define OF_TYPE(type)                                                                              \
    {#type,                                                                                        \
     DAVAR_MEMORY(type, longest(a[0]), shortest(a[0]), stride(a[1]), largest(a[2]), taus(a[3]))},  \
        {"GRID_" #type, DAVAR_MEMORY_GRID(type, longest(a[0]), shortest(a[0]), stride(a[1]),       \
                                          largest(a[2]), taus(a[3]))},                             \
        {"GLR_" #type, DAVAR_MEMORY_GLR(type, longest(a[0]), largest(a[2]), taus(a[3]))},          \
        {"CASCADE_" #type, DAVAR_CASCADE_MEMORY(type, a[0])},

/* Of the macro with this name, or 0. list: its arguments, joined by commas. */
static size_t bytes_of(const char *name, const char *list)
{
    /* The table has the values of all macros, so an argument of one must not stop another. */
    uint32_t a[ARGUMENTS] = {1U, 1U, 1U, 1U};
    for (size_t i = 0U; (i < ARGUMENTS) && (*list != '\0'); i++) {
        char *end = NULL;
        a[i] = (uint32_t)strtoul(list, &end, 10);
        list = (*end == ',') ? (end + 1) : end;
    }
    const struct {
        const char *name;
        size_t bytes;
    } all[] = {OF_TYPE(Q15) OF_TYPE(Q31) OF_TYPE(F32){NULL, 0U}};
    size_t i = 0U;
    while ((all[i].name != NULL) && (strcmp(all[i].name, name) != 0)) {
        i++;
    }
    return all[i].bytes;
}

int print_memory(int count, char *words[])
{
    if (count != 3) {
        return 2;
    }
    pointer_bytes = strtoul(words[0], NULL, 10);
    const size_t bytes = bytes_of(words[1], words[2]);
    if (bytes == 0U) {
        (void)fprintf(stderr, "davar-promise: no macro for the memory of %s\n", words[1]);
        return 2;
    }
    (void)printf("bytes %zu\n", bytes);
    return 0;
}
