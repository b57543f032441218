/* davar tests - shared by the programs that measure costs on a target: noise of a fixed seed, and
 * the cost of a measurement itself. */
#ifndef DAVAR_TESTS_MEASURING_H
#define DAVAR_TESTS_MEASURING_H

#include "board.h"

static uint32_t noise_state = 1U;

/* Sum of so many uniform variates of a byte: nearly Gaussian. */
static inline int32_t noise_of(unsigned variates)
{
    int32_t sum = 0;
    for (unsigned k = 0U; k < variates; k++) {
        noise_state = (noise_state * 1664525U) + 1013904223U;
        sum += (int32_t)(noise_state >> 24U) - 128;
    }
    return sum;
}

static inline uint32_t instructions_of_nothing(void)
{
    const uint32_t mark = board_mark();
    return board_instructions_since(mark);
}

static inline uint32_t larger(uint32_t a, uint32_t b)
{
    return (a > b) ? a : b;
}

#endif
