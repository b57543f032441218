/* davar - stage [2]: sliding overlapping Allan variance per cluster size, newest difference in, oldest out.
 *
 * D = sum of the later m samples - sum of the earlier m samples of a span of 2 m. Moving a span by one sample changes
 * its D by x[new] - 2 x[middle] + x[old] (2.1). `head` is the D of the span that ends at the leading edge, `tail` of
 * the one that starts at the trailing edge:
 *
 *   tail          head - 2 m           head
 *    |x x x x x|x x x|x x x x x x|x x x x x x|
 *    |<- m ->|<- m ->|       |<- m ->|<- m ->|
 *      D_tail                      D_head
 */
#ifndef DAVAR_SRC_ALLAN_H
#define DAVAR_SRC_ALLAN_H

#include "window/gaps.h"
#include "window/ring.h"

typedef struct {
    sum_t sum; /* of D^2: over the window (sliding) or since the start, modulo (grid) */
    difference_t head;
    difference_t tail; /* sliding only */
} tau_t;

typedef struct {
    const uint32_t *m; /* the cluster sizes, as configured */
    tau_t *tau;
    uint32_t run;     /* samples up to the leading edge without a gap */
    uint32_t to_gap;  /* samples from the leading edge to the next gap, or DAVAR_NO_GAP */
    uint32_t room;    /* samples from the trailing edge to the next gap, or DAVAR_NO_GAP */
    uint8_t count;    /* of the cluster sizes */
    bool starting;    /* spans still reach in front of the first sample */
    bool mirrored;    /* ... into its mirror image */
    bool run_doubles; /* the run reaches back into its own mirror image */
    bool warming;     /* sliding, centred: the first window still grows on both sides (2.6) */
    bool octaves;     /* each cluster size is twice the one before it */
} allan_t;

/* Sliding, centred: the first window still grows on both sides (2.6). */
static inline bool is_warming(const allan_t *allan)
{
    return DAVAR_CENTRED && allan->warming;
}

/* Samples of the longest span. */
static inline uint32_t allan_span_max(const allan_t *allan)
{
    return 2U * allan->m[allan->count - 1U];
}

/* An edge on its way over one sample changes D (2.1). */
static inline difference_t allan_lead_step(const sample_t *head, size_t m)
{
    const sample_t *const oldest = head - (2U * m);
    return *head - (2 * (difference_t)oldest[m]) + *oldest;
}

static inline difference_t allan_trail_step(const sample_t *tail, size_t m)
{
    return tail[2U * m] - (2 * (difference_t)tail[m]) + *tail;
}

/* The leading edge alone moves: no gap near it. */
static inline void allan_lead(allan_t *allan, const sample_t *head)
{
    for (uint32_t t = 0U; t < allan->count; t++) {
        allan->tau[t].head += allan_lead_step(head, allan->m[t]);
        sum_add_square(&allan->tau[t].sum, allan->tau[t].head);
    }
}

/* The trailing edge alone moves, likewise; the window stays as long as the longest span. */
static inline void allan_trail(allan_t *allan, const sample_t *tail)
{
    for (uint32_t t = 0U; t < allan->count; t++) {
        sum_subtract_square(&allan->tau[t].sum, allan->tau[t].tail);
        allan->tau[t].tail += allan_trail_step(tail, allan->m[t]);
    }
}

/* What one sample at `position` adds to D near the start, where a span reaches in front of the first sample: into its
 * mirror image (centred) or into nothing (trailing). By symmetry D is 0 until m samples are there (2.6). */
static difference_t allan_start_step(const sample_t *head, size_t position, size_t m, bool mirrored)
{
    if (mirrored && (position < m)) {
        return 0;
    }
    difference_t step = *head;
    if (position >= m) {
        const sample_t *const middle = head - m;
        step -= 2 * (difference_t)*middle;
    }
    if (position >= (2U * m)) {
        step += *(head - (2U * m));
    } else if (mirrored) {
        step += *(head - ((2U * (position - m)) + 1U));
    }
    return step;
}

/* ... by a sample anywhere. */
static difference_t allan_any_step(const allan_t *allan, const sample_t *head, uint32_t position, uint32_t m)
{
    return allan->starting ? allan_start_step(head, position, m, DAVAR_CENTRED && allan->mirrored)
                           : allan_lead_step(head, m);
}

/* The run of samples without a gap takes in the sample at `position`. */
static void allan_extend_run(allan_t *allan, const davar_gaps_t *gaps, const davar_window_t *window, uint32_t position)
{
    if (allan->to_gap == 0U) {
        allan->run = 0U;
        allan->run_doubles = false;
        allan->to_gap = davar_gaps_after(gaps, window, position);
    }
    if (allan->to_gap != DAVAR_NO_GAP) {
        allan->to_gap--;
    }
    if (allan->run < allan_span_max(allan)) {
        allan->run += allan->run_doubles ? 2U : 1U;
    }
}

/* `head` samples are behind the leading edge: can a span still reach in front of the first one? */
static void allan_end_start(allan_t *allan, uint32_t head)
{
    if (head >= allan_span_max(allan)) {
        allan->starting = false;
    }
}

/* The trailing edge, one sample on, is at `tail`. */
static void allan_shrink_room(allan_t *allan, const davar_gaps_t *gaps, const davar_window_t *window, uint32_t tail)
{
    if (allan->room == DAVAR_NO_GAP) {
        return;
    }
    allan->room--;
    if (allan->room == 0U) {
        allan->room = davar_gaps_after(gaps, window, tail);
    }
}

/* No gap near the leading edge, no span in front of the start. */
static bool allan_leads_freely(const allan_t *allan)
{
    return (allan->run >= allan_span_max(allan)) && (allan->to_gap == DAVAR_NO_GAP) && !allan->starting;
}

#endif
