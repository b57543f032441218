/* davar-sim - one monitor per channel, which compares every result with the table of
 * --model-table. */
#ifndef WATCH_H
#define WATCH_H

#include "instances/engine.h"
#include "instances/model_table.h"
#include "options/options.h"

typedef struct {
    model_table_t table;
    davar_monitor_t *monitor; /* one per channel; null: no table */
    davar_misfit_t misfit;    /* of the newest result */
} watch_t;

/* Reads the table of --model-table and starts the monitors. Without --model-table it does nothing.
 * Do not move the watch afterwards. False: a bad table, no cluster size in common with the results,
 * or out of memory. */
bool watch_open(watch_t *watch, const options_t *options, const engine_t *engine,
                sim_error_t *error);

/* Compares the newest result of a channel with the table. Null without a table. Valid until the
 * next call. */
const davar_misfit_t *watch_compare(watch_t *watch, size_t channel, const davar_result_t *result);

/* Allowed if all zero. */
void watch_close(watch_t *watch);

#endif
