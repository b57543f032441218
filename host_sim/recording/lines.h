/* davar-sim - the lines of a text file, plain or gzip, from a file, a pipe or standard input ("-"). */
#ifndef LINES_H
#define LINES_H

#include "recording/bytes_in.h"

#define LINES_LENGTH_MAX ((size_t)256U * 1024U)

/* Fields are private but for `name` and `number`. */
typedef struct {
    const char *name; /* of the file, for messages */
    uint64_t number;  /* of the newest line, from 1 */
    bytes_in_t in;
    char *buffer;
    size_t begin; /* first byte not handed out yet */
    size_t end;   /* behind the last byte read */
    bool drained; /* the file has no more bytes */
} lines_t;

typedef enum {
    LINES_FAIL = -1,
    LINES_END = 0,
    LINES_LINE = 1,
} lines_status_t;

/* Opens `name`, which must outlive it. False: as bytes_in_open. */
bool lines_open(lines_t *lines, const char *name, sim_error_t *error);

/* Hands out the next line without its end ("\n" or "\r\n"; the last line may lack one), zero-terminated, valid until the
 * next call. A UTF-8 byte order mark before the first line is skipped. LINES_FAIL: what bytes_in_read finds,
 * or a line of more than LINES_LENGTH_MAX bytes. */
lines_status_t lines_next(lines_t *lines, char **text, size_t *length, sim_error_t *error);

/* How much of the file has been read, 0 to 1; negative when that is unknown (a pipe). */
double lines_fraction(const lines_t *lines);

void lines_close(lines_t *lines);

#endif
