/* davar-sim - pacing on the monotonic clock. */
#include "replay/pace.h"

#include "common/sim_clock.h"

#include <math.h>
#include <time.h>

#define NAP_MAX_S 1.0
#define DUE_MAX 1e18

void pace_start(pace_t *pace, double rate_hz, double times_real_time)
{
    pace->samples_per_s = rate_hz * times_real_time;
    pace->start_s = sim_clock_s();
}

bool pace_is_unlimited(const pace_t *pace)
{
    return !(pace->samples_per_s > 0.0);
}

uint64_t pace_due(const pace_t *pace)
{
    if (pace_is_unlimited(pace)) {
        return UINT64_MAX;
    }
    return (uint64_t)fmin((sim_clock_s() - pace->start_s) * pace->samples_per_s, DUE_MAX);
}

void pace_wait(const pace_t *pace, uint64_t sample)
{
    if (pace_is_unlimited(pace)) {
        return;
    }
    const double due_s = pace->start_s + ((double)sample + 1.0) / pace->samples_per_s;
    const double until_s = fmin(due_s, sim_clock_s() + NAP_MAX_S);
    const double whole_s = floor(until_s);
    const struct timespec deadline = {.tv_sec = (time_t)whole_s,
                                      .tv_nsec = (long)(1e9 * (until_s - whole_s))};
    (void)clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, NULL);
}
