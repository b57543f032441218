/* Velocity random walk of the three axes of an accelerometer: see accelerometer.c. */
#ifndef ACCELEROMETER_H
#define ACCELEROMETER_H

#include "davar/davar.h"

/* Call it before the interrupt is enabled. Returns DAVAR_OK, or the cause (davar_status_text). */
davar_status_t accelerometer_start(void);

/* Call it from the data-ready interrupt: one sample of each axis, in counts. */
void accelerometer_sample(int16_t x, int16_t y, int16_t z);

/* Reports lost samples since the last sample. */
void accelerometer_lost(uint32_t samples);

/* Call it from the main loop until it returns -1. Writes the next new value, m/s/sqrt(h) with its
 * 95 % limits, and returns the axis, 0 to 2. */
int accelerometer_noise(davar_coefficient_t *velocity_random_walk);

#endif
