/* davar - marks parts of a result as absent: NaN, and no upper limit. */
#ifndef DAVAR_SRC_ABSENT_H
#define DAVAR_SRC_ABSENT_H

#include "davar/types.h"

/* The confidence intervals of the cluster sizes from index `from` on. */
void davar_absent_taus(davar_result_t *result, uint32_t from);

/* All coefficients and the kind of noise. */
void davar_absent_coefficients(davar_result_t *result);

#endif
