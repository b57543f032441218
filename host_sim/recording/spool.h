/* davar-sim - records of doubles in a temporary file: a recording of any length in bounded memory. */
#ifndef SPOOL_H
#define SPOOL_H

#include "common/sim_error.h"

#include <stddef.h>
#include <stdint.h>

/* Fields are private but for `records`. */
typedef struct {
    int descriptor;
    size_t width;     /* doubles per record */
    double *buffer;   /* records not written yet */
    size_t capacity;  /* of the buffer, in records */
    size_t buffered;  /* records in the buffer */
    uint64_t records; /* in all */
} spool_t;

/* ${TMPDIR:-/tmp} */
const char *spool_folder(void);

/* Makes an empty spool of `width` doubles per record in ${TMPDIR:-/tmp}. The file has no name from the start on, so it
 * vanishes with the program. */
bool spool_open(spool_t *spool, size_t width, sim_error_t *error);

/* Appends one record. */
bool spool_put(spool_t *spool, const double *record, sim_error_t *error);

/* Writes out what is buffered; needed once between the last put and the first read. */
bool spool_flush(spool_t *spool, sim_error_t *error);

/* Reads `count` records from record `first` on; they must exist. */
bool spool_read(const spool_t *spool, uint64_t first, size_t count, double *records,
                sim_error_t *error);

/* Allowed on a spool that is all zero or whose open failed. */
void spool_close(spool_t *spool);

#endif
