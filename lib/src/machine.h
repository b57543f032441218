/* davar - 128-bit products and sums, leading zeros: the only place that asks what the machine has. */
#ifndef DAVAR_SRC_MACHINE_H
#define DAVAR_SRC_MACHINE_H

#include <stdint.h>

/* A 128-bit integer modulo 2^128; signed values are two's complement. */
typedef struct {
    uint64_t low;
    uint64_t high;
} davar_u128_t;

/* The product by 32-bit parts, for compilers without a 128-bit type (and for the tests of this path on those with). */
static inline davar_u128_t davar_multiply_u64_by_parts(uint64_t a, uint64_t b)
{
    const uint64_t a0 = a & UINT32_MAX;
    const uint64_t a1 = a >> 32U;
    const uint64_t b0 = b & UINT32_MAX;
    const uint64_t b1 = b >> 32U;
    const uint64_t p00 = a0 * b0;
    const uint64_t p01 = a0 * b1;
    const uint64_t p10 = a1 * b0;
    const uint64_t middle = (p00 >> 32U) + (p01 & UINT32_MAX) + (p10 & UINT32_MAX);
    const davar_u128_t product = {
        (middle << 32U) | (p00 & UINT32_MAX),
        (a1 * b1) + (p01 >> 32U) + (p10 >> 32U) + (middle >> 32U),
    };
    return product;
}

/* A sum or a difference with its carry by comparison, a product with a small factor by parts: likewise. */
static inline davar_u128_t davar_u128_add_by_parts(davar_u128_t a, davar_u128_t b)
{
    const uint64_t low = a.low + b.low;
    const davar_u128_t sum = {low, a.high + b.high + (uint64_t)(low < b.low)};
    return sum;
}

static inline davar_u128_t davar_u128_subtract_by_parts(davar_u128_t a, davar_u128_t b)
{
    const davar_u128_t difference = {a.low - b.low, a.high - b.high - (uint64_t)(a.low < b.low)};
    return difference;
}

/* Leading zeros of a value that is not 0, by halving. */
static inline uint32_t davar_leading_zeros_by_halving(uint64_t value)
{
    uint32_t zeros = 0U;
    for (uint32_t step = 32U; step > 0U; step >>= 1U) {
        if ((value >> (64U - step)) == 0U) {
            value <<= step;
            zeros += step;
        }
    }
    return zeros;
}

#ifdef __SIZEOF_INT128__
__extension__ typedef unsigned __int128 davar_native_u128_t;

static inline davar_native_u128_t davar_native_u128(davar_u128_t value)
{
    return ((davar_native_u128_t)value.high << 64U) | value.low;
}

static inline davar_u128_t davar_u128_from_native(davar_native_u128_t native)
{
    const davar_u128_t value = {(uint64_t)native, (uint64_t)(native >> 64U)};
    return value;
}

static inline davar_u128_t davar_u128_add(davar_u128_t a, davar_u128_t b)
{
    return davar_u128_from_native(davar_native_u128(a) + davar_native_u128(b));
}

static inline davar_u128_t davar_u128_subtract(davar_u128_t a, davar_u128_t b)
{
    return davar_u128_from_native(davar_native_u128(a) - davar_native_u128(b));
}

static inline davar_u128_t davar_multiply_u64(uint64_t a, uint64_t b)
{
    return davar_u128_from_native((davar_native_u128_t)a * b);
}

static inline uint32_t davar_leading_zeros(uint64_t value)
{
    return (uint32_t)__builtin_clzll(value);
}
#else
static inline davar_u128_t davar_u128_add(davar_u128_t a, davar_u128_t b)
{
    return davar_u128_add_by_parts(a, b);
}

static inline davar_u128_t davar_u128_subtract(davar_u128_t a, davar_u128_t b)
{
    return davar_u128_subtract_by_parts(a, b);
}

static inline davar_u128_t davar_multiply_u64(uint64_t a, uint64_t b)
{
    return davar_multiply_u64_by_parts(a, b);
}

static inline uint32_t davar_leading_zeros(uint64_t value)
{
    return davar_leading_zeros_by_halving(value);
}
#endif

/* Signed product, modulo 2^128: the unsigned one, less each operand's sign times the other. */
static inline davar_u128_t davar_multiply_i64(int64_t a, int64_t b)
{
    davar_u128_t product = davar_multiply_u64((uint64_t)a, (uint64_t)b);
    product.high -= (a < 0) ? (uint64_t)b : 0U;
    product.high -= (b < 0) ? (uint64_t)a : 0U;
    return product;
}

/* Modulo 2^128, signed or not. */
static inline davar_u128_t davar_u128_scale(davar_u128_t a, uint32_t factor)
{
    davar_u128_t product = davar_multiply_u64(a.low, factor);
    product.high += a.high * factor;
    return product;
}

#endif
