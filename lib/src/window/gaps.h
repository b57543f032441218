/* davar - the gaps a window remembers: boundaries that no difference may span, and their mirror images. */
#ifndef DAVAR_SRC_GAPS_H
#define DAVAR_SRC_GAPS_H

#include "davar/instance.h"

/* Returned by davar_gaps_after when no boundary follows. */
#define DAVAR_NO_GAP UINT32_MAX

/* Forgets the boundaries that a window of this length has left, which ends where the window does. To be called at least every 2^31 samples, since an older boundary would
 * seem to lie ahead. O(gaps). */
void davar_gaps_forget(davar_gaps_t *gaps, const davar_window_t *window, uint32_t length);

/* Remembers the boundary in front of the sample that comes next, and forgets those that a window of this length has left. A boundary at
 * the very start, or at one already known, changes nothing. False: full, nothing changed. O(gaps). */
bool davar_gaps_push(davar_gaps_t *gaps, const davar_window_t *window, uint32_t length);

/* At the end of a record: a gap behind the last sample is none. */
void davar_gaps_forget_last(davar_gaps_t *gaps, uint32_t end);

/* Samples from `position` to the first boundary behind it (mirror images included), DAVAR_NO_GAP when there is none.
 * O(log gaps). */
uint32_t davar_gaps_after(const davar_gaps_t *gaps, const davar_window_t *window, uint32_t position);

/* Boundaries inside [tail, head), between two of its samples. O(gaps). */
uint32_t davar_gaps_inside(const davar_gaps_t *gaps, const davar_window_t *window);

/* How many of the spans of 2 m samples inside [tail, head) contain a boundary (1.5). O(gaps). */
uint32_t davar_gaps_spans_lost(const davar_gaps_t *gaps, const davar_window_t *window, uint32_t m);

#endif
