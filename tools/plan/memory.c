/* davar-promise - the memory of a setup on the core that it is for. The macros of the library are
 * the only formulas; on another core, they differ by the size of a pointer alone. */
#include "memory.h"

#include "davar/cascade.h"
#include "davar/davar.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ARGUMENTS 7U

static size_t pointer_bytes;

/* From here on, the macros take this size of a pointer. A macro that needs the size of another type
 * does not compile: that size has to come from a compiler for the core. */
#ifdef __clang__
#pragma clang diagnostic ignored "-Wkeyword-macro"
#endif
#define sizeof(type) _Generic((type){0}, void * : pointer_bytes)

#define OF_TYPE(type)                                                                              \
    {#type, DAVAR_MEMORY_##type(a[0], a[1], a[2], a[3])},                                          \
        {"STRIDE_" #type, DAVAR_MEMORY_STRIDE_##type(a[0], a[1])},                                 \
        {"GRID_" #type, DAVAR_MEMORY_GRID_##type(a[0], a[1], a[2], a[3], a[4], a[5], a[6])},       \
        {"GLR_" #type,                                                                             \
         (a[2] == 0U) ? 0U : DAVAR_MEMORY_GLR_##type(a[0], a[1], a[2], a[3], a[4], a[5])},         \
        {"CASCADE_" #type, DAVAR_CASCADE_MEMORY(type, a[0])},

/* Of the macro with this name, or 0. list: its arguments, joined by commas. */
static size_t bytes_of(const char *name, const char *list)
{
    /* The table has the values of all macros, so an argument of one must not stop another. */
    uint32_t a[ARGUMENTS] = {1U, 1U, 1U, 1U, 1U, 1U, 1U};
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
    size_t sum = 0U;
    pointer_bytes = strtoul(words[0], NULL, 10);
    for (int i = 1; (i + 1) < count; i += 2) {
        const size_t bytes = bytes_of(words[i], words[i + 1]);
        if (bytes == 0U) {
            (void)fprintf(stderr, "davar-promise: no macro DAVAR_MEMORY_%s\n", words[i]);
            return 2;
        }
        sum += bytes;
    }
    (void)printf("bytes %zu\n", sum);
    return 0;
}
