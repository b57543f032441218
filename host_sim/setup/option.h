/* davar programs - an option of a command line, and the functions that read its value. */
#ifndef OPTION_H
#define OPTION_H

#include "common/sim_error.h"

#include <stddef.h>
#include <stdint.h>

typedef struct option_row option_t;

/* Reads the value of an option into `place`. False: a bad value; the message names the option. */
typedef bool option_read_t(const option_t *option, const char *text, void *place,
                           sim_error_t *error);

/* An entry without a name and a reader is a heading of the help; one without a help text, too, ends
 * a list. */
struct option_row {
    const char *name;
    const char *argument; /* as --help shows it; null: the option takes no value */
    option_read_t *read;
    size_t offset;    /* in the program's values, of the member that it sets */
    const char *help; /* lines of --help; null: none */
};

/* A whole number that is optional. */
typedef struct {
    bool given;
    uint32_t value;
} optional_u32_t;

/* Two bounds that are optional. */
typedef struct {
    bool given;
    double low;
    double high;
} optional_range_t;

option_read_t read_flag;     /* no value -> bool */
option_read_t read_text;     /* any text -> const char * */
option_read_t read_whole;    /* 0 .. 2^32 - 1, digits only -> uint32_t */
option_read_t read_count;    /* the same -> optional_u32_t */
option_read_t read_real;     /* a finite number -> double */
option_read_t read_positive; /* a finite number above zero -> double */
option_read_t read_range;    /* LOW:HIGH, 0 <= LOW <= HIGH -> optional_range_t */
option_read_t read_choice;   /* a word of `argument` -> its position, an enum */

/* Reads a comma-separated list of whole numbers. False also if it is longer than `capacity`. */
bool option_list(const option_t *option, const char *text, uint32_t *values, size_t capacity,
                 size_t *count, sim_error_t *error);

#endif
