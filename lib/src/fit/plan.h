/* davar - what the files of the fit share: degrees of freedom, numbers with one exponent, the plan. Private to the fit. */
#ifndef DAVAR_FIT_PLAN_H
#define DAVAR_FIT_PLAN_H

#include "davar/fit.h"
#include "number/scaled.h"

/* Terms of a model, and the one that is always there. */
#define TERMS ((int)DAVAR_COEFFICIENT_COUNT)
#define WHITE ((int)DAVAR_ANGLE_RANDOM_WALK)

/* --- what each noise kind does to the overlapping Allan variance (confidence.c) --- */

/* Equivalent degrees of freedom of `differences` overlapping differences at cluster size m, never below 1 (5.1). */
double davar_noise_edf(davar_coefficient_kind_t noise, double m, double differences);

/* (white-noise edf at m) / (differences + m / 2), see (5.1). */
double davar_noise_white_weight(double m);

/* Sum over all lags of the squared cross-correlation of the kernels of two cluster sizes (short <= long), exact (5.3). */
double davar_noise_white_overlap(double m_short, double m_long);

/* Correlation of the Allan variances at two cluster sizes of one long window for a noise kind (5.8). */
double davar_noise_correlation(davar_coefficient_kind_t noise, double m_short, double m_long);

/* Of the fixed point 2.30. */
#define NOISE_BITS 30

/* The lower factor of davar_chi_square for s = edf^-1/2, 0 < s <= 1 (5.2); both as 2.30. */
uint32_t davar_chi_square_low(uint32_t s);

/* 95 % limits of a variance with edf degrees of freedom, edf >= 1, as factors (5.2). */
void davar_chi_square(scaled_t edf, scaled_t *low, scaled_t *high);

/* --- positive numbers with one exponent (aligned.c, 5.14): sums with fixed-point factors are sums of integers --- */

/* Brings the numbers to one exponent, which is returned; their mantissas have 28 bits at most, so that 32 products with factors of 29
 * bits fit 62. What is smaller than the largest loses what lies below its last bit. */
int32_t davar_align(scaled_t value[], int count);

/* Sum of factor[t] * value[t], in units of 2^exponent; 0 where it is negative. */
uint64_t davar_aligned_sum(const int32_t factor[], const scaled_t value[], int count);

/* --- the plan (plan.c) --- */

/* 1.0 in the fixed point of the plan: of a functional, of a share of white noise and its sigma, of the root of edf, and of a
 * misfit. */
#define DAVAR_FIT_FUNCTIONAL_BITS 29U
#define DAVAR_FIT_FUNCTIONAL_ONE 536870912.0
#define DAVAR_FIT_SHARE_BITS 20U
#define DAVAR_FIT_ROOT_BITS 20
#define DAVAR_FIT_MISFIT_ONE 67108864.0

/* Sigma is at most 64 shares; beyond, the cluster sizes do not show the term. */
#define DAVAR_FIT_SIGMA_MOST (UINT32_C(1) << 26U)

/* A centre is taken as at most 2^20: then the smallest share leaves nothing of white noise. */
#define DAVAR_FIT_CENTRE_MOST 1048576.0F

/* A term counts as resolved when its fit, beside a model without it, exceeds this many standard errors (5.7). */
#define DAVAR_FIT_THRESHOLD_QUARTERS 12U
#define DAVAR_FIT_THRESHOLD (DAVAR_FIT_THRESHOLD_QUARTERS / 4.0)

/* An absent term above this many standard errors is a doubt that the intervals of the others must hold (5.10). */
#define DAVAR_FIT_DOUBT_QUARTERS 1U
#define DAVAR_FIT_DOUBT (DAVAR_FIT_DOUBT_QUARTERS / 4.0)

/* Beside a doubt, an estimate with s = edf^-1/2 above this (two standard errors) may be nothing at all (5.10). */
#define DAVAR_FIT_NOTHING 0.36

/* A misfit counts as real when it exceeds its mean by this many times its spread under white noise (5.9). */
#define DAVAR_FIT_MISFIT 5.0

/* One-sided 95 % point of a Gaussian. */
#define DAVAR_FIT_BOUND 1.645

/* How many cluster sizes a window supports: a size that does not fit leaves none of the longer ones, gaps or not. */
uint8_t davar_fit_usable(const davar_result_t *result);

/* Brings a plan for just as many cluster sizes, one at least, up to date with differences and window length in result (5.5). */
void davar_fit_prepare_window(davar_plan_t *plan, const davar_result_t *result);

/* Brings the plan up to date with the cluster sizes, differences and window length in result; needs none of its Allan
 * variances. Nothing is done when the window holds no difference (5.4) (5.5). */
void davar_fit_prepare(davar_plan_t *plan, const davar_result_t *result);

/* From a[k] of avar = sum a[k] m^(k - 2) to the squares of the coefficients in their units (1.2). */
void davar_square_units(double rate_hz, double unit[]);

/* Makes the plan fit a rate: from roots of amplitudes to the coefficients in their units. */
void davar_plan_rate(davar_plan_t *plan, double rate_hz);

/* The share of the differences that is new evidence: 1, or less where the window holds mirror images (5.13) or was chosen (10.14). */
scaled_t davar_fit_evidence(const davar_result_t *result);

#endif
