/* davar-sim - one library instance per channel. Their configurations differ only in what follows
 * from the filter. */
#ifndef ENGINE_H
#define ENGINE_H

#include "centred/centred.h"
#include "davar/fit.h"
#include "davar_curve.h"
#include "davar_node.h"
#include "instances/settings.h"
#include "learning/learn.h"
#include "recording/quantise.h"
#include "recording/timing.h"

/* What follows from the filter of a channel. */
typedef struct {
    davar_config_t config;
    davar_plan_t plan;
} filtered_t;

typedef struct {
    davar_config_t config; /* of channel 0 */
    davar_curve_t curve;   /* the cluster sizes of every result */
    filtered_t *filtered;  /* one per channel */
    davar_filter_t filter;
    const davar_filter_t *declared; /* the filter of channel 0, or null: unknown */
    const davar_filter_t **filters; /* one per channel; null: unknown */
    davar_port_number_t number;
    size_t count;
    davar_t *instances;        /* trailing windows */
    centred_t **centred;       /* centred windows: one per channel instead; null: trailing */
    davar_cascade_t *cascades; /* started if the curve has one */
    uint64_t *memory;
    davar_node_channel_t *channels;
} engine_t;

/* Allocates and starts `count` instances. A recording of 16-bit counts runs as q15. If its windows
 * are too large for q15, it runs as q31 with the same results. `settings` must outlive the engine;
 * do not move the engine. `learned`: the filter of each channel for --bandwidth auto, otherwise not
 * read; it must outlive the engine too. False: the library rejects the configuration (the message
 * names the option), or out of memory. */
bool engine_start(engine_t *engine, const settings_t *settings, const quantisation_t *quantisation,
                  const timing_t *timing, size_t count, const learned_t *learned,
                  const options_t *options, sim_error_t *error);

/* Reports `missing` lost samples to channel c, and its cascade. */
void engine_gap(const engine_t *engine, size_t c, uint32_t missing);

/* Adds the counters of one more channel. Gaps and missing samples are the same in all channels and
 * are not summed. */
void engine_add_health(davar_health_t *sum, const davar_health_t *one);

/* Input faults and missed results of one channel. */
davar_health_t engine_health_of(const engine_t *engine, size_t channel);

/* The same of all channels. */
davar_health_t engine_health(const engine_t *engine);

/* Allowed after a failed start. */
void engine_free(engine_t *engine);

#endif
