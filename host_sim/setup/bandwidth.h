/* davar programs - the gyro's filter as a user writes it: parts in series with + between them, in
 * the order in which the noise passes them, or none.
 *
 * - HZ[:ORDER[:PERCENT]]: an analogue low-pass of 1 or 2 poles (2) with its -3 dB frequency, known
 *   to PERCENT (10); only as the first part
 * - biquad:HZ, pt1:HZ, notch:HZ:Q, each with [:PERCENT] (0): digital, at the sample rate
 * - average[ORDER]:N: ORDER (1) moving averages of N samples
 * - cic[ORDER]:N: the same, then every N-th sample is kept
 * - sum:N: the sums of N samples that davar_average makes; only as the last part
 * - ba:B0,B1,..[:A1,A2,..[:PERCENT]]: coefficients at the sample rate; the angle random walk after
 *   them is known to PERCENT (0)
 *
 * The sample rate is the one at the place of the part. */
#ifndef BANDWIDTH_H
#define BANDWIDTH_H

#include "davar/filter.h"

/* Reads the complete text as a filter for samples at rate_hz; 0: checks only its form, and the
 * filter is not valid. Returns null, or what was expected, for an error message. */
const char *bandwidth_read(const char *text, double rate_hz, davar_filter_t *filter);

/* True if a part has a frequency, so that the filter depends on the rate. The form is good. */
bool bandwidth_has_hz(const char *text);

#endif
