/* davar-sim - writes complete lines to standard output. However the program ends, the output ends
 * with a complete line. */
#ifndef ROWS_OUT_H
#define ROWS_OUT_H

#include "common/sim_error.h"
#include "output/fields.h"

/* Fields are private. All zero: empty. */
typedef struct {
    char *text;
    size_t bytes;
    size_t capacity;
    bool lost; /* out of memory for some text */
} rows_out_t;

/* Appends text, one character or a cell to the current line. rows_out_take reports errors. `absent`
 * (shorter than DECIMAL_TEXT_BYTES): the text of an absent value. */
void rows_out_put(rows_out_t *rows, const char *text);
void rows_out_put_character(rows_out_t *rows, char character);
void rows_out_put_cell(rows_out_t *rows, const cell_t *cell, const char *absent);

/* Ends the current line. Writes the lines if there are many, or if `now` is true. False: out of
 * memory, standard output accepts no more data, or a signal has arrived. */
bool rows_out_take(rows_out_t *rows, bool now, sim_error_t *error);

/* Discards unwritten lines. */
void rows_out_close(rows_out_t *rows);

#endif
