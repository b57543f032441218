/* davar-sim - converts decimal text to double: the same bits as strtod, several times faster. */
#ifndef DECIMAL_H
#define DECIMAL_H

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

#endif
