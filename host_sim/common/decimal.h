/* davar-sim - converts decimal text to double and back: the same bits as strtod and the same bytes
 * as snprintf, several times faster. */
#ifndef DECIMAL_H
#define DECIMAL_H

#include <stddef.h>
#include <stdint.h>

typedef enum {
    DECIMAL_OK = 0,
    DECIMAL_SYNTAX, /* not a decimal number; also hexadecimal, nan and inf, which strtod accepts */
    DECIMAL_RANGE   /* a decimal number, but above the largest double */
} decimal_status_t;

/* Reads [+-]digits[.digits][e[+-]digits] at *cursor, with at least one digit before the exponent
 * and no leading space. DECIMAL_OK: *value is the nearest double (round half even; too small a
 * number becomes a subnormal or zero) and *cursor points after the last character used. Otherwise
 * both are unchanged. The text must end in a character that cannot continue a number, such as a
 * comma or the terminating zero. Cost: O(characters). */
decimal_status_t decimal_parse(const char **cursor, double *value);

/* `text` has that many bytes. */
#define DECIMAL_TEXT_BYTES 32U

/* Writes a number like printf's %.*g, with 1 to DECIMAL_DIGITS_MAX significant digits, and a
 * terminating zero. Returns the length. */
#define DECIMAL_DIGITS_MAX 17
size_t decimal_print(double value, int digits, char *text);

/* The same for a whole number. */
size_t decimal_print_whole(uint64_t value, char *text);

#endif
