/* davar-sim - turns the options into a library configuration. */
#ifndef SETTINGS_H
#define SETTINGS_H

#include "options/options.h"

/* The configuration and the arrays it points to: do not copy or move it. */
typedef struct {
    davar_config_t config; /* rate and scale are set later */
    bool is_centred;
    uint32_t taus[DAVAR_TAUS_MAX];
} settings_t;

/* Sets the defaults of options that were not given. False: a tau list that no window allows. The
 * library checks everything else, see settings_check. */
bool settings_make(settings_t *settings, const options_t *options, sim_error_t *error);

/* Checks with the library, before the recording is read, that it accepts the configuration. False:
 * the message names the option. */
bool settings_check(const settings_t *settings, const options_t *options, sim_error_t *error);

/* The fewest samples that give one epoch. */
uint64_t settings_samples_needed(const settings_t *settings);

#endif
