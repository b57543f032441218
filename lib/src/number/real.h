/* davar - floating-point numbers: their bits, conversions from integers, roots, quotients and
 * products. They are correctly rounded as IEEE 754 requires, so the bits are the same on every
 * target. Without a floating-point instruction they are computed in integers, much faster than by
 * the digit-by-digit library of a compiler. */
#ifndef DAVAR_SRC_REAL_H
#define DAVAR_SRC_REAL_H

#include "number/machine.h"
#include "number/strict.h"

#include <math.h>

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
double davar_double_of_u64_by_parts(uint64_t value);

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

/* Compares non-negative numbers by their bits. A negative number or NaN counts as larger than
 * all. */
bool davar_is_between(double low, double value, double high);

/* The root of 0, NaN or infinity is itself, that of a negative number NaN. */
double davar_root_by_integers(double value);

double davar_divide_by_integers(double dividend, double divisor);

/* a is 0 or normal; b and the product are normal. */
double davar_scale_by_integers(double a, double b);

/* The root of a quotient, both rounded. The dividend is 0 or normal, the divisor and the quotient
 * are normal. */
double davar_root_of_quotient_by_integers(double dividend, double divisor);

/* Steps of 32 bits. The root of m in [1, 4), as 2.30 with 24 bits, is 9.23 and correctly rounded.
 * The reciprocal of b in [1, 2), as 1.31, is 0.32 within 3 units. */
uint32_t davar_root_of_mantissa_by_integers(uint32_t m);
uint32_t davar_reciprocal_of_mantissa(uint32_t b);

/* amount / n truncated, up to 4 too small; n is not 0. */
static inline uint32_t davar_divided(uint32_t amount, uint32_t n)
{
    const uint32_t zeros = davar_leading_zeros_32(n);
    return davar_upper_product(amount, davar_reciprocal_of_mantissa(n << zeros)) >> (31U - zeros);
}

static inline double davar_root(double value)
{
#ifdef DAVAR_SOFT_DOUBLE
    return davar_root_by_integers(value);
#else
    return sqrt(value);
#endif
}

/* Exact except for the root: 2^15 .. 2^16, of 24 bits. On Arm the instruction itself, because sqrtf
 * sets errno unless the user switches that off. */
static inline uint32_t davar_root_of_mantissa(uint32_t m)
{
#ifdef DAVAR_SOFT_FLOAT
    return davar_root_of_mantissa_by_integers(m);
#elif defined(__arm__) && defined(__GNUC__) && !defined(DAVAR_PORTABLE)
    float root;
    __asm__("vsqrt.f32 %0, %1" : "=t"(root) : "t"((float)m));
    return (uint32_t)(root * 256.0F);
#else
    return (uint32_t)(sqrtf((float)m) * 256.0F);
#endif
}

static inline double davar_root_of_quotient(double dividend, double divisor)
{
#ifdef DAVAR_SOFT_DOUBLE
    return davar_root_of_quotient_by_integers(dividend, divisor);
#else
    return sqrt(dividend / divisor);
#endif
}

static inline double davar_divide(double a, double b)
{
#ifdef DAVAR_SOFT_DOUBLE
    return davar_divide_by_integers(a, b);
#else
    return a / b;
#endif
}

static inline double davar_scale(double a, double b)
{
#ifdef DAVAR_SOFT_DOUBLE
    return davar_scale_by_integers(a, b);
#else
    return a * b;
#endif
}

/* --- values as float32, for frames and packets --- */

/* Magnitudes that may be sent, except 0: the least and the most. */
#define DAVAR_SINGLE_LEAST 1e-30F
#define DAVAR_SINGLE_MOST 1e30F

/* The bits of (float)value. NaN has the same bits on every machine. */
uint32_t davar_single_bits(double value);

/* The value, 0 below DAVAR_SINGLE_LEAST, or NaN above DAVAR_SINGLE_MOST. NaN stays NaN. */
double davar_single_signed(double value);

/* The same; a negative value becomes NaN. */
double davar_single_magnitude(double value);

/* The same for an upper limit: above DAVAR_SINGLE_MOST it is infinity, which is no limit. */
double davar_single_limit(double value);

#endif
