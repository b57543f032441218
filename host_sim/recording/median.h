/* davar-sim - the exact median of the time steps in a spool, in bounded memory. */
#ifndef MEDIAN_H
#define MEDIAN_H

#include "common/spool.h"

/* Median of times[i + 1] - times[i], all >= 0. For an even number of steps it is the mean of the
 * middle two. The spool has at least two records of width 1. False: spool fault or out of memory.
 * Memory: O(1) (512 KiB). Cost: O(records). */
bool median_step(const spool_t *times, double *median_s, sim_error_t *error);

#endif
