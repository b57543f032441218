/* davar-sim - skips torn register reads, with the filter of a device (davar/torn.h). */
#ifndef TORN_H
#define TORN_H

#include "recording/recording.h"
#include "recording/timing.h"

/* Removes the rows in which any column has a torn read. The next row gets one more missing sample.
 * The samples must be counts. reads[c]: torn reads of column c. A recording without time stamps
 * gets those of its rate, so that the rows that stay keep their times. */
bool torn_skip(uint64_t *reads, recording_t *recording, timing_t *timing, sim_error_t *error);

#endif
