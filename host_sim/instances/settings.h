/* davar-sim - from options to a library configuration. */
#ifndef SETTINGS_H
#define SETTINGS_H

#include "davar/types.h"
#include "options/options.h"

/* The configuration and what it points to: do not copy or move it. */
typedef struct {
    davar_config_t config; /* rate and scale are still open */
    uint32_t taus[DAVAR_TAUS_MAX];
} settings_t;

/* Fills in what the options leave out. False: a tau list that no window allows. Everything else is checked by the
 * library, see settings_check. */
bool settings_make(settings_t *settings, const options_t *options, sim_error_t *error);

/* Asks the library, before the recording is read, whether it would accept the configuration. False: no, and which option
 * is concerned. */
bool settings_check(const settings_t *settings, const options_t *options, sim_error_t *error);

/* Reports a refusal of the library as "--option: cause". Returns false. */
bool settings_fail(davar_status_t status, const options_t *options, sim_error_t *error);

/* Samples a recording needs at least to give one epoch. */
uint64_t settings_samples_needed(const davar_config_t *config);

#endif
