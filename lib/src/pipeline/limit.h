/* davar - samples at or beyond what their bits hold: clamped, and counted. */
#ifndef DAVAR_SRC_LIMIT_H
#define DAVAR_SRC_LIMIT_H

#include "pipeline/pipelines.h"

static inline sample_t limited(sample_t highest, davar_t *davar, sample_t sample)
{
    const uint32_t half = (uint32_t)highest;
    if (((uint32_t)sample + half) < (2U * half)) { /* -highest .. highest - 1 */
        return sample;
    }
    davar_count(&davar->health.saturated);
    return (sample < 0) ? (sample_t)(-highest - 1) : highest;
}

#endif
