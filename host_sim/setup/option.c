/* davar programs - option values. */
#include "setup/option.h"

#include "common/decimal.h"

#include <string.h>

bool read_flag(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    (void)option;
    (void)text;
    (void)error;
    *(bool *)place = true;
    return true;
}

bool read_text(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    (void)option;
    (void)error;
    *(const char **)place = text;
    return true;
}

/* Reads digits at *cursor. False: no digits, or *overflow is true and the number exceeds 32
 * bits. */
static bool scan_u32(const char **cursor, uint32_t *value, bool *overflow)
{
    uint64_t sum = 0;
    const char *digit = *cursor;
    *overflow = false;
    for (; (*digit >= '0') && (*digit <= '9'); digit++) {
        sum = 10U * sum + (uint64_t)(*digit - '0');
        if (sum > UINT32_MAX) {
            *overflow = true;
            return false;
        }
    }
    const bool any = (digit != *cursor);
    *cursor = digit;
    *value = (uint32_t)sum;
    return any;
}

static bool fail_u32(const option_t *option, const char *text, bool overflow, sim_error_t *error)
{
    return sim_fail(error, "--%s: %s, found '%s'", option->name,
                    overflow ? "number too large (at most 4294967295)" : "not a whole number",
                    text);
}

bool read_whole(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    bool overflow = false;
    const char *cursor = text;
    return (scan_u32(&cursor, place, &overflow) && (*cursor == '\0')) ||
           fail_u32(option, text, overflow, error);
}

bool read_count(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    optional_u32_t *const count = place;
    count->given = true;
    return read_whole(option, text, &count->value, error);
}

bool option_list(const option_t *option, const char *text, uint32_t *values, size_t capacity,
                 size_t *count, sim_error_t *error)
{
    bool overflow = false;
    const char *cursor = text;
    for (*count = 0; *count < capacity; cursor++) {
        if (!scan_u32(&cursor, &values[*count], &overflow) ||
            ((*cursor != ',') && (*cursor != '\0'))) {
            return fail_u32(option, text, overflow, error);
        }
        (*count)++;
        if (*cursor == '\0') {
            return true;
        }
    }
    return sim_fail(error, "--%s: more than %zu numbers, found '%s'", option->name, capacity, text);
}

bool read_real(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    const char *cursor = text;
    return ((decimal_parse(&cursor, place) == DECIMAL_OK) && (*cursor == '\0')) ||
           sim_fail(error, "--%s: not a finite number, found '%s'", option->name, text);
}

bool read_positive(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    return read_real(option, text, place, error) &&
           ((*(const double *)place > 0.0) ||
            sim_fail(error, "--%s: must be above zero, found '%s'", option->name, text));
}

bool read_range(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    optional_range_t *const range = place;
    const char *cursor = text;
    range->given = true;
    bool good = (decimal_parse(&cursor, &range->low) == DECIMAL_OK) && (*cursor == ':');
    if (good) {
        cursor++;
        good = (decimal_parse(&cursor, &range->high) == DECIMAL_OK) && (*cursor == '\0');
    }
    if (!good) {
        return sim_fail(error, "--%s: two numbers LOW:HIGH expected, found '%s'", option->name,
                        text);
    }
    return ((range->low >= 0.0) && (range->low <= range->high)) ||
           sim_fail(error, "--%s: 0 <= LOW <= HIGH expected, found '%s'", option->name, text);
}

static bool fail_choice(const option_t *option, const char *text, sim_error_t *error)
{
    char words[128];
    size_t used = 0;
    for (const char *c = option->argument; (*c != '\0') && (used + 3U < sizeof words); c++) {
        words[used++] = (*c == '|') ? ',' : *c;
        if (*c == '|') {
            words[used++] = ' ';
        }
    }
    words[used] = '\0';
    return sim_fail(error, "--%s: one of %s expected, found '%s'", option->name, words, text);
}

bool read_choice(const option_t *option, const char *text, void *place, sim_error_t *error)
{
    const size_t length = strlen(text);
    unsigned position = 0;
    for (const char *word = option->argument; *word != '\0'; position++) {
        const size_t span = strcspn(word, "|");
        if ((span == length) && (memcmp(word, text, span) == 0)) {
            memcpy(place, &position, sizeof position);
            return true;
        }
        word += span + ((word[span] == '|') ? 1U : 0U);
    }
    return fail_choice(option, text, error);
}
