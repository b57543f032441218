/* davar-sim - converts decimal text to double: Clinger's exact case here, the rest by strtod. */
#include "common/decimal.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

#define DIGITS_EXACT 19     /* decimal digits that always fit 64 bits */
#define POWERS_EXACT 22     /* 10^22 is the largest power of ten that is a double */
#define EXPONENT_MAX 100000 /* far above any double; keeps the sum below from overflowing */

/* The parsed number: (-1)^negative * mantissa * 10^exponent. */
typedef struct {
    uint64_t mantissa;
    int digits; /* significant digits so far, without leading zeros */
    int exponent;
    bool negative;
    bool any_digit;
    bool capped; /* an exponent was above EXPONENT_MAX, so `exponent` is not valid */
} parts_t;

static bool is_digit(char c)
{
    return (c >= '0') && (c <= '9');
}

static const char *scan_sign(const char *text, bool *negative)
{
    *negative = (*text == '-');
    return ((*text == '-') || (*text == '+')) ? text + 1 : text;
}

/* Counts digits after the first DIGITS_EXACT, but does not keep them: strtod converts such a
 * number. */
static const char *scan_digits(const char *text, parts_t *parts)
{
    for (; is_digit(*text); text++) {
        parts->any_digit = true;
        if (parts->digits < DIGITS_EXACT) {
            parts->mantissa = 10U * parts->mantissa + (uint64_t)(*text - '0');
        }
        if (parts->mantissa != 0U) {
            parts->digits++;
        }
    }
    return text;
}

static const char *scan_fraction(const char *text, parts_t *parts)
{
    if (*text != '.') {
        return text;
    }
    const char *first = text + 1;
    const char *end = scan_digits(first, parts);
    parts->capped = (end - first > EXPONENT_MAX);
    parts->exponent -= parts->capped ? 0 : (int)(end - first);
    return end;
}

/* An 'e' without digits after it is not part of the number: the cursor stays on it. */
static const char *scan_exponent(const char *text, parts_t *parts)
{
    if ((*text != 'e') && (*text != 'E')) {
        return text;
    }
    bool negative = false;
    const char *digit = scan_sign(text + 1, &negative);
    if (!is_digit(*digit)) {
        return text;
    }
    int exponent = 0;
    for (; is_digit(*digit); digit++) {
        if (exponent < EXPONENT_MAX) {
            exponent = 10 * exponent + (*digit - '0');
        }
    }
    parts->capped = parts->capped || (exponent >= EXPONENT_MAX);
    parts->exponent += negative ? -exponent : exponent;
    return digit;
}

/* If mantissa and power of ten are both exact, one rounding gives the correct result. This does not
 * apply where doubles are computed with extra precision. */
static bool is_exact_case(const parts_t *parts)
{
    return (FLT_EVAL_METHOD == 0) && !parts->capped && (parts->digits <= DIGITS_EXACT) &&
           (parts->mantissa <= (UINT64_C(1) << 53)) && (parts->exponent >= -POWERS_EXACT) &&
           (parts->exponent <= POWERS_EXACT);
}

static double exact_value(const parts_t *parts)
{
    static const double POWER[POWERS_EXACT + 1] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                   1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                   1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    const double magnitude = (parts->exponent < 0)
                                 ? (double)parts->mantissa / POWER[-parts->exponent]
                                 : (double)parts->mantissa * POWER[parts->exponent];
    return parts->negative ? -magnitude : magnitude;
}

decimal_status_t decimal_parse(const char **cursor, double *value)
{
    parts_t parts = {0};
    const char *end = scan_sign(*cursor, &parts.negative);
    end = scan_fraction(scan_digits(end, &parts), &parts);
    if (!parts.any_digit) {
        return DECIMAL_SYNTAX;
    }
    end = scan_exponent(end, &parts);
    const double parsed = is_exact_case(&parts) ? exact_value(&parts) : strtod(*cursor, NULL);
    if (!isfinite(parsed)) {
        return DECIMAL_RANGE;
    }
    *value = parsed;
    *cursor = end;
    return DECIMAL_OK;
}
