/* davar-sim - sends results as frames (addons/can/DESIGN.md), or in a dialect (docs/DIALECTS.md),
 * through the link contract. */
#ifndef WIRE_OUT_H
#define WIRE_OUT_H

#include "davar_link.h"
#include "instances/engine.h"
#include "options/options.h"
#include "output/fields.h"

typedef struct {
    davar_link_t *link;
    const engine_t *engine;
    davar_encoder_t *encoder;     /* one per channel, of davar's own frames */
    davar_telemetry_t *telemetry; /* or of a dialect; otherwise null */
    davar_can_health_t health;
} wire_out_t;

/* Samples of all channels without a loss between them: samples[c] points to `count` samples of
 * channel c. */
typedef struct {
    const davar_port_samples_t *samples;
    davar_port_number_t number;
    uint64_t first; /* index of the first sample; lost samples are counted */
    size_t count;
} raw_run_t;

/* Opens the link of --out. With a pty it prints the name of the pty on standard error. */
bool wire_out_open(wire_out_t *wire, const options_t *options, const engine_t *engine,
                   sim_error_t *error);

/* Sends the frames of one result, and of the monitor if the row has a misfit. Waits while there is
 * no room. False: the link is lost. */
bool wire_out_result(wire_out_t *wire, size_t channel, const epoch_row_t *row, sim_error_t *error);

/* Sends unchanged samples (--raw). Waits while there is no room. False: the link is lost. */
bool wire_out_raw(wire_out_t *wire, const raw_run_t *run, sim_error_t *error);

/* Sends every health counter once more. */
bool wire_out_finish(wire_out_t *wire, sim_error_t *error);

/* Allowed if all zero, and after a failed open. */
void wire_out_close(wire_out_t *wire);

#endif
