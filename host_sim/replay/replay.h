/* davar-sim - pass 2: the port (davar_port.h) that replays a spooled recording and writes the
 * results. */
#ifndef REPLAY_H
#define REPLAY_H

#include "davar_port.h"
#include "output/output.h"
#include "recording/progress.h"
#include "replay/chunk.h"
#include "replay/epoch_time.h"
#include "replay/pace.h"

/* Setup of a replay; all of it belongs to the caller and must outlive the replay. */
typedef struct {
    const recording_t *recording;
    const timing_t *timing;
    const quantisation_t *quantisation;
    davar_port_number_t number;
    davar_t *instances; /* one per channel, of the results of the port; null: centred windows */
    output_t *output;
    progress_t *progress;
    double times_real_time; /* 0: as fast as possible */
} replay_setup_t;

typedef struct {
    replay_setup_t setup;
    chunk_t chunk;
    size_t position; /* rows of the chunk already delivered */
    uint64_t lost;   /* samples missing so far; they take time too */
    davar_port_samples_t samples[OPTIONS_COLUMNS_MAX];
    epoch_time_t epoch_time;
    pace_t pace;
    sim_error_t *error; /* has the message after the port reported a fault */
} replay_t;

/* Prepares the port and starts the clock of the pace. */
bool replay_open(replay_t *replay, const replay_setup_t *setup, sim_error_t *error);

/* The port itself; `replay` is its context. */
davar_port_t replay_port(replay_t *replay);

/* Writes a result with the report of law glr, which may be null. */
davar_port_send_t replay_send(replay_t *replay, size_t channel, const davar_result_t *result,
                              const davar_glr_report_t *report);

/* Sleeps until the next sample is due (at most a second). */
void replay_wait(const replay_t *replay);

/* Allowed after a failed open. */
void replay_close(replay_t *replay);

#endif
