/* davar - the plan of a fit beyond davar_fit_plan(). Private to stage [5]. */
#ifndef DAVAR_FIT_PLAN_H
#define DAVAR_FIT_PLAN_H

#include "davar/fit.h"

/* Limits of a standard deviation, as factors, whose square has edf degrees of freedom (5.2). */
void davar_deviation_interval(double edf, double *low, double *high);

/* Every difference that the window could hold is there once, at the first `count` cluster sizes: no gap, no mirror. */
bool davar_fit_is_whole(const davar_result_t *result, int count);

/* The share of the differences that is new evidence: 1, or less where the window holds mirror images (5.13). */
double davar_fit_evidence(const davar_result_t *result);

/* Fills what the window length and the differences in it decide (5.5). */
void davar_fit_plan_window(davar_fit_plan_t *plan, const davar_result_t *result);

#endif
