/* davar-sim - the table of the error model. */
#include "instances/model_table.h"

#include "common/text.h"
#include "recording/row.h"

#include <math.h>

#define TAU_TOLERANCE 0.01

typedef enum { COLUMN_M = 0, COLUMN_ADEV, COLUMN_TOLERANCE, COLUMN_TAU, COLUMN_COUNT } column_t;

static const char *const COLUMN[COLUMN_COUNT] = {"m", "adev_dps", "relative_tolerance", "tau_s"};

/* The file and the position of its columns while it is read. */
typedef struct {
    lines_t lines;
    header_t header;
    size_t place[COLUMN_COUNT];
    double value[HEADER_COLUMNS_MAX];
    double rate_hz;
} reader_t;

static bool find_columns(reader_t *reader, sim_error_t *error)
{
    char names[512];
    for (size_t c = 0; c < COLUMN_COUNT; c++) {
        reader->place[c] = header_find(&reader->header, COLUMN[c]);
        if ((reader->place[c] == HEADER_NONE) && (c != COLUMN_TAU)) {
            return sim_fail(
                error,
                "%s: no column %s (found: %s); tools/davarlab export MODEL -o TABLE.csv writes one",
                reader->lines.name, COLUMN[c], header_list(&reader->header, names, sizeof names));
        }
    }
    return true;
}

static double value_of(const reader_t *reader, column_t column)
{
    return reader->value[reader->place[column]];
}

static bool refuse(const reader_t *reader, column_t column, const char *what, sim_error_t *error)
{
    return row_fail(&reader->lines, COLUMN[column], what, value_of(reader, column), error);
}

/* A table for another rate would compare different times. */
static bool check_tau(const reader_t *reader, sim_error_t *error)
{
    if (reader->place[COLUMN_TAU] == HEADER_NONE) {
        return true;
    }
    const double tau_s = value_of(reader, COLUMN_M) / reader->rate_hz;
    const bool good = (fabs(value_of(reader, COLUMN_TAU) - tau_s) <= TAU_TOLERANCE * tau_s);
    return good ||
           refuse(reader, COLUMN_TAU, "made for a different sample rate than the recording", error);
}

static bool take_row(const reader_t *reader, model_table_t *table, sim_error_t *error)
{
    const double m = value_of(reader, COLUMN_M);
    const davar_model_tau_t tau = {(uint32_t)(((m >= 1.0) && (m <= UINT32_MAX)) ? m : 0.0),
                                   value_of(reader, COLUMN_ADEV),
                                   value_of(reader, COLUMN_TOLERANCE)};
    if ((tau.m == 0U) || (fabs((double)tau.m - m) > 0.0)) {
        return refuse(reader, COLUMN_M, "not a cluster size", error);
    }
    for (uint8_t i = 0; i < table->count; i++) {
        if (table->tau[i].m == tau.m) {
            return refuse(reader, COLUMN_M, "cluster size repeated", error);
        }
    }
    if (!(tau.adev_dps > 0.0)) {
        return refuse(reader, COLUMN_ADEV, "must be above 0", error);
    }
    if (!(tau.relative_tolerance >= 0.0)) {
        return refuse(reader, COLUMN_TOLERANCE, "must not be negative", error);
    }
    if (table->count == MODEL_TABLE_MAX) {
        return refuse(reader, COLUMN_M, "too many cluster sizes", error);
    }
    table->tau[table->count] = tau;
    table->count++;
    return check_tau(reader, error);
}

static bool read_rows(reader_t *reader, model_table_t *table, sim_error_t *error)
{
    char *text = NULL;
    size_t length = 0;
    for (;;) {
        const lines_status_t status = lines_next(&reader->lines, &text, &length, error);
        if (status != LINES_LINE) {
            return (status == LINES_END) &&
                   ((table->count > 0U) ||
                    sim_fail(error, "%s: has no cluster sizes", reader->lines.name));
        }
        if (!text_is_blank(text) &&
            (!row_parse(&reader->lines, text, length, &reader->header, reader->value, error) ||
             !take_row(reader, table, error))) {
            return false;
        }
    }
}

bool model_table_read(model_table_t *table, const char *path, double rate_hz, sim_error_t *error)
{
    reader_t reader = {.rate_hz = rate_hz};
    table->count = 0;
    if (!lines_open(&reader.lines, path, error)) {
        return false;
    }
    const bool headed = header_read(&reader.header, &reader.lines, error);
    const bool good = headed && find_columns(&reader, error) && read_rows(&reader, table, error);
    header_free(&reader.header);
    lines_close(&reader.lines);
    return good;
}
