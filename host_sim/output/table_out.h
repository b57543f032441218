/* davar-sim - a table for people: one line per epoch, with units. */
#ifndef TABLE_OUT_H
#define TABLE_OUT_H

#include "output/fields.h"
#include "output/rows_out.h"

/* Writes the names and units of the columns. */
void table_out_header(rows_out_t *rows, bool floored);

/* Writes one row. Without an angle random walk it has the upper limit, if there is one, and the
 * reason. */
void table_out_row(rows_out_t *rows, const char *channel, const epoch_row_t *row);

#endif
