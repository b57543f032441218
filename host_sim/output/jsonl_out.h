/* davar-sim - JSON lines: one object per epoch with the names of the CSV columns. An absent value
 * is null. */
#ifndef JSONL_OUT_H
#define JSONL_OUT_H

#include "output/fields.h"
#include "output/rows_out.h"

/* Writes one row. Every row names its channel. */
void jsonl_out_row(rows_out_t *rows, const fields_t *fields, const char *channel,
                   const epoch_row_t *row);

#endif
