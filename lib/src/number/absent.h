/* davar - what a result says where nothing was fitted: NaN, and no upper limit. */
#ifndef DAVAR_SRC_ABSENT_H
#define DAVAR_SRC_ABSENT_H

#include "davar/types.h"

/* Of the cluster sizes from `from` on. */
void davar_absent_taus(davar_result_t *result, uint32_t from);

/* ... and no kind of noise. */
void davar_absent_coefficients(davar_result_t *result);

#endif
