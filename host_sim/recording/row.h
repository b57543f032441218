/* davar-sim - one row of numbers. */
#ifndef ROW_H
#define ROW_H

#include "recording/header.h"

/* Reads the row that is the newest line: values[0 .. header->count - 1]. False: a field that is no finite decimal number,
 * or another number of fields than the header has; the message names line and column. */
bool row_parse(const lines_t *lines, const char *text, size_t length, const header_t *header,
               double *values, sim_error_t *error);

/* Reports a value of the newest line as unusable: "FILE:LINE: column NAME: what, found 'value'". Returns false. */
bool row_fail(const lines_t *lines, const char *column, const char *what, double found,
              sim_error_t *error);

#endif
