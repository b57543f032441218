/* davar - the natural logarithm, the same bits on every target. */
#ifndef DAVAR_SRC_LOGARITHM_H
#define DAVAR_SRC_LOGARITHM_H

#include "number/machine.h"

/* ln(mantissa 2^exponent) within 2e-7; the top bit of the mantissa is set, |exponent| <= 64. 24
 * binary digits after the point. */
int32_t davar_logarithm(uint32_t mantissa, int32_t exponent);

/* ln n, n > 0. */
static inline int32_t davar_logarithm_of_count(uint32_t n)
{
    const uint32_t zeros = davar_leading_zeros_32(n);
    return davar_logarithm(n << zeros, -(int32_t)zeros);
}

#endif
