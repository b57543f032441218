/* davar - the door of float samples: one quantisation, by a power of two, and exact integers from there on (2.3). */
#ifndef DAVAR_SRC_DOOR_H
#define DAVAR_SRC_DOOR_H

#include "number/ieee.h"
#include "pipeline/pipelines.h"

/* The smallest power of two q with full_scale <= 2^30 q (2.3). */
static inline double door_quantum(double full_scale)
{
    double quantum = 1.0;
    while ((quantum * 1073741824.0) < full_scale) {
        quantum *= 2.0;
    }
    while ((quantum * 536870912.0) >= full_scale) {
        quantum *= 0.5;
    }
    return quantum;
}

/* NaN and inf stay outside: by their bits, which no flag of a compiler bends. */
static inline bool door_admits(float rate)
{
    return (davar_bits_of_float(rate) & UINT32_C(0x7F800000)) != UINT32_C(0x7F800000);
}

/* To the nearest quantum, halves away from zero. Exact: the scale is a power of two, so is the remainder. */
static inline int32_t door_counts(davar_t *davar, float rate)
{
    const float limit = (float)davar->config->full_scale;
    float inside = rate;
    if ((rate >= limit) || (rate <= -limit)) {
        davar_count(&davar->health.saturated);
        inside = (rate > 0.0F) ? limit : -limit;
    }
    const float scaled = inside * davar->counts_per_unit;
    const int32_t whole = (int32_t)scaled;
    const float rest = scaled - (float)whole;
    return whole + ((rest >= 0.5F) ? 1 : 0) - ((rest <= -0.5F) ? 1 : 0);
}

#endif
