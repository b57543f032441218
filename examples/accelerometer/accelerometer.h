/* Velocity random walk of an accelerometer's three axes: see accelerometer.c. */
#ifndef ACCELEROMETER_H
#define ACCELEROMETER_H

#include "davar/davar.h"

/* Before the interrupt is enabled. DAVAR_OK, or why not (davar_status_text). */
davar_status_t accelerometer_start(void);

/* From the data-ready interrupt: one sample of each axis, counts. */
void accelerometer_sample(int16_t x, int16_t y, int16_t z);

/* Samples that were missed since the last one. */
void accelerometer_lost(uint32_t samples);

/* From the main loop, until it says -1: the next new value, m/s/sqrt(h) with its 95 % limits; returns the axis, 0 to 2. */
int accelerometer_noise(davar_coefficient_t *velocity_random_walk);

#endif
