/* davar-sim - one row of numbers. */
#ifndef ROW_H
#define ROW_H

#include "recording/header.h"

/* Reads the newest line as a row: values[0 .. header->count - 1]. False: a field is not a finite
 * decimal number, or the number of fields differs from the header. The message names line and
 * column. */
bool row_parse(const lines_t *lines, const char *text, size_t length, const header_t *header,
               double *values, sim_error_t *error);

/* Reports a bad value of the newest line: "FILE:LINE: column NAME: what, found 'value'". Returns
 * false. */
bool row_fail(const lines_t *lines, const char *column, const char *what, double found,
              sim_error_t *error);

#endif
