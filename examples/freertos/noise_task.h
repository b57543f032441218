/* davar under FreeRTOS: see noise_task.c. */
#ifndef NOISE_TASK_H
#define NOISE_TASK_H

#include "davar/davar.h"

/* Call it before the scheduler: creates the queue and the task. Returns DAVAR_OK, or the cause. */
davar_status_t noise_start(void);

/* Call it from the data-ready interrupt, once per sample. */
void noise_sample(int16_t count);

/* Blocks lost because the queue was full. */
uint32_t noise_blocks_lost(void);

/* Provided by you; runs in the task. ARW is result->coefficient[DAVAR_ANGLE_RANDOM_WALK],
 * deg/sqrt(h); value NaN: not resolved. */
void noise_report(const davar_result_t *result);

#endif
