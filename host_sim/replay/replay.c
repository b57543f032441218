/* davar-sim - replay port. */
#include "replay/replay.h"

#include "common/sim_clock.h"
#include "common/stop.h"

/* Rows and lost samples before the next row. */
static uint64_t sample_index(const replay_t *replay)
{
    const chunk_t *chunk = &replay->chunk;
    const uint32_t missing =
        (replay->position < chunk->count) ? chunk->missing[replay->position] : 0U;
    return chunk->first + replay->position + replay->lost + missing;
}

/* The number of rows that may be delivered now: up to the next loss, and only those that are
 * due. */
static size_t rows_due(const replay_t *replay)
{
    const size_t run = chunk_run(&replay->chunk, replay->position);
    if (pace_is_unlimited(&replay->pace)) {
        return run;
    }
    const uint64_t next = sample_index(replay);
    const uint64_t due = pace_due(&replay->pace);
    const uint64_t ready = (due > next) ? due - next : 0U;
    return (ready < run) ? (size_t)ready : run;
}

static davar_port_read_t hand_out(replay_t *replay, size_t rows, davar_port_block_t *block)
{
    const uint32_t missing = replay->chunk.missing[replay->position];
    for (size_t c = 0; c < replay->setup.recording->selection.count; c++) {
        replay->samples[c] =
            chunk_samples(&replay->chunk, replay->setup.number, c, replay->position);
    }
    *block = (davar_port_block_t){.samples = replay->samples, .count = rows, .missing = missing};
    const raw_run_t run = {replay->samples, replay->setup.number, sample_index(replay), rows};
    replay->lost += missing;
    replay->position += rows;
    return output_samples(replay->setup.output, &run, missing > 0U, replay->error)
               ? DAVAR_PORT_READ_BLOCK
               : DAVAR_PORT_READ_FAULT;
}

static bool load(replay_t *replay)
{
    const replay_setup_t *setup = &replay->setup;
    replay->position = 0;
    return chunk_next(&replay->chunk, setup->recording, setup->timing, setup->quantisation,
                      setup->number, replay->error);
}

static davar_port_read_t read_rows(void *context, davar_port_block_t *block)
{
    replay_t *replay = context;
    const uint64_t row = replay->chunk.first + replay->position;
    progress_show(replay->setup.progress, "running",
                  (double)row / (double)replay->setup.recording->rows, row);
    if (stop_requested(replay->error)) {
        return DAVAR_PORT_READ_FAULT;
    }
    if ((replay->position == replay->chunk.count) && !load(replay)) {
        return DAVAR_PORT_READ_FAULT;
    }
    if (replay->chunk.count == 0U) {
        return DAVAR_PORT_READ_END;
    }
    const size_t rows = rows_due(replay);
    return (rows > 0U) ? hand_out(replay, rows, block) : DAVAR_PORT_READ_AGAIN;
}

davar_port_send_t replay_send(replay_t *replay, size_t channel, const davar_result_t *result,
                              const davar_glr_report_t *report)
{
    epoch_row_t row = {.result = result, .report = report};
    if (!epoch_time_find(&replay->epoch_time, result->epoch, &row.time_s, replay->error) ||
        !output_row(replay->setup.output, channel, &row, replay->error)) {
        return DAVAR_PORT_SEND_FAULT;
    }
    return DAVAR_PORT_SEND_DONE;
}

static davar_port_send_t send_row(void *context, size_t channel, const davar_result_t *result)
{
    replay_t *replay = context;
    davar_glr_report_t report;
    if (replay->setup.instances == NULL) {
        return replay_send(replay, channel, result, NULL);
    }
    davar_glr_report(&replay->setup.instances[channel], &report);
    return replay_send(replay, channel, result, &report);
}

static uint32_t now_us(void *context)
{
    (void)context;
    return (uint32_t)(uint64_t)(1e6 * sim_clock_s());
}

bool replay_open(replay_t *replay, const replay_setup_t *setup, sim_error_t *error)
{
    *replay = (replay_t){.setup = *setup, .error = error};
    epoch_time_open(&replay->epoch_time, setup->recording, setup->timing->rate_hz);
    pace_start(&replay->pace, setup->timing->rate_hz, setup->times_real_time);
    return chunk_open(&replay->chunk, setup->recording->selection.count, error);
}

davar_port_t replay_port(replay_t *replay)
{
    return (davar_port_t){.context = replay, .read = read_rows, .send = send_row, .now_us = now_us};
}

void replay_wait(const replay_t *replay)
{
    pace_wait(&replay->pace, sample_index(replay));
}

void replay_close(replay_t *replay)
{
    chunk_close(&replay->chunk);
}
