/* davar-sim - one monitor per channel: every result against the table of --model-table. */
#ifndef WATCH_H
#define WATCH_H

#include "instances/engine.h"
#include "instances/model_table.h"
#include "options/options.h"

typedef struct {
    model_table_t table;
    davar_monitor_t *monitor; /* one per channel; null: no table was given */
    davar_misfit_t misfit;    /* of the newest result */
} watch_t;

/* Reads the table of --model-table and starts the monitors; nothing to do without one. Do not move the watch afterwards.
 * False: a bad table, no cluster size that the results have too, or no memory. */
bool watch_open(watch_t *watch, const options_t *options, const engine_t *engine,
                sim_error_t *error);

/* The newest result of a channel against the table; null without one. Valid until the next call. */
const davar_misfit_t *watch_look(watch_t *watch, size_t channel, const davar_result_t *result);

/* Allowed on one that is all zero. */
void watch_close(watch_t *watch);

#endif
