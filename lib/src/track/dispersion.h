/* davar - how much wider than Gaussian noise's the blocks scatter: heavy tails and correlated noise widen the thresholds of the
 * detector instead of alarming for ever. */
#ifndef DAVAR_SRC_DISPERSION_H
#define DAVAR_SRC_DISPERSION_H

#include "number/logarithm.h"

/* phi: mean square of the steps of ln b, over that of chi-squares. 24 digits: 1 is Gaussian. */
typedef struct {
    uint32_t phi;
    int32_t before; /* ln of the block before */
    uint32_t count; /* blocks so far, up to where the mean begins to forget */
} davar_dispersion_t;

void davar_dispersion_start(davar_dispersion_t *dispersion);

/* The next ln b. `unit` is 1 over the mean square step of a chi-square's logarithm, 16 digits; the mean forgets over 2^memory
 * blocks. */
void davar_dispersion_learn(davar_dispersion_t *dispersion, int32_t logarithm, uint32_t unit, uint32_t memory);

#endif
