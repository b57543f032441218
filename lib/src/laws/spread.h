/* davar - the variation of a section of the recording: the exact sum over its blocks of K^2 times
 * the variance in each. */
#ifndef DAVAR_SRC_SPREAD_H
#define DAVAR_SRC_SPREAD_H

#include "laws/logarithm.h"

/* The sum of b modulo 2^96 over a number of blocks, which are independent chi-squares in white
 * noise. A running sum wraps around, and the difference of two running sums is the sum between
 * them. */
typedef struct {
    uint64_t low;
    uint32_t high;
    uint32_t blocks;
} davar_spread_t;

/* Field by field, here and below: on small cores the compiler calls memcpy or memset for a whole
 * struct. */
static inline void spread_copy(davar_spread_t *to, const davar_spread_t *from)
{
    to->low = from->low;
    to->high = from->high;
    to->blocks = from->blocks;
}

static inline void spread_add(davar_spread_t *sum, const davar_spread_t *more)
{
    sum->low += more->low;
    sum->high += more->high + ((sum->low < more->low) ? 1U : 0U);
    sum->blocks += more->blocks;
}

/* The sum between two running sums. */
static inline davar_spread_t spread_between(const davar_spread_t *from, const davar_spread_t *to)
{
    const davar_spread_t between = {to->low - from->low,
                                    to->high - from->high - ((to->low < from->low) ? 1U : 0U),
                                    to->blocks - from->blocks};
    return between;
}

/* Bits `at` to at + 31 of the sum, at < 64. Negative (above -32) it shifts a short sum up. */
static inline uint32_t spread_bits(const davar_spread_t *sum, int32_t at)
{
    const uint32_t middle = (uint32_t)(sum->low >> 32U);
    if (at < 0) {
        return (uint32_t)sum->low << (uint32_t)(-at);
    }
    const uint32_t shift = (uint32_t)at & 31U;
    const uint32_t lower = (at < 32) ? (uint32_t)sum->low : middle;
    const uint32_t upper = (at < 32) ? middle : sum->high;
    return (lower >> shift) | ((upper << 1U) << (31U - shift));
}

/* Where the upper 32 bits of a sum that is not 0 begin, so that the first of them is set. */
static inline int32_t spread_exponent(const davar_spread_t *sum)
{
    const uint32_t middle = (uint32_t)(sum->low >> 32U);
    if (sum->high != 0U) {
        return 64 - (int32_t)davar_leading_zeros_32(sum->high);
    }
    return (middle != 0U) ? (32 - (int32_t)davar_leading_zeros_32(middle))
                          : -(int32_t)davar_leading_zeros_32((uint32_t)sum->low);
}

/* The sum is not 0. */
static inline int32_t spread_logarithm(const davar_spread_t *sum)
{
    const int32_t exponent = spread_exponent(sum);
    return davar_logarithm(spread_bits(sum, exponent), exponent);
}

/* ln of the mean block; at least one block. */
static inline int32_t spread_logarithm_of_mean(const davar_spread_t *sum)
{
    return spread_logarithm(sum) - davar_logarithm_of_count(sum->blocks);
}

#endif
