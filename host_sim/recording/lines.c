/* davar-sim - lines of a file. */
#include "recording/lines.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#define BYTE_ORDER_MARK "\xEF\xBB\xBF"

bool lines_open(lines_t *lines, const char *name, sim_error_t *error)
{
    *lines = (lines_t){.name = name};
    if (!bytes_in_open(&lines->in, name, error)) {
        lines_close(lines);
        return false;
    }
    lines->buffer = malloc(LINES_LENGTH_MAX + 1U);
    if (lines->buffer == NULL) {
        lines_close(lines);
        return sim_fail(error, "%s: out of memory", name);
    }
    return true;
}

static bool read_more(lines_t *lines, sim_error_t *error)
{
    size_t got = 0;
    const char *problem =
        bytes_in_read(&lines->in, lines->buffer + lines->end, LINES_LENGTH_MAX - lines->end, &got);
    if (problem != NULL) {
        return sim_fail(error, "%s:%" PRIu64 ": %s", lines->name, lines->number, problem);
    }
    lines->end += got;
    lines->drained = (got == 0U);
    return true;
}

/* Moves the unfinished line to the front and reads more data after it. */
static bool fill(lines_t *lines, sim_error_t *error)
{
    const size_t kept = lines->end - lines->begin;
    memmove(lines->buffer, lines->buffer + lines->begin, kept);
    lines->begin = 0;
    lines->end = kept;
    if (kept == LINES_LENGTH_MAX) {
        return sim_fail(error, "%s:%" PRIu64 ": line longer than %zu bytes; not a recording",
                        lines->name, lines->number + 1U, LINES_LENGTH_MAX);
    }
    return read_more(lines, error);
}

/* The end of the line; null if it has not been read yet. */
static char *find_end(lines_t *lines, size_t searched)
{
    char *from = lines->buffer + lines->begin + searched;
    char *newline = memchr(from, '\n', lines->end - lines->begin - searched);
    if ((newline == NULL) && lines->drained) {
        newline = lines->buffer + lines->end;
    }
    return newline;
}

static void skip_byte_order_mark(const lines_t *lines, char **text)
{
    const size_t mark_bytes = sizeof BYTE_ORDER_MARK - 1U;
    if ((lines->number == 1U) && (strncmp(*text, BYTE_ORDER_MARK, mark_bytes) == 0)) {
        *text += mark_bytes;
    }
}

static void hand_out(lines_t *lines, char *end, char **text, size_t *length)
{
    *text = lines->buffer + lines->begin;
    lines->begin = (size_t)(end - lines->buffer) + 1U;
    if (lines->begin > lines->end) {
        lines->begin = lines->end;
    }
    lines->number++;
    if ((end > *text) && (end[-1] == '\r')) {
        end--;
    }
    *end = '\0';
    skip_byte_order_mark(lines, text);
    *length = (size_t)(end - *text);
}

lines_status_t lines_next(lines_t *lines, char **text, size_t *length, sim_error_t *error)
{
    size_t searched = 0;
    char *end = find_end(lines, searched);
    while (end == NULL) {
        searched = lines->end - lines->begin;
        if (!fill(lines, error)) {
            return LINES_FAIL;
        }
        end = find_end(lines, searched);
    }
    if (lines->drained && (lines->begin == lines->end)) {
        return LINES_END;
    }
    hand_out(lines, end, text, length);
    return LINES_LINE;
}

double lines_fraction(const lines_t *lines)
{
    return bytes_in_fraction(&lines->in);
}

void lines_close(lines_t *lines)
{
    bytes_in_close(&lines->in);
    free(lines->buffer);
    lines->buffer = NULL;
}
