/* davar-sim - decimal text to double: Clinger's exact case here, the rest by strtod. Double to
 * decimal text: in exact integers here, the rest by snprintf. */
#include "common/decimal.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- from text -------------------------------------------------------------------------------- */

#define DIGITS_EXACT 19     /* decimal digits that always fit 64 bits */
#define POWERS_EXACT 22     /* 10^22 is the largest power of ten that is a double */
#define EXPONENT_MAX 100000 /* far above any double; keeps the sum below from overflowing */

/* The parsed number: (-1)^negative * mantissa * 10^exponent. */
typedef struct {
    uint64_t mantissa;
    size_t digits; /* so far, with leading zeros; the mantissa is valid up to DIGITS_EXACT */
    int exponent;
    bool negative;
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

static const char *scan_digits(const char *text, parts_t *parts)
{
    const char *const first = text;
    uint64_t mantissa = parts->mantissa; /* modulo 2^64 */
    for (; is_digit(*text); text++) {
        mantissa = 10U * mantissa + (uint64_t)(*text - '0');
    }
    parts->mantissa = mantissa;
    parts->digits += (size_t)(text - first);
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
    if (parts.digits == 0U) {
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

/* --- to text ---------------------------------------------------------------------------------- */

/* A number in decimal: digits[0].digits[1]digits[2]... * 10^exponent. */
typedef struct {
    char digits[DECIMAL_DIGITS_MAX];
    int exponent;
} written_t;

static char *put(char *to, const char *from, size_t count)
{
    memcpy(to, from, count);
    return to + count;
}

static char *put_zeros(char *to, size_t count)
{
    memset(to, '0', count);
    return to + count;
}

/* The last `count` digits of a value. */
static void put_digits(char *to, uint64_t value, size_t count)
{
    for (; count > 1U; count -= 2U) {
        const unsigned pair = (unsigned)(value % 100U);
        value /= 100U;
        to[count - 1U] = (char)('0' + (pair % 10U));
        to[count - 2U] = (char)('0' + (pair / 10U));
    }
    if (count > 0U) {
        *to = (char)('0' + (value % 10U));
    }
}

size_t decimal_print_whole(uint64_t value, char *text)
{
    size_t count = 1U;
    for (uint64_t rest = value / 10U; rest > 0U; rest /= 10U) {
        count++;
    }
    put_digits(text, value, count);
    text[count] = '\0';
    return count;
}

#ifdef __SIZEOF_INT128__
#define FIVES 27 /* 5^27 is the largest power of five below 2^63 */

__extension__ typedef unsigned __int128 u128_t;

static const uint64_t FIVE[FIVES + 1] = {UINT64_C(1),
                                         UINT64_C(5),
                                         UINT64_C(25),
                                         UINT64_C(125),
                                         UINT64_C(625),
                                         UINT64_C(3125),
                                         UINT64_C(15625),
                                         UINT64_C(78125),
                                         UINT64_C(390625),
                                         UINT64_C(1953125),
                                         UINT64_C(9765625),
                                         UINT64_C(48828125),
                                         UINT64_C(244140625),
                                         UINT64_C(1220703125),
                                         UINT64_C(6103515625),
                                         UINT64_C(30517578125),
                                         UINT64_C(152587890625),
                                         UINT64_C(762939453125),
                                         UINT64_C(3814697265625),
                                         UINT64_C(19073486328125),
                                         UINT64_C(95367431640625),
                                         UINT64_C(476837158203125),
                                         UINT64_C(2384185791015625),
                                         UINT64_C(11920928955078125),
                                         UINT64_C(59604644775390625),
                                         UINT64_C(298023223876953125),
                                         UINT64_C(1490116119384765625),
                                         UINT64_C(7450580596923828125)};

/* mantissa 2^exponent 10^tens, which is below 2^63 and at least 1, rounded down. *rest: the rest as
 * a fraction, compared with a half: -1, 0 or 1. The product of 53 and 63 bits is exact. */
static uint64_t scale(uint64_t mantissa, int exponent, int tens, int *rest)
{
    const u128_t product = (u128_t)mantissa * FIVE[tens];
    const int shift = exponent + tens;
    *rest = -1;
    if (shift >= 0) {
        return (uint64_t)product << (unsigned)shift;
    }
    const u128_t half = (u128_t)1U << (unsigned)(-shift - 1);
    const u128_t below = product & (2U * half - 1U);
    *rest = (below > half) - (below < half);
    return (uint64_t)(product >> (unsigned)-shift);
}

/* floor(log10(2^exponent)) */
static int tens_of(int exponent)
{
    const int offset = 1000;
    return (exponent * 78913 + (offset << 18)) / (1 << 18) - offset;
}

/* Writes `count` digits of a number above 0. False: it is too small or too large for this. */
static bool write(double value, int count, written_t *written)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    const uint64_t top = UINT64_C(1) << 52U;
    const uint64_t mantissa = (bits % top) | top; /* a subnormal number is too small */
    const int exponent = (int)(bits / top) - 1023 - 52;
    const uint64_t end = FIVE[count] << (unsigned)count; /* 10^count */
    written->exponent = tens_of(exponent + 52);          /* or 1 more */
    int tens = count - 1 - written->exponent;
    if ((tens < 1) || (tens > FIVES)) {
        return false;
    }
    int rest;
    uint64_t digits = scale(mantissa, exponent, tens, &rest);
    if (digits >= end) {
        digits = scale(mantissa, exponent, tens - 1, &rest);
        written->exponent++;
    }
    digits += ((rest > 0) || ((rest == 0) && (digits % 2U == 1U))) ? 1U : 0U;
    if (digits == end) {
        digits /= 10U;
        written->exponent++;
    }
    put_digits(written->digits, digits, (size_t)count);
    return true;
}
#else
static bool write(double value, int count, written_t *written)
{
    (void)value;
    (void)count;
    (void)written;
    return false;
}
#endif

/* The digits with a point after the first `before` of them, without zeros at the end. */
static char *put_with_point(char *to, const char *digits, size_t count, size_t before)
{
    if (count <= before) {
        return put_zeros(put(to, digits, count), before - count);
    }
    to = put(to, digits, before);
    *to = '.';
    return put(to + 1, digits + before, count - before);
}

static char *put_exponent(char *to, int exponent)
{
    const unsigned size = (unsigned)((exponent < 0) ? -exponent : exponent);
    to = put(to, (exponent < 0) ? "e-" : "e+", 2U);
    put_digits(to, size, 2U);
    return to + 2;
}

size_t decimal_print(double value, int digits, char *text)
{
    written_t written;
    const double size = fabs(value);
    if (!(size > 0.0) || !isfinite(size) || !write(size, digits, &written)) {
        return (size_t)snprintf(text, DECIMAL_TEXT_BYTES, "%.*g", digits, value);
    }
    size_t count = (size_t)digits;
    while ((count > 1U) && (written.digits[count - 1U] == '0')) {
        count--;
    }
    *text = '-';
    char *end = text + ((value < 0.0) ? 1 : 0);
    if ((written.exponent < -4) || (written.exponent >= digits)) {
        end = put_exponent(put_with_point(end, written.digits, count, 1U), written.exponent);
    } else if (written.exponent < 0) {
        end = put_zeros(put(end, "0.", 2U), (size_t)(-written.exponent - 1));
        end = put(end, written.digits, count);
    } else {
        end = put_with_point(end, written.digits, count, (size_t)written.exponent + 1U);
    }
    *end = '\0';
    return (size_t)(end - text);
}
