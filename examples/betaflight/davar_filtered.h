/* The gyro after Betaflight's filters: see davar_filtered.c. */
#ifndef DAVAR_FILTERED_H
#define DAVAR_FILTERED_H

#include "davar_gyro.h"

#include "davar/davar.h"

#ifdef DAVAR_GYRO_FILTERED /* a build option */
void davar_filtered_sample(void);
void davar_filtered_start(void);
void davar_filtered_push(void);
/* Replaces *noise if the axis has a new result. */
void davar_filtered_take(uint8_t axis, davar_gyro_noise_t *noise);
#else
static inline void davar_filtered_sample(void) {}
static inline void davar_filtered_start(void) {}
static inline void davar_filtered_push(void) {}
static inline void davar_filtered_take(uint8_t axis, davar_gyro_noise_t *noise)
{
    (void)axis;
    (void)noise;
}
#endif

/* The angle random walk of a result, multiplied by `scale`. */
davar_gyro_noise_t davar_gyro_noise(const davar_result_t *result, float scale);

#endif
