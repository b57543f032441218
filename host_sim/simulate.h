/* davar-sim - the whole job on one page. */
#ifndef SIMULATE_H
#define SIMULATE_H

#include "options/options.h"

/* Recording in, results on standard output. False: the message says why. */
bool simulate(const options_t *options, sim_error_t *error);

#endif
