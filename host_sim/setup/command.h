/* davar programs - reads a command line by a table of options, and prints the table as help. */
#ifndef COMMAND_H
#define COMMAND_H

#include "setup/option.h"

typedef struct {
    const char *name;   /* of the program */
    const char *before; /* text of the help before the options, and after them */
    const char *after;
    const option_t *const *lists; /* in the order of the help; the last is null */
    /* Stores a word that is not an option. `last` is the option before it; null: none. */
    bool (*read_word)(void *values, const option_t *last, const char *word, sim_error_t *error);
} command_t;

typedef enum {
    COMMAND_BAD = -1,
    COMMAND_RUN = 0,
    COMMAND_HELP, /* these two options: every program has them, and they end the command line */
    COMMAND_VERSION,
} command_status_t;

/* Reads the command line into `values`, which keeps pointers into argv. COMMAND_BAD: the message
 * names the option. */
command_status_t command_read(const command_t *command, void *values, int argc, char **argv,
                              sim_error_t *error);

/* Prints what --help or --version stands for. False: another status, or standard output failed. */
bool command_show(const command_t *command, command_status_t status, sim_error_t *error);

/* Reads one option by its name. */
bool command_set(const command_t *command, void *values, const char *name, const char *text,
                 sim_error_t *error);

#endif
