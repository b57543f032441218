/* davar - a value at every sample: window sums that follow both edges of the window, one sample at a time. */
#ifndef DAVAR_SRC_SLIDING_H
#define DAVAR_SRC_SLIDING_H

#include "stages.h"

/* The leading edge takes in one sample; `times` is 2 while the mirrored start grows on both sides at once (2.6). */
static void sliding_head_allan(allan_t *allan, const ring_t *ring, uint32_t index, const davar_window_t *window,
                               unsigned times)
{
    const uint32_t position = window->head - 1U;
    const uint32_t length = window->head - window->tail;
    for (uint32_t t = 0U; t < allan->count; t++) {
        tau_t *const tau = &allan->tau[t];
        const uint32_t span = 2U * tau->m;
        tau->head += allan->starting ? allan_start_step(ring, index, position, tau->m, allan->mirrored)
                                     : allan_step(ring, index, tau->m);
        for (unsigned i = 0U; (i < times) && (allan->run >= span) && (length >= span); i++) {
            sum_add_square(&tau->sum, tau->head);
        }
        if (length == span) {
            tau->tail = tau->head; /* the only span of the window: both edges see the same difference */
        }
    }
}

static void sliding_tail_allan(allan_t *allan, const ring_t *ring, uint32_t index, uint32_t length)
{
    const sample_t *const x = ring->sample;
    for (uint32_t t = 0U; t < allan->count; t++) {
        tau_t *const tau = &allan->tau[t];
        const uint32_t span = 2U * tau->m;
        if ((length >= span) && (allan->room >= span)) {
            sum_subtract_square(&tau->sum, tau->tail);
        }
        if (length > span) {
            tau->tail +=
                x[ring_behind(ring, index, span)] - (2 * (difference_t)x[ring_behind(ring, index, tau->m)]) + x[index];
        }
    }
}

static void sliding_head_moments(moments_t *moments, const ring_t *ring, uint32_t index, uint32_t length)
{
    if (moments->segment == 0U) {
        return;
    }
    const powers_t newest = powers_of(ring->sample[index], moments->shift);
    powers_add(&moments->whole, &newest);
    if (length > moments->segment) {
        const powers_t leaving = powers_of(ring->sample[ring_before(ring, index, moments->segment)], moments->shift);
        powers_add(&moments->first, &leaving);
    }
}

static void sliding_tail_moments(moments_t *moments, const ring_t *ring, uint32_t index)
{
    if (moments->segment == 0U) {
        return;
    }
    const powers_t oldest = powers_of(ring->sample[index], moments->shift);
    powers_subtract(&moments->whole, &oldest);
    powers_subtract(&moments->first, &oldest);
}

static void sliding_head(stages_t *stages, davar_t *davar)
{
    davar_window_t *const window = &davar->window;
    const uint32_t index = ring_index(&stages->ring, window->received - window->head);
    allan_extend_run(&stages->allan, &davar->gaps, window, window->head);
    window->head++;
    sliding_head_allan(&stages->allan, &stages->ring, index, window, 1U);
    sliding_head_moments(&stages->moments, &stages->ring, index, window->head - window->tail);
    allan_end_start(&stages->allan, window->head);
}

static void sliding_tail(stages_t *stages, davar_t *davar)
{
    davar_window_t *const window = &davar->window;
    const uint32_t index = ring_index(&stages->ring, window->received - window->tail);
    sliding_tail_allan(&stages->allan, &stages->ring, index, window->head - window->tail);
    sliding_tail_moments(&stages->moments, &stages->ring, index);
    window->tail++;
    allan_shrink_room(&stages->allan, &davar->gaps, window);
}

/* Both edges at once, which is what happens at nearly every sample. */
static void sliding_both(stages_t *stages, davar_t *davar)
{
    davar_window_t *const window = &davar->window;
    const ring_t *const ring = &stages->ring;
    const uint32_t head_index = ring_index(ring, window->received - window->head);
    const uint32_t tail_index = ring_index(ring, window->received - window->tail);
    const uint32_t length = window->head - window->tail;
    allan_slide(&stages->allan, *ring, head_index, tail_index);
    sliding_head_moments(&stages->moments, ring, head_index, length + 1U);
    sliding_tail_moments(&stages->moments, ring, tail_index);
    window->head++;
    window->tail++;
}

/* No gap near either edge, no span that reaches beyond the window or the start: kept as a flag, since only the careful
 * steps and a new gap can change it. */
static bool sliding_is_plain(const allan_t *allan, const davar_window_t *window)
{
    return (allan->run >= allan->span_max) && (allan->to_gap == DAVAR_NO_GAP) && (allan->room == DAVAR_NO_GAP) &&
           ((window->head - window->tail) >= allan->span_max) && !allan->starting;
}

/* Moves the window to [tail, head), the leading edge first so that it never gets shorter than it will be. */
static void sliding_move_carefully(stages_t *stages, davar_t *davar, uint32_t head, uint32_t tail)
{
    davar_window_t *const window = &davar->window;
    while ((window->head != head) || (window->tail != tail)) {
        const bool both = (window->head != head) && (window->tail != tail);
        if (both && sliding_is_plain(&stages->allan, window)) {
            sliding_both(stages, davar);
        } else if (window->head != head) {
            sliding_head(stages, davar);
        } else {
            sliding_tail(stages, davar);
        }
    }
    stages->allan.plain = sliding_is_plain(&stages->allan, window);
}

static void sliding_move(stages_t *stages, davar_t *davar, uint32_t head, uint32_t tail)
{
    const davar_window_t *const window = &davar->window;
    if (stages->allan.plain && ((head - window->head) == 1U) && ((tail - window->tail) == 1U)) {
        sliding_both(stages, davar);
    } else {
        sliding_move_carefully(stages, davar, head, tail);
    }
}

/* Moments of the mirrored window [-n - 1, n + 1): every sample counts twice, in the first part as often as it or its
 * image lies there. */
static void sliding_warm_moments(moments_t *moments, sample_t sample, uint32_t position, uint32_t half)
{
    if (moments->segment == 0U) {
        return;
    }
    const powers_t powers = powers_of(sample, moments->shift);
    powers_add(&moments->whole, &powers);
    powers_add(&moments->whole, &powers);
    if ((position + moments->segment) < half) {
        powers_add(&moments->first, &powers);
    }
    if ((position + half) >= moments->segment) {
        powers_add(&moments->first, &powers);
    }
}

/* Centred start: the window grows on both sides of the first sample at once, [-n - 1, n + 1), until it is full. The
 * mirror image is written into the ring for the trailing edge to find; its differences are those of the right half with
 * the sign turned, so their squares are counted twice (2.6). */
static void sliding_warm(stages_t *stages, davar_t *davar)
{
    davar_window_t *const window = &davar->window;
    ring_t *const ring = &stages->ring;
    const uint32_t position = window->head;
    const uint32_t index = ring_index(ring, 1U);
    const uint32_t half = davar->config->window_max / 2U;
    ring->sample[ring_before(ring, index, (2U * position) + 1U)] = ring->sample[index];
    allan_extend_run(&stages->allan, &davar->gaps, window, window->head);
    window->head++;
    window->tail--;
    sliding_head_allan(&stages->allan, ring, index, window, 2U);
    sliding_warm_moments(&stages->moments, ring->sample[index], position, half);
    allan_end_start(&stages->allan, window->head);
}

/* The window is full: the trailing edge's differences are the mirror images of the leading edge's. */
static void sliding_end_warm(stages_t *stages, davar_t *davar)
{
    allan_t *const allan = &stages->allan;
    for (uint32_t t = 0U; t < allan->count; t++) {
        allan->tau[t].tail = -allan->tau[t].head;
    }
    allan->warming = false;
    allan->run_step = 1U;
    allan->room = davar_gaps_after(&davar->gaps, &davar->window, davar->window.tail);
}

#endif
