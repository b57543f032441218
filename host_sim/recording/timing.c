/* davar-sim - rate and gaps. */
#include "recording/timing.h"

#include "recording/median.h"

#include <math.h>

#define GAP_FACTOR_DEFAULT 1.5
#define CHUNK 4096U
#define DOUBTFUL_RATE 0.20
#define DOUBTFUL_GAPS 0.05

/* Rows divided by time; 0 if no time passes. */
static bool mean_rate(double *rate_hz, const recording_t *recording, sim_error_t *error)
{
    double first_s = 0.0;
    double last_s = 0.0;
    if (!spool_read(&recording->times, 0U, 1U, &first_s, error) ||
        !spool_read(&recording->times, recording->rows - 1U, 1U, &last_s, error)) {
        return false;
    }
    *rate_hz = (last_s > first_s) ? ((double)(recording->rows - 1U) / (last_s - first_s)) : 0.0;
    return true;
}

static bool rate_from_stamps(timing_t *timing, const recording_t *recording,
                             const options_t *options, sim_error_t *error)
{
    if (recording->rows < 2U) {
        return sim_fail(error, "%s: only one row: too short to determine the sample rate",
                        options->recording);
    }
    if (!median_step(&recording->times, &timing->period_s, error) ||
        !mean_rate(&timing->mean_rate_hz, recording, error)) {
        return false;
    }
    if (!(timing->period_s > 0.0) || !isfinite(1.0 / timing->period_s)) {
        return sim_fail(error,
                        "%s: column time_s: the median time step is 0, so the sample rate is "
                        "unknown; give --rate",
                        options->recording);
    }
    timing->rate_hz = 1.0 / timing->period_s;
    return true;
}

/* The number of samples missing in a step of step_s seconds; 0 if the step is not a gap. */
static double missing_in(const timing_t *timing, double step_s)
{
    if (step_s <= timing->gap_limit_s) {
        return 0.0;
    }
    return fmin(fmax(round(step_s / timing->period_s) - 1.0, 1.0), UINT32_MAX);
}

/* Counts the gaps, and stores the missing samples of each row unless `missing` is null. The first
 * row has no time stamp before it. */
static bool walk_steps(uint64_t *gaps, spool_t *missing, const timing_t *timing,
                       const recording_t *recording, sim_error_t *error)
{
    double time_s[CHUNK];
    double newest_s = (double)INFINITY;
    *gaps = 0;
    for (uint64_t first = 0; first < recording->rows; first += CHUNK) {
        const uint64_t left = recording->rows - first;
        const size_t count = (left < CHUNK) ? (size_t)left : CHUNK;
        if (!spool_read(&recording->times, first, count, time_s, error)) {
            return false;
        }
        for (size_t i = 0; i < count; i++) {
            const double lost = missing_in(timing, time_s[i] - newest_s);
            newest_s = time_s[i];
            *gaps += (lost > 0.0) ? 1U : 0U;
            if ((missing != NULL) && !spool_put(missing, &lost, error)) {
                return false;
            }
        }
    }
    return true;
}

static bool find_gaps(timing_t *timing, const recording_t *recording, sim_error_t *error)
{
    return walk_steps(&timing->gaps, NULL, timing, recording, error) &&
           ((timing->gaps == 0U) ||
            (spool_open(&timing->missing, 1U, error) &&
             walk_steps(&timing->breaks, &timing->missing, timing, recording, error) &&
             spool_flush(&timing->missing, error)));
}

bool timing_find(timing_t *timing, const recording_t *recording, const options_t *options,
                 sim_error_t *error)
{
    const bool given = (options->setup.rate_hz > 0.0);
    *timing = (timing_t){.rate_hz = options->setup.rate_hz, .steps = recording->rows - 1U};
    if (!given && !rate_from_stamps(timing, recording, options, error)) {
        return false;
    }
    if (given && recording->has_time && !mean_rate(&timing->stamped_hz, recording, error)) {
        return false;
    }
    timing->period_s = 1.0 / timing->rate_hz;
    const double factor = (options->gap_factor > 0.0) ? options->gap_factor : GAP_FACTOR_DEFAULT;
    const bool look = recording->has_time && (!given || (options->gap_factor > 0.0));
    timing->gap_limit_s = look ? factor * timing->period_s : HUGE_VAL;
    return !look || find_gaps(timing, recording, error);
}

bool timing_missing(const timing_t *timing, uint64_t first, size_t count, double *missing,
                    sim_error_t *error)
{
    if (timing->breaks > 0U) {
        return spool_read(&timing->missing, first, count, missing, error);
    }
    for (size_t i = 0; i < count; i++) {
        missing[i] = 0.0;
    }
    return true;
}

bool timing_is_contradicted(const timing_t *timing)
{
    return (timing->stamped_hz > 0.0) &&
           (fabs(timing->stamped_hz - timing->rate_hz) > DOUBTFUL_RATE * timing->rate_hz);
}

bool timing_is_doubtful(const timing_t *timing)
{
    const bool rates_differ =
        (timing->mean_rate_hz > 0.0) &&
        (fabs(timing->mean_rate_hz - timing->rate_hz) > DOUBTFUL_RATE * timing->rate_hz);
    return rates_differ || ((double)timing->gaps > DOUBTFUL_GAPS * (double)timing->steps);
}

void timing_close(timing_t *timing)
{
    spool_close(&timing->missing);
}
