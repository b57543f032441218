/* davar-node - alarm. */
#include "alarm.h"

bool alarm_step(alarm_level_t *alarm, uint64_t epoch, bool unstable)
{
    if (!alarm->started || (unstable == alarm->high)) {
        alarm->since = epoch;
        alarm->started = true;
    }
    const uint64_t needed = alarm->high ? alarm->off_samples : alarm->on_samples;
    if ((unstable != alarm->high) && (epoch - alarm->since >= needed)) {
        alarm->high = unstable;
        alarm->since = epoch;
    }
    return alarm->high;
}
