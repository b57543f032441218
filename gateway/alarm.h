/* davar-node - hysteresis of the alarm: rises after unstable for on_s, falls after stable for off_s of signal time. */
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

/* Takes one result; returns the level now. */
bool alarm_step(alarm_level_t *alarm, uint64_t epoch, bool unstable);

#endif
