/** @file
 * davar - fit: the noise coefficients of a window from its Allan deviations, with 95 % intervals.
 *
 * davar_fit_white estimates the angle random walk; davar_fit estimates all five terms. Both are
 * optional steps after davar_take and are linked only if they are called. The header also lists the
 * cluster sizes to configure, and the degrees of freedom and intervals that the fits use.
 *
 * Arithmetic: integers, and IEEE floating point with + - * / and sqrt only. Every target computes
 * the same bits (DESIGN 5.14). No function allocates memory, blocks or reads a clock.
 *
 * Threads: the functions keep no state. One plan serves one caller at a time.
 *
 * Cost: T cluster sizes. Instructions for each core: docs/COST.md. */
#ifndef DAVAR_FIT_H
#define DAVAR_FIT_H

#include "davar/filter.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What the fit of white noise reads for windows of one length without gaps, at one sample rate.
 * tools/davar-plan writes it as a constant for davar_fit_white_whole; davar_plan_t keeps it up to
 * date for every window. Fields are private. */
typedef struct {
    /** @privatesection */
    uint8_t count;      /* usable cluster sizes that the plan is solved for */
    uint8_t passed;     /* the first size that the filter passes, or the last one */
    uint8_t white_bits; /* the functional of white noise is in units of 2^white_bits */
    bool declared;      /* the filter is known, or known to be absent */
    uint32_t window;    /* length without gaps and mirror images that it fits (5.5), or 0 */
    /* Of the filter, for white noise of variance 1 before it (5.16). */
    float sample;    /* variance of a sample */
    float hidden;    /* root of white noise, in counts, that rounding hides (5.15) */
    float step;      /* N^2 over rounding times this: whether rounding is white; 0: it is */
    uint32_t coarse; /* rounding of a sample over white noise from which it hides it, as 2.30 */
    double rounding_variance; /* of a sample, in squared counts */
    uint64_t misfit_limit;
    double unit;    /* of the root of white noise, to deg/sqrt(h), at the rate */
    float rounding; /* white noise that rounding of variance 1 looks like (5.15) */
    /* Of the usable sizes (5.4), and of the window (5.5). */
    uint32_t white_tails; /* what tails add to 1 / edf of white noise */
    uint32_t white_low;
    float white_high;
    uint32_t sigma[DAVAR_COEFFICIENT_COUNT];
    uint32_t doubt[DAVAR_COEFFICIENT_COUNT];
    float centre[DAVAR_COEFFICIENT_COUNT];
    float rounding_most[DAVAR_COEFFICIENT_COUNT]; /* largest amplitude of rounding of variance 1 */
    uint32_t root_edf[DAVAR_TAUS_MAX];
    float high[DAVAR_TAUS_MAX];            /* upper limits of the deviations */
    float to_white[DAVAR_TAUS_MAX];        /* m / gain */
    uint32_t inverse_gain[DAVAR_TAUS_MAX]; /* 23.9; at most 2^23 */
    int32_t functional[DAVAR_COEFFICIENT_COUNT]
                      [DAVAR_TAUS_MAX]; /* white noise, and each term with it */
} davar_white_plan_t;

/** Everything a fit needs that does not depend on the Allan deviations: a cache, not a history.
 * The caller owns it. Fields are private. */
typedef struct davar_plan {
    /** @privatesection */
    davar_white_plan_t white;
    uint8_t sizes; /* usable cluster sizes that the plan is solved for (5.4), of all sizes */
    int8_t variance_exponent[DAVAR_COEFFICIENT_COUNT]; /* powers of two: the units of variance */
    /* Of the cluster sizes and the filter. */
    float m[DAVAR_TAUS_MAX];
    float gain[DAVAR_TAUS_MAX];    /* m avar */
    float flicker[DAVAR_TAUS_MAX]; /* root of the share of flicker that passes the filter */
    float walk[DAVAR_TAUS_MAX];    /* ... of random walk */
    float offset[DAVAR_TAUS_MAX];  /* relative error of gain by one standard error of the axis */
    float level;                   /* ... of the white noise by a filter that was learned */
    float covariance[(DAVAR_TAUS_MAX * (DAVAR_TAUS_MAX + 1)) / 2]; /* of m avar / gain, times n */
    float spread; /* samples over which the filter spreads a sample of noise (5.19) */
    float floor;  /* variance of the rounding that covariance includes */
    float weight[DAVAR_TAUS_MAX];
    float freedom[DAVAR_TAUS_MAX]; /* degrees of freedom per effective difference */
    /* Of the usable sizes. */
    float doubtful[DAVAR_TAUS_MAX]; /* offset^2 / 2 that the amplitude of white noise leaves */
    int32_t variance[DAVAR_COEFFICIENT_COUNT][DAVAR_TAUS_MAX]; /* of the amplitudes */
    float offset_variance[DAVAR_COEFFICIENT_COUNT];            /* ... by the uncertain cutoff */
    float scale[DAVAR_COEFFICIENT_COUNT]; /* units of functional, sigma and centre */
    float unit[DAVAR_COEFFICIENT_COUNT];
    float misfit_spread;
    /* Of the window and the rate, like `white`. */
    double edf[DAVAR_TAUS_MAX];
    double root[DAVAR_COEFFICIENT_COUNT]; /* of amplitudes, to coefficients in their units */
    float low[DAVAR_TAUS_MAX];
    float room[DAVAR_COEFFICIENT_COUNT];
    float half_kappa; /* kappa / 2 that it fits too (5.19) */
    double rate_hz;   /* that it fits, or 0 */
} davar_plan_t;

/** Prepares a plan for `count` cluster sizes m[] in samples, strictly ascending, without knowledge
 * of a filter. The fits then test whether the short sizes read low, and withhold their result if
 * they do (DAVAR_NOISE_FILTERED).
 * count: 1 to DAVAR_TAUS_MAX (asserted). The plan keeps no pointer to m.
 * Cost: O(T^3) in doubles, once. */
#define davar_plan_init DAVAR_SIZED(davar_plan_init)
void davar_plan_init(davar_plan_t *plan, const uint32_t *m, uint8_t count);

/** The same for samples that are known to be white: no low-pass below half the sample rate. */
#define davar_plan_init_white DAVAR_SIZED(davar_plan_init_white)
void davar_plan_init_white(davar_plan_t *plan, const uint32_t *m, uint8_t count);

/** The same for a gyro with `filter`, which is valid (asserted). The angle random walk is then that
 * of the samples at long cluster times, where no filter changes it. After an analogue low-pass that
 * is sampled, it includes the noise that is aliased: for one pole it is sqrt(x coth x) times that of
 * the gyro with x = pi cutoff, for example 9 % more at a cutoff of 0.25 of the rate.
 * Cost: O(P T^2) in doubles, once, with P = 4 m[last], 64 to 16384 points.
 * Formula (5.16). */
#define davar_plan_init_filtered DAVAR_SIZED(davar_plan_init_filtered)
void davar_plan_init_filtered(davar_plan_t *plan, const uint32_t *m, uint8_t count,
                              const davar_filter_t *filter);

/** Fits white noise alone: the angle random walk with its interval.
 *
 * Reads from *result: tau[], up to the first entry without differences; window_samples and
 * mirrored_samples, whose sum is at most 2^31 (asserted); unit_per_count (0: rounding to counts is
 * not removed); kurtosis and, if it is NaN, dispersion, which widen the intervals in noise with
 * heavy tails (needs DAVAR_LAWS); equal_samples (0: unknown), which show a stuck sensor.
 * rate_hz: samples per second, above 0. The cluster sizes must be
 * those of the plan.
 * Writes result->noise, the coefficients, and edf, low and high of every tau. By result->noise:
 * - WHITE: the angle random walk has a value and an interval, every tau has an interval, and the
 *   other terms have upper limits.
 * - MIXED: white noise does not explain the window. The angle random walk has the upper limit that
 *   the shortest tau implies; everything else is absent. Call davar_fit.
 * - COARSE: rounding to counts hides the noise. The angle random walk has an upper limit, the other
 *   terms are absent, and every tau has the interval 0 to infinity.
 * - CONSTANT: every difference is 0, or the newest samples are equal (5.24). All terms are absent;
 *   every tau has that same interval.
 * - FILTERED: the short cluster sizes read low, as after a filter that is not declared, or
 *   contradict the declared one. All terms are absent, and every tau has that same interval.
 *   Declare the filter (davar_plan_init_filtered), or that the samples are white
 *   (davar_plan_init_white).
 * - UNKNOWN: the window holds no difference. Everything is absent.
 *
 * @return True if white noise explains the window, so that the angle random walk is present.
 *
 * Cost: O(T); for a new window length or kurtosis O(T) more; if the number of usable taus changes,
 * O(T^3).
 * Formulas (5.3) to (5.5), (5.7), (5.9) to (5.11), (5.13) to (5.17), (5.19). */
#define davar_fit_white DAVAR_SIZED(davar_fit_white)
bool davar_fit_white(davar_plan_t *plan, double rate_hz, davar_result_t *result);

/** Fits white noise with a plan that tools/davar-plan wrote for all cluster sizes of the result.
 * davar_plan_init and its helpers are then not linked. davar_fit_white gives the same results
 * if the window supports every cluster size. If gaps leave the longest sizes without a difference,
 * the others stand in for them: at least three, with half of the weight of white noise; otherwise
 * the noise is UNKNOWN. Cost: O(T). */
#define davar_fit_white_ready DAVAR_SIZED(davar_fit_white_ready)
bool davar_fit_white_ready(davar_plan_t *plan, double rate_hz, davar_result_t *result);

/** Fits white noise to a window without gaps, of the length and the rate for which tools/davar-plan
 * wrote the constant plan (asserted).
 * noise and the angle random walk have the bits of davar_fit_white; the rest is absent. The linker
 * adds nothing that only other windows, the intervals of the sizes and the other terms need.
 * @return True if white noise explains the window. Cost: O(T). */
#define davar_fit_walk DAVAR_SIZED(davar_fit_walk)
bool davar_fit_walk(const davar_white_plan_t *plan, davar_result_t *result);

/** Estimates the angle random walk of a window from the cluster sizes that show white noise alone,
 * where davar_fit_white, davar_fit_white_ready or davar_fit left it absent; call it after them with
 * the same plan and rate. Otherwise it only sets flat_from and flat_to to 0.
 * - MIXED, with a declared filter: in slow motion. The short sizes are used as far as white noise
 *   and a ramp explain them.
 * - FILTERED: after a low-pass that is not declared, or not as declared. The long sizes are used, from
 *   four times the one on from which m avar is constant.
 * Writes the angle random walk with its interval, flat_from and flat_to; noise stays. If
 * there is no such part, or it has fewer than 16 degrees of freedom, the upper limit stays; for MIXED
 * it becomes larger if the long sizes settle above it.
 * @return True if the angle random walk is present.
 *
 * Cost: O(T^3) in floats, only where the angle random walk is absent. Stack: 1 kB with 8 sizes.
 * Formula (5.23). */
#define davar_fit_flat DAVAR_SIZED(davar_fit_flat)
bool davar_fit_flat(davar_plan_t *plan, double rate_hz, davar_result_t *result);

/** Fits the five terms of (1.2), none of them negative, with their 95 % intervals.
 * Reads and writes the same fields as davar_fit_white, which it tries first: for white noise the
 * results are equal. For any other mix result->noise is MIXED, a resolved term is present, and an
 * unresolved term has an upper limit.
 *
 * With sizes of a cascade, a plan for all sizes is needed. Quantization and the angle random walk
 * then come from the window, because it is newer; bias instability, rate random walk and rate ramp
 * come from the cascade once four of its sizes have differences. If the window is CONSTANT, COARSE or FILTERED, davar_fit ignores the cascade. Without a window, the
 * cascade gives all terms, and the angle random walk is the mean over what its longest size
 * remembers. The fit distinguishes white noise that changed meanwhile from a drift, by the power
 * that each size of the cascade remembers (11.9). result->noise is WHITE only if white noise
 * explains window and cascade.
 * Cost: white noise O(T). Any other mix O(T^2), which at T = 8 is ten times as much, and a hundred
 * times without a double FPU. Stack: up to 2.7 kB.
 * Formulas (5.3) to (5.11), (5.13) to (5.19). */
#define davar_fit DAVAR_SIZED(davar_fit)
void davar_fit(davar_plan_t *plan, double rate_hz, davar_result_t *result);

/** Describes result->noise in English.
 * @return A text that is never null and must not be changed. Cost: O(1). */
const char *davar_noise_text(davar_noise_t noise);

/** Computes the equivalent degrees of freedom of one Allan variance under one pure noise kind.
 * The overlapping Allan variance at cluster size m >= 1, in a window of at least 2 m samples
 * (asserted) without gaps. The rate ramp counts as rate random walk.
 * @return At least 1. Within 2 % of the exact value for window >= 6 m (5 % for rate random walk at
 *         m = 1), and never too large by more than that.
 *
 * Cost: O(1). Formula (5.1), after Greenhall and Riley 2003. */
double davar_edf(davar_coefficient_kind_t noise, uint32_t m, uint32_t window);

/** Computes degrees of freedom of result->tau[t], of a window or a cascade, that hold for every
 * noise.
 * This is the smallest value of the pure noise kinds, reduced for gaps and mirrored samples; a
 * mixture has no fewer (5.6). Use it for results without a fit. tau[t].differences > 0, and
 * window_samples and mirrored_samples together at most 2^31 (asserted).
 * @return At least 1. Cost: O(1). */
#define davar_edf_least DAVAR_SIZED(davar_edf_least)
double davar_edf_least(const davar_result_t *result, uint8_t t);

/** Computes the 95 % limits of a variance with edf degrees of freedom.
 * The limits are factors: the interval is variance * *low to variance * *high. An edf below 1
 * counts as 1. The relative error is below 1e-3 of the exact quantiles. Cost: O(1).
 * Formula (5.2). */
void davar_chi_square_interval(double edf, double *low, double *high);

/** Writes the octaves (1, 2, 4 and so on) that a window of `window` samples supports by the 25 %
 * rule, 9 m <= window; m = 1 always fits a window of 2 samples.
 * @return How many it wrote to taus[], at most `capacity`. 0: window < 2.
 *
 * Cost: O(capacity). Formula (1.3), [FAST]. */
uint8_t davar_taus_octave(uint32_t window, uint32_t *taus, uint8_t capacity);

/** Writes a geometric series of distinct sizes from 1 to window / 9, rounded: the "relevant times"
 * of [FAST] with its 25 % rule. `wanted` is the number of sizes before duplicates are removed.
 * @return How many it wrote to taus[], at most `capacity`. 0: window < 2, or wanted is 0.
 *
 * Cost: O(capacity), and 100 steps of bisection. Formula (1.4). */
uint8_t davar_taus_geometric(uint32_t window, uint8_t wanted, uint32_t *taus, uint8_t capacity);

#ifdef __cplusplus
}
#endif

#endif
