/* davar-sim - segments of a recording, without gaps inside. */
#include "learning/channels.h"

#include <stdlib.h>

#define ROUNDING_OF_COUNTS (1.0 / 12.0)

/* Is there a gap between the samples of a segment? */
static bool find_gap(bool *gap, const timing_t *timing, uint64_t first, size_t count,
                     sim_error_t *error)
{
    double missing[SPECTRUM_LONG];
    if (!timing_missing(timing, first, count, missing, error)) {
        return false;
    }
    *gap = false;
    for (size_t i = 1; i < count; i++) {
        *gap = *gap || (missing[i] > 0.0);
    }
    return true;
}

/* Adds the segment that begins at sample `first`. rows: a buffer for all channels. */
static bool add_segment(spectrum_t *spectrum, const recording_t *recording, uint64_t first,
                        size_t channel, double *rows, sim_error_t *error)
{
    const size_t width = recording->selection.count;
    double samples[SPECTRUM_LONG];
    if (!spool_read(&recording->samples, first, spectrum->segment, rows, error)) {
        return false;
    }
    for (size_t i = 0; i < spectrum->segment; i++) {
        samples[i] = rows[i * width + channel];
    }
    spectrum_add(spectrum, samples);
    return true;
}

static bool read_segments(spectrum_t *spectrum, const recording_t *recording,
                          const timing_t *timing, size_t channel, double *rows, sim_error_t *error)
{
    for (size_t i = 0; i < spectrum_places(spectrum, recording->rows); i++) {
        const uint64_t first = spectrum_place(spectrum, recording->rows, i);
        bool gap = false;
        if (!find_gap(&gap, timing, first, spectrum->segment, error) ||
            (!gap && !add_segment(spectrum, recording, first, channel, rows, error))) {
            return false;
        }
    }
    return true;
}

bool learn_channels(learned_t *learned, const recording_t *recording, const timing_t *timing,
                    const options_t *options, sim_error_t *error)
{
    const bool counted = (options->arith == ARITH_FIXED) && (options->setup.lsb > 0.0);
    const size_t width = recording->selection.count;
    double *rows = malloc(sizeof(double) * SPECTRUM_LONG * width);
    spectrum_t spectrum = {0};
    if ((rows == NULL) || !spectrum_open(&spectrum, recording->rows)) {
        free(rows);
        return sim_fail(error, "out of memory");
    }
    bool good = true;
    for (size_t c = 0; good && (c < width); c++) {
        spectrum.count = 0;
        good = read_segments(&spectrum, recording, timing, c, rows, error);
        learned[c] = learn_filter(&spectrum, counted ? ROUNDING_OF_COUNTS : 0.0);
    }
    spectrum_close(&spectrum);
    free(rows);
    return good;
}
