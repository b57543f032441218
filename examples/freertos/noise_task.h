/* davar under FreeRTOS: see noise_task.c. */
#ifndef NOISE_TASK_H
#define NOISE_TASK_H

#include "davar/davar.h"

/* Before the scheduler: makes the queue and the task. DAVAR_OK, or why davar refused. */
davar_status_t noise_start(void);

/* From the data-ready interrupt, one sample each. */
void noise_sample(int16_t count);

/* Blocks that found the queue full. */
uint32_t noise_blocks_lost(void);

/* Yours, in the task: ARW is result->coefficient[DAVAR_ANGLE_RANDOM_WALK], deg/sqrt(h); value NaN: not resolved. */
void noise_report(const davar_result_t *result);

#endif
