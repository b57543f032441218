/* davar tests - the Allan deviations of a window by brute force. */
#ifndef DAVAR_TESTS_OBSERVED_H
#define DAVAR_TESTS_OBSERVED_H

#include "davar/types.h"

#include <math.h>

/* Fills adev of every tau of *result, which has m and differences. phase: room for window + 1. */
static inline void observe_window(const double samples[], uint32_t window, double phase[],
                                  davar_result_t *result)
{
    double mean = 0.0;
    for (uint32_t i = 0U; i < window; i++) {
        mean += samples[i] / window;
    }
    phase[0] = 0.0;
    for (uint32_t i = 0U; i < window; i++) {
        phase[i + 1U] = phase[i] + samples[i] - mean;
    }
    for (int t = 0; t < result->tau_count; t++) {
        const uint32_t m = result->tau[t].m;
        double sum = 0.0;
        for (uint32_t i = 0U; i + (2U * m) <= window; i++) {
            const double d = phase[i + (2U * m)] - (2.0 * phase[i + m]) + phase[i];
            sum += d * d;
        }
        result->tau[t].adev = sqrt(sum / (2.0 * m * m * result->tau[t].differences));
    }
}

#endif
