/* davar - one variance or two? The likelihood ratio of a stretch that is split in an older and a newer part. */
#ifndef DAVAR_SRC_LIKELIHOOD_H
#define DAVAR_SRC_LIKELIHOOD_H

#include "track/spread.h"

#define GAIN_DIGITS 12U /* binary, behind the point, of a likelihood ratio and of what it is compared with */

/* The stretch that is split: what every split of it needs. */
typedef struct {
    davar_spread_t sum;
    int32_t exponent;    /* where its upper 32 bits begin */
    uint32_t reciprocal; /* of these bits */
    int32_t logarithm;   /* of its mean block; INT32_MIN until it is asked for */
    uint32_t degrees;    /* nu, 8 digits */
} davar_stretch_t;

/* At least one block, a sum that is not 0, at most 1023 blocks. */
void davar_stretch(davar_stretch_t *stretch, const davar_spread_t *sum, uint32_t degrees);

/* Bound without a logarithm: false only when the gain of this split cannot reach `limit` (6 digits, below 2^24). */
bool davar_likelihood_may_reach(const davar_stretch_t *stretch, const davar_spread_t *older, uint32_t limit);

/* G = nu/2 (N_t ln(S_t/N_t) - N_o ln(S_o/N_o) - N_n ln(S_n/N_n)); both parts hold a block, neither sum is 0. */
int32_t davar_likelihood_gain(davar_stretch_t *stretch, const davar_spread_t *older);

#endif
