/* davar-sim - rows. Every field is checked, even in columns that are not processed. */
#include "recording/row.h"

#include "common/decimal.h"
#include "common/text.h"

#include <inttypes.h>
#include <string.h>
#include <strings.h>

#define FOUND_CHARACTERS_MAX 40

static bool is_not_finite(const char *field, size_t length)
{
    static const char *const WORDS[] = {"nan",       "inf",  "infinity", "-nan",     "-inf",
                                        "-infinity", "+nan", "+inf",     "+infinity"};
    for (size_t w = 0; w < sizeof WORDS / sizeof WORDS[0]; w++) {
        if ((length == strlen(WORDS[w])) && (strncasecmp(field, WORDS[w], length) == 0)) {
            return true;
        }
    }
    return false;
}

static const char *describe(const char *field, size_t length, decimal_status_t status)
{
    if (length == 0U) {
        return "empty field";
    }
    if (is_not_finite(field, length)) {
        return "not a finite number";
    }
    return (status == DECIMAL_RANGE) ? "number too large" : "not a number";
}

static bool fail_field(const lines_t *lines, const char *column, const char *field,
                       decimal_status_t status, sim_error_t *error)
{
    size_t length = strcspn(field, ",");
    while ((length > 0U) && ((field[length - 1U] == ' ') || (field[length - 1U] == '\t'))) {
        length--;
    }
    const char *what = describe(field, length, status);
    const bool cut = (length > FOUND_CHARACTERS_MAX);
    return sim_fail(error, "%s:%" PRIu64 ": column %s: %s, found '%.*s%s'", lines->name,
                    lines->number, column, what, cut ? FOUND_CHARACTERS_MAX : (int)length, field,
                    cut ? "..." : "");
}

static bool fail_short(const lines_t *lines, const header_t *header, size_t found,
                       sim_error_t *error)
{
    return sim_fail(
        error, "%s:%" PRIu64 ": column %s: row too short: %zu columns in the header, found %zu",
        lines->name, lines->number, header->name[found], header->count, found);
}

static bool fail_long(const lines_t *lines, const header_t *header, const char *rest,
                      sim_error_t *error)
{
    size_t found = header->count + 1U;
    for (const char *comma = strchr(rest, ','); comma != NULL; comma = strchr(comma + 1, ',')) {
        found++;
    }
    return sim_fail(
        error, "%s:%" PRIu64 ": column %zu: row too long: %zu columns in the header, found %zu",
        lines->name, lines->number, header->count + 1U, header->count, found);
}

/* Reads the field at *cursor and moves past its spaces to a comma or the end. */
static bool parse_field(const lines_t *lines, const char **cursor, const char *column,
                        double *value, sim_error_t *error)
{
    const char *field = text_skip_blanks(*cursor);
    const char *end = field;
    const decimal_status_t status = decimal_parse(&end, value);
    end = text_skip_blanks(end);
    if ((status != DECIMAL_OK) || ((*end != ',') && (*end != '\0'))) {
        return fail_field(lines, column, field, status, error);
    }
    *cursor = end;
    return true;
}

bool row_parse(const lines_t *lines, const char *text, size_t length, const header_t *header,
               double *values, sim_error_t *error)
{
    const char *cursor = text;
    for (size_t c = 0; c < header->count; c++) {
        if (!parse_field(lines, &cursor, header->name[c], &values[c], error)) {
            return false;
        }
        const bool last = (c + 1U == header->count);
        if (!last && (*cursor == '\0')) {
            return fail_short(lines, header, c + 1U, error);
        }
        cursor += last ? 0 : 1;
    }
    if (*cursor == ',') {
        return fail_long(lines, header, cursor + 1, error);
    }
    if (cursor != text + length) {
        return sim_fail(error, "%s:%" PRIu64 ": not a text recording, found byte 0x00", lines->name,
                        lines->number);
    }
    return true;
}

bool row_fail(const lines_t *lines, const char *column, const char *what, double found,
              sim_error_t *error)
{
    return sim_fail(error, "%s:%" PRIu64 ": column %s: %s, found '%.15g'", lines->name,
                    lines->number, column, what, found);
}
