/* davar-sim - lines of a file. zlib tells gzip from plain text by content. */
#include "lines.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define ZLIB_BUFFER_BYTES 131072U
#define BYTE_ORDER_MARK "\xEF\xBB\xBF"

static int open_descriptor(const char *name)
{
    return (strcmp(name, "-") == 0) ? dup(STDIN_FILENO) : open(name, O_RDONLY | O_CLOEXEC);
}

static bool inspect(lines_t *lines, int descriptor, sim_error_t *error)
{
    struct stat status;
    if (fstat(descriptor, &status) != 0) {
        return sim_fail(error, "%s: %s", lines->name, strerror(errno));
    }
    if (S_ISDIR(status.st_mode)) {
        return sim_fail(error, "%s: is a directory, not a recording", lines->name);
    }
    lines->file_bytes = S_ISREG(status.st_mode) ? (uint64_t)status.st_size : 0U;
    return true;
}

static bool attach(lines_t *lines, int descriptor, sim_error_t *error)
{
    if (!inspect(lines, descriptor, error)) {
        return false;
    }
    lines->file = gzdopen(descriptor, "rb");
    lines->buffer = malloc(LINES_LENGTH_MAX + 1U);
    if ((lines->file == NULL) || (lines->buffer == NULL)) {
        return sim_fail(error, "%s: out of memory", lines->name);
    }
    (void)gzbuffer(lines->file, ZLIB_BUFFER_BYTES);
    return true;
}

bool lines_open(lines_t *lines, const char *name, sim_error_t *error)
{
    *lines = (lines_t){.name = name};
    const int descriptor = open_descriptor(name);
    if (descriptor < 0) {
        return sim_fail(error, "%s: %s", name, strerror(errno));
    }
    if (attach(lines, descriptor, error)) {
        return true;
    }
    if (lines->file == NULL) {
        (void)close(descriptor);
    }
    lines_close(lines);
    return false;
}

static bool fail_reading(const lines_t *lines, sim_error_t *error)
{
    const int saved_errno = errno;
    int code = Z_OK;
    const char *detail = gzerror(lines->file, &code);
    if (code == Z_BUF_ERROR) {
        return sim_fail(error, "%s:%" PRIu64 ": gzip data ends too early (truncated file)", lines->name, lines->number);
    }
    if (code == Z_ERRNO) {
        return sim_fail(error, "%s: %s", lines->name, strerror(saved_errno));
    }
    return sim_fail(error, "%s:%" PRIu64 ": corrupt gzip data (%s)", lines->name, lines->number, detail);
}

/* A truncated gzip file shows as end of file with an error code set, not as a failed read. */
static bool read_more(lines_t *lines, sim_error_t *error)
{
    const unsigned room = (unsigned)(LINES_LENGTH_MAX - lines->end);
    const int got = gzread(lines->file, lines->buffer + lines->end, room);
    int code = Z_OK;
    (void)gzerror(lines->file, &code);
    if ((got < 0) || ((got == 0) && (code != Z_OK))) {
        return fail_reading(lines, error);
    }
    lines->end += (size_t)got;
    lines->drained = (got == 0);
    return true;
}

/* Moves the unfinished line to the front and reads on behind it. */
static bool fill(lines_t *lines, sim_error_t *error)
{
    const size_t kept = lines->end - lines->begin;
    memmove(lines->buffer, lines->buffer + lines->begin, kept);
    lines->begin = 0;
    lines->end = kept;
    if (kept == LINES_LENGTH_MAX) {
        return sim_fail(error, "%s:%" PRIu64 ": line longer than %zu bytes; not a recording", lines->name,
                        lines->number + 1U, LINES_LENGTH_MAX);
    }
    return read_more(lines, error);
}

/* Where the line ends; null while its end has not been read. */
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
    const z_off_t offset = gzoffset(lines->file);
    if ((lines->file_bytes == 0U) || (offset < 0)) {
        return -1.0;
    }
    const double fraction = (double)offset / (double)lines->file_bytes;
    return (fraction < 1.0) ? fraction : 1.0;
}

void lines_close(lines_t *lines)
{
    if (lines->file != NULL) {
        (void)gzclose(lines->file);
    }
    free(lines->buffer);
    *lines = (lines_t){0};
}
