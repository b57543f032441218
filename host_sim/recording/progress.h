/* davar-sim - prints "reading 45 %" on standard error about once per second. */
#ifndef PROGRESS_H
#define PROGRESS_H

#include "options/options.h"

typedef struct {
    bool shown;
    bool terminal; /* overwrite the line instead of adding one */
    bool dirty;    /* a message is on the line */
    double next_s; /* monotonic time of the next message */
} progress_t;

void progress_start(progress_t *progress, show_t show);

/* Cheap enough for every block of data. fraction: 0 to 1; negative if unknown, then `rows` is shown
 * instead. */
void progress_show(progress_t *progress, const char *doing, double fraction, uint64_t rows);

/* Clears the line, so that other messages start on a clean one. */
void progress_clear(progress_t *progress);

#endif
