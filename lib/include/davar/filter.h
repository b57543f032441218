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

/** Build option: noise after a filter, of davar_plan_init_filtered, and of davar_plan_init, which
 * knows of none. 0: davar_plan_init_white alone (asserted). */
#ifndef DAVAR_FILTERS
#define DAVAR_FILTERS 1
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define DAVAR_FILTER_ZEROS 31U  /**< zeros of a filter, at most */
#define DAVAR_FILTER_POLES 8U   /**< poles of a filter, at most */
#define DAVAR_FILTER_SPAN 1024U /**< samples over which a filter spreads one, at most */

/** The filter between the gyro's noise and the samples that davar gets, as coefficients at the rate
 * of these samples: y[n] = b[0] x[n] + b[1] x[n - 1] + .. - a[1] y[n - 1] - a[2] y[n - 2] - .., as
 * SciPy and MATLAB print them, and then moving averages. All zeros: no filter. The gain at
 * frequency 0 is ignored: davar assumes that it is 1.
 *
 * Set the coefficients, or let the functions below fill them for the filters of data sheets and
 * firmware. The fields are in their ranges if davar_filter_is_valid. */
typedef struct davar_filter {
    double b[DAVAR_FILTER_ZEROS + 1U]; /**< numerator; unused entries are 0 */
    double a[DAVAR_FILTER_POLES + 1U]; /**< denominator; a[0] is 1, or all are 0: no poles */
    double uncertainty; /**< relative standard uncertainty of the frequency axis, 0 to 0.5 */
    double level; /**< ... of the angle random walk after a filter that was learned, 0 to 0.5 */
    double count_variance; /**< of a count, for white noise of density 1; if summed is above 1 */
    double count_step;     /**< half the mean square of the difference of two counts, similarly */
    uint16_t length;       /**< samples in each moving average, at least 1 */
    uint16_t summed;  /**< counts that are added up in a sample; 0 and 1: a sample is one count */
    uint8_t averages; /**< moving averages in series, 0 to 8; averages * length is at most
                         DAVAR_FILTER_SPAN */
} davar_filter_t;

/** @name Parts in series
 * Each function appends a part to *filter, in the order in which the noise passes them; begin with
 * all zeros. Frequencies are over the rate of the samples at this place: davar_filter_cic and
 * davar_filter_sum lower it for later parts. A part out of its range, or one too many for
 * DAVAR_FILTER_ZEROS and DAVAR_FILTER_POLES, makes the filter invalid for good, which
 * davar_filter_is_valid reports. Cost: below 10 000 operations in doubles, davar_filter_cic and
 * davar_filter_sum: 500 000 and 20 000 times `length` more, and 3.2 kB of stack.
 *
 * Formulas (5.20) to (5.22). @{ */

/** An analogue low-pass of a data sheet, sampled: it must be the first part. cutoff: -3 dB, above
 * 0 and up to 4. poles: 1 or 2 (Butterworth). uncertainty: relative, of cutoff; a data sheet is
 * known to about 0.1. What is above half the sample rate is aliased. */
void davar_filter_low_pass(davar_filter_t *filter, double cutoff, unsigned poles,
                           double uncertainty);

/** The digital Butterworth low-pass of two poles that most flight controllers call biquad or
 * LowPassFilter2p. cutoff: above 0 and below 0.5. */
void davar_filter_biquad(davar_filter_t *filter, double cutoff);

/** The digital low-pass of one pole y += k (x - y) with k = dt / (dt + 1 / (2 pi cutoff)), PT1 or
 * alpha filter. cutoff: above 0 and up to 4. */
void davar_filter_pt1(davar_filter_t *filter, double cutoff);

/** The digital notch of two poles. centre: above 0 and below 0.5. q: 0.1 to 100. */
void davar_filter_notch(davar_filter_t *filter, double centre, double q);

/** Any coefficients. a: null for a_count 0, otherwise a[0] is 1. */
void davar_filter_ba(davar_filter_t *filter, const double *b, unsigned b_count, const double *a,
                     unsigned a_count);

/** Moving averages of `length` samples, 1 to 1024, `order` of them in series, 1 to 8. */
void davar_filter_average(davar_filter_t *filter, unsigned order, unsigned length);

/** The same, then every `length`-th sample, 1 to 4096. */
void davar_filter_cic(davar_filter_t *filter, unsigned order, unsigned length);

/** The sums of `length` counts, 1 to 4096, of which each is a sample. It is the last part. */
void davar_filter_sum(davar_filter_t *filter, unsigned length);

/** @} */

/** Tells whether the fields are in their ranges, and the coefficients stable, soon forgotten
 * (DAVAR_FILTER_SPAN; a cutoff of 0.002 is) and not 0 at frequency 0.
 * Cost: up to 40 000 operations in doubles. */
bool davar_filter_is_valid(const davar_filter_t *filter);

/** Computes the power gain of a filter for white noise at a frequency, relative to that at 0.
 * frequency: over the rate of the samples that davar gets, 0 to 0.5. The filter is valid
 * (asserted).
 * @return At least 0; 1 at frequency 0, and at every frequency if the filter is all zeros.
 *
 * Cost: 100 operations in doubles, and the check. Formula (5.16). */
double davar_filter_power(const davar_filter_t *filter, double frequency);

/** Sets the whitening of law glr for a gyro with `filter`, which is valid (asserted):
 * glr.whiten_first, whiten_second, whiten_level and whiten_tolerance. The detector then keeps its
 * rate of false alarms after the filter, and detects a change about as early as without one. With a
 * cutoff that is wrong by 20 %, false alarms are at most a third more. After a narrow filter and
 * with a sigma below five counts, it delays alarms instead: do not use it. Call it before init, or
 * copy its values into a const configuration (tools/davar-plan --bandwidth prints them).
 * Reads glr.block: set it before. Init rejects one out of range.
 * Cost: O(P (glr.block + order)) in doubles, once, with P = 64 to 16384 points.
 * Formula (10.16). */
void davar_whiten(davar_config_t *config, const davar_filter_t *filter);

/** Sets the bounds of kurtosis and contribution, moments.kurtosis_low to moments.contribution_high,
 * so that about the share `rate` of the windows of unchanged Gaussian noise is unstable: at most
 * 1.5 times `rate` at window.shortest, fewer in longer windows. The bounds of [SONG18] call 19 % of
 * windows of 400 white samples unstable. A stated rate detects small changes later.
 * Reads law, window.shortest and moments.segment, which is below window.shortest (asserted).
 * rate: 1e-4 to 0.1 (asserted). filter: null for white noise.
 * Cost: O(P (order + 32)) in doubles, at most eight times, with P as for davar_whiten.
 * Formula (4.3). */
void davar_bound_unstable_rate(davar_config_t *config, double rate, const davar_filter_t *filter);

#ifdef __cplusplus
}
#endif

#endif
