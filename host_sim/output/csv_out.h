/* davar-sim - CSV: a header row, then one row per epoch. An absent value is an empty field. */
#ifndef CSV_OUT_H
#define CSV_OUT_H

#include "output/fields.h"
#include "output/rows_out.h"

/* with_channel: a column `channel` comes first. */
void csv_out_header(rows_out_t *rows, const fields_t *fields, bool with_channel);

/* channel: null when the header has no such column. */
void csv_out_row(rows_out_t *rows, const fields_t *fields, const char *channel,
                 const epoch_row_t *row);

#endif
