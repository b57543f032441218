/* davar-sim - column choice. */
#include "recording/selection.h"

#include <string.h>

#define LIST_BYTES 600

static bool add(selection_t *selection, const header_t *header, size_t column,
                const options_t *options, sim_error_t *error)
{
    const char *name = header->name[column];
    const unit_t unit = unit_of(name);
    if ((unit == UNIT_COUNTS) && !(options->setup.lsb > 0.0)) {
        return sim_fail(error, "%s: column %s: counts need --lsb (deg/s per count)",
                        options->recording, name);
    }
    selection->column[selection->count] = column;
    selection->unit[selection->count] = unit;
    selection->name[selection->count] = name;
    selection->count++;
    return true;
}

static bool add_named(selection_t *selection, const header_t *header, const char *name,
                      const options_t *options, sim_error_t *error)
{
    const size_t column = header_find(header, name);
    if (column == HEADER_NONE) {
        char list[LIST_BYTES];
        return sim_fail(error, "%s: no column '%s' (--column); the columns are: %s",
                        options->recording, name, header_list(header, list, sizeof list));
    }
    for (size_t c = 0; c < selection->count; c++) {
        if (selection->column[c] == column) {
            return sim_fail(error, "--column: '%s' given twice", name);
        }
    }
    return add(selection, header, column, options, error);
}

static size_t find_default(const header_t *header, size_t time)
{
    size_t others = 0;
    size_t other = HEADER_NONE;
    for (size_t c = 0; c < header->count; c++) {
        if (strncmp(header->name[c], "gyro_", 5) == 0) {
            return c;
        }
        if (c != time) {
            others++;
            other = c;
        }
    }
    return (others == 1U) ? other : HEADER_NONE;
}

static bool add_default(selection_t *selection, const header_t *header, const options_t *options,
                        sim_error_t *error)
{
    const size_t column = find_default(header, selection->time);
    if (column == HEADER_NONE) {
        char list[LIST_BYTES];
        return sim_fail(error, "%s: no gyro_* column; choose with --column from: %s",
                        options->recording, header_list(header, list, sizeof list));
    }
    return add(selection, header, column, options, error);
}

bool selection_make(selection_t *selection, const header_t *header, const options_t *options,
                    sim_error_t *error)
{
    *selection = (selection_t){.time = header_find(header, "time_s")};
    if (options->column_count == 0U) {
        if (!add_default(selection, header, options, error)) {
            return false;
        }
    }
    for (size_t c = 0; c < options->column_count; c++) {
        if (!add_named(selection, header, options->columns[c], options, error)) {
            return false;
        }
    }
    if ((selection->time == HEADER_NONE) && !(options->setup.rate_hz > 0.0)) {
        return sim_fail(error, "%s: no column time_s: the sample rate is unknown; give --rate",
                        options->recording);
    }
    return true;
}
