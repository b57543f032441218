/* davar - floating-point numbers as bits, and from integers, without floating-point
 * instructions. */
#ifndef DAVAR_SRC_IEEE_H
#define DAVAR_SRC_IEEE_H

#include "number/machine.h"
#include "number/strict.h"

typedef union {
    double value;
    uint64_t bits;
} davar_double_t;

typedef union {
    float value;
    uint32_t bits;
} davar_float_t;

static inline uint64_t davar_bits_of_double(double value)
{
    return ((davar_double_t){.value = value}).bits;
}

static inline double davar_double_of_bits(uint64_t bits)
{
    return ((davar_double_t){.bits = bits}).value;
}

static inline uint32_t davar_bits_of_float(float value)
{
    return ((davar_float_t){.value = value}).bits;
}

static inline float davar_float_of_bits(uint32_t bits)
{
    return ((davar_float_t){.bits = bits}).value;
}

/* 1 / value; the value is a power of two. */
static inline double davar_inverse_of_power(float value)
{
    return davar_double_of_bits((uint64_t)(1023U + 127U - (davar_bits_of_float(value) >> 23U))
                                << 52U);
}

/* mantissa * 2^(exponent - 1086) to the nearest double, ties to even. The top bit of the mantissa
 * is set. */
static inline double davar_double_of_mantissa(uint64_t mantissa, uint32_t exponent)
{
    const uint64_t kept = mantissa >> 11U;
    const uint32_t rest = (uint32_t)mantissa & 0x7FFU;
    const uint32_t up = ((rest > 0x400U) || ((rest == 0x400U) && ((kept & 1U) != 0U))) ? 1U : 0U;
    return davar_double_of_bits(((uint64_t)(exponent - 1U) << 52U) + kept + up);
}

/* Rounds like (double)value. */
static inline double davar_double_of_u64_by_parts(uint64_t value)
{
    if (value == 0U) {
        return 0.0;
    }
    const uint32_t zeros = davar_leading_zeros(value);
    return davar_double_of_mantissa(value << zeros, 1086U - zeros);
}

static inline double davar_double_of_u64(uint64_t value)
{
#ifdef DAVAR_SOFT_DOUBLE
    return davar_double_of_u64_by_parts(value);
#else
    return (double)value;
#endif
}

/* Each half rounds, then their sum. */
static inline double davar_double_of_u128(davar_u128_t value)
{
    return (davar_double_of_u64(value.high) * 18446744073709551616.0) +
           davar_double_of_u64(value.low);
}

#endif
