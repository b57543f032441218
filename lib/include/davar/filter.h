/** @file
 * davar - filter: what is between the noise of a gyro and the samples that davar gets, for the fit
 * (davar/fit.h) and for the window laws.
 *
 * Arithmetic: IEEE double with + - * / and sqrt only, so every target computes the same bits. No
 * function allocates memory, blocks or reads a clock.
 *
 * Threads: the functions keep no state. */
#ifndef DAVAR_FILTER_H
#define DAVAR_FILTER_H

#include "davar/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The filter between the gyro's noise and the samples that davar gets: a low-pass, then moving
 * averages, then every n-th sample. All zeros: no filter. DAVAR_LOW_PASS and DAVAR_SUM initialise
 * the common ones, alone or both: davar_filter_t filter = {DAVAR_LOW_PASS(250, 1000, 2),
 * DAVAR_SUM(8)}. */
typedef struct davar_filter {
    double
        cutoff; /**< -3 dB over the rate of the samples that davar gets, 0.002 to 2 times decimation */
    double uncertainty; /**< relative standard uncertainty of cutoff, 0 to 0.5 */
    uint8_t poles; /**< of an analogue low-pass, sampled: 1, 2 (Butterworth), or 0: no low-pass */
    uint8_t averages; /**< moving averages in series, 0 to 8; a CIC of order n has n */
    /** samples in each moving average, before the decimation, 1 to 4096; averages * length is at
     * most DAVAR_FILTER_SPAN_MOST samples after the decimation */
    uint16_t length;
    uint16_t decimation; /**< every n-th sample is kept; 0 and 1: every sample */
    /** counts that are added up in a sample; above 1, averages is 1 and the two fields above
     * are the same number. 0 and 1: a sample is one count */
    uint16_t summed;
} davar_filter_t;

/** Samples over which all moving averages of a filter together may spread a sample. */
#define DAVAR_FILTER_SPAN_MOST 1024U

/** A low-pass of 1 or 2 poles with its -3 dB frequency in Hz, known to 10 %. rate_hz: rate of the
 * samples that davar gets. */
#define DAVAR_LOW_PASS(hz, rate_hz, order)                                                         \
    .cutoff = (double)(hz) / (double)(rate_hz), .uncertainty = 0.1, .poles = (order)

/** The sums of `n` samples each. 1: each sample is one count, for C++ compilers that warn about the
 * fields that DAVAR_LOW_PASS omits. */
#define DAVAR_SUM(n) .averages = 1U, .length = (n), .decimation = (n), .summed = (n)

/** Computes the power gain of a filter for white noise at a frequency, relative to that at 0.
 * frequency: over the rate of the samples that davar gets, 0 to 0.5. Aliases are included. The
 * fields of *filter are in their ranges (asserted).
 * @return At least 0; 1 at frequency 0, and at every frequency if the filter is all zeros.
 *
 * Cost: O(decimation) in doubles. Formula (5.16). */
double davar_filter_power(const davar_filter_t *filter, double frequency);

/** Sets the whitening of law glr for a gyro with `filter`, whose fields are in their ranges
 * (asserted): glr.whiten_first, whiten_second, whiten_level and whiten_tolerance. The detector
 * then keeps its rate of false alarms after the filter, and detects a change about as early as
 * without one. With a cutoff that is wrong by 20 %, false alarms are at most a third more. After a
 * narrow filter and with a sigma below five counts, it delays alarms instead: do not use it. Call
 * it before init, or copy its values into a const configuration (tools/davar-plan --bandwidth
 * prints them).
 * Reads glr.block: set it before. Init rejects one out of range.
 * Cost: O(P (decimation + glr.block)) in doubles, once, with P = 4 / cutoff, 64 to 16384 points.
 * Formula (10.16). */
void davar_whiten(davar_config_t *config, const davar_filter_t *filter);

/** Sets the bounds of kurtosis and contribution, moments.kurtosis_low to moments.contribution_high,
 * so that about the share `rate` of the windows of unchanged Gaussian noise is unstable: at most
 * 1.5 times `rate` at window.shortest, fewer in longer windows. The bounds of [SONG18] call 19 % of
 * windows of 400 white samples unstable. A stated rate detects small changes later.
 * Reads law, window.shortest and moments.segment, which is below window.shortest (asserted).
 * rate: 1e-4 to 0.1 (asserted). filter: null for white noise.
 * Cost: O(P (decimation + 32)) in doubles, at most eight times, with P as for davar_whiten.
 * Formula (4.3). */
void davar_bound_unstable_rate(davar_config_t *config, double rate, const davar_filter_t *filter);

#ifdef __cplusplus
}
#endif

#endif
