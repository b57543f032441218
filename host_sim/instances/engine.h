/* davar-sim - one library instance per channel, all of one configuration. */
#ifndef ENGINE_H
#define ENGINE_H

#include "davar_node.h"
#include "instances/settings.h"
#include "recording/quantise.h"

typedef struct {
    davar_config_t config;
    davar_plan_t plan;
    davar_port_number_t number;
    size_t count;
    davar_t *instances;
    uint64_t *memory;
    davar_node_channel_t *channels;
} engine_t;

/* Allocates and starts `count` instances. A recording of 16-bit counts runs as q15 unless the library finds its windows
 * too large for that, then as q31 with the same results. `settings` must outlive the engine; do not move the engine.
 * False: refused by the library (the message names the option), or no memory. */
bool engine_start(engine_t *engine, const settings_t *settings, const quantisation_t *quantisation,
                  double rate_hz, size_t count, const options_t *options, sim_error_t *error);

/* The weather of one more channel: gaps and missing of one (they are the same in all), the rest summed. */
void engine_add_health(davar_health_t *sum, const davar_health_t *one);

/* The weather of all channels. */
davar_health_t engine_health(const engine_t *engine);

/* Allowed after a failed start. */
void engine_free(engine_t *engine);

#endif
