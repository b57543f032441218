/** @file
 * davar - kalman: from the noise that davar measures to the numbers that a filter takes, in SI.
 *
 * ```
 * ARW -> davar_rate_density -> davar_rate_variance     covariance of one sample
 *                           -> davar_process_variance  Q of the angle, for each step
 * RRW -> davar_walk_density -> davar_process_variance  Q of the bias
 * ```
 *
 * docs/KALMAN.md derives each number. NaN in, NaN out. Threads: any. No state, no memory. */
#ifndef DAVAR_KALMAN_H
#define DAVAR_KALMAN_H

#include "davar/types.h"

#include <math.h>

#define DAVAR_DEG 0.017453292519943295 /**< rad */

/** Unit of the rate: of the samples times unit_per_count. Results have it too: float samples in rad/s
 * give an ARW in rad/sqrt(h). */
typedef enum { DAVAR_DEG_PER_S = 0, DAVAR_RAD_PER_S = 1 } davar_rate_unit_t;

/** @return The ARW to use after a result: its value; without one that before, but no more than its
 * upper limit. arw_before: the return value before, at first that of the data sheet, in the
 * unit of the result. */
static inline double davar_arw_to_use(const davar_result_t *result, double arw_before)
{
    const davar_coefficient_t *const arw = &result->coefficient[DAVAR_ANGLE_RANDOM_WALK];
    const double most = (arw->high < arw_before) ? arw->high : arw_before;
    return arw->present ? arw->value : most;
}

/** @return Density of white noise, rad/s/sqrt(Hz), two-sided (that of a data sheet is one-sided,
 * sqrt(2) times as large). arw: of davar_fit or davar_floor_take, or a limit of it; `unit` times
 * s/sqrt(h), as in deg/sqrt(h). */
static inline double davar_rate_density(double arw, davar_rate_unit_t unit)
{
    return arw * ((unit == DAVAR_DEG_PER_S) ? DAVAR_DEG : 1.0) / 60.0;
}

/** @return Density of the rate random walk, rad/s^2/sqrt(Hz). rrw: `unit` times s/h/sqrt(h), as in
 * deg/h/sqrt(h). */
static inline double davar_walk_density(double rrw, davar_rate_unit_t unit)
{
    return davar_rate_density(rrw, unit) / 3600.0;
}

/** @return Variance of the white noise of a sample, (rad/s)^2. rate_hz: of the samples as the filter
 * uses them, each the mean over its period; NaN unless positive. */
static inline double davar_rate_variance(double density, double rate_hz)
{
    return (rate_hz > 0.0) ? (density * density * rate_hz) : (double)NAN;
}

/** @return What a step adds to a variance: rad^2 of the angle by davar_rate_density, (rad/s)^2 of
 * the bias by davar_walk_density. seconds: of the step, 0 or more; otherwise NaN. */
static inline double davar_process_variance(double density, double seconds)
{
    return (seconds >= 0.0) ? (density * density * seconds) : (double)NAN;
}

#endif
