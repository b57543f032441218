/* davar - the short cut of the fit: does a window show white noise only (5.5) (5.7) (5.9)? Private
 * to the fit. */
#ifndef DAVAR_FIT_WHITE_H
#define DAVAR_FIT_WHITE_H

#include "davar/fit.h"
#include "number/scaled.h"

/* q^2 / 12, the variance of rounding to counts of size q (5.15); 0: unknown. */
scaled_t davar_rounding(const davar_white_plan_t *plan, const davar_result_t *result);

/* An upper limit of the angle random walk, rounding included: at least half a count, because
 * rounding can hide as much. */
double davar_half_a_count_at_least(const davar_white_plan_t *plan, const davar_result_t *result,
                                   double limit);

/* Writes DAVAR_NOISE_COARSE: all is absent except an upper limit of the angle random walk. `limit`
 * includes rounding. */
void davar_write_coarse(const davar_plan_t *plan, double limit, davar_result_t *result);

/* Writes a result that withholds all terms and all limits. */
void davar_write_unlimited(const davar_plan_t *plan, davar_noise_t noise, davar_result_t *result);

/* Writes DAVAR_NOISE_FILTERED: all is absent except an upper limit of the angle random walk, from
 * the longest cluster sizes of the window (5.17). */
void davar_write_filtered(const davar_plan_t *plan, davar_result_t *result);

/* White noise fitted to the usable cluster sizes of a result. */
typedef struct {
    int usable; /* cluster sizes with differences; the rest of the plan stands in (5.5) */
    int32_t exponent;
    scaled_t rounding; /* variance of rounding of a sample */
    scaled_t doubt;    /* by how much rounding may differ from white noise of that variance */
    scaled_t square;   /* N^2 of a sample */
    scaled_t sum;      /* ... with the rounding that scatters with it: 1 of a share */
    scaled_t inverse_sum;
    uint32_t inverse; /* the same in the fixed point of share_of */
    uint32_t lost;    /* low bits that shares lack, because sum is so much smaller than y */
    uint32_t share[DAVAR_COEFFICIENT_COUNT]; /* amplitude over sum in plan->scale; 0: none */
    unsigned suspects;                       /* bit k: term k is significant (5.7) */
    uint32_t lack;                           /* by which the short sizes read low, a share (5.17) */
    bool repeats; /* rounding errors repeat so much that short sizes prove no other filter (5.15) */
    scaled_t adev[DAVAR_TAUS_MAX];
    scaled_t y[DAVAR_TAUS_MAX];       /* adev^2 m / gain without rounding, aligned to `exponent` */
    uint32_t rounded[DAVAR_TAUS_MAX]; /* what rounding had in y */
} davar_white_t;

/* Writes the result if white noise explains the window or the window shows nothing, and returns
 * true. Otherwise *white describes the window, and only the values that no fit can give are
 * written. */
bool davar_white_suffices(davar_plan_t *plan, double rate_hz, davar_result_t *result,
                          davar_white_t *white);

#endif
