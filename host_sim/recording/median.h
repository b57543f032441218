/* davar-sim - the exact median of the steps between spooled time stamps, in bounded memory. */
#ifndef MEDIAN_H
#define MEDIAN_H

#include "recording/spool.h"

/* Median of times[i + 1] - times[i], all >= 0 (for an even number of steps the mean of the middle two). The spool holds
 * at least two records of width 1. False: spool fault or no memory. Memory O(1) (512 KiB), time O(records). */
bool median_step(const spool_t *times, double *median_s, sim_error_t *error);

#endif
