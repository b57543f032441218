/* davar-sim - determines sample rate and gaps from the time stamps or from --rate. */
#ifndef TIMING_H
#define TIMING_H

#include "recording/recording.h"

typedef struct {
    double rate_hz;
    double period_s;
    double gap_limit_s;  /* a longer step is a gap; infinite: gaps are not detected */
    double mean_rate_hz; /* rows divided by time; 0 if the time stamps are not used */
    double stamped_hz;   /* with --rate: rows divided by time, for a note; 0: no time stamps */
    uint64_t gaps;       /* steps that are gaps, by the time stamps */
    uint64_t steps;
    uint64_t breaks; /* rows with samples missing before them; 0: the spool below is unused */
    spool_t missing; /* per row: samples missing just before it */
} timing_t;

/* Without --rate the period is the median time step. False: only one row, a median step of zero, or
 * a spool fault. */
bool timing_find(timing_t *timing, const recording_t *recording, const options_t *options,
                 sim_error_t *error);

/* Reads how many samples are missing before each of `count` rows. */
bool timing_missing(const timing_t *timing, uint64_t first, size_t count, double *missing,
                    sim_error_t *error);

/* True if --rate and the time stamps differ by more than 20 %. */
bool timing_is_contradicted(const timing_t *timing);

/* True if the samples do not look evenly spaced: median and mean rate differ by more than 20 %, or
 * more than 5 % of the steps are gaps. */
bool timing_is_doubtful(const timing_t *timing);

/* Allowed if all zero, and after a failed find. */
void timing_close(timing_t *timing);

#endif
