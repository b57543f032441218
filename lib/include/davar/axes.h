/* davar - three axes of one sensor: three instances that are begun, pushed and taken together.
 * A convenience over davar.h, linked only where it is called. */
#ifndef DAVAR_AXES_H
#define DAVAR_AXES_H

#include "davar/davar.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DAVAR_AXES 3U

typedef struct {
    davar_t axis[DAVAR_AXES]; /* x, y, z: whatever davar.h offers goes for each */
} davar_axes_t;

/* davar_init_* for each axis with one configuration. `memory` holds three times davar_memory_size_* (DAVAR_MEMORY_*, each rounded
 * up to 8). Returns the first refusal; then none of the axes may be used. */
davar_status_t davar_axes_init_q15(davar_axes_t *axes, const davar_config_t *config, void *memory, size_t bytes);
davar_status_t davar_axes_init_q31(davar_axes_t *axes, const davar_config_t *config, void *memory, size_t bytes);
davar_status_t davar_axes_init_f32(davar_axes_t *axes, const davar_config_t *config, void *memory, size_t bytes);

/* One sample of each axis. Cost, refusal and interrupts: as three of davar_push_*. */
void davar_axes_push_q15(davar_axes_t *axes, int16_t x, int16_t y, int16_t z);
void davar_axes_push_q31(davar_axes_t *axes, int32_t x, int32_t y, int32_t z);
void davar_axes_push_f32(davar_axes_t *axes, float x, float y, float z);

/* davar_gap for each axis. */
void davar_axes_gap(davar_axes_t *axes, uint32_t missing);

/* Takes the result of the first axis, x before y before z, that has one waiting: 0, 1 or 2; -1: none has. Call it until then. */
#define davar_axes_take DAVAR_SIZED(davar_axes_take)
int davar_axes_take(davar_axes_t *axes, davar_result_t *result);

#ifdef __cplusplus
}
#endif

#endif
