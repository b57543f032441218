/* davar-sim - writes results as text in one of the formats, or as frames on a link. */
#ifndef OUTPUT_H
#define OUTPUT_H

#include "instances/batches.h"
#include "instances/floors.h"
#include "instances/watch.h"
#include "options/options.h"
#include "output/fields.h"
#include "output/rows_out.h"
#include "output/wire_out.h"
#include "recording/selection.h"

typedef struct {
    rows_out_t text; /* for the text formats */
    out_t format;
    fields_t fields;
    const selection_t *selection;
    bool raw;          /* send the samples too */
    bool flush_rows;   /* write each row immediately */
    uint64_t rows;     /* written so far */
    uint64_t coarse;   /* rows whose noise is below half a count */
    uint64_t filtered; /* rows withheld because the short cluster sizes read low */
    uint8_t reached;   /* cluster sizes that had a difference in some row */
    watch_t watch;     /* for --model-table */
    floors_t floors;   /* for --floor */
    batches_t batches; /* for --details */
    wire_out_t wire;   /* for OUT_LINK */
} output_t;

/* All arguments belong to the caller and must outlive the output. False: a bad --model-table, or
 * the link of --out cannot be opened. */
bool output_open(output_t *output, const options_t *options, const engine_t *engine,
                 const selection_t *selection, sim_error_t *error);

/* Writes one row, and the header before the first one. Fills in `misfit` of the row. False: the
 * stream accepts no more data, or a signal has arrived. */
bool output_row(output_t *output, size_t channel, const epoch_row_t *plain, sim_error_t *error);

/* Samples of all channels, after a gap if some are missing: sends them to the link if --raw is
 * given, and adds them to the floors. Call it before they are pushed. False: the link is lost, or
 * out of memory. */
bool output_samples(output_t *output, const raw_run_t *run, bool is_gap, sim_error_t *error);

/* Flushes. False: the stream did not accept everything. */
bool output_finish(output_t *output, sim_error_t *error);

/* Allowed if all zero. */
void output_close(output_t *output);

#endif
