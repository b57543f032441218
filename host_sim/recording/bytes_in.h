/* davar-sim - the bytes of a file, unpacked when it is gzip, from a file, a pipe or standard input ("-"). */
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
    const unsigned char *next; /* of what has been read and not been used */
    size_t left;
    bool at_end; /* the file has no more */
    bytes_place_t place;
    z_stream stream;
    bool unpacking;      /* the stream is to be ended */
    uint64_t taken;      /* bytes used of the file */
    uint64_t given;      /* bytes handed out */
    uint64_t file_bytes; /* as stored; 0: unknown */
    char why[96];
} bytes_in_t;

/* False: no such file, a directory, standard output itself (results would be read as data), no memory. */
bool bytes_in_open(bytes_in_t *in, const char *name, sim_error_t *error);

/* At most `room` bytes (> 0) to `to`; `got` is 0 at the end only. Returns null, or what is wrong: unreadable; gzip that is
 * truncated, corrupt, followed by anything but gzip and zeros, or grows beyond what a recording does. */
const char *bytes_in_read(bytes_in_t *in, void *to, size_t room, size_t *got);

/* How much of the file has been used, 0 to 1; negative when that is unknown (a pipe). */
double bytes_in_fraction(const bytes_in_t *in);

/* Allowed after a failed open. */
void bytes_in_close(bytes_in_t *in);

#endif
