/* davar-sim - the monotonic clock. */
#include "common/sim_clock.h"

#include <time.h>

double sim_clock_s(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
