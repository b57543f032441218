/* davar-sim - the table of options: name, whether it takes a value, and a handler for the value. */
#ifndef OPTION_TABLE_H
#define OPTION_TABLE_H

#include "options/options.h"

/* Stores the value of one option. False: a bad value; the message names the option. */
typedef bool (*option_apply_t)(options_t *options, const char *text, sim_error_t *error);

typedef struct {
    const char *name;
    option_apply_t apply; /* null: the option takes no value; options.c handles it */
} option_entry_t;

/* All long options; the last entry has a null name. */
extern const option_entry_t OPTION_TABLE[];

/* Adds the column names of a comma list. */
bool option_add_columns(options_t *options, const char *text, sim_error_t *error);

#endif
