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

static bool count_gaps(timing_t *timing, const recording_t *recording, sim_error_t *error)
{
    double time_s[CHUNK];
    for (uint64_t first = 0; first + 1U < recording->rows; first += CHUNK - 1U) {
        const uint64_t left = recording->rows - first;
        const size_t count = (left < CHUNK) ? (size_t)left : CHUNK;
        if (!spool_read(&recording->times, first, count, time_s, error)) {
            return false;
        }
        for (size_t i = 1; i < count; i++) {
            timing->gaps += (timing_missing(timing, time_s[i] - time_s[i - 1U]) > 0U) ? 1U : 0U;
        }
    }
    return true;
}

bool timing_find(timing_t *timing, const recording_t *recording, const options_t *options,
                 sim_error_t *error)
{
    const bool given = (options->rate_hz > 0.0);
    *timing = (timing_t){.rate_hz = options->rate_hz, .steps = recording->rows - 1U};
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
    return !look || count_gaps(timing, recording, error);
}

uint32_t timing_missing(const timing_t *timing, double step_s)
{
    if (step_s <= timing->gap_limit_s) {
        return 0U;
    }
    const double missing = round(step_s / timing->period_s) - 1.0;
    if (missing < 1.0) {
        return 1U;
    }
    return (missing < (double)UINT32_MAX) ? (uint32_t)missing : UINT32_MAX;
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
