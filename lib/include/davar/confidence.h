/* davar - stage [5a]: how sure an Allan variance is.
 * Pure functions in IEEE floating point with + - * / and sqrt only: the same bits on every target. */
#ifndef DAVAR_CONFIDENCE_H
#define DAVAR_CONFIDENCE_H

#include "davar/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Equivalent degrees of freedom of the overlapping Allan variance at cluster size m in a window of `window`
 * samples without gaps, for one pure noise kind (the ramp counts as rate random walk). m >= 1, window >= 2 m
 * (asserted). At least 1; within 2 % of the exact value for window >= 6 m (5 % for rate random walk at m = 1), never
 * optimistic beyond that. Formula (5.1), after Greenhall and Riley 2003. O(1). */
double davar_edf(davar_coefficient_kind_t noise, uint32_t m, uint32_t window);

/* Degrees of freedom of cluster size result->tau[t] that hold whatever the noise is: the least of the pure kinds, with gaps and
 * mirrored samples taken off. At least 1. For results without a fit, or whose window no fit explains; a mixture has no fewer (5.6).
 * tau[t].differences > 0 (asserted). O(1). */
#define davar_edf_least DAVAR_SIZED(davar_edf_least)
double davar_edf_least(const davar_result_t *result, uint8_t t);

/* 95 % limits of a variance with edf degrees of freedom, as factors: variance * *low .. variance * *high.
 * edf >= 1 (smaller is taken as 1). Relative error below 1e-3 of the exact quantiles (5.2). O(1). */
void davar_chi_square_interval(double edf, double *low, double *high);

#ifdef __cplusplus
}
#endif

#endif
