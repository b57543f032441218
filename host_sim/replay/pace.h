/* davar-sim - when a sample is due: immediately, or at a multiple of real time. */
#ifndef PACE_H
#define PACE_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
    double samples_per_s; /* 0: all samples are due immediately */
    double start_s;       /* monotonic */
} pace_t;

/* Starts the clock. times_real_time: 0 for as fast as possible. */
void pace_start(pace_t *pace, double rate_hz, double times_real_time);

bool pace_is_unlimited(const pace_t *pace);

/* Samples that have become due since the start. Sample i is due (i + 1) periods after it. */
uint64_t pace_due(const pace_t *pace);

/* Sleeps until sample i is due, but at most one second: call pace_due again. Deadlines are
 * absolute, so delays do not add up. */
void pace_wait(const pace_t *pace, uint64_t sample);

#endif
