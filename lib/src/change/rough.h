/* davar - stage [3b] in 32 bits: tells nearly every verdict at a fraction of the cost, and says when it cannot (3.5). */
#ifndef DAVAR_SRC_ROUGH_H
#define DAVAR_SRC_ROUGH_H

#include "change/stationarity.h"

typedef enum { ROUGH_INSIDE = 0, ROUGH_OUTSIDE, ROUGH_UNSURE } davar_rough_t;

/* K and S against their bounds, where there is a variance. Unsure: within 2^-23 of a bound, and bounds far from any use. */
davar_rough_t davar_rough_kurtosis(const davar_config_t *config, const davar_central_t *whole);
davar_rough_t davar_rough_contribution(const davar_config_t *config, const davar_central_t *whole,
                                       const davar_central_t *first);

#endif
