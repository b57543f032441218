/* davar - the general fit: any mix of the five terms, by non-negative forward selection. Private to
 * the fit. */
#ifndef DAVAR_FIT_MIXTURE_H
#define DAVAR_FIT_MIXTURE_H

#include "davar/fit.h"

/* A sum of noise terms, tau in samples: avar(m) = sum a[k] x[k](m), x[k] = m^(k - 2) without a
 * filter, and rounding / m. */
typedef struct {
    const davar_result_t *data; /* the Allan variances to fit */
    const davar_plan_t *plan;   /* of its cluster sizes */
    int first; /* sizes to fit, of a window or a cascade (5.18): first to end - 1 */
    int end;
    double rounding; /* variance of rounding (5.15) */
    double tails;    /* relative variance that heavy tails add to N^2; not in its tests (5.19) */

    unsigned terms;                        /* bit k: term k is in the model */
    double a[DAVAR_COEFFICIENT_COUNT];     /* 0 for an absent term */
    double tried[DAVAR_COEFFICIENT_COUNT]; /* an absent term, fitted with the model; either sign */
    double variance[DAVAR_COEFFICIENT_COUNT]; /* of a or tried; INFINITY: not resolvable */
    double least[DAVAR_COEFFICIENT_COUNT];    /* lower 95 % limit of a, doubts included (5.10) */
    double grow;                              /* misfit in the variances; 1: the model fits */
} davar_mixture_t;

/* Fills `terms` and everything below it. Starts with white noise of variance `white` (> 0) per
 * sample and adds one of the terms in `suspects` (bit k: term k), if any. O(T^2). */
void davar_mixture_fit(davar_mixture_t *model, double white, unsigned suspects);

/* Has size t differences? */
bool davar_mixture_has(const davar_mixture_t *model, int t);

/* m avar of white noise of variance 1 at size t: after the filter, times the power that the size
 * remembers (11.9). */
double davar_mixture_white(const davar_mixture_t *model, int t);

/* Degrees of freedom of an Allan variance of this mix (5.6), with heavy tails (5.19). */
double davar_mixture_edf(const davar_mixture_t *model, int t);

/* Upper limit of an absent term (5.11). */
double davar_mixture_most(const davar_mixture_t *model, int term);

/* Is white noise half of the Allan variance at a size that the filter passes (5.16)? */
bool davar_mixture_shows_white(const davar_mixture_t *model);

/* Does the model contradict what the plan knows of the filter (5.17)? */
bool davar_mixture_is_filtered(const davar_mixture_t *model);

#endif
