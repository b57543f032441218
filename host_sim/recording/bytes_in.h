/* davar-sim - reads the bytes of a file, a pipe or standard input ("-"), and unpacks gzip. */
#ifndef BYTES_IN_H
#define BYTES_IN_H

#include "common/sim_error.h"

#include <stddef.h>
#include <stdint.h>
#include <zlib.h>

typedef enum { BYTES_PLAIN = 0, BYTES_MEMBER, BYTES_BETWEEN, BYTES_PADDING } bytes_place_t;

/* Fields are private. */
typedef struct {
    int descriptor;
    unsigned char *buffer;
    const unsigned char *next; /* first unused byte of the buffer */
    size_t left;
    bool at_end; /* end of the file */
    bytes_place_t place;
    z_stream stream;
    bool unpacking;      /* the zlib stream must be ended */
    uint64_t taken;      /* bytes of the file used so far */
    uint64_t given;      /* bytes returned so far */
    uint64_t file_bytes; /* size of the file; 0: unknown */
    char why[96];
} bytes_in_t;

/* False: no such file, a directory, standard output itself (results would be read as data), or out
 * of memory. */
bool bytes_in_open(bytes_in_t *in, const char *name, sim_error_t *error);

/* Writes at most `room` bytes (> 0) to `to`; `got` is 0 only at the end. Returns null, or the
 * error: unreadable, or gzip data that is truncated, corrupt, followed by anything except gzip and
 * zeros, or grows more than a recording does. */
const char *bytes_in_read(bytes_in_t *in, void *to, size_t room, size_t *got);

/* The part of the file that has been used, 0 to 1; negative if the size is unknown (a pipe). */
double bytes_in_fraction(const bytes_in_t *in);

/* Allowed after a failed open. */
void bytes_in_close(bytes_in_t *in);

#endif
