/* davar - integers modulo 2^256 for the moments of q31, four limbs of 64 bits; signed values are two's complement. Operands
 * go by address and are changed in place: by value, structs this large would be moved by library calls on some targets. */
#ifndef DAVAR_SRC_WIDE_H
#define DAVAR_SRC_WIDE_H

#include "change/stationarity.h"
#include "number/ieee.h"

#define WIDE_LIMBS 4U

typedef struct {
    uint64_t limb[WIDE_LIMBS]; /* least significant first */
} wide_t;

static void wide_fill(wide_t *wide, uint64_t low, uint64_t high, uint64_t rest)
{
    wide->limb[0] = low;
    wide->limb[1] = high;
    wide->limb[2] = rest;
    wide->limb[3] = rest;
}

static void wide_from_i64(wide_t *wide, int64_t value)
{
    const uint64_t sign = (value < 0) ? UINT64_MAX : 0U;
    wide_fill(wide, (uint64_t)value, sign, sign);
}

static void wide_from_u128(wide_t *wide, const davar_u128_t *value)
{
    wide_fill(wide, value->low, value->high, 0U);
}

static void wide_from_i128(wide_t *wide, const davar_u128_t *value)
{
    wide_fill(wide, value->low, value->high, ((int64_t)value->high < 0) ? UINT64_MAX : 0U);
}

static void wide_add(wide_t *a, const wide_t *b)
{
    uint64_t carry = 0U;
    for (unsigned i = 0U; i < WIDE_LIMBS; i++) {
        const uint64_t partial = a->limb[i] + carry;
        a->limb[i] = partial + b->limb[i];
        carry = (uint64_t)(partial < carry) + (uint64_t)(a->limb[i] < partial);
    }
}

static void wide_subtract(wide_t *a, const wide_t *b)
{
    uint64_t borrow = 0U;
    for (unsigned i = 0U; i < WIDE_LIMBS; i++) {
        const uint64_t partial = a->limb[i] - borrow;
        borrow = (uint64_t)(a->limb[i] < borrow) + (uint64_t)(partial < b->limb[i]);
        a->limb[i] = partial - b->limb[i];
    }
}

static davar_u128_t wide_carry(davar_u128_t part, uint64_t carry)
{
    const davar_u128_t addend = {carry, 0U};
    return davar_u128_add(part, addend);
}

static void wide_scale(wide_t *a, uint64_t factor)
{
    uint64_t carry = 0U;
    for (unsigned i = 0U; i < WIDE_LIMBS; i++) {
        const davar_u128_t part = wide_carry(davar_multiply_u64(a->limb[i], factor), carry);
        a->limb[i] = part.low;
        carry = part.high;
    }
}

/* Schoolbook, truncated: right for two's complement operands too. `product` may be one of the factors. */
static void wide_multiply(wide_t *product, const wide_t *a, const wide_t *b)
{
    wide_t sum;
    wide_fill(&sum, 0U, 0U, 0U);
    for (unsigned i = 0U; i < WIDE_LIMBS; i++) {
        uint64_t carry = 0U;
        for (unsigned j = 0U; (i + j) < WIDE_LIMBS; j++) {
            davar_u128_t part = davar_multiply_u64(a->limb[i], b->limb[j]);
            part = wide_carry(part, carry);
            part = wide_carry(part, sum.limb[i + j]);
            sum.limb[i + j] = part.low;
            carry = part.high;
        }
    }
    wide_fill(product, sum.limb[0], sum.limb[1], sum.limb[2]);
    product->limb[3] = sum.limb[3];
}

/* Of a value that is not negative: its top 64 bits. */
static void wide_magnitude(const wide_t *wide, davar_magnitude_t *magnitude)
{
    unsigned top = WIDE_LIMBS - 1U;
    while ((top > 1U) && (wide->limb[top] == 0U)) {
        top--;
    }
    davar_magnitude(magnitude, wide->limb[top - 1U], wide->limb[top], (int32_t)(64U * (top - 1U)));
}

#endif
