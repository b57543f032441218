/* davar - positive numbers as a mantissa of 32 bits and a power of two. What follows from a result's ADEVs (a limit, a root, a
 * bound) is known to a few percent; 32 bits are plenty, and integers cost every core the same and give it the same bits. */
#ifndef DAVAR_SRC_SCALED_H
#define DAVAR_SRC_SCALED_H

#include "number/real.h"

#define SCALED_TOP (UINT32_C(1) << 31U)

/* The exponent of 0: far below that of any double, so that a product with 0 is none either. */
#define SCALED_ZERO (-16384)

/* mantissa * 2^exponent; the top bit of the mantissa is set, or it is 0. */
typedef struct {
    uint32_t mantissa;
    int32_t exponent;
} scaled_t;

/* Of a normal double, to 32 bits; anything smaller is 0. */
static inline scaled_t scaled_of_double(double value)
{
    const uint64_t bits = davar_bits_of_double(value);
    const int32_t exponent = (int32_t)(bits >> 52U);
    const uint32_t mantissa = SCALED_TOP | (uint32_t)(bits >> 21U);
    const scaled_t normal = {mantissa, exponent - (1023 + 31)};
    const scaled_t zero = {0U, SCALED_ZERO};
    const scaled_t scaled = (exponent == 0) ? zero : normal;
    return scaled;
}

/* Of a positive normal float, exactly. */
static inline scaled_t scaled_of_float(float value)
{
    const uint32_t bits = davar_bits_of_float(value);
    const scaled_t scaled = {SCALED_TOP | (bits << 8U), (int32_t)(bits >> 23U) - (127 + 31)};
    return scaled;
}

/* value * 2^exponent, not 0. */
static inline scaled_t scaled_of_u32(uint32_t value, int32_t exponent)
{
    const uint32_t zeros = davar_leading_zeros_32(value);
    const scaled_t scaled = {value << zeros, exponent - (int32_t)zeros};
    return scaled;
}

/* 0 when it is too small for a normal double, infinity when too large. */
static inline double scaled_to_double(scaled_t scaled)
{
    const int32_t exponent = scaled.exponent + (1023 + 31);
    if ((uint32_t)(exponent - 1) >= 0x7FEU) {
        return (exponent <= 0) ? 0.0 : (double)INFINITY;
    }
    const uint32_t upper = ((uint32_t)exponent << 20U) + ((scaled.mantissa << 1U) >> 12U);
    return davar_double_of_bits(((uint64_t)upper << 32U) | (scaled.mantissa << 21U));
}

/* Without a branch, which data as random as these would mislead. */
static inline scaled_t scaled_times(scaled_t a, scaled_t b)
{
    const uint32_t product = davar_upper_product(a.mantissa, b.mantissa);
    const uint32_t shift = 1U - (product >> 31U); /* two top bits multiply to at least 2^62 */
    const scaled_t scaled = {product << shift, a.exponent + b.exponent + 32 - (int32_t)shift};
    return scaled;
}

/* Of the mantissa's upper 24 bits, rounded as a float's. */
static inline scaled_t scaled_root(scaled_t a)
{
    const uint32_t odd = (uint32_t)a.exponent & 1U;
    const uint32_t root = davar_root_of_mantissa((a.mantissa & ~UINT32_C(0xFF)) >> odd);
    const scaled_t scaled = {root << 8U, ((a.exponent - (int32_t)odd) / 2) + (int32_t)odd - 16};
    return scaled;
}

#endif
