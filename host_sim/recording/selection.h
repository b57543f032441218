/* davar-sim - which columns of the recording are processed. */
#ifndef SELECTION_H
#define SELECTION_H

#include "options/options.h"
#include "recording/header.h"
#include "recording/unit.h"

typedef struct {
    size_t time;                        /* position of time_s; HEADER_NONE without it */
    size_t count;                       /* channels, >= 1 */
    size_t column[OPTIONS_COLUMNS_MAX]; /* position in the row */
    unit_t unit[OPTIONS_COLUMNS_MAX];
    const char *name[OPTIONS_COLUMNS_MAX]; /* owned by the header */
} selection_t;

/* Selects the columns of --column. Without it, selects the first gyro_* column, otherwise the only
 * one that is not time_s. False: unknown or repeated column, no clear default (the message lists
 * the columns), counts without --lsb, or neither time_s nor --rate. */
bool selection_make(selection_t *selection, const header_t *header, const options_t *options,
                    sim_error_t *error);

#endif
