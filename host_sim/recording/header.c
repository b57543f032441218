/* davar-sim - the header row. */
#include "recording/header.h"

#include "common/decimal.h"
#include "common/text.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Anything except text means that the file is not a recording. Reports this instead of listing odd
 * names. */
static bool check_text(const lines_t *lines, const char *text, size_t length, sim_error_t *error)
{
    for (size_t i = 0; i < length; i++) {
        const unsigned char byte = (unsigned char)text[i];
        if (((byte < 0x20U) && (byte != '\t')) || (byte == 0x7FU)) {
            return sim_fail(error, "%s:%" PRIu64 ": not a text recording, found byte 0x%02x",
                            lines->name, lines->number, byte);
        }
    }
    return true;
}

static bool check_name(const header_t *header, const lines_t *lines, const char *name,
                       sim_error_t *error)
{
    const size_t number = header->count + 1U;
    if (number > HEADER_COLUMNS_MAX) {
        return sim_fail(error, "%s:%" PRIu64 ": more than %u columns", lines->name, lines->number,
                        HEADER_COLUMNS_MAX);
    }
    if (*name == '\0') {
        return sim_fail(error, "%s:%" PRIu64 ": column %zu: empty name in the header row",
                        lines->name, lines->number, number);
    }
    if (header_find(header, name) != HEADER_NONE) {
        return sim_fail(error,
                        "%s:%" PRIu64 ": column %zu: name used twice in the header row, found '%s'",
                        lines->name, lines->number, number, name);
    }
    const char *cursor = name;
    double value = 0.0;
    if ((decimal_parse(&cursor, &value) == DECIMAL_OK) && (*cursor == '\0')) {
        return sim_fail(
            error, "%s:%" PRIu64 ": column %zu: no header row: a column name expected, found '%s'",
            lines->name, lines->number, number, name);
    }
    return true;
}

static bool split(header_t *header, const lines_t *lines, sim_error_t *error)
{
    char *rest = header->text;
    while (rest != NULL) {
        char *comma = strchr(rest, ',');
        if (comma != NULL) {
            *comma = '\0';
        }
        const char *name = text_trim(rest);
        if (!check_name(header, lines, name, error)) {
            return false;
        }
        header->name[header->count] = name;
        header->count++;
        rest = (comma != NULL) ? comma + 1 : NULL;
    }
    return true;
}

/* Finds the first line that is neither a comment nor blank. */
static bool find_row(lines_t *lines, char **text, size_t *length, sim_error_t *error)
{
    lines_status_t status = lines_next(lines, text, length, error);
    while ((status == LINES_LINE) &&
           ((**text == '#') || ((*length == strlen(*text)) && text_is_blank(*text)))) {
        status = lines_next(lines, text, length, error);
    }
    if (status == LINES_END) {
        return sim_fail(error, "%s:%" PRIu64 ": empty recording: no header row", lines->name,
                        lines->number);
    }
    return (status == LINES_LINE);
}

bool header_read(header_t *header, lines_t *lines, sim_error_t *error)
{
    char *text = NULL;
    size_t length = 0;
    if (!find_row(lines, &text, &length, error) || !check_text(lines, text, length, error)) {
        return false;
    }
    header->count = 0;
    header->text = malloc(length + 1U);
    if (header->text == NULL) {
        return sim_fail(error, "%s: out of memory", lines->name);
    }
    memcpy(header->text, text, length + 1U);
    return split(header, lines, error);
}

size_t header_find(const header_t *header, const char *name)
{
    for (size_t c = 0; c < header->count; c++) {
        if (strcmp(header->name[c], name) == 0) {
            return c;
        }
    }
    return HEADER_NONE;
}

const char *header_list(const header_t *header, char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (size_t c = 0; (c < header->count) && (used < size); c++) {
        const int wrote =
            snprintf(text + used, size - used, "%s%s", (c > 0U) ? ", " : "", header->name[c]);
        used += (wrote > 0) ? (size_t)wrote : 0U;
    }
    return text;
}

void header_free(header_t *header)
{
    free(header->text);
    header->text = NULL;
    header->count = 0;
}
