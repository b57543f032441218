/* davar-sim - the table of the error model: CSV from `tools/davarlab export MODEL -o TABLE.csv`. */
#ifndef MODEL_TABLE_H
#define MODEL_TABLE_H

#include "common/sim_error.h"
#include "davar/monitor.h"

#define MODEL_TABLE_MAX 64U

typedef struct {
    davar_model_tau_t tau[MODEL_TABLE_MAX];
    uint8_t count; /* >= 1 */
} model_table_t;

/* Reads columns m, adev_dps, relative_tolerance. If there is a column tau_s, it must equal m /
 * rate_hz within 1 %. False: no such file, a missing column, an impossible value, a repeated
 * cluster size, no row, or more than MODEL_TABLE_MAX rows. The message names file, line and
 * column. */
bool model_table_read(model_table_t *table, const char *path, double rate_hz, sim_error_t *error);

#endif
