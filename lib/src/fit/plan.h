/* davar - shared by the files of the fit: degrees of freedom, sums of aligned numbers, the plan.
 * Private to the fit. */
#ifndef DAVAR_FIT_PLAN_H
#define DAVAR_FIT_PLAN_H

#include "davar/fit.h"
#include "number/hop.h"
#include "number/scaled.h"

/* The number of terms, and the term that every model has. */
#define TERMS ((int)DAVAR_COEFFICIENT_COUNT)
#define WHITE ((int)DAVAR_ANGLE_RANDOM_WALK)

/* --- degrees of freedom and limits (confidence.c) --- */

/* Equivalent degrees of freedom of `differences` overlapping differences at cluster size m, never
 * below 1 (5.1). */
double davar_noise_edf(davar_coefficient_kind_t noise, double m, double differences);

/* The same for `differences` at a hop of m / lags, m large (11.6). */
double davar_hop_edf(davar_coefficient_kind_t noise, uint32_t differences, uint32_t lags);

/* The edf of white noise at m over (differences + m / 2) (5.1). */
double davar_noise_white_weight(double m);

/* Sum over all lags of the squared cross-correlation of the kernels of two cluster sizes (short <=
 * long), exact (5.3). */
double davar_noise_white_overlap(double m_short, double m_long);

/* Correlation of the Allan variances at two cluster sizes of one long window for a noise kind
 * (5.8). */
double davar_noise_correlation(davar_coefficient_kind_t noise, double m_short, double m_long);

/* Fixed point 2.30, and a product of two. */
#define NOISE_BITS 30

static inline uint32_t noise_times(uint32_t a, uint32_t b)
{
    return davar_upper_product(a, b) << 2U;
}

/* The lower factor of davar_chi_square for s = edf^-1/2, 0 < s <= 1 (5.2); both as 2.30. */
uint32_t davar_chi_square_low(uint32_t s);

/* 95 % limits of a variance with edf degrees of freedom, edf >= 1, as factors (5.2). */
void davar_chi_square(scaled_t edf, scaled_t *low, scaled_t *high);

/* --- positive numbers with one exponent (5.14): their sums are sums of integers --- */

/* Brings the numbers to one exponent and returns it. Mantissas then have at most 28 bits, so 32
 * products with factors of 29 bits fit 62 bits. Smaller numbers lose their bits below the last one
 * of the largest. */
int32_t davar_align(scaled_t value[], int count);

/* Sum of factor[t] * value[t], in units of 2^exponent. */
int64_t davar_aligned_sum(const int32_t factor[], const scaled_t value[], int count);

/* --- the plan (plan.c) --- */

/* The fixed point of functionals, of shares of white noise and their sigma, of the root of edf, and
 * of a misfit. */
#define DAVAR_FIT_FUNCTIONAL_BITS 29U
#define DAVAR_FIT_FUNCTIONAL_ONE 536870912.0
#define DAVAR_FIT_SHARE_BITS 20U
#define DAVAR_FIT_ROOT_BITS 20
#define DAVAR_FIT_MISFIT_ONE 67108864.0

/* The fixed point of 1 / gain, which the narrowest low-pass makes 3e6. */
#define DAVAR_FIT_GAIN_BITS 9U

/* Sigma is at most 64 shares; above, the cluster sizes do not resolve the term. */
#define DAVAR_FIT_SIGMA_MOST (UINT32_C(1) << 26U)

/* A centre is at most 2^20: the smallest share then leaves no white noise. It is at least 2^-32, so
 * that it fits a shift. After a filter it can be negative; the term then takes nothing. */
#define DAVAR_FIT_CENTRE_MOST 1048576.0F
#define DAVAR_FIT_CENTRE_LEAST 2.3283064365386963e-10F

/* A term is resolved if its fit, next to a model without it, exceeds this many standard errors
 * (5.7). */
#define DAVAR_FIT_THRESHOLD_QUARTERS 12U
#define DAVAR_FIT_THRESHOLD (DAVAR_FIT_THRESHOLD_QUARTERS / 4.0)

/* The gains of an uncertain filter do not change linearly: a quarter more variance (5.16). */
#define DAVAR_FIT_AXIS_MARGIN 1.25

/* A cluster size passes the filter if its gain is at least this (5.16). */
#define DAVAR_FIT_PASSED 0.35F

/* An absent term above this many standard errors widens the intervals of the others (5.10). */
#define DAVAR_FIT_DOUBT_QUARTERS 1U
#define DAVAR_FIT_DOUBT (DAVAR_FIT_DOUBT_QUARTERS / 4.0)

/* A drift that was not found counts as so much larger than it seems, in standard errors: where the
 * test just misses it, it is larger on average (5.10). */
#define DAVAR_FIT_MISSED_QUARTERS 6U
#define DAVAR_FIT_MISSED (DAVAR_FIT_MISSED_QUARTERS / 4.0)

/* Then an estimate with s = edf^-1/2 above this (two standard errors) may be 0 (5.10). */
#define DAVAR_FIT_NOTHING 0.36

/* A misfit is real if it exceeds its mean by this many times its spread under white noise (5.9). */
#define DAVAR_FIT_MISFIT 5.0

/* One-sided 95 % point of a Gaussian. */
#define DAVAR_FIT_BOUND 1.645

/* Element of plan->covariance for t <= u. */
static inline int plan_pair(int t, int u)
{
    return ((u * (u + 1)) / 2) + t;
}

/* Writes the sizes and forgets everything else. */
void davar_plan_start(davar_plan_t *plan, const uint32_t *m, uint8_t count);

/* Writes the covariances of size u with itself and with shorter sizes for white samples (5.3). */
void davar_plan_white_row(davar_plan_t *plan, int u);

/* Solves the plan for its first `count` sizes (5.4). */
void davar_plan_solve(davar_plan_t *plan, uint8_t count);

/* Number of cluster sizes that the window supports. If one size has no differences, no longer one
 * counts. Those of a cascade do not count. */
uint8_t davar_fit_usable(const davar_result_t *result);

/* Updates a plan that has as many cluster sizes, at least one, to the differences and window length
 * in result (5.5). */
void davar_fit_prepare_window(davar_plan_t *plan, const davar_result_t *result);

/* Updates the plan to the cluster sizes, differences and window length in result, but reads no
 * Allan variance. Does nothing if the window has no difference (5.4) (5.5). Returns
 * davar_fit_usable. */
uint8_t davar_fit_prepare(davar_plan_t *plan, const davar_result_t *result);

/* Factors from a[k] of avar = sum a[k] m^(k - 2) to the squared coefficients of (1.2). */
void davar_square_units(double rate_hz, double unit[]);

/* Sets the factors from roots of amplitudes to coefficients in their units, if the rate is new. */
void davar_plan_rate(davar_plan_t *plan, double rate_hz);

/* Share of the differences that is new evidence: below 1 for mirror images (5.13) and chosen
 * windows (10.14). */
scaled_t davar_fit_evidence(const davar_result_t *result);

/* Share of the degrees of freedom of a whole window that a cluster size has: gaps, and evidence. 1
 * for a cascade, whose differences are counted one by one. */
double davar_fit_kept(const davar_result_t *result, const davar_adev_t *tau);

#endif
