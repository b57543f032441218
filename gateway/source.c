/* davar-node - counts from text: a header, then one count per line. If a line has commas, only its
 * first field is read. A line is read completely or it is a fault. */
#include "source.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#define NUMBER_BYTES 24U /* of a count with sign, leading spaces and zeros */

bool source_open(source_t *source, const char *where)
{
    const bool is_value = (strncmp(where, "value:", 6) == 0);
    *source = (source_t){.is_value = is_value};
    if (strcmp(where, "-") == 0) {
        source->descriptor = dup(STDIN_FILENO);
    } else {
        source->descriptor = open(is_value ? where + 6 : where, O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    }
    struct stat what;
    if ((source->descriptor < 0) || (fstat(source->descriptor, &what) != 0)) {
        return false;
    }
    if (S_ISDIR(what.st_mode)) {
        errno = EISDIR;
        return false;
    }
    const int flags = fcntl(source->descriptor, F_GETFL);
    return fcntl(source->descriptor, F_SETFL, flags | O_NONBLOCK) == 0;
}

/* Reads a 32-bit whole number with only spaces around it, up to the first comma or the end. */
static source_read_t parse(const char *text, size_t length, int32_t *count)
{
    char number[NUMBER_BYTES + 1U];
    const char *comma = memchr(text, ',', length);
    size_t size = (comma != NULL) ? (size_t)(comma - text) : length;
    while ((size > 0U) && (strchr(" \t\r", text[size - 1U]) != NULL) && (text[size - 1U] != '\0')) {
        size--;
    }
    if ((size == 0U) || (size > NUMBER_BYTES) || (memchr(text, '\0', length) != NULL)) {
        return SOURCE_FAULT;
    }
    memcpy(number, text, size);
    number[size] = '\0';
    char *end = NULL;
    errno = 0;
    const long long value = strtoll(number, &end, 10);
    const char *start = number + strspn(number, " \t"); /* strtoll also skips line ends */
    if ((strchr("\r\v\f", *start) != NULL) || (end == number) || (*end != '\0') || (errno != 0) ||
        (value > INT32_MAX) || (value < INT32_MIN)) {
        return SOURCE_FAULT;
    }
    *count = (int32_t)value;
    return SOURCE_SAMPLE;
}

static source_read_t read_value(source_t *source, int32_t *count)
{
    const ssize_t got = pread(source->descriptor, source->text, sizeof source->text, 0);
    if ((got <= 0) || ((size_t)got == sizeof source->text)) {
        return SOURCE_FAULT;
    }
    return parse(source->text, (size_t)got - ((source->text[got - 1] == '\n') ? 1U : 0U), count);
}

/* The length of the first line in the buffer, without its end. False: no complete line yet. */
static bool find_line(const source_t *source, size_t *length)
{
    const char *end = memchr(source->text, '\n', source->held);
    *length = (end != NULL) ? (size_t)(end - source->text) : source->held;
    return (end != NULL) || (source->ended && (source->held > 0U)) ||
           (source->held == sizeof source->text);
}

static void drop_line(source_t *source, size_t length)
{
    const size_t all = (length < source->held) ? length + 1U : length;
    source->too_long =
        (all == sizeof source->text) && (length == all); /* the remainder is not a line */
    source->held -= all;
    memmove(source->text, source->text + all, source->held);
}

static source_read_t fill(source_t *source)
{
    const ssize_t got =
        read(source->descriptor, source->text + source->held, sizeof source->text - source->held);
    if (got > 0) {
        source->held += (size_t)got;
        return SOURCE_SAMPLE;
    }
    source->ended = (got == 0);
    return ((got == 0) || (errno == EAGAIN) || (errno == EINTR)) ? SOURCE_AGAIN : SOURCE_FAULT;
}

static bool is_no_number(const char *text, size_t length)
{
    return (length == 3U) &&
           ((strncasecmp(text, "nan", 3) == 0) || (strncasecmp(text, "inf", 3) == 0));
}

/* Empty lines and notes (#), then one line that begins with a letter. After that line, or after the
 * first count, every line is a sample. */
static bool is_header(source_t *source, const char *text, size_t length)
{
    const size_t bare = length - (((length > 0U) && (text[length - 1U] == '\r')) ? 1U : 0U);
    if (source->started) {
        return false;
    }
    if ((bare == 0U) || (text[0] == '#')) {
        return true;
    }
    source->started = true;
    return (isalpha((unsigned char)text[0]) != 0) && !is_no_number(text, bare);
}

/* Reads the first line in the buffer: a sample, a fault, or (AGAIN) neither. */
static source_read_t take_line(source_t *source, size_t length, int32_t *count)
{
    source_read_t answer = SOURCE_AGAIN;
    const bool rest = source->too_long; /* the rest of a line that already was a fault */
    if (!rest && !is_header(source, source->text, length)) {
        answer = (length < sizeof source->text) ? parse(source->text, length, count) : SOURCE_FAULT;
    }
    drop_line(source, length);
    return answer;
}

source_read_t source_read(source_t *source, int32_t *count)
{
    size_t length = 0;
    if (source->is_value) {
        return read_value(source, count);
    }
    for (;;) {
        const bool whole = find_line(source, &length);
        if (!whole && source->ended) {
            return SOURCE_END;
        }
        const source_read_t answer = whole ? take_line(source, length, count) : fill(source);
        if (whole && (answer != SOURCE_AGAIN)) {
            return answer;
        }
        if (!whole && (answer != SOURCE_SAMPLE) && !source->ended) {
            return answer;
        }
    }
}

void source_close(source_t *source)
{
    (void)close(source->descriptor);
}
