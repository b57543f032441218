/* davar - float samples become counts once, by a power of two (2.3). After that they are exact
 * integers. */
#ifndef DAVAR_SRC_QUANTUM_H
#define DAVAR_SRC_QUANTUM_H

#include "number/machine.h"
#include "number/real.h"

/* Significant bits of a quantised float sample: full_scale <= 2^30 quanta (2.3). */
#define DAVAR_FLOAT_BITS 31U

/* 1 / q for the smallest power of two q with full_scale <= 2^30 q (2.3). */
static inline float davar_counts_per_unit(double full_scale)
{
    double quantum = 1.0;
    while ((quantum * 1073741824.0) < full_scale) {
        quantum *= 2.0;
    }
    while ((quantum * 536870912.0) >= full_scale) {
        quantum *= 0.5;
    }
    return (float)(1.0 / quantum);
}

/* Tests the bits of a sample: a compiler flag such as -ffast-math may drop other tests. */
static inline bool davar_is_finite(float rate)
{
    return (davar_bits_of_float(rate) & UINT32_C(0x7F800000)) != UINT32_C(0x7F800000);
}

/* To the nearest quantum, halves away from zero; limited to +-limit, and then counted in
 * *saturated. Scaling by a power of two and the remainder are exact. */
static inline int32_t davar_float_to_counts(float rate, float limit, float counts_per_unit,
                                            uint32_t *saturated)
{
    float inside = rate;
    if ((rate >= limit) || (rate <= -limit)) {
        davar_count(saturated);
        inside = (rate > 0.0F) ? limit : -limit;
    }
    const float scaled = inside * counts_per_unit;
    const int32_t whole = (int32_t)scaled;
    const float rest = scaled - (float)whole;
    return whole + ((rest >= 0.5F) ? 1 : 0) - ((rest <= -0.5F) ? 1 : 0);
}

#endif
