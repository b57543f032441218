/* davar - integers modulo 2^256 for the moments of q31, four limbs of 64 bits; signed values are two's complement. */
#ifndef DAVAR_SRC_WIDE_H
#define DAVAR_SRC_WIDE_H

#include "machine.h"
#include "stationarity.h"

#define WIDE_LIMBS 4U

typedef struct {
    uint64_t limb[WIDE_LIMBS]; /* least significant first */
} wide_t;

static inline wide_t wide_from_i64(int64_t value)
{
    const uint64_t sign = (value < 0) ? UINT64_MAX : 0U;
    wide_t wide;
    wide.limb[0] = (uint64_t)value;
    for (unsigned i = 1U; i < WIDE_LIMBS; i++) {
        wide.limb[i] = sign;
    }
    return wide;
}

static inline wide_t wide_from_u128(davar_u128_t value)
{
    wide_t wide = {{value.low, value.high}};
    return wide;
}

static inline wide_t wide_from_i128(davar_u128_t value)
{
    wide_t wide = wide_from_i64((int64_t)value.high);
    wide.limb[0] = value.low;
    wide.limb[1] = value.high;
    return wide;
}

static inline wide_t wide_add(wide_t a, wide_t b)
{
    uint64_t carry = 0U;
    for (unsigned i = 0U; i < WIDE_LIMBS; i++) {
        const uint64_t partial = a.limb[i] + carry;
        a.limb[i] = partial + b.limb[i];
        carry = (uint64_t)(partial < carry) + (uint64_t)(a.limb[i] < partial);
    }
    return a;
}

static inline wide_t wide_subtract(wide_t a, wide_t b)
{
    uint64_t borrow = 0U;
    for (unsigned i = 0U; i < WIDE_LIMBS; i++) {
        const uint64_t partial = a.limb[i] - borrow;
        borrow = (uint64_t)(a.limb[i] < borrow) + (uint64_t)(partial < b.limb[i]);
        a.limb[i] = partial - b.limb[i];
    }
    return a;
}

static inline davar_u128_t wide_carry(davar_u128_t part, uint64_t carry)
{
    const davar_u128_t addend = {carry, 0U};
    return davar_u128_add(part, addend);
}

static inline wide_t wide_scale(wide_t a, uint64_t factor)
{
    uint64_t carry = 0U;
    for (unsigned i = 0U; i < WIDE_LIMBS; i++) {
        davar_u128_t part = davar_multiply_u64(a.limb[i], factor);
        part = wide_carry(part, carry);
        a.limb[i] = part.low;
        carry = part.high;
    }
    return a;
}

/* Schoolbook, truncated: right for two's complement operands too. */
static inline wide_t wide_multiply(wide_t a, wide_t b)
{
    wide_t product = {{0}};
    for (unsigned i = 0U; i < WIDE_LIMBS; i++) {
        uint64_t carry = 0U;
        for (unsigned j = 0U; (i + j) < WIDE_LIMBS; j++) {
            davar_u128_t part = davar_multiply_u64(a.limb[i], b.limb[j]);
            part = wide_carry(part, carry);
            part = wide_carry(part, product.limb[i + j]);
            product.limb[i + j] = part.low;
            carry = part.high;
        }
    }
    return product;
}

/* Of a value that is not negative: its top 64 bits. */
static davar_magnitude_t wide_magnitude(wide_t wide)
{
    unsigned top = WIDE_LIMBS - 1U;
    while ((top > 1U) && (wide.limb[top] == 0U)) {
        top--;
    }
    const davar_u128_t upper = {wide.limb[top - 1U], wide.limb[top]};
    return davar_magnitude_u128(upper, (int32_t)(64U * (top - 1U)));
}

#endif
