/* davar-sim - the values of the command line. Derived values are in settings.h. */
#ifndef OPTIONS_H
#define OPTIONS_H

#include "setup/setup.h"

#define OPTIONS_COLUMNS_MAX 256U

typedef enum {
    ARITH_FIXED = 0,
    ARITH_FLOAT,
} arith_t;

/* Where the epoch is in its window. */
typedef enum {
    MODE_TRAILING = 0, /* the newest sample */
    MODE_CENTRED,      /* the middle (centred/) */
} window_mode_t;

typedef enum {
    OUT_CSV = 0,
    OUT_JSONL,
    OUT_TABLE, /* for people */
    OUT_LINK,  /* can:, slcan: or a dialect */
} out_t;

typedef enum {
    SHOW_AUTO = 0, /* if standard error is a terminal and standard output is not */
    SHOW_ALWAYS,
    SHOW_NEVER,
} show_t;

typedef struct {
    setup_t setup;                      /* what davar-node has too */
    const char *recording;              /* "-": standard input */
    char *columns[OPTIONS_COLUMNS_MAX]; /* names in order; allocated */
    size_t column_count;                /* 0: choose by name */
    double full_scale;                  /* 0: not given */
    double gap_factor;                  /* 0: not given */
    uint32_t bits;                      /* 0: not given */
    bool learns_filter;                 /* --bandwidth auto */
    arith_t arith;
    bool mode_given;
    window_mode_t mode;
    bool out_given; /* otherwise a table on a terminal, and CSV elsewhere or with details */
    out_t out;
    const char *link;        /* for OUT_LINK: as in davar_link.h */
    const char *model_table; /* file with the table of the error model; null: none */
    const char *device;      /* command that runs the job on a device; null: run here */
    double pace;             /* times real time; 0: as fast as possible */
    show_t progress;
    bool details;
    bool floor;
} options_t;

/* Before the command line is read. */
extern const options_t options_usual;

/* The table of all options. */
extern const command_t options_command;

/* Reads the command line. COMMAND_BAD: the message names the option. It keeps pointers into
 * argv. */
command_status_t options_parse(options_t *options, int argc, char **argv, sim_error_t *error);

/* Frees what options_parse allocated. */
void options_free(options_t *options);

#endif
