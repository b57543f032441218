/* davar-sim - when a sample is due: as fast as it goes, or at a multiple of real time. */
#ifndef PACE_H
#define PACE_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    double samples_per_s; /* 0: everything is due at once */
    double start_s;       /* monotonic */
} pace_t;

/* Starts the clock. times_real_time: 0 for as fast as it goes. */
void pace_start(pace_t *pace, double rate_hz, double times_real_time);

bool pace_is_unlimited(const pace_t *pace);

/* Samples that have become due since the start. Sample i is due (i + 1) periods after it. */
uint64_t pace_due(const pace_t *pace);

/* Sleeps until sample i is due, but not longer than a second: ask pace_due again. Deadlines are absolute, so that
 * delays do not add up. */
void pace_wait(const pace_t *pace, uint64_t sample);

#endif
