/* davar programs - what davar-sim and davar-node have in common: options, and the configuration
 * that follows from them. */
#ifndef SETUP_H
#define SETUP_H

#include "davar/can.h"
#include "davar/filter.h"
#include "davar/floor.h"
#include "davar_curve.h"
#include "davar_law_id.h"
#include "setup/bandwidth.h"
#include "setup/command.h"

typedef enum {
    TAUS_OCTAVE = 0,
    TAUS_GEOMETRIC,
    TAUS_LIST,
} taus_kind_t;

typedef enum {
    ENGINE_AUTO = 0,
    ENGINE_GRID,
} engine_choice_t;

#define SETUP_FILTER 1024U /* characters of a filter: 40 coefficients in full precision */

/* The values of the options. Those of a program begin with them. */
typedef struct {
    double rate_hz;            /* 0: not given, also below */
    double lsb;                /* unit per count */
    bool skips_torn;           /* --skip-torn-reads */
    char filter[SETUP_FILTER]; /* --bandwidth FILTER, whose form is good; "": undeclared */
    davar_law_id_t law;
    optional_u32_t window_max;
    optional_u32_t window_min;
    optional_u32_t segment;
    optional_range_t kurtosis;
    optional_range_t contribution;
    double unstable_rate;
    optional_u32_t grow;
    optional_u32_t shrink;
    taus_kind_t taus_kind;
    uint32_t taus_wanted;          /* geometric: how many */
    uint32_t taus[DAVAR_TAUS_MAX]; /* list */
    size_t tau_count;
    double longest_tau_s;
    double false_alarms_per_hour; /* glr, also below */
    double cut_interval_s;
    optional_u32_t block;
    optional_u32_t shock_blocks;
    optional_u32_t stride;
    engine_choice_t engine;
    uint32_t can_base;       /* identifier of channel 0 */
    uint32_t can_content;    /* DAVAR_SEND_* */
    bool raw;                /* send frames of the samples too */
    const char *frames_only; /* the last of these three options that was given; null: none */
    uint32_t baud;           /* of a serial line; 0: unchanged */
} setup_t;

/* Before the command line is read. */
#define SETUP_USUAL                                                                                \
    {                                                                                              \
        .law = DAVAR_LAW_ID_OR, .can_base = DAVAR_CAN_BASE,                                        \
        .can_content = DAVAR_SEND_ADEV | DAVAR_SEND_COEFFICIENTS                                   \
    }

/* The options that are equal in both programs, in three lists. */
extern const option_t setup_law[], setup_window[], setup_glr[];

/* Options with a help text or a name of each program. */
option_read_t setup_read_base;    /* hexadecimal; these three: -> setup_t */
option_read_t setup_read_content; /* a word of `argument`: summary|full|intervals|fd */
option_read_t setup_read_raw;

/* Writes the configuration for trailing windows and wide counts, and its cluster sizes into
 * taus[DAVAR_TAUS_MAX]. False: options that contradict each other. */
bool setup_configure(const setup_t *setup, davar_config_t *config, uint32_t *taus,
                     sim_error_t *error);

/* Checks with the library, without memory, that it accepts the configuration. False: the message
 * names the option. */
bool setup_check(const davar_config_t *config, bool is_float, sim_error_t *error);

/* Reports an error of the library as "--option: cause". Returns false. */
bool setup_fail(davar_status_t status, bool is_float, sim_error_t *error);

/* Reads the value of --bandwidth, and checks its form. `other`: what else
 * the option takes, for the error message. */
bool setup_read_filter(setup_t *setup, const char *text, const char *other, sim_error_t *error);

/* Writes the declared filter for a sample rate. */
bool setup_filter(const setup_t *setup, double rate_hz, davar_filter_t *filter, sim_error_t *error);

/* Sets what follows from the filter: whitening, and the bounds of --unstable-rate. filter null:
 * unknown. */
void setup_adapt(const setup_t *setup, davar_config_t *config, const davar_filter_t *filter);

/* Plans the floor of one channel, for --floor. filter null: unknown. False: it is, or the library
 * rejects the configuration; the message names the channel. */
bool setup_floor(const davar_config_t *config, davar_port_number_t number,
                 const davar_filter_t *filter, const char *name, davar_floor_plan_t *plan,
                 sim_error_t *error);

/* Sets the cluster sizes of a result: those of the window, then every octave up to --longest-tau.
 * False: the cascade would have no size, or more than it can have. */
bool setup_curve(const setup_t *setup, const davar_config_t *config, davar_port_number_t number,
                 davar_curve_t *curve, sim_error_t *error);

#endif
