/* davar-sim - pass 1: reads, checks and spools the complete recording. */
#ifndef RECORDING_H
#define RECORDING_H

#include "common/spool.h"
#include "recording/header.h"
#include "recording/progress.h"
#include "recording/quantise.h"
#include "recording/selection.h"

typedef struct {
    header_t header;
    selection_t selection;
    spool_t samples; /* one record per row: an admitted number (quantise.h) per channel */
    spool_t times;   /* one time stamp per row, seconds; unused without time_s */
    bool has_time;
    uint64_t rows;
    extent_t extent; /* over all channels */
} recording_t;

/* Reads and checks every field of every row. False: the message names file, line and column, and
 * nothing has been printed. Memory is bounded, because samples go to a temporary file. */
bool recording_load(recording_t *recording, const options_t *options, progress_t *progress,
                    sim_error_t *error);

/* Allowed after a failed load. */
void recording_free(recording_t *recording);

#endif
