/* davar tests - any bytes as a recording of davar-sim, plain or gzip. They are rejected with one
 * line that names the file, or accepted. The rows and values are then those of a reader that splits
 * at commas and uses strtod. */
#define _GNU_SOURCE /* memfd_create */
#include "fuzzing.h"
#include "recording/recording.h"

#include <ctype.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>
#include <zlib.h>

#define BYTES_MAX 4096U
#define FIELDS_MAX 64U

enum { IS_GZIP = 1, HAS_LSB = 2, HAS_RATE = 4, IS_FLOAT = 8 };

typedef struct {
    char text[BYTES_MAX + 1U];
    size_t length;
    size_t next;
} expected_t;

/* --- another reader --- */

/* The next line without its end; null after the last. */
static char *line_of(expected_t *expected, size_t *length)
{
    if (expected->next >= expected->length) {
        return NULL;
    }
    char *const line = &expected->text[expected->next];
    char *const end = memchr(line, '\n', expected->length - expected->next);
    *length = (end != NULL) ? (size_t)(end - line) : (expected->length - expected->next);
    expected->next += *length + 1U;
    if ((*length > 0U) && (line[*length - 1U] == '\r')) {
        (*length)--;
    }
    line[*length] = '\0';
    return line;
}

static bool is_blank(const char *line, size_t length)
{
    return strspn(line, " \t") == length;
}

/* The first line after leading comments and blank lines. */
static char *header_of(expected_t *expected, size_t *length)
{
    char *line = line_of(expected, length);
    while ((line != NULL) && (is_blank(line, *length) || (line[0] == '#'))) {
        line = line_of(expected, length);
    }
    return line;
}

static size_t split(char *line, char *field[])
{
    size_t count = 0U;
    for (char *rest = line; (rest != NULL) && (count < FIELDS_MAX); count++) {
        field[count] = strsep(&rest, ",");
    }
    return count;
}

/* A decimal number and nothing else, by the format of recordings. */
static double number_of(const char *field)
{
    char *end = NULL;
    const double value = strtod(field, &end);
    REQUIRE((end != field) && (end[strspn(end, " \t")] == '\0'));
    REQUIRE((strpbrk(field, "xXnNiIpP") == NULL) && isfinite(value));
    return value;
}

static void same_row(const recording_t *recording, uint64_t row, char *field[])
{
    double kept[OPTIONS_COLUMNS_MAX];
    sim_error_t error = {{0}};
    const selection_t *const selection = &recording->selection;
    REQUIRE(spool_read(&recording->samples, row, 1U, kept, &error));
    for (size_t c = 0U; c < selection->count; c++) {
        const double value = number_of(field[selection->column[c]]);
        if ((selection->unit[c] == UNIT_DPS) || (selection->unit[c] == UNIT_OTHER)) {
            REQUIRE((kept[c] >= value) && (kept[c] <= value));
        }
    }
}

static void same(const recording_t *recording, expected_t *expected)
{
    char *field[FIELDS_MAX];
    size_t length = 0U;
    char *line = header_of(expected, &length);
    REQUIRE(line != NULL);
    const size_t columns = split(line, field);
    REQUIRE(columns == recording->header.count);
    uint64_t rows = 0U;
    double newest = -(double)INFINITY;
    for (line = line_of(expected, &length); line != NULL; line = line_of(expected, &length)) {
        REQUIRE(strlen(line) == length);
        if (!is_blank(line, length)) {
            REQUIRE(split(line, field) == columns);
            same_row(recording, rows, field);
            rows++;
            if (recording->has_time) {
                const double now = number_of(field[recording->selection.time]);
                REQUIRE(now >= newest);
                newest = now;
            }
        }
    }
    REQUIRE(rows == recording->rows);
}

/* Two columns of plain numbers: nothing to reject. */
static bool is_plain(const char *text, size_t length)
{
    static const char header[] = "time_s,gyro_z_dps\n";
    if ((length <= sizeof header) || (memcmp(text, header, sizeof header - 1U) != 0)) {
        return false;
    }
    unsigned state = 0U; /* characters of this row: digit, comma, digit, end of line */
    for (size_t i = sizeof header - 1U; i < length; i++) {
        const bool is_right =
            (state % 2U == 0U) ? (text[i] == '1') : (text[i] == ((state == 1U) ? ',' : '\n'));
        if (!is_right) {
            return false;
        }
        state = (state + 1U) % 4U;
    }
    return state == 0U;
}

/* --- davar-sim's reader --- */

static void write_all(int file, const void *data, size_t bytes)
{
    REQUIRE(write(file, data, bytes) == (ssize_t)bytes);
}

static void write_gzip(int file, const uint8_t *data, size_t bytes)
{
    gzFile packed = gzdopen(dup(file), "wb1");
    REQUIRE((packed != NULL) && (gzwrite(packed, data, (unsigned)bytes) == (int)bytes));
    REQUIRE(gzclose(packed) == Z_OK);
}

static void check_message(const sim_error_t *error, const char *name)
{
    REQUIRE(strncmp(error->text, name, strlen(name)) == 0 || strncmp(error->text, "--", 2U) == 0);
    for (const char *c = error->text; *c != '\0'; c++) {
        REQUIRE(!iscntrl((unsigned char)*c));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static expected_t expected;
    bytes_t bytes = {data, data + size};
    const uint8_t how = byte(&bytes);
    const size_t length = (size_t)(bytes.end - bytes.next);
    if (length > BYTES_MAX) {
        return 0;
    }
    const int file = memfd_create("recording", 0U);
    char name[32];
    REQUIRE(file >= 0);
    if ((how & IS_GZIP) != 0U) {
        write_gzip(file, bytes.next, length);
    } else {
        write_all(file, bytes.next, length);
    }
    (void)snprintf(name, sizeof name, "/proc/self/fd/%d", file);
    const options_t options = {.recording = name,
                               .setup = {.lsb = ((how & HAS_LSB) != 0U) ? 0.01 : 0.0,
                                         .rate_hz = ((how & HAS_RATE) != 0U) ? 100.0 : 0.0},
                               .arith = ((how & IS_FLOAT) != 0U) ? ARITH_FLOAT : ARITH_FIXED,
                               .progress = SHOW_NEVER};
    progress_t progress;
    recording_t recording;
    sim_error_t error = {{0}};
    progress_start(&progress, options.progress);
    const bool taken = recording_load(&recording, &options, &progress, &error);
    const bool is_packed = ((how & IS_GZIP) == 0U) && (length >= 2U) && (bytes.next[0] == 0x1FU) &&
                           (bytes.next[1] == 0x8BU);
    if (!taken) {
        check_message(&error, name);
        REQUIRE(!is_plain((const char *)bytes.next, length));
    } else if (!is_packed && (recording.header.count <= FIELDS_MAX) && ((how & HAS_LSB) == 0U)) {
        const size_t mark =
            ((length >= 3U) && (memcmp(bytes.next, "\xEF\xBB\xBF", 3U) == 0)) ? 3U : 0U;
        expected.length = length - mark;
        expected.next = 0U;
        memcpy(expected.text, bytes.next + mark, expected.length);
        same(&recording, &expected);
    }
    recording_free(&recording);
    (void)close(file);
    return 0;
}
