/* davar-node - counts from text. A line that starts with '#' or a letter (a header) is passed over; of a line with
 * commas the first field counts. */
#include "source.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

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

static source_read_t parse(const char *text, int32_t *count)
{
    char *end = NULL;
    errno = 0;
    const long long value = strtoll(text, &end, 10);
    const bool number = (end != text) && ((*end == '\0') || (*end == ',') || isspace((unsigned char)*end));
    if (!number || (errno != 0) || (value > INT32_MAX) || (value < INT32_MIN)) {
        return SOURCE_FAULT;
    }
    *count = (int32_t)value;
    return SOURCE_SAMPLE;
}

static source_read_t read_value(const source_t *source, int32_t *count)
{
    char text[64];
    const ssize_t got = pread(source->descriptor, text, sizeof text - 1U, 0);
    if (got <= 0) {
        return SOURCE_FAULT;
    }
    text[got] = '\0';
    return parse(text, count);
}

/* Takes one line out of what is held into `line`; false: no whole line yet. */
static bool take_line(source_t *source, char *line, size_t size)
{
    const char *end = memchr(source->text, '\n', source->held);
    const bool last = source->ended && (source->held > 0U);
    if ((end == NULL) && !last && (source->held < sizeof source->text)) {
        return false;
    }
    const size_t length = (end != NULL) ? (size_t)(end - source->text) : source->held;
    const size_t kept = (length < size) ? length : size - 1U;
    memcpy(line, source->text, kept);
    line[kept] = '\0';
    source->held -= (end != NULL) ? length + 1U : length;
    memmove(source->text, source->text + ((end != NULL) ? length + 1U : length), source->held);
    source->line++;
    return true;
}

static source_read_t fill(source_t *source)
{
    const ssize_t got = read(source->descriptor, source->text + source->held, sizeof source->text - source->held);
    if (got > 0) {
        source->held += (size_t)got;
        return SOURCE_SAMPLE;
    }
    source->ended = (got == 0);
    return ((got == 0) || (errno == EAGAIN) || (errno == EINTR)) ? SOURCE_AGAIN : SOURCE_FAULT;
}

static bool is_header(const char *line)
{
    return (line[0] == '#') || (line[0] == '\0') || (isalpha((unsigned char)line[0]) != 0);
}

source_read_t source_read(source_t *source, int32_t *count)
{
    char line[64];
    if (source->is_value) {
        return read_value(source, count);
    }
    for (;;) {
        if (take_line(source, line, sizeof line)) {
            if (!is_header(line)) {
                return parse(line, count);
            }
        } else if (source->ended) {
            return SOURCE_END;
        } else {
            const source_read_t answer = fill(source);
            if ((answer != SOURCE_SAMPLE) && !source->ended) {
                return answer;
            }
        }
    }
}

void source_close(source_t *source)
{
    (void)close(source->descriptor);
}
