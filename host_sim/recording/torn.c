/* davar-sim - torn register reads: copies the spools without the rows that have one. */
#include "recording/torn.h"

#include "davar/torn.h"

#include <stdlib.h>
#include <string.h>

#define BLOCK_ROWS 512U

typedef struct {
    const double *samples; /* of each column */
    double time_s;
    double missing;
} line_t;

/* The copy, and the row that waits for its successor. */
typedef struct {
    size_t width;
    davar_torn_t *filter; /* per column */
    double *rows;         /* the samples of the row that waits, then of a block */
    double time_s[BLOCK_ROWS];
    double lost[BLOCK_ROWS];
    line_t waiting;
    bool waits;
    spool_t samples;
    spool_t times;
    spool_t missing;
    uint64_t breaks;
} copy_t;

static bool open_copy(copy_t *copy, size_t width, sim_error_t *error)
{
    *copy = (copy_t){.width = width};
    copy->filter = malloc(width * sizeof *copy->filter);
    copy->rows = malloc((BLOCK_ROWS + 1U) * width * sizeof *copy->rows);
    if ((copy->filter == NULL) || (copy->rows == NULL)) {
        return sim_fail(error, "out of memory");
    }
    for (size_t c = 0; c < width; c++) {
        davar_torn_init(&copy->filter[c]);
    }
    return spool_open(&copy->samples, width, error) && spool_open(&copy->times, 1U, error) &&
           spool_open(&copy->missing, 1U, error);
}

static void close_copy(copy_t *copy)
{
    free(copy->filter);
    free(copy->rows);
    spool_close(&copy->samples);
    spool_close(&copy->times);
    spool_close(&copy->missing);
}

/* Writes the row that waits. */
static bool keep(copy_t *copy, sim_error_t *error)
{
    const line_t *line = &copy->waiting;
    copy->breaks += (line->missing > 0.0) ? 1U : 0U;
    return spool_put(&copy->samples, line->samples, error) &&
           spool_put(&copy->times, &line->time_s, error) &&
           spool_put(&copy->missing, &line->missing, error);
}

/* Pushes a row to all filters. Returns whether the row before it is torn in a column. */
static bool push(copy_t *copy, const line_t *line)
{
    bool torn = false;
    for (size_t c = 0; c < copy->width; c++) {
        int32_t before = 0;
        if (line->missing > 0.0) {
            (void)davar_torn_gap(&copy->filter[c], &before);
        }
        const davar_torn_step_t step =
            davar_torn_push(&copy->filter[c], (int32_t)line->samples[c], &before);
        torn = torn || (step == DAVAR_TORN_READ);
    }
    return torn;
}

static bool take(copy_t *copy, line_t line, sim_error_t *error)
{
    if (push(copy, &line)) {
        line.missing += copy->waiting.missing + 1.0;
    } else if (copy->waits && !keep(copy, error)) {
        return false;
    }
    copy->waiting = line;
    copy->waits = true;
    return true;
}

static bool read_block(copy_t *copy, const recording_t *recording, const timing_t *timing,
                       uint64_t first, size_t count, sim_error_t *error)
{
    for (size_t i = 0; i < count; i++) {
        copy->time_s[i] = (double)(first + i) / timing->rate_hz;
    }
    return spool_read(&recording->samples, first, count, copy->rows + copy->width, error) &&
           timing_missing(timing, first, count, copy->lost, error) &&
           (!recording->has_time ||
            spool_read(&recording->times, first, count, copy->time_s, error));
}

/* The next block overwrites this one, so the row that waits then is copied. */
static bool take_block(copy_t *copy, size_t count, sim_error_t *error)
{
    for (size_t i = 0; i < count; i++) {
        const line_t line = {copy->rows + ((i + 1U) * copy->width), copy->time_s[i], copy->lost[i]};
        if (!take(copy, line, error)) {
            return false;
        }
    }
    memcpy(copy->rows, copy->waiting.samples, copy->width * sizeof *copy->rows);
    copy->waiting.samples = copy->rows;
    return true;
}

static bool copy_rows(copy_t *copy, const recording_t *recording, const timing_t *timing,
                      sim_error_t *error)
{
    for (uint64_t first = 0; first < recording->rows; first += BLOCK_ROWS) {
        const uint64_t left = recording->rows - first;
        const size_t count = (left < BLOCK_ROWS) ? (size_t)left : BLOCK_ROWS;
        if (!read_block(copy, recording, timing, first, count, error) ||
            !take_block(copy, count, error)) {
            return false;
        }
    }
    return keep(copy, error) && spool_flush(&copy->samples, error) &&
           spool_flush(&copy->times, error) && spool_flush(&copy->missing, error);
}

static void exchange(spool_t *a, spool_t *b)
{
    const spool_t kept = *a;
    *a = *b;
    *b = kept;
}

bool torn_skip(uint64_t *reads, recording_t *recording, timing_t *timing, sim_error_t *error)
{
    copy_t copy;
    const bool good = open_copy(&copy, recording->selection.count, error) &&
                      copy_rows(&copy, recording, timing, error);
    if (good) {
        exchange(&recording->samples, &copy.samples);
        exchange(&recording->times, &copy.times);
        exchange(&timing->missing, &copy.missing);
        recording->rows = recording->samples.records;
        recording->has_time = true;
        timing->breaks = copy.breaks;
        for (size_t c = 0; c < copy.width; c++) {
            reads[c] = davar_torn_reads(&copy.filter[c]);
        }
    }
    close_copy(&copy);
    return good;
}
