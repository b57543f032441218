/* davar-sim - has a fixed window changed since one that is half a window older, or more (4.5)? As in
 * the library's pipelines, for windows that the host computes. */
#ifndef PAST_H
#define PAST_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint32_t level[2]; /* of the first sum of two windows, half a window apart; 0: not yet */
    uint32_t wait;     /* samples until the next one is kept */
} past_t;

#define PAST_UNKNOWN UINT32_MAX

/* The level of an exact sum of squares, high 2^64 + low. */
uint32_t past_level(uint64_t high, uint64_t low);

/* At each epoch. level: of the first sum, or PAST_UNKNOWN if the window is not full or m not 1. */
bool past_next(past_t *past, uint32_t stride, uint32_t longest, uint32_t level);

#endif
