/* davar - stage [5]: the five noise coefficients from ADEV(tau), with honest intervals.
 * Steps of their own behind davar_take, linked only where they are called: davar_fit_white for the angle random walk, davar_fit for
 * all five. Pure functions in integers, and in IEEE floating point with + - * / and sqrt only: the same bits on every target (5.14). */
#ifndef DAVAR_FIT_H
#define DAVAR_FIT_H

#include "davar/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What a fit needs and the Allan variances do not change: a memo, never a history. Fields are private. */
typedef struct davar_plan {
    uint8_t count;                                     /* usable cluster sizes it is made for (5.4) */
    int8_t variance_exponent[DAVAR_COEFFICIENT_COUNT]; /* powers of two that are the units of variance */
    float m[DAVAR_TAUS_MAX];
    float weight[DAVAR_TAUS_MAX];
    float freedom[DAVAR_TAUS_MAX]; /* degrees of freedom per effective difference */
    int32_t functional[DAVAR_COEFFICIENT_COUNT]
                      [DAVAR_TAUS_MAX];                        /* amplitudes of white noise and of one term beside it */
    int32_t variance[DAVAR_COEFFICIENT_COUNT][DAVAR_TAUS_MAX]; /* ... and what they scatter */
    float scale[DAVAR_COEFFICIENT_COUNT];                      /* units of functional, sigma and centre */
    float centre[DAVAR_COEFFICIENT_COUNT];
    float unit[DAVAR_COEFFICIENT_COUNT];
    float misfit_spread;
    uint64_t misfit_limit;
    uint32_t window; /* window length without gaps or mirror images that the rest is made for (5.5); 0: none */
    double edf[DAVAR_TAUS_MAX];
    uint32_t root_edf[DAVAR_TAUS_MAX];
    float low[DAVAR_TAUS_MAX];
    float high[DAVAR_TAUS_MAX];
    uint32_t sigma[DAVAR_COEFFICIENT_COUNT];
    float room[DAVAR_COEFFICIENT_COUNT];
    uint32_t doubt[DAVAR_COEFFICIENT_COUNT];
    uint32_t white_low;
    float white_high;
    double rate_hz; /* that the rest is made for; 0: none */
    double root[DAVAR_COEFFICIENT_COUNT];
} davar_plan_t;

/* Makes a plan for `count` (1..DAVAR_TAUS_MAX) strictly ascending cluster sizes. The plan belongs to the caller. O(count^2). */
#define davar_plan_init DAVAR_SIZED(davar_plan_init)
void davar_plan_init(davar_plan_t *plan, const uint32_t *m, uint8_t count);

/* Fits white noise alone. Returns true if white noise explains the window, so that the angle random walk is present. Writes
 * result->noise, and in each case:
 *   DAVAR_NOISE_WHITE     the angle random walk with its interval, edf and limits of every tau, upper limits of the other terms
 *   DAVAR_NOISE_MIXED     the upper limit of the angle random walk that the shortest tau gives; all else is absent. Call davar_fit
 *   DAVAR_NOISE_COARSE    the upper limit of the angle random walk; every other coefficient is absent, and the interval of every tau is
 *                         0 to infinity
 *   DAVAR_NOISE_CONSTANT  every coefficient is absent; the interval of every tau is 0 to infinity
 *   DAVAR_NOISE_UNKNOWN   the window holds no difference; all is absent
 * Parameters as for davar_fit. Cost: O(T), a new window length O(T), a change in the number of usable taus O(T^2). */
#define davar_fit_white DAVAR_SIZED(davar_fit_white)
bool davar_fit_white(davar_plan_t *plan, double rate_hz, davar_result_t *result);

/* The same with a plan that tools/davar-plan wrote for all cluster sizes of the result, so that davar_plan_init and what it
 * needs are not linked. Where the window supports all of them it gives the same bits. A window that supports fewer (a short one, or
 * one with gaps) gets DAVAR_NOISE_UNKNOWN. */
#define davar_fit_white_ready DAVAR_SIZED(davar_fit_white_ready)
bool davar_fit_white_ready(davar_plan_t *plan, double rate_hz, davar_result_t *result);

/* Fits A_-2 .. A_2 >= 0 to the Allan variances in result->tau (adev, m, differences of result->tau_count entries; the
 * entries from the first with differences == 0 on are left out), window length result->window_samples with
 * result->mirrored_samples in it, the size of a count result->unit_per_count (0: no rounding is taken off), at rate_hz (> 0) samples per second. Writes result->noise, result->coefficient[], and edf, low, high of
 * every tau entry from the noise mix that was found.
 * A pure function of result and rate_hz: the plan only saves the work that the last window shares with this one, so
 * one plan serves one caller at a time. The cluster sizes must be those of the plan.
 * Cost: white noise O(T), any other mix O(T^2) (at T = 8 about ten times as much, a hundred without a double FPU: docs/COST.md), a new window length O(T), a change in the number of usable taus O(T^2). About 2 kB of stack.
 * Formulas (5.3) to (5.11). */
#define davar_fit DAVAR_SIZED(davar_fit)
void davar_fit(davar_plan_t *plan, double rate_hz, davar_result_t *result);

#ifdef __cplusplus
}
#endif

#endif
