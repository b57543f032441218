/* davar-node - hysteresis of the alarm. The alarm rises after on_s of unstable signal time and
 * falls after off_s of stable signal time. */
#ifndef ALARM_H
#define ALARM_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    uint64_t on_samples;
    uint64_t off_samples;
    uint64_t since; /* epoch of the last result that agreed with the level */
    bool high;
    bool started;
} alarm_level_t;

/* Processes one result and returns the current level. */
bool alarm_step(alarm_level_t *alarm, uint64_t epoch, bool unstable);

#endif
