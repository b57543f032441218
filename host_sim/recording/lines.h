/* davar-sim - reads the lines of a text file, plain or gzip, from a file, a pipe or standard input
 * ("-"). */
#ifndef LINES_H
#define LINES_H

#include "recording/bytes_in.h"

#define LINES_LENGTH_MAX ((size_t)256U * 1024U)

/* Fields are private except `name` and `number`. */
typedef struct {
    const char *name; /* name of the file, for messages */
    uint64_t number;  /* number of the newest line, from 1 */
    bytes_in_t in;
    char *buffer;
    size_t begin; /* first byte not returned yet */
    size_t end;   /* after the last byte read */
    bool drained; /* the file has no more bytes */
} lines_t;

typedef enum {
    LINES_FAIL = -1,
    LINES_END = 0,
    LINES_LINE = 1,
} lines_status_t;

/* Opens `name`, which must outlive it. False: see bytes_in_open. */
bool lines_open(lines_t *lines, const char *name, sim_error_t *error);

/* Returns the next line without its end ("\n" or "\r\n"; the last line may lack one),
 * zero-terminated, valid until the next call. Skips a UTF-8 byte order mark before the first line.
 * LINES_FAIL: an error of bytes_in_read, or a line of more than LINES_LENGTH_MAX bytes. */
lines_status_t lines_next(lines_t *lines, char **text, size_t *length, sim_error_t *error);

/* The part of the file that has been read, 0 to 1; negative if the size is unknown (a pipe). */
double lines_fraction(const lines_t *lines);

void lines_close(lines_t *lines);

#endif
