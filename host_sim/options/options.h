/* davar-sim - the values of the command line. Derived values are in settings.h. */
#ifndef OPTIONS_H
#define OPTIONS_H

#include "common/sim_error.h"
#include "davar/can.h"
#include "davar/types.h"
#include "davar_bandwidth.h"
#include "davar_law_id.h"

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
    TAUS_OCTAVE = 0,
    TAUS_GEOMETRIC,
    TAUS_LIST,
} taus_kind_t;

typedef enum {
    OUT_CSV = 0,
    OUT_JSONL,
    OUT_LINK, /* can:, slcan: or a dialect */
} out_t;

typedef enum {
    SHOW_AUTO = 0, /* if standard error is a terminal and standard output is not */
    SHOW_ALWAYS,
    SHOW_NEVER,
} show_t;

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

typedef struct {
    const char *recording;              /* "-": standard input */
    char *columns[OPTIONS_COLUMNS_MAX]; /* names in order; allocated */
    size_t column_count;                /* 0: choose by name */
    double rate_hz;                     /* 0: from the time stamps */
    double lsb;                         /* unit per count; 0: not given */
    double full_scale;                  /* 0: not given */
    double gap_factor;                  /* 0: not given */
    uint32_t bits;                      /* 0: not given */
    bool skips_torn;                    /* --skip-torn-reads */
    bool declares_filter;               /* --bandwidth FILTER */
    bool learns_filter;                 /* --bandwidth auto */
    davar_bandwidth_t bandwidth;
    arith_t arith;
    davar_law_id_t law;
    double false_alarms_per_hour; /* glr; 0: not given */
    double cut_interval_s;        /* glr; 0: not given */
    optional_u32_t shock_blocks;  /* glr */
    optional_u32_t block;         /* glr */
    bool mode_given;
    window_mode_t mode;
    optional_u32_t window_max;
    optional_u32_t window_min;
    optional_u32_t segment;
    optional_u32_t grow;
    optional_u32_t shrink;
    optional_u32_t stride;
    bool uses_grid;
    optional_range_t kurtosis;
    optional_range_t contribution;
    double unstable_rate; /* 0: not given */
    taus_kind_t taus_kind;
    uint32_t taus_wanted;          /* geometric: how many */
    uint32_t taus[DAVAR_TAUS_MAX]; /* list */
    size_t tau_count;
    double longest_tau_s; /* 0: not given */
    out_t out;
    const char *link;        /* for OUT_LINK: as in davar_link.h */
    uint32_t can_base;       /* identifier of channel 0 */
    uint32_t can_content;    /* DAVAR_SEND_* */
    bool raw;                /* send frames of the samples too */
    const char *frames_only; /* the last of the three that was given; null: none */
    uint32_t baud;           /* of a serial line; 0: unchanged */
    const char *model_table; /* file with the table of the error model; null: none */
    const char *device;      /* command that runs the job on a device; null: run here */
    double pace;             /* times real time; 0: as fast as possible */
    show_t progress;
    bool details;
} options_t;

typedef enum {
    OPTIONS_BAD = -1,
    OPTIONS_RUN = 0,
    OPTIONS_HELP,
    OPTIONS_VERSION,
} options_status_t;

/* Reads the command line. OPTIONS_BAD: the message names the option. It keeps pointers into
 * argv. */
options_status_t options_parse(options_t *options, int argc, char **argv, sim_error_t *error);

/* Frees what options_parse allocated. */
void options_free(options_t *options);

#endif
