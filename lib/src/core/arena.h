/* davar - an arena in the caller's memory: 8-byte aligned pieces, one after the other. Without
 * memory it only counts bytes. */
#ifndef DAVAR_SRC_ARENA_H
#define DAVAR_SRC_ARENA_H

#include <stddef.h>
#include <stdint.h>

typedef struct {
    unsigned char *memory; /* null: count only */
    size_t used;
} davar_arena_t;

/* Room for count objects of `size` bytes; null if the arena only counts or count is 0. A sum that a
 * size_t cannot hold stays at SIZE_MAX - 7, which is larger than any memory. */
static inline void *davar_arena_take(davar_arena_t *arena, size_t count, size_t size)
{
    const size_t at = arena->used;
    if (count > ((SIZE_MAX - 7U - at) / size)) {
        arena->used = SIZE_MAX - 7U;
        return NULL;
    }
    const size_t bytes = count * size;
    arena->used += (bytes + 7U) & ~(size_t)7U;
    return ((arena->memory == NULL) || (bytes == 0U)) ? NULL : &arena->memory[at];
}

#endif
