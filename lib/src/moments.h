/* davar - stage [3a]: exact power sums, and from them the central moments as integers. */
#ifndef DAVAR_SRC_MOMENTS_H
#define DAVAR_SRC_MOMENTS_H

#include "ring.h"
#include "stationarity.h"
#include "wide.h"

typedef struct {
    powers_t whole;   /* sliding: over the window; grid: since the start, modulo */
    powers_t first;   /* sliding: over the window without its last `segment` samples */
    uint32_t segment; /* 0: kurtosis and contribution are switched off */
    uint32_t shift;   /* bits dropped so that a sample fits the moments */
} moments_t;

static davar_magnitude_t moments_magnitude(const wide_t *wide)
{
    unsigned top = WIDE_LIMBS - 1U;
    while ((top > 0U) && (wide->limb[top] == 0U)) {
        top--;
    }
    davar_magnitude_t magnitude = davar_magnitude(wide->limb[top], (int32_t)(64U * top));
    const int32_t zeros = (int32_t)(64U * top) - magnitude.exponent;
    if ((top > 0U) && (zeros > 0)) {
        magnitude.mantissa |= wide->limb[top - 1U] >> (uint32_t)(64 - zeros);
    }
    return magnitude;
}

/* n^2 s^2 and n^4 m4 of n samples, from their power sums: exact (3.3). */
static davar_central_t moments_central(const powers_t *powers, uint32_t n)
{
    const wide_t p1 = wide_from_i64(powers->first);
    const wide_t p2 = wide_from_u64(powers->second);
    const wide_t p3 = POWERS_THIRD_WIDE(powers);
    const wide_t p4 = wide_from_u128(powers->fourth);
    const wide_t p1_squared = wide_multiply(p1, p1);
    const wide_t second = wide_subtract(wide_scale(p2, n), p1_squared);
    wide_t fourth = wide_subtract(wide_scale(p4, n), wide_scale(wide_multiply(p1, p3), 4U));
    fourth = wide_add(wide_scale(fourth, n), wide_scale(wide_multiply(p1_squared, p2), 6U));
    fourth = wide_subtract(wide_scale(fourth, n), wide_scale(wide_multiply(p1_squared, p1_squared), 3U));
    const davar_central_t central = {moments_magnitude(&second), moments_magnitude(&fourth)};
    return central;
}

#endif
