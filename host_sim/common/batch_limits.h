/* davar-sim - the limits of an Allan deviation by batch means (5.25). */
#ifndef BATCH_LIMITS_H
#define BATCH_LIMITS_H

#include "davar/types.h"

#include <stddef.h>

/* Of differences that end within some samples. */
typedef struct {
    double squares;
    double count;
} batch_sums_t;

/* True if the fit has no better limits: its noise is neither white nor hidden by rounding. */
bool batch_limits_apply(const davar_result_t *result);

/* Computes the limits of a size again, from eight batches of its differences. sums: of `steps` runs
 * of `step` samples, `stride` apart. clusters: samples of the window over m. Leaves the limits if
 * there are fewer than 16 runs, a batch would be shorter than m, or gaps take half of one. */
void batch_limits(const batch_sums_t *sums, size_t stride, uint64_t steps, uint64_t step,
                  double clusters, davar_adev_t *tau);

#endif
