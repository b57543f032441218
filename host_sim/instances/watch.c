/* davar-sim - monitors. */
#include "instances/watch.h"

#include <stdlib.h>

static bool has_tau(const model_table_t *table, const davar_curve_t *curve)
{
    for (uint8_t i = 0; i < table->count; i++) {
        for (uint8_t t = 0; t < curve->tau_count; t++) {
            if (table->tau[i].m == curve->taus[t]) {
                return true;
            }
        }
    }
    return false;
}

bool watch_open(watch_t *watch, const options_t *options, const engine_t *engine,
                sim_error_t *error)
{
    if (options->model_table == NULL) {
        return true;
    }
    if (!model_table_read(&watch->table, options->model_table, engine->config.rate_hz, error)) {
        return false;
    }
    if (!has_tau(&watch->table, &engine->curve)) {
        return sim_fail(
            error,
            "--model-table: %s: it has no cluster size in common with --taus or --longest-tau",
            options->model_table);
    }
    watch->monitor = calloc(engine->count, sizeof *watch->monitor);
    if (watch->monitor == NULL) {
        return sim_fail(error, "out of memory");
    }
    for (size_t c = 0; c < engine->count; c++) {
        if (davar_monitor_init(&watch->monitor[c], watch->table.tau, watch->table.count,
                               DAVAR_MONITOR_MEMORY) != DAVAR_MONITOR_OK) {
            return sim_fail(error, "--model-table: %s: not a valid table for the monitor",
                            options->model_table);
        }
    }
    return true;
}

const davar_misfit_t *watch_compare(watch_t *watch, size_t channel, const davar_result_t *result)
{
    if (watch->monitor == NULL) {
        return NULL;
    }
    davar_monitor_update(&watch->monitor[channel], result, &watch->misfit);
    return &watch->misfit;
}

void watch_close(watch_t *watch)
{
    free(watch->monitor);
    *watch = (watch_t){0};
}
