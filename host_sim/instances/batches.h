/* davar-sim - sums of squared differences per channel, for intervals of Allan deviations in noise
 * that is neither white nor a power of tau: next to lines and in motion (5.25). */
#ifndef BATCHES_H
#define BATCHES_H

#include "instances/engine.h"

typedef struct batches_channel batches_channel_t;

typedef struct {
    const engine_t *engine; /* null: closed */
    batches_channel_t *channels;
    uint32_t step; /* samples of a sum */
} batches_t;

/* Only with --details and without law glr, whose windows exclude samples. `engine` must outlive
 * it. False: out of memory. */
bool batches_open(batches_t *batches, const options_t *options, const engine_t *engine,
                  sim_error_t *error);

/* Adds samples of all channels, after a gap if some are missing. Does nothing if closed. False: out of
 * memory. */
bool batches_push(batches_t *batches, const davar_port_samples_t *samples, size_t count,
                  bool is_gap, sim_error_t *error);

/* Computes the limits of the sizes of a window again where the fit's do not hold. Call it for every
 * result, in order: it also drops the sums before the window. */
void batches_apply(batches_t *batches, size_t channel, davar_result_t *result);

/* Allowed if all zero. */
void batches_close(batches_t *batches);

#endif
