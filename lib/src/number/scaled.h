/* davar - positive numbers as a 32-bit mantissa and a power of two, for limits, roots and bounds.
 * These are known to a few percent, and integers cost the same and give the same bits on every
 * core. */
#ifndef DAVAR_SRC_SCALED_H
#define DAVAR_SRC_SCALED_H

#include "number/real.h"

#define SCALED_TOP (UINT32_C(1) << 31U)

/* The exponent of 0: so far below that of any double that a product with 0 also becomes 0. */
#define SCALED_ZERO (-16384)

/* mantissa * 2^exponent; the top bit of the mantissa is set unless it is 0. */
typedef struct {
    uint32_t mantissa;
    int32_t exponent;
} scaled_t;

/* From a normal double, to 32 bits; anything smaller becomes 0. */
static inline scaled_t scaled_of_double(double value)
{
    const uint64_t bits = davar_bits_of_double(value);
    const int32_t exponent = (int32_t)(bits >> 52U);
    const scaled_t normal = {SCALED_TOP | (uint32_t)(bits >> 21U), exponent - (1023 + 31)};
    const scaled_t zero = {0U, SCALED_ZERO};
    return (exponent == 0) ? zero : normal;
}

/* From a positive normal float, exactly. */
static inline scaled_t scaled_of_float(float value)
{
    const uint32_t bits = davar_bits_of_float(value);
    return (scaled_t){SCALED_TOP | (bits << 8U), (int32_t)(bits >> 23U) - (127 + 31)};
}

/* value * 2^exponent; the value is not 0. */
static inline scaled_t scaled_of_u32(uint32_t value, int32_t exponent)
{
    const uint32_t zeros = davar_leading_zeros_32(value);
    return (scaled_t){value << zeros, exponent - (int32_t)zeros};
}

/* value * 2^exponent */
static inline scaled_t scaled_of_u64(uint64_t value, int32_t exponent)
{
    if (value == 0U) {
        return (scaled_t){0U, SCALED_ZERO};
    }
    const uint32_t zeros = davar_leading_zeros(value);
    return (scaled_t){(uint32_t)((value << zeros) >> 32U), exponent + 32 - (int32_t)zeros};
}

/* Truncated to 32 bits. */
static inline scaled_t scaled_of_u128(const davar_u128_t *value)
{
    if (value->high == 0U) {
        return scaled_of_u64(value->low, 0);
    }
    const uint32_t zeros = davar_leading_zeros(value->high);
    const uint64_t rest = (value->low >> 1U) >> (63U - zeros);
    return scaled_of_u64((value->high << zeros) | rest, 64 - (int32_t)zeros);
}

/* Truncated to 24 bits; the exponent must fit a float. */
static inline float scaled_to_float(scaled_t scaled)
{
    return davar_float_of_bits(((uint32_t)(scaled.exponent + 127 + 31) << 23U) +
                               ((scaled.mantissa << 1U) >> 9U));
}

/* Without a branch: random data would mispredict it. */
static inline scaled_t scaled_times(scaled_t a, scaled_t b)
{
    const uint32_t product = davar_upper_product(a.mantissa, b.mantissa);
    const uint32_t shift = 1U - (product >> 31U); /* two top bits multiply to at least 2^62 */
    return (scaled_t){product << shift, a.exponent + b.exponent + 32 - (int32_t)shift};
}

/* Within a few units of the last bit; a is not 0. */
static inline scaled_t scaled_inverse(scaled_t a)
{
    return (scaled_t){davar_reciprocal_of_mantissa(a.mantissa), -63 - a.exponent};
}

/* Within a few units of the last bit; b is not 0. */
static inline scaled_t scaled_quotient(scaled_t a, scaled_t b)
{
    return scaled_times(a, scaled_inverse(b));
}

/* 2^20 log2, straight between powers of two; 0 of 0. */
static inline uint32_t scaled_level(scaled_t a)
{
    const uint32_t whole = (uint32_t)(a.exponent + 64) << 20U;
    return (a.mantissa == 0U) ? 0U : (whole + ((a.mantissa << 1U) >> 12U));
}

/* The levels of two sums over N samples of noise: do they differ by more than without a change once
 * in a thousand times? The limit is about 2^24 / sqrt(samples); below 64 samples it is infinite
 * (4.5). */
static inline bool scaled_levels_differ(uint32_t one, uint32_t other, uint32_t samples)
{
    const uint32_t bits = 31U - davar_leading_zeros_32(samples | 1U);
    const uint32_t whole = UINT32_C(1) << (24U - (bits / 2U));
    const uint32_t limit = ((bits % 2U) == 0U) ? whole : (whole - (whole / 4U));
    return (samples >= 64U) && ((one - other + limit) > (2U * limit));
}

/* The same as one function, where flash is scarce. */
bool davar_levels_differ(uint32_t one, uint32_t other, uint32_t samples);

/* The smaller number loses the bits below the last one of the larger. */
scaled_t davar_scaled_plus(scaled_t a, scaled_t b);

/* 0 if too small for a normal double, infinity if too large. */
double davar_scaled_to_double(scaled_t scaled);

/* In units of 2^-bits, to the nearest, at most UINT32_MAX. */
uint32_t davar_scaled_to_fixed(scaled_t a, int32_t bits);

/* From the upper 24 bits of the mantissa, rounded like a float. */
scaled_t davar_scaled_root(scaled_t a);

/* Rounded like a float; 0 below 1e-37. */
static inline float scaled_root_of_float(float x)
{
    return (x > 1e-37F) ? scaled_to_float(davar_scaled_root(scaled_of_float(x))) : 0.0F;
}

#endif
