/* davar-sim - what the user should know beside the results, on standard error. */
#ifndef REPORT_H
#define REPORT_H

#include "instances/engine.h"
#include "recording/recording.h"
#include "recording/timing.h"

/* Before the run: choices made for the user, and what looks odd. */
void report_notes(const options_t *options, const recording_t *recording, const timing_t *timing,
                  const quantisation_t *quantisation);

/* After the run: one line when anything out of the ordinary was counted. */
void report_weather(const davar_health_t *health);

/* After the run: why so many of the results have no coefficients. */
void report_coarse(uint64_t coarse, uint64_t rows);

#endif
