/* davar-sim - intervals of Allan deviations in any stationary noise, by batch means (5.25). Those of
 * the fit hold for white noise and for powers of tau; next to lines and in motion they are too narrow. */
#ifndef BATCHES_H
#define BATCHES_H

#include "instances/engine.h"

#define BATCHES_STEPS 64U /* of a window at least, where it can be cut */

/* Of the differences up to a sample. */
typedef struct {
    double squares;
    double count;
} batch_sums_t;

/* Computes the limits of a size anew, from eight batches of its differences. sums: after each
 * `step` samples, `stride` apart, from the first difference to number `steps`. clusters: samples of
 * the window over m. Leaves the limits if there are too few steps, or a batch would be shorter than
 * m. */
void batches_limits(const batch_sums_t *sums, size_t stride, uint64_t steps, uint64_t step,
                    double clusters, davar_adev_t *tau);

typedef struct batches_channel batches_channel_t;

typedef struct {
    const engine_t *engine; /* null: no --details */
    batches_channel_t *channels;
    bool is_centred;
} batches_t;

/* Does nothing without --details. `engine` must outlive it. False: out of memory. */
bool batches_open(batches_t *batches, const options_t *options, const engine_t *engine,
                  sim_error_t *error);

/* Adds samples of all channels, after a gap if some are missing. False: out of memory. */
bool batches_push(batches_t *batches, const davar_port_samples_t *samples, size_t count,
                  bool is_gap, sim_error_t *error);

/* Replaces the limits of the sizes of a window, unless its noise is white, or a size has too few
 * differences for eight batches. Epochs do not go back. */
void batches_apply(batches_t *batches, size_t channel, davar_result_t *result);

/* Allowed if all zero. */
void batches_close(batches_t *batches);

#endif
