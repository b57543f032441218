/* davar - the natural logarithm, the same bits on every target. */
#ifndef DAVAR_SRC_LOGARITHM_H
#define DAVAR_SRC_LOGARITHM_H

#include "number/machine.h"

#define LOGARITHM_DIGITS 24U /* binary, behind the point */

/* ln(mantissa 2^exponent), the top bit of the mantissa set, |exponent| at most 64. Within 2e-7: three products, one table. */
int32_t davar_logarithm(uint32_t mantissa, int32_t exponent);

/* ln n, n > 0 */
static inline int32_t davar_logarithm_of_count(uint32_t n)
{
    const uint32_t zeros = davar_leading_zeros_32(n);
    return davar_logarithm(n << zeros, -(int32_t)zeros);
}

#endif
