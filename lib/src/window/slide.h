/* davar - the whole window moves by one sample: where a value at every sample spends its time (2.2). */
#ifndef DAVAR_SRC_SLIDE_H
#define DAVAR_SRC_SLIDE_H

#include "window/stages.h"

/* Cluster sizes, from the first, whose taps neither edge looks for beyond the end of the ring. */
static inline uint32_t allan_straight(const allan_t *allan, edge_t head, edge_t tail)
{
    const uint32_t reach = (head.reach < tail.reach) ? head.reach : tail.reach;
    uint32_t count = allan->count;
    while ((count > 0U) && ((2U * allan->m[count - 1U]) > reach)) {
        count--;
    }
    return count;
}

/* The whole window moves by one sample, for cluster sizes whose taps lie on one side of the end of the ring. The loop that
 * a value at every sample spends most of its time in: few live values, so that they stay in registers. */
DAVAR_APART static void slide_straight(tau_t *tau, const tau_t *end, const uint32_t *m, const sample_t *head,
                                       const sample_t *tail)
{
    const difference_t newest = (difference_t)*head;
    const difference_t oldest = (difference_t)*tail;
    while (tau != end) {
        const size_t lag = *m;
        const difference_t trailing = tau->tail;
        tau->tail = trailing + oldest - (2 * (difference_t)tail[lag]) + tail[2U * lag];
        const sample_t *const before = head - (2U * lag);
        const difference_t leading = tau->head + newest - (2 * (difference_t)before[lag]) + *before;
        tau->head = leading;
        sum_slide(&tau->sum, leading, trailing);
        tau++;
        m++;
    }
}

/* ... for those of which some do. */
DAVAR_APART static void slide_around(tau_t *tau, const tau_t *end, const uint32_t *m, const edge_t edge[2])
{
    while (tau != end) {
        const difference_t trailing = tau->tail;
        tau->tail = trailing + allan_trail_step(edge[1], *m);
        const difference_t leading = tau->head + allan_lead_step(edge[0], *m);
        tau->head = leading;
        sum_slide(&tau->sum, leading, trailing);
        tau++;
        m++;
    }
}

#if defined(__GNUC__) && defined(__ARM_ARCH_PROFILE) && (__ARM_ARCH_PROFILE == 'M') && (__ARM_ARCH_ISA_THUMB == 2) &&  \
    !defined(__ARM_BIG_ENDIAN) && (NUMBER_SUM_BITS == 64U) && !defined(DAVAR_PORTABLE)
#include "window/slide_armv7m.h"
#else
/* Octaves share taps: the one that leaves the span of m is the middle one of 2 m. Both edges on their way along them. */
typedef struct {
    tau_t *tau;
    uint32_t span; /* of `tau` */
    difference_t newest;
    difference_t oldest;
    difference_t before; /* half a span in front of the leading edge */
    difference_t behind; /* half a span behind the trailing one */
} octaves_t;

/* ... up to spans of `reach`, which is not below the first one; the edges are on the taps' side of the end of the ring. */
static inline void slide_octaves_up_to(octaves_t *at, const sample_t *head, const sample_t *tail, uint32_t reach)
{
    do {
        tau_t *const tau = at->tau;
        const difference_t trailing = tau->tail;
        tau->tail = trailing + at->oldest - (2 * at->behind);
        at->behind = tail[at->span];
        tau->tail += at->behind;
        difference_t leading = tau->head + at->newest - (2 * at->before);
        at->before = *(head - at->span);
        leading += at->before;
        tau->head = leading;
        sum_slide(&tau->sum, leading, trailing);
        at->span *= 2U;
        at->tau++;
    } while (at->span <= reach);
}

/* Taps at `lag` and beyond: those of an edge that lie behind the end of the ring, or in front of its start, follow the turn. */
static inline void edges_turn(edge_t *head, edge_t *tail, uint32_t lag)
{
    if (lag > head->reach) {
        head->at += head->turn;
        head->reach = UINT32_MAX;
    }
    if (lag > tail->reach) {
        tail->at -= tail->turn;
        tail->reach = UINT32_MAX;
    }
}

/* ... for all octaves: where an edge's taps begin to lie beyond the end of the ring, so do all that follow. */
DAVAR_APART static void slide_octaves(stages_t *stages, uint32_t head_index, uint32_t tail_index)
{
    const allan_t *const allan = &stages->allan;
    edge_t head = allan_leading(&stages->ring, head_index);
    edge_t tail = allan_trailing(&stages->ring, tail_index);
    const uint32_t m = allan->m[0];
    const uint32_t span_max = m << allan->count;
    octaves_t at = {.tau = allan->tau, .span = 2U * m, .newest = *head.at, .oldest = *tail.at};
    edges_turn(&head, &tail, m);
    at.before = *(head.at - m);
    at.behind = tail.at[m];
    do {
        edges_turn(&head, &tail, at.span);
        slide_octaves_up_to(&at, head.at, tail.at, smaller(span_max, smaller(head.reach, tail.reach)));
    } while (at.span <= span_max);
}
#endif

/* ... for any cluster sizes. */
DAVAR_APART static void slide_any(stages_t *stages, uint32_t head, uint32_t tail)
{
    const allan_t *const allan = &stages->allan;
    tau_t *const tau = allan->tau;
    const edge_t edge[2] = {allan_leading(&stages->ring, head), allan_trailing(&stages->ring, tail)};
    const uint32_t straight = allan_straight(allan, edge[0], edge[1]);
    slide_straight(tau, tau + straight, allan->m, edge[0].at, edge[1].at);
    if (straight < allan->count) {
        slide_around(tau + straight, tau + allan->count, allan->m + straight, edge);
    }
}

/* The whole window moves by one sample, leading and trailing edge, which are at `head` and `tail` in the ring: no gap near
 * either, window not shorter than the longest span. */
static inline void slide(stages_t *stages, uint32_t head, uint32_t tail)
{
    if (stages->allan.octaves) {
        slide_octaves(stages, head, tail);
    } else {
        slide_any(stages, head, tail);
    }
}

#endif
