/* davar - the short cut of the fit: is white noise all that a window shows (5.5) (5.7) (5.9)? Private to stage [5]. */
#ifndef DAVAR_FIT_WHITE_H
#define DAVAR_FIT_WHITE_H

#include "davar/fit.h"
#include "number/scaled.h"

/* Rounding to counts of size q adds q^2 / 12 to the variance of a sample (5.15). Its share of `variance`, as 2.30; 0: not known. */
uint32_t davar_rounding_share(const davar_result_t *result, scaled_t variance);

/* From this share on, what is left is below half a count. */
#define DAVAR_FIT_COARSE (UINT32_C(1) << 28U)

/* The angle random walk without rounding, over that with it. */
typedef struct {
    scaled_t value;
    scaled_t low;
    scaled_t high;
} davar_unrounded_t;

/* For a share below DAVAR_FIT_COARSE. `least`, as 2.30: lower limit of the variance, over the variance; `high`: upper limit of its root. */
davar_unrounded_t davar_unrounded(uint32_t share, uint32_t least, scaled_t high);

/* An upper limit of the angle random walk, with rounding in it: at least half a count, for so much can hide. */
double davar_half_a_count_at_least(const davar_plan_t *plan, const davar_result_t *result,
                                   double limit);

/* Writes DAVAR_NOISE_COARSE: all is absent but an upper limit of the angle random walk, from one with rounding in it. */
void davar_write_coarse(const davar_plan_t *plan, double limit, davar_result_t *result);

/* White noise fitted to the usable cluster sizes of a result. */
typedef struct {
    scaled_t adev[DAVAR_TAUS_MAX];
    scaled_t y[DAVAR_TAUS_MAX]; /* adev^2 m, aligned: */
    int32_t exponent;
    scaled_t square;  /* N^2 of a sample */
    uint32_t inverse; /* its reciprocal, as share_of() needs it */
    uint32_t drift; /* powers of two that N^2 lacks to be of the size of y, and shares lack bits */
    uint32_t share
        [DAVAR_COEFFICIENT_COUNT]; /* amplitude of one more term over N^2, in plan->scale; 0: none, or negative */
    unsigned suspects; /* bit k: term k is significant (5.7) */
    bool explains;     /* no misfit (5.9) */
} davar_white_t;

/* Does white noise explain all that a window shows, or does it show nothing? Then the result is written; otherwise *white says
 * what is there, and of the result only what no fit can give is written. */
bool davar_white_suffices(davar_plan_t *plan, double rate_hz, davar_result_t *result,
                          davar_white_t *white);

#endif
