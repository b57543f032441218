/* davar tests - the plan that davar-plan wrote, `ready`, equals the one that the library makes and
 * gives the same results. TAUS: cluster sizes. MAKE: makes the plan `made`. Prints how many of 1960
 * results are the same, and whether some are white. */
#include "davar/davar.h"
#include "davar/fit.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

extern davar_plan_t ready;
static const uint32_t taus[] = {TAUS};
#define COUNT (sizeof taus / sizeof taus[0])
int main(void)
{
    static davar_plan_t made;
    static davar_result_t a, b;
    uint32_t seed = 1U, same = 0U, white = 0U;
    MAKE;
    if (memcmp(&made, &ready, sizeof made) != 0) {
        return puts("another plan");
    }
    for (int i = 0; i < 2000; i++) {
        memset(&a, 0, sizeof a);
        a.tau_count = COUNT;
        a.window_samples = 200U + 10U * (i % 7);
        for (size_t t = 0; t < COUNT; t++) {
            seed = seed * 1664525U + 1013904223U;
            a.tau[t].m = taus[t];
            a.tau[t].differences = a.window_samples + 1U - 2U * taus[t];
            a.tau[t].adev = (1.0 + 0.1 * (seed >> 8) / 16777216.0) / sqrt(taus[t]);
        }
        memcpy(&b, &a, sizeof a);
        if (i % 50 == 49) { /* a window without a difference */
            b.tau[0].differences = 0U;
            (void)davar_fit_white_ready(&ready, 100.0, &b);
            if ((b.noise != DAVAR_NOISE_UNKNOWN) || !isnan(b.tau[0].low) ||
                b.coefficient[DAVAR_ANGLE_RANDOM_WALK].present) {
                return puts("something out of nothing");
            }
            continue;
        }
        (void)davar_fit_white(&made, 100.0, &a);
        (void)davar_fit_white_ready(&ready, 100.0, &b);
        same += (memcmp(&a, &b, sizeof a) == 0) ? 1U : 0U;
        white += (a.noise == DAVAR_NOISE_WHITE) ? 1U : 0U;
    }
    return printf("%u %s", same, (white > 0U) ? "some" : "none") < 0;
}
