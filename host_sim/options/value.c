/* davar-sim - option values. */
#include "options/value.h"

#include "common/decimal.h"

#include <stdio.h>
#include <string.h>

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

static bool fail_u32(const char *option, const char *text, bool overflow, sim_error_t *error)
{
    return sim_fail(error, "--%s: %s, found '%s'", option,
                    overflow ? "number too large (at most 4294967295)" : "not a whole number",
                    text);
}

bool value_u32(const char *option, const char *text, uint32_t *value, sim_error_t *error)
{
    bool overflow = false;
    const char *cursor = text;
    if (!scan_u32(&cursor, value, &overflow) || (*cursor != '\0')) {
        return fail_u32(option, text, overflow, error);
    }
    return true;
}

bool value_u32_list(const char *option, const char *text, uint32_t *values, size_t capacity,
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
    return sim_fail(error, "--%s: more than %zu numbers, found '%s'", option, capacity, text);
}

bool value_positive(const char *option, const char *text, double *value, sim_error_t *error)
{
    const char *cursor = text;
    if ((decimal_parse(&cursor, value) != DECIMAL_OK) || (*cursor != '\0')) {
        return sim_fail(error, "--%s: not a finite number, found '%s'", option, text);
    }
    if (!(*value > 0.0)) {
        return sim_fail(error, "--%s: must be above zero, found '%s'", option, text);
    }
    return true;
}

bool value_range(const char *option, const char *text, double *low, double *high,
                 sim_error_t *error)
{
    const char *cursor = text;
    bool good = (decimal_parse(&cursor, low) == DECIMAL_OK) && (*cursor == ':');
    if (good) {
        cursor++;
        good = (decimal_parse(&cursor, high) == DECIMAL_OK) && (*cursor == '\0');
    }
    if (!good) {
        return sim_fail(error, "--%s: two numbers LOW:HIGH expected, found '%s'", option, text);
    }
    if ((*low < 0.0) || (*low > *high)) {
        return sim_fail(error, "--%s: 0 <= LOW <= HIGH expected, found '%s'", option, text);
    }
    return true;
}

static void list_words(const char *const *words, size_t count, char *text, size_t size)
{
    size_t used = 0;
    for (size_t w = 0; (w < count) && (used < size); w++) {
        const int wrote =
            snprintf(text + used, size - used, "%s%s", (w > 0U) ? ", " : "", words[w]);
        used += (wrote > 0) ? (size_t)wrote : 0U;
    }
}

bool value_choice(const char *option, const char *text, const char *const *words, size_t count,
                  size_t *choice, sim_error_t *error)
{
    for (size_t w = 0; w < count; w++) {
        if (strcmp(text, words[w]) == 0) {
            *choice = w;
            return true;
        }
    }
    char list[256] = "";
    list_words(words, count, list, sizeof list);
    return sim_fail(error, "--%s: one of %s expected, found '%s'", option, list, text);
}
