/* davar - counters of input faults, which stop at their largest value. */
#ifndef DAVAR_SRC_COUNT_H
#define DAVAR_SRC_COUNT_H

#include <stddef.h>
#include <stdint.h>

static inline void davar_count(uint32_t *counter)
{
    if (*counter < UINT32_MAX) {
        (*counter)++;
    }
}

static inline void davar_count_many(uint32_t *counter, size_t more)
{
    const uint32_t room = UINT32_MAX - *counter;
    *counter += (more < room) ? (uint32_t)more : room;
}

#endif
