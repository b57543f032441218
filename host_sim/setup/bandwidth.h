/* davar programs - the gyro's filter as a user writes it.
 *
 * - HZ[:ORDER[:PERCENT]]: a low-pass of 1 or 2 poles (2) with its -3 dB frequency, known to so many
 *   percent (10)
 * - average[ORDER]:N: ORDER (1) moving averages of N samples, together at most 1024
 * - cic[ORDER]:N: the same, but every N-th sample is kept
 * - sum:N: the sums of N samples that davar_average makes
 * - FILTER+FILTER: a low-pass and then one of the others
 * - none: no filter */
#ifndef BANDWIDTH_H
#define BANDWIDTH_H

#include "davar/filter.h"

#include <stdbool.h>

/* The forms above, for an error message. */
#define BANDWIDTH_FORMS                                                                            \
    "HZ[:ORDER[:PERCENT]] (order 1 or 2, at most 50 percent), average[ORDER]:N, cic[ORDER]:N or "  \
    "sum:N (N to 4096; ORDER times N of averages to 1024), HZ+average:N or none"

/* The range of a cutoff, for an error message. */
#define BANDWIDTH_RANGE                                                                            \
    "a cutoff from 0.002 times the sample rate to 2 times that before decimation"

/* A filter whose sample rate is not known yet. */
typedef struct {
    davar_filter_t filter; /* cutoff is 0 */
    double hz;             /* its cutoff; 0: no low-pass */
} bandwidth_t;

/* Reads the complete text. False if it has another form, or a value out of range. */
bool bandwidth_read(const char *text, bandwidth_t *bandwidth);

/* Writes the filter for a sample rate. False if its cutoff is out of range for it. */
bool bandwidth_at(const bandwidth_t *bandwidth, double rate_hz, davar_filter_t *filter);

#endif
