/* davar - hands out the caller's memory piece by piece, 8-byte aligned; without memory it only
 * counts. */
#ifndef DAVAR_SRC_ARENA_H
#define DAVAR_SRC_ARENA_H

#include <stddef.h>
#include <stdint.h>

typedef struct {
    unsigned char *memory; /* null: count only */
    size_t used;
} davar_arena_t;

/* Room for count objects of `size` bytes; null when the arena only counts or nothing was asked for.
 * More than a size_t can tell stays at SIZE_MAX - 7, which no memory has. */
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
