/* davar-sim - rows as JSON lines: one object per epoch with the names of the CSV columns; an absent value is null. */
#ifndef JSONL_OUT_H
#define JSONL_OUT_H

#include "fields.h"

#include <stdio.h>

/* Write errors show in ferror(file). */
void jsonl_out_row(FILE *file, const fields_t *fields, const char *channel, const epoch_row_t *row);

#endif
