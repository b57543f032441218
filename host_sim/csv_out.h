/* davar-sim - rows as CSV: a header row, then one row per epoch; an absent value is an empty field. */
#ifndef CSV_OUT_H
#define CSV_OUT_H

#include "fields.h"

#include <stdio.h>

/* with_channel: a column `channel` comes first. */
void csv_out_header(FILE *file, const fields_t *fields, bool with_channel);

/* channel: null when the header has no such column. Write errors show in ferror(file). */
void csv_out_row(FILE *file, const fields_t *fields, const char *channel, const epoch_row_t *row);

#endif
