/* davar-sim - whole lines to standard output: however the program ends, the output ends at the end of a line. */
#ifndef ROWS_OUT_H
#define ROWS_OUT_H

#include "common/sim_error.h"

#include <stddef.h>

/* Fields are private. All zero: no lines. */
typedef struct {
    char *text;
    size_t bytes;
    size_t capacity;
    bool lost; /* there was no memory for a piece of text */
} rows_out_t;

/* A piece of the line at work. What fails is told by rows_out_take. */
void rows_out_put(rows_out_t *rows, const char *text);

/* The line at work is whole; lines are written when they are many, or `now`. False: no memory, standard output takes no
 * more, or a signal asks to stop. */
bool rows_out_take(rows_out_t *rows, bool now, sim_error_t *error);

/* What has not been written is lost. */
void rows_out_close(rows_out_t *rows);

#endif
