/* davar-sim - complete lines. A write of at most PIPE_BUF bytes to a pipe is atomic. A caught
 * signal does not split a write to a file. */
#include "output/rows_out.h"

#include "common/decimal.h"
#include "common/stop.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define MANY_BYTES 65536U

static bool make_room(rows_out_t *rows, size_t bytes)
{
    if (bytes <= rows->capacity) {
        return true;
    }
    char *text = realloc(rows->text, 2U * bytes);
    if (text != NULL) {
        rows->text = text;
        rows->capacity = 2U * bytes;
    }
    return text != NULL;
}

void rows_out_put(rows_out_t *rows, const char *text)
{
    const size_t length = strlen(text);
    if (!make_room(rows, rows->bytes + length)) {
        rows->lost = true;
    } else if (length > 0U) {
        memcpy(rows->text + rows->bytes, text, length);
        rows->bytes += length;
    } else { /* nothing to put */
    }
}

void rows_out_put_character(rows_out_t *rows, char character)
{
    if (!make_room(rows, rows->bytes + 1U)) {
        rows->lost = true;
    } else {
        rows->text[rows->bytes] = character;
        rows->bytes++;
    }
}

void rows_out_put_cell(rows_out_t *rows, const cell_t *cell, const char *absent)
{
    if (!make_room(rows, rows->bytes + DECIMAL_TEXT_BYTES)) {
        rows->lost = true;
    } else {
        rows->bytes += cell_print(cell, absent, rows->text + rows->bytes);
    }
}

/* Bytes of the lines to write together: as many lines as fit PIPE_BUF, but at least one. */
static size_t piece(const char *text, size_t left)
{
    if (left <= PIPE_BUF) {
        return left;
    }
    for (size_t end = PIPE_BUF; end > 0U; end--) {
        if (text[end - 1U] == '\n') {
            return end;
        }
    }
    const char *end = memchr(text, '\n', left);
    return (end != NULL) ? (size_t)(end - text) + 1U : left;
}

/* A full disk may have accepted part of a line. This truncates a file to the last complete line. */
static void drop_partial_line(const char *text, size_t written)
{
    size_t part = 0;
    while ((part < written) && (text[written - part - 1U] != '\n')) {
        part++;
    }
    struct stat status;
    const off_t at = lseek(STDOUT_FILENO, 0, SEEK_CUR);
    if ((part > 0U) && (fstat(STDOUT_FILENO, &status) == 0) && S_ISREG(status.st_mode) &&
        (status.st_size == at) && (ftruncate(STDOUT_FILENO, at - (off_t)part) == 0)) {
        (void)lseek(STDOUT_FILENO, at - (off_t)part, SEEK_SET);
    }
}

static bool write_piece(const char *text, size_t bytes, sim_error_t *error)
{
    size_t written = 0;
    while (written < bytes) {
        if ((written == 0U) && stop_requested(error)) {
            return false;
        }
        const ssize_t done = write(STDOUT_FILENO, text + written, bytes - written);
        if ((done < 0) && (errno != EINTR)) {
            const int cause = errno;
            drop_partial_line(text, written);
            return sim_fail(error, "standard output: %s", strerror(cause));
        }
        written += (done > 0) ? (size_t)done : 0U;
    }
    return true;
}

bool rows_out_take(rows_out_t *rows, bool now, sim_error_t *error)
{
    if (rows->lost) {
        return sim_fail(error, "out of memory");
    }
    if (!now && (rows->bytes < MANY_BYTES)) {
        return true;
    }
    for (size_t from = 0; from < rows->bytes;) {
        const size_t bytes = piece(rows->text + from, rows->bytes - from);
        if (!write_piece(rows->text + from, bytes, error)) {
            return false;
        }
        from += bytes;
    }
    rows->bytes = 0;
    return true;
}

void rows_out_close(rows_out_t *rows)
{
    free(rows->text);
    *rows = (rows_out_t){0};
}
