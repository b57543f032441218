/* davar-sim - chunks of the recording. */
#include "replay/chunk.h"

#include <stdlib.h>

bool chunk_open(chunk_t *chunk, size_t channels, sim_error_t *error)
{
    *chunk = (chunk_t){0};
    chunk->samples.any = calloc(channels * CHUNK_ROWS, sizeof(int32_t));
    chunk->record = calloc(channels * CHUNK_ROWS, sizeof(double));
    chunk->missing = calloc(CHUNK_ROWS, sizeof(uint32_t));
    if ((chunk->samples.any == NULL) || (chunk->record == NULL) || (chunk->missing == NULL)) {
        return sim_fail(error, "out of memory");
    }
    return true;
}

static void convert_channel(chunk_t *chunk, const quantisation_t *quantisation,
                            davar_port_number_t number, size_t channels, size_t c)
{
    const double *admitted = chunk->record + c;
    for (size_t i = 0; i < chunk->count; i++, admitted += channels) {
        const size_t at = c * CHUNK_ROWS + i;
        switch (number) {
        case DAVAR_PORT_Q15:
            chunk->samples.q15[at] = (int16_t)quantise_count(quantisation, *admitted);
            break;
        case DAVAR_PORT_Q31:
            chunk->samples.q31[at] = quantise_count(quantisation, *admitted);
            break;
        case DAVAR_PORT_F32:
        default:
            chunk->samples.f32[at] = (float)*admitted;
            break;
        }
    }
}

static bool find_missing(chunk_t *chunk, const timing_t *timing, sim_error_t *error)
{
    double missing[CHUNK_ROWS];
    if (!timing_missing(timing, chunk->first, chunk->count, missing, error)) {
        return false;
    }
    for (size_t i = 0; i < chunk->count; i++) {
        chunk->missing[i] = (uint32_t)missing[i];
    }
    return true;
}

bool chunk_next(chunk_t *chunk, const recording_t *recording, const timing_t *timing,
                const quantisation_t *quantisation, davar_port_number_t number, sim_error_t *error)
{
    chunk->first += chunk->count;
    const uint64_t left = recording->rows - chunk->first;
    chunk->count = (left < CHUNK_ROWS) ? (size_t)left : CHUNK_ROWS;
    if (!spool_read(&recording->samples, chunk->first, chunk->count, chunk->record, error)) {
        return false;
    }
    for (size_t c = 0; c < recording->selection.count; c++) {
        convert_channel(chunk, quantisation, number, recording->selection.count, c);
    }
    return find_missing(chunk, timing, error);
}

size_t chunk_run(const chunk_t *chunk, size_t from)
{
    size_t end = from + 1U;
    while ((end < chunk->count) && (chunk->missing[end] == 0U)) {
        end++;
    }
    return end - from;
}

davar_port_samples_t chunk_samples(const chunk_t *chunk, davar_port_number_t number, size_t channel,
                                   size_t from)
{
    const size_t at = channel * CHUNK_ROWS + from;
    davar_port_samples_t samples = {0};
    switch (number) {
    case DAVAR_PORT_Q15:
        samples.q15 = chunk->samples.q15 + at;
        break;
    case DAVAR_PORT_Q31:
        samples.q31 = chunk->samples.q31 + at;
        break;
    case DAVAR_PORT_F32:
    default:
        samples.f32 = chunk->samples.f32 + at;
        break;
    }
    return samples;
}

void chunk_close(chunk_t *chunk)
{
    free(chunk->samples.any);
    free(chunk->missing);
    free(chunk->record);
    *chunk = (chunk_t){0};
}
