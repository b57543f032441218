/* davar tests - how often the intervals of davar_fit hold the truth, by Monte Carlo over independent windows. */
#ifndef DAVAR_TESTS_COVERAGE_H
#define DAVAR_TESTS_COVERAGE_H

#include "davar/types.h"
#include "gyro_noise.h"

typedef struct {
    const char *name;
    gyro_noise_t noise;
    uint32_t window;
    uint32_t taus[DAVAR_TAUS_MAX];
    uint8_t tau_count;
} scenario_t;

typedef struct {
    double adev[DAVAR_TAUS_MAX];                 /* share of windows whose interval holds the true ADEV */
    double coefficient[DAVAR_COEFFICIENT_COUNT]; /* share whose statement (interval, or upper bound) holds the truth */
    double present[DAVAR_COEFFICIENT_COUNT];     /* share that reports the term */
    double extra;                                /* share that reports any term that is not there */
    double arw_ratio;                            /* median of high / low, an honest interval must not be a wide one */
} coverage_t;

void coverage_run(const scenario_t *scenario, unsigned windows, uint64_t seed, coverage_t *coverage);
void coverage_print(const scenario_t *scenario, unsigned windows, const coverage_t *coverage);

#endif
