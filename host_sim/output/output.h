/* davar-sim - where results go: a stream in one of the formats, or frames on a link. */
#ifndef OUTPUT_H
#define OUTPUT_H

#include "instances/watch.h"
#include "options/options.h"
#include "output/fields.h"
#include "output/rows_out.h"
#include "output/wire_out.h"
#include "recording/selection.h"

typedef struct {
    rows_out_t text; /* of the formats that are text */
    out_t format;
    fields_t fields;
    const selection_t *selection;
    bool raw;        /* samples go out too */
    bool flush_rows; /* somebody watches */
    uint64_t rows;   /* written so far */
    uint64_t coarse; /* of these: noise below half a count */
    watch_t watch;   /* of --model-table */
    wire_out_t wire; /* of OUT_LINK */
} output_t;

/* All of it belongs to the caller and must outlive the output. False: a bad --model-table, or the
 * link of --out cannot be opened. */
bool output_open(output_t *output, const options_t *options, const engine_t *engine,
                 const selection_t *selection, sim_error_t *error);

/* Writes one row, before the first one the header; `misfit` of the row is filled in here. False: the stream takes no more,
 * or a signal asks to stop. */
bool output_row(output_t *output, size_t channel, const epoch_row_t *plain, sim_error_t *error);

/* Passes samples on to the link, where --raw asks for them; call it before they are pushed. False: the link is lost. */
bool output_raw(output_t *output, const raw_run_t *run, sim_error_t *error);

/* Flushes. False: the stream did not take everything. */
bool output_finish(output_t *output, sim_error_t *error);

/* Allowed on one that is all zero. */
void output_close(output_t *output);

#endif
