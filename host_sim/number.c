/* davar-sim - decimal text to double: Clinger's exact case by hand, the rest by strtod. */
#include "number.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

#define DIGITS_EXACT 19     /* decimal digits that always fit 64 bits */
#define POWERS_EXACT 22     /* 10^22 is the largest power of ten that is a double */
#define EXPONENT_MAX 100000 /* beyond it strtod decides; keeps the sum below from overflowing */

/* What the characters say: (-1)^negative * mantissa * 10^exponent. */
typedef struct {
    uint64_t mantissa;
    int digits; /* significant digits seen, leading zeros not counted */
    int exponent;
    bool negative;
    bool any_digit;
} decimal_t;

static bool is_digit(char c)
{
    return (c >= '0') && (c <= '9');
}

static const char *scan_sign(const char *text, bool *negative)
{
    *negative = (*text == '-');
    return ((*text == '-') || (*text == '+')) ? text + 1 : text;
}

/* Digits beyond DIGITS_EXACT are counted, not kept: such a number goes to strtod. */
static const char *scan_digits(const char *text, decimal_t *decimal)
{
    for (; is_digit(*text); text++) {
        decimal->any_digit = true;
        if (decimal->digits < DIGITS_EXACT) {
            decimal->mantissa = 10U * decimal->mantissa + (uint64_t)(*text - '0');
        }
        if (decimal->mantissa != 0U) {
            decimal->digits++;
        }
    }
    return text;
}

static const char *scan_fraction(const char *text, decimal_t *decimal)
{
    if (*text != '.') {
        return text;
    }
    const char *first = text + 1;
    const char *end = scan_digits(first, decimal);
    decimal->exponent -= (end - first > EXPONENT_MAX) ? EXPONENT_MAX : (int)(end - first);
    return end;
}

/* An 'e' without digits behind it does not belong to the number: the cursor stays on it. */
static const char *scan_exponent(const char *text, decimal_t *decimal)
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
    decimal->exponent += negative ? -exponent : exponent;
    return digit;
}

/* Mantissa and power of ten both exact: one rounding, hence the correct one. Not so where doubles are computed wider. */
static bool is_exact_case(const decimal_t *decimal)
{
    return (FLT_EVAL_METHOD == 0) && (decimal->digits <= DIGITS_EXACT) && (decimal->mantissa <= (UINT64_C(1) << 53)) &&
           (decimal->exponent >= -POWERS_EXACT) && (decimal->exponent <= POWERS_EXACT);
}

static double exact_value(const decimal_t *decimal)
{
    static const double POWER[POWERS_EXACT + 1] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,
                                                   1e8,  1e9,  1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
                                                   1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    const double magnitude = (decimal->exponent < 0) ? (double)decimal->mantissa / POWER[-decimal->exponent]
                                                     : (double)decimal->mantissa * POWER[decimal->exponent];
    return decimal->negative ? -magnitude : magnitude;
}

number_status_t number_parse(const char **cursor, double *value)
{
    decimal_t decimal = {0};
    const char *end = scan_sign(*cursor, &decimal.negative);
    end = scan_fraction(scan_digits(end, &decimal), &decimal);
    if (!decimal.any_digit) {
        return NUMBER_SYNTAX;
    }
    end = scan_exponent(end, &decimal);
    const double parsed = is_exact_case(&decimal) ? exact_value(&decimal) : strtod(*cursor, NULL);
    if (!isfinite(parsed)) {
        return NUMBER_RANGE;
    }
    *value = parsed;
    *cursor = end;
    return NUMBER_OK;
}
