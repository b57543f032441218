/* davar-sim - sample rate and gaps, from the time stamps or from --rate. */
#ifndef TIMING_H
#define TIMING_H

#include "recording/recording.h"

typedef struct {
    double rate_hz;
    double period_s;
    double gap_limit_s;  /* a longer step is a gap; infinite: no gaps are looked for */
    double mean_rate_hz; /* rows over time; 0 when the time stamps do not matter */
    double stamped_hz; /* with --rate: rows over time all the same, for a note; 0: no time stamps */
    uint64_t gaps;     /* steps that are gaps */
    uint64_t steps;
} timing_t;

/* Without --rate the period is the median time step. False: one row only, a median step of zero, or a spool fault. */
bool timing_find(timing_t *timing, const recording_t *recording, const options_t *options,
                 sim_error_t *error);

/* Samples that a step of so many seconds leaves out: 0 when it is no gap. */
uint32_t timing_missing(const timing_t *timing, double step_s);

/* True when --rate and the time stamps are more than 20 % apart. */
bool timing_is_contradicted(const timing_t *timing);

/* True when the time stamps do not look like those of evenly spaced samples: median and mean rate more than 20 % apart,
 * or more than 5 % of the steps are gaps. */
bool timing_is_doubtful(const timing_t *timing);

#endif
