/* davar-sim - part of the spooled recording in memory, in the number type of the instances. */
#ifndef CHUNK_H
#define CHUNK_H

#include "davar_port.h"
#include "recording/quantise.h"
#include "recording/recording.h"
#include "recording/timing.h"

#define CHUNK_ROWS 4096U

/* Samples of all channels, CHUNK_ROWS per channel, channel after channel. */
typedef union {
    void *any;
    int16_t *q15;
    int32_t *q31;
    float *f32;
} chunk_samples_t;

typedef struct {
    uint64_t first; /* row of the first sample */
    size_t count;   /* number of rows */
    chunk_samples_t samples;
    uint32_t *missing; /* per row: samples lost just before it */
    double *record;    /* rows as spooled */
} chunk_t;

/* Allocates for `channels` channels; the chunk is empty and ends at row 0. */
bool chunk_open(chunk_t *chunk, size_t channels, sim_error_t *error);

/* Loads the next rows. count is 0 at the end of the recording. */
bool chunk_next(chunk_t *chunk, const recording_t *recording, const timing_t *timing,
                const quantisation_t *quantisation, davar_port_number_t number, sim_error_t *error);

/* Number of rows from `from` onward without a loss between them, >= 1. */
size_t chunk_run(const chunk_t *chunk, size_t from);

/* The samples of a channel, beginning at row `from` of the chunk. */
davar_port_samples_t chunk_samples(const chunk_t *chunk, davar_port_number_t number, size_t channel,
                                   size_t from);

/* Allowed after a failed open. */
void chunk_close(chunk_t *chunk);

#endif
