/* davar-sim - notes to the user on standard error. */
#ifndef REPORT_H
#define REPORT_H

#include "instances/engine.h"
#include "learning/learn.h"
#include "recording/recording.h"
#include "recording/timing.h"

/* Before the run: choices made for the user, and suspicious input. */
void report_notes(const options_t *options, const recording_t *recording, const timing_t *timing,
                  const quantisation_t *quantisation);

/* Before the run: the number of torn register reads that were skipped, of each column. */
void report_torn(const selection_t *selection, const uint64_t *torn);

/* Before the run: the filter that was learned for each column. */
void report_learned(const selection_t *selection, const learned_t *learned, double rate_hz);

/* After the run: one line with the counts of input faults and missed results, if there are any. */
void report_counters(const davar_health_t *health);

/* After the run: how many results have no coefficients because the counts are too coarse. */
void report_coarse(uint64_t coarse, uint64_t rows);

/* After the run: the cluster sizes that no result reached, of `count`; `reached` of them have
 * differences. */
void report_unreached(const uint32_t *taus, uint8_t count, uint8_t reached);

/* After the run: how many results are withheld because the short cluster sizes read low, if that is
 * more than random fluctuations explain. */
void report_filtered(uint64_t filtered, uint64_t rows, bool declared);

#endif
