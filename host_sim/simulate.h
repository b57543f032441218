/* davar-sim - runs the complete job. */
#ifndef SIMULATE_H
#define SIMULATE_H

#include "options/options.h"

/* Reads the recording and writes results to standard output. False: error has the message. */
bool simulate(const options_t *options, sim_error_t *error);

#endif
