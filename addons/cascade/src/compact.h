/* davar - positive numbers in 32 bits, for sums that a push updates: a mantissa of 22 bits,
 * truncated, and an exponent for squares of variances of any samples. */
#ifndef DAVAR_SRC_COMPACT_H
#define DAVAR_SRC_COMPACT_H

#include "number/scaled.h"
#include "stage.h"

#define COMPACT_MANTISSA_BITS 22U
#define COMPACT_BIAS 160U /* from 2^-159 on, below 2^863; 0 is 0 */

static inline compact_t compact_of_scaled(scaled_t value)
{
    const uint32_t exponent = (uint32_t)(value.exponent + 31) + COMPACT_BIAS;
    return (value.mantissa == 0U) ? 0U
                                  : ((exponent << COMPACT_MANTISSA_BITS) +
                                     ((value.mantissa << 1U) >> (32U - COMPACT_MANTISSA_BITS)));
}

static inline scaled_t scaled_of_compact(compact_t value)
{
    const scaled_t zero = {0U, SCALED_ZERO};
    const scaled_t scaled = {SCALED_TOP | ((value << (32U - COMPACT_MANTISSA_BITS)) >> 1U),
                             (int32_t)(value >> COMPACT_MANTISSA_BITS) -
                                 (31 + (int32_t)COMPACT_BIAS)};
    return (value == 0U) ? zero : scaled;
}

/* Truncated. The bits of larger numbers are larger. */
static inline compact_t compact_plus(compact_t a, compact_t b)
{
    const uint32_t top = UINT32_C(1) << COMPACT_MANTISSA_BITS;
    const compact_t large = (a < b) ? b : a;
    const compact_t small = (a < b) ? a : b;
    const uint32_t shift = (large >> COMPACT_MANTISSA_BITS) - (small >> COMPACT_MANTISSA_BITS);
    if ((small == 0U) || (shift > COMPACT_MANTISSA_BITS)) {
        return large;
    }
    const uint32_t more = (top | (small & (top - 1U))) >> shift;
    const uint32_t sum = (top | (large & (top - 1U))) + more;
    return (sum < (2U * top)) ? (large + more) : (((large & ~(top - 1U)) + (sum >> 1U)));
}

/* Truncated. */
static inline compact_t compact_square(compact_t value)
{
    const uint32_t mantissa = SCALED_TOP | ((value << (32U - COMPACT_MANTISSA_BITS)) >> 1U);
    const uint32_t product = davar_upper_product(mantissa, mantissa);
    const uint32_t shift = 1U - (product >> 31U);
    const uint32_t exponent = (2U * (value >> COMPACT_MANTISSA_BITS)) + 1U - COMPACT_BIAS - shift;
    return (value == 0U) ? 0U
                         : ((exponent << COMPACT_MANTISSA_BITS) +
                            ((product << (shift + 1U)) >> (32U - COMPACT_MANTISSA_BITS)));
}

#endif
