/* davar-sim - recordings. */
#include "recording/recording.h"

#include "common/text.h"
#include "recording/lines.h"
#include "recording/row.h"

#include <float.h>
#include <inttypes.h>
#include <stdlib.h>

#define PROGRESS_ROWS 16384U

/* Buffers for the current row. */
typedef struct {
    double value[HEADER_COLUMNS_MAX];
    double admitted[OPTIONS_COLUMNS_MAX];
    double newest_time_s;
    uint64_t blank_line; /* number of the first blank line since the last row; 0: none */
} row_buffer_t;

static bool admit_time(recording_t *recording, const lines_t *lines, row_buffer_t *row,
                       sim_error_t *error)
{
    const double time_s = row->value[recording->selection.time];
    if ((recording->rows > 0U) && (time_s < row->newest_time_s)) {
        return row_fail(lines, "time_s", "time runs backwards", time_s, error);
    }
    row->newest_time_s = time_s;
    return spool_put(&recording->times, &time_s, error);
}

static void widen(extent_t *extent, double admitted)
{
    extent->low = (admitted < extent->low) ? admitted : extent->low;
    extent->high = (admitted > extent->high) ? admitted : extent->high;
}

static bool admit_samples(recording_t *recording, const options_t *options, const lines_t *lines,
                          row_buffer_t *row, sim_error_t *error)
{
    const selection_t *selection = &recording->selection;
    for (size_t c = 0; c < selection->count; c++) {
        const double value = row->value[selection->column[c]];
        const char *problem = quantise_admit(options, selection->unit[c], value, &row->admitted[c]);
        if (problem != NULL) {
            return row_fail(lines, selection->name[c], problem, value, error);
        }
        widen(&recording->extent, row->admitted[c]);
    }
    return spool_put(&recording->samples, row->admitted, error);
}

/* Blank lines may only end a recording. Their position is kept until a row follows. */
static bool note_blank(const lines_t *lines, row_buffer_t *row)
{
    if (row->blank_line == 0U) {
        row->blank_line = lines->number;
    }
    return true;
}

static bool take_line(recording_t *recording, const options_t *options, const lines_t *lines,
                      const char *text, size_t length, row_buffer_t *row, sim_error_t *error)
{
    if (text_is_blank(text) && (text_skip_blanks(text) == text + length)) {
        return note_blank(lines, row);
    }
    if (row->blank_line != 0U) {
        return sim_fail(error, "%s:%" PRIu64 ": column %s: empty row between rows, found ''",
                        lines->name, row->blank_line, recording->header.name[0]);
    }
    if (!row_parse(lines, text, length, &recording->header, row->value, error)) {
        return false;
    }
    if (recording->has_time && !admit_time(recording, lines, row, error)) {
        return false;
    }
    recording->rows++;
    return admit_samples(recording, options, lines, row, error);
}

static bool read_rows(recording_t *recording, const options_t *options, lines_t *lines,
                      row_buffer_t *row, progress_t *progress, sim_error_t *error)
{
    char *text = NULL;
    size_t length = 0;
    lines_status_t status = lines_next(lines, &text, &length, error);
    while (status == LINES_LINE) {
        if (!take_line(recording, options, lines, text, length, row, error)) {
            return false;
        }
        if (recording->rows % PROGRESS_ROWS == 0U) {
            progress_show(progress, "reading", lines_fraction(lines), recording->rows);
        }
        status = lines_next(lines, &text, &length, error);
    }
    if ((status == LINES_END) && (recording->rows == 0U)) {
        return sim_fail(error, "%s:%" PRIu64 ": no rows after the header", lines->name,
                        lines->number);
    }
    return (status == LINES_END) && spool_flush(&recording->samples, error) &&
           (!recording->has_time || spool_flush(&recording->times, error));
}

static bool prepare(recording_t *recording, const options_t *options, lines_t *lines,
                    sim_error_t *error)
{
    if (!header_read(&recording->header, lines, error) ||
        !selection_make(&recording->selection, &recording->header, options, error)) {
        return false;
    }
    recording->has_time = (recording->selection.time != HEADER_NONE);
    recording->extent = (extent_t){.low = DBL_MAX, .high = -DBL_MAX};
    return spool_open(&recording->samples, recording->selection.count, error) &&
           (!recording->has_time || spool_open(&recording->times, 1U, error));
}

static bool load(recording_t *recording, const options_t *options, lines_t *lines,
                 progress_t *progress, sim_error_t *error)
{
    if (!prepare(recording, options, lines, error)) {
        return false;
    }
    row_buffer_t *row = calloc(1U, sizeof *row);
    if (row == NULL) {
        return sim_fail(error, "out of memory");
    }
    const bool good = read_rows(recording, options, lines, row, progress, error);
    free(row);
    return good;
}

bool recording_load(recording_t *recording, const options_t *options, progress_t *progress,
                    sim_error_t *error)
{
    *recording = (recording_t){0};
    lines_t lines;
    if (!lines_open(&lines, options->recording, error)) {
        return false;
    }
    const bool good = load(recording, options, &lines, progress, error);
    lines_close(&lines);
    return good;
}

void recording_free(recording_t *recording)
{
    spool_close(&recording->samples);
    spool_close(&recording->times);
    header_free(&recording->header);
}
