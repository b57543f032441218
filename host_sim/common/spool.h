/* davar-sim - stores records of doubles in a temporary file: a recording of any length in bounded
 * memory. */
#ifndef SPOOL_H
#define SPOOL_H

#include "common/sim_error.h"

#include <stddef.h>
#include <stdint.h>

/* Fields are private except `records`. */
typedef struct {
    int descriptor;
    size_t width;     /* doubles per record */
    double *buffer;   /* records not written yet */
    size_t capacity;  /* size of the buffer, in records */
    size_t buffered;  /* records in the buffer */
    uint64_t records; /* total number of records */
} spool_t;

/* ${TMPDIR:-/tmp} */
const char *spool_folder(void);

/* Makes an empty spool with `width` doubles per record in ${TMPDIR:-/tmp}. The file is unlinked at
 * once, so it disappears with the program. */
bool spool_open(spool_t *spool, size_t width, sim_error_t *error);

/* Appends one record. */
bool spool_put(spool_t *spool, const double *record, sim_error_t *error);

/* Writes buffered records. Needed once between the last put and the first read. */
bool spool_flush(spool_t *spool, sim_error_t *error);

/* Reads `count` records, starting at record `first`. They must exist. */
bool spool_read(const spool_t *spool, uint64_t first, size_t count, double *records,
                sim_error_t *error);

/* Allowed if all zero, and after a failed open. */
void spool_close(spool_t *spool);

#endif
