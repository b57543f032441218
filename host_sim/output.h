/* davar-sim - where results go: a stream in one of the formats. */
#ifndef OUTPUT_H
#define OUTPUT_H

#include "fields.h"
#include "options.h"
#include "selection.h"

#include <stdio.h>

typedef struct {
    FILE *file;
    out_t format;
    fields_t fields;
    const selection_t *selection;
    bool flush_rows; /* somebody watches */
    uint64_t rows;   /* written so far */
} output_t;

void output_open(output_t *output, FILE *file, const options_t *options, const davar_config_t *config,
                 const selection_t *selection);

/* Writes one row, before the first one the header. False: the stream takes no more. */
bool output_row(output_t *output, size_t channel, const epoch_row_t *row, sim_error_t *error);

/* Flushes. False: the stream did not take everything. */
bool output_finish(output_t *output, sim_error_t *error);

#endif
