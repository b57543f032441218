/* davar tests - counts from text of any bytes: every line after the header is one sample or one
 * fault, however the text is split. */
#include "fuzzing.h"
#include "source.h"

#include <ctype.h>
#include <fcntl.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#define TEXT_MAX 12000U
#define ANSWERS_MAX (TEXT_MAX + 8U)

typedef struct {
    size_t count;
    int32_t sample[ANSWERS_MAX];
    bool fault[ANSWERS_MAX];
} answers_t;

/* Reads until the source has no more data for now. */
static source_read_t drain(source_t *source, answers_t *answers)
{
    for (;;) {
        int32_t count = 0;
        const source_read_t answer = source_read(source, &count);
        if ((answer == SOURCE_AGAIN) || (answer == SOURCE_END)) {
            return answer;
        }
        REQUIRE(answers->count < ANSWERS_MAX);
        answers->fault[answers->count] = (answer == SOURCE_FAULT);
        answers->sample[answers->count] = (answer == SOURCE_FAULT) ? 0 : count;
        answers->count++;
    }
}

static void read_all(const uint8_t *text, size_t size, size_t piece, answers_t *answers)
{
    static source_t source;
    int ends[2];
    REQUIRE(pipe(ends) == 0);
    REQUIRE(fcntl(ends[0], F_SETFL, O_NONBLOCK) == 0);
    source = (source_t){.descriptor = ends[0]};
    answers->count = 0U;
    for (size_t at = 0U; at < size; at += piece) {
        const size_t bytes = (piece < (size - at)) ? piece : size - at;
        REQUIRE(write(ends[1], text + at, bytes) == (ssize_t)bytes);
        (void)drain(&source, answers);
    }
    (void)close(ends[1]);
    REQUIRE(drain(&source, answers) != SOURCE_SAMPLE);
    REQUIRE(drain(&source, answers) == SOURCE_END);
    source_close(&source);
}

/* True if this line precedes all samples. `last`: all lines after it are samples. */
static bool is_front(const uint8_t *line, size_t length, bool *last)
{
    length -= ((length > 0U) && (line[length - 1U] == '\r')) ? 1U : 0U;
    *last = (length > 0U) && (line[0] != '#');
    const bool word = (length == 3U) && ((strncasecmp((const char *)line, "nan", 3U) == 0) ||
                                         (strncasecmp((const char *)line, "inf", 3U) == 0));
    return !*last || ((isalpha(line[0]) != 0) && !word);
}

static size_t lines_of(const uint8_t *text, size_t size)
{
    size_t lines = 0U;
    bool begun = false;
    for (size_t at = 0U; at < size;) {
        const uint8_t *const end = memchr(text + at, '\n', size - at);
        const size_t length = (end != NULL) ? (size_t)(end - (text + at)) : size - at;
        lines += (begun || !is_front(text + at, length, &begun)) ? 1U : 0U;
        at += length + 1U;
    }
    return lines;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static answers_t whole;
    static answers_t pieces;
    if ((size < 1U) || (size > TEXT_MAX)) {
        return 0;
    }
    const size_t piece = 1U + data[0];
    read_all(data + 1, size - 1U, TEXT_MAX, &whole);
    read_all(data + 1, size - 1U, piece, &pieces);
    REQUIRE(whole.count == pieces.count);
    REQUIRE(memcmp(whole.sample, pieces.sample, whole.count * sizeof whole.sample[0]) == 0);
    REQUIRE(memcmp(whole.fault, pieces.fault, whole.count * sizeof whole.fault[0]) == 0);
    REQUIRE(whole.count == lines_of(data + 1, size - 1U));
    return 0;
}
