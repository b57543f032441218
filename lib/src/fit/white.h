/* davar - the short cut of the fit: is white noise all that a window shows (5.5) (5.7) (5.9)? Private to stage [5]. */
#ifndef DAVAR_FIT_WHITE_H
#define DAVAR_FIT_WHITE_H

#include "davar/fit.h"
#include "number/scaled.h"

/* White noise fitted to the usable cluster sizes of a result. */
typedef struct {
    scaled_t adev[DAVAR_TAUS_MAX];
    scaled_t y[DAVAR_TAUS_MAX]; /* adev^2 m, aligned: */
    int32_t exponent;
    scaled_t square;  /* N^2 of a sample */
    uint32_t inverse; /* its reciprocal, as share_of() needs it */
    uint32_t drift;   /* powers of two that N^2 lacks to be of the size of y, and shares lack bits */
    uint32_t
        share[DAVAR_COEFFICIENT_COUNT]; /* amplitude of one more term over N^2, in plan->scale; 0: none, or negative */
    unsigned suspects;                  /* bit k: term k is significant (5.7) */
    bool explains;                      /* no misfit (5.9) */
} davar_white_t;

/* Does white noise explain all that a window shows, or does it show nothing? Then the result is written; otherwise *white says
 * what is there, and of the result only what no fit can give is written. */
bool davar_white_suffices(davar_plan_t *plan, double rate_hz, davar_result_t *result, davar_white_t *white);

#endif
