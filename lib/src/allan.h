/* davar - stage [2]: sliding overlapping Allan variance per cluster size, newest difference in, oldest out.
 *
 * D = sum of the later m samples - sum of the earlier m samples of a span of 2 m. Moving a span by one sample changes
 * its D by x[new] - 2 x[middle] + x[old] (2.2). `head` is the D of the span that ends at the leading edge, `tail` of
 * the one that starts at the trailing edge:
 *
 *   tail          head - 2 m           head
 *    |x x x x x|x x x|x x x x x x|x x x x x x|
 *    |<- m ->|<- m ->|       |<- m ->|<- m ->|
 *      D_tail                      D_head
 */
#ifndef DAVAR_SRC_ALLAN_H
#define DAVAR_SRC_ALLAN_H

#include "gaps.h"
#include "ring.h"

typedef struct {
    sum_t sum; /* of D^2: over the window (sliding) or since the start, modulo (grid) */
    difference_t head;
    difference_t tail; /* sliding only */
    uint32_t m;
} tau_t;

typedef struct {
    tau_t *tau;
    uint32_t count;
    uint32_t span_max; /* 2 m of the largest tau */
    uint32_t run;      /* samples up to the leading edge without a gap */
    uint32_t run_step; /* 2 while the run reaches back into its own mirror image, else 1 */
    uint32_t to_gap;   /* samples from the leading edge to the next gap, or DAVAR_NO_GAP */
    uint32_t room;     /* samples from the trailing edge to the next gap, or DAVAR_NO_GAP */
    bool plain;        /* sliding: nothing but whole spans near either edge */
    bool starting;     /* spans still reach in front of the first sample */
    bool mirrored;     /* ... into its mirror image */
    bool warming;      /* sliding, centred: the first window still grows on both sides (2.6) */
} allan_t;

/* The whole window moves by one sample: no gap near either edge, window not shorter than the longest span. The octave
 * below shares its taps: x[n - 2 m] of one cluster size is x[n - m] of the next. */
static inline void allan_slide(allan_t *allan, ring_t ring, uint32_t head_index, uint32_t tail_index)
{
    const sample_t *const head_at = &ring.sample[head_index];
    const sample_t *const tail_at = &ring.sample[tail_index];
    const uint32_t tail_room = ring.capacity - tail_index;
    difference_t head_far = *head_at;
    difference_t tail_far = *tail_at;
    uint32_t far_lag = 0U;
    tau_t *const end = &allan->tau[allan->count];
    for (tau_t *tau = allan->tau; tau != end; tau++) {
        const uint32_t m = tau->m;
        if (m != far_lag) {
            head_far = *(head_at + ((m <= head_index) ? 0U : ring.capacity) - m);
            tail_far = *(tail_at + m - ((m < tail_room) ? 0U : ring.capacity));
        }
        far_lag = 2U * m;
        const difference_t head_middle = head_far;
        const difference_t tail_middle = tail_far;
        head_far = *(head_at + ((far_lag <= head_index) ? 0U : ring.capacity) - far_lag);
        tail_far = *(tail_at + far_lag - ((far_lag < tail_room) ? 0U : ring.capacity));
        tau->head += *head_at - (2 * head_middle) + head_far;
        sum_slide(&tau->sum, tau->head, tau->tail);
        tau->tail += tail_far - (2 * tail_middle) + *tail_at;
    }
}

/* What one sample at `position` adds to D near the start, where a span reaches in front of the first sample: into its
 * mirror image (centred) or into nothing (trailing). By symmetry D is 0 until m samples are there (2.6). */
static difference_t allan_start_step(const ring_t *ring, uint32_t index, uint32_t position, uint32_t m, bool mirrored)
{
    const sample_t *const x = ring->sample;
    if (mirrored && (position < m)) {
        return 0;
    }
    difference_t step = x[index];
    if (position >= m) {
        step -= 2 * (difference_t)x[ring_before(ring, index, m)];
    }
    if (position >= (2U * m)) {
        step += x[ring_before(ring, index, 2U * m)];
    } else if (mirrored) {
        step += x[ring_before(ring, index, (2U * position) - (2U * m) + 1U)];
    }
    return step;
}

static difference_t allan_step(const ring_t *ring, uint32_t index, uint32_t m)
{
    const sample_t *const x = ring->sample;
    return x[index] - (2 * (difference_t)x[ring_before(ring, index, m)]) + x[ring_before(ring, index, 2U * m)];
}

/* The run of samples without a gap takes in the sample at `position`. */
static void allan_extend_run(allan_t *allan, const davar_gaps_t *gaps, const davar_window_t *window, uint32_t position)
{
    if (allan->to_gap == 0U) {
        allan->run = 0U;
        allan->run_step = 1U;
        allan->to_gap = davar_gaps_after(gaps, window, position);
    }
    if (allan->to_gap != DAVAR_NO_GAP) {
        allan->to_gap--;
    }
    if (allan->run < allan->span_max) {
        allan->run += allan->run_step;
    }
}

/* `head` samples are behind the leading edge: can a span still reach in front of the first one? */
static void allan_end_start(allan_t *allan, uint32_t head)
{
    if (head >= allan->span_max) {
        allan->starting = false;
    }
}

/* The trailing edge, one sample on: window->tail is the new one. */
static void allan_shrink_room(allan_t *allan, const davar_gaps_t *gaps, const davar_window_t *window)
{
    if (allan->room == DAVAR_NO_GAP) {
        return;
    }
    allan->room--;
    if (allan->room == 0U) {
        allan->room = davar_gaps_after(gaps, window, window->tail);
    }
}

#endif
