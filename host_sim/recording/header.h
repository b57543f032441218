/* davar-sim - the header row: column names in order. */
#ifndef HEADER_H
#define HEADER_H

#include "recording/lines.h"

#define HEADER_COLUMNS_MAX 1024U
#define HEADER_NONE SIZE_MAX

typedef struct {
    char *text;                           /* owns the characters of the names */
    const char *name[HEADER_COLUMNS_MAX]; /* surrounding spaces removed */
    size_t count;
} header_t;

/* Skips leading "# key: value" and blank lines and reads the header row. False: no header row,
 * bytes that are not text, an empty or repeated name, or numbers instead of names. */
bool header_read(header_t *header, lines_t *lines, sim_error_t *error);

/* Position of the column with that name; HEADER_NONE if there is no such column. */
size_t header_find(const header_t *header, const char *name);

/* All names, separated by ", ", cut to fit `size` bytes. Returns text. */
const char *header_list(const header_t *header, char *text, size_t size);

void header_free(header_t *header);

#endif
