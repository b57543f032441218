/* davar-sim - batch limits. */
#include "common/batch_limits.h"

#include <math.h>

#define BATCHES ((uint64_t)8U)
#define NORMAL_95 1.96
#define STUDENT_95 2.365 /* of seven degrees of freedom */
#define CUBE_LEAST 1e-4  /* so that a limit is at most 100 times the deviation */
#define EDF_LEAST 0.8    /* below it, Wilson and Hilferty's limits no longer widen */

bool batch_limits_apply(const davar_result_t *result)
{
    return (result->noise == DAVAR_NOISE_MIXED) || (result->noise == DAVAR_NOISE_FILTERED) ||
           ((result->noise == DAVAR_NOISE_WHITE) && (result->flat_from > 0U));
}

/* Relative variance of the mean of batches, with the covariance of neighbours. */
static double relative_variance(const double mean_of[BATCHES], double mean)
{
    double own = 0.0;
    double next = 0.0;
    for (uint32_t b = 0; b < BATCHES; b++) {
        const double off = mean_of[b] / mean - 1.0;
        own += off * off;
        next += (b > 0U) ? (off * (mean_of[b - 1U] / mean - 1.0)) : 0.0;
    }
    return (own + ((next > 0.0) ? (2.0 * next) : 0.0)) / ((BATCHES - 1.0) * BATCHES);
}

/* Wilson and Hilferty. */
static double limit_of(double variance, double spread, double sigmas)
{
    const double third = 1.0 - spread + sigmas * sqrt(spread);
    return sqrt(variance / fmax(third * third * third, CUBE_LEAST));
}

/* The mean of batch b, or NaN if gaps take half of it. */
static double mean_of_batch(const batch_sums_t *sums, size_t stride, uint64_t steps, uint64_t step,
                            uint64_t b)
{
    batch_sums_t all = {0.0, 0.0};
    const uint64_t begin = b * steps / BATCHES;
    const uint64_t end = (b + 1U) * steps / BATCHES;
    for (uint64_t i = begin; i < end; i++) {
        all.squares += sums[i * stride].squares;
        all.count += sums[i * stride].count;
    }
    const uint64_t whole = (end - begin) * step;
    return (2.0 * all.count >= (double)whole) ? (all.squares / all.count) : (double)NAN;
}

void batch_limits(const batch_sums_t *sums, size_t stride, uint64_t steps, uint64_t step,
                  double clusters, davar_adev_t *tau)
{
    double mean_of[BATCHES];
    double mean = 0.0;
    if ((steps < 2U * BATCHES) || (steps * step < BATCHES * tau->m)) {
        return;
    }
    for (uint64_t b = 0; b < BATCHES; b++) {
        mean_of[b] = mean_of_batch(sums, stride, steps, step, b);
        mean += mean_of[b] / BATCHES;
    }
    if (!(mean > 0.0)) { /* NaN too */
        return;
    }
    const double variance = fmax(relative_variance(mean_of, mean), 1.0 / clusters);
    const double wider = STUDENT_95 / NORMAL_95;
    const double edf = fmax(2.0 / (variance * wider * wider), EDF_LEAST);
    const double spread = 2.0 / (9.0 * edf);
    tau->edf = edf;
    tau->low = limit_of(tau->adev * tau->adev, spread, NORMAL_95);
    tau->high = limit_of(tau->adev * tau->adev, spread, -NORMAL_95);
}
