/* davar-sim - learns the filter of each channel of a recording. */
#ifndef CHANNELS_H
#define CHANNELS_H

#include "learning/learn.h"
#include "recording/recording.h"
#include "recording/timing.h"

/* Writes one entry per selected column. False: a spool fault, or out of memory. */
bool learn_channels(learned_t *learned, const recording_t *recording, const timing_t *timing,
                    const options_t *options, sim_error_t *error);

#endif
