/* davar - a value at every sample: window sums that follow both edges of the window, one sample at a time.
 *
 * Nearly always the window glides (both edges move by one), grows or shrinks (one edge moves) with nothing near its
 * edges; those steps are plain. The careful ones know about gaps, the start, and spans longer than the window. */
#ifndef DAVAR_SRC_SLIDING_H
#define DAVAR_SRC_SLIDING_H

#include "window/slide.h"

/* --- where the edges are in the ring ----------------------------------------------------------------------------- */

/* The sample that the leading edge takes in next. */
static const sample_t *sliding_head(const stages_t *stages, const davar_window_t *window)
{
    return ring_leading(&stages->ring, window->lag);
}

/* The sample that the trailing edge leaves behind next. */
static const sample_t *sliding_tail(const stages_t *stages, const davar_window_t *window)
{
    return ring_trailing(&stages->ring, window->lag + window->length);
}

/* --- moments ----------------------------------------------------------------------------------------------------- */

/* The newest of the window's first part, which the window has grown to or glided to. */
static inline sample_t newest_of_first(const stages_t *stages, const davar_t *davar)
{
    return *ring_trailing(&stages->ring, davar->window.lag + 1U + davar->config->segment);
}

/* The window has grown over the sample `head`. */
DAVAR_RARE static void sliding_lead_moments(stages_t *stages, const davar_t *davar, sample_t head)
{
    if (!has_moments(davar->config)) {
        return;
    }
    powers_add(&stages->moments.whole, head);
    if (davar->window.length > davar->config->segment) {
        powers_add(&stages->moments.first, newest_of_first(stages, davar));
    }
}

/* The window loses the sample `tail`, and is longer than the segment. */
DAVAR_APART static void sliding_trail_moments(stages_t *stages, const davar_t *davar, sample_t tail)
{
    if (has_moments(davar->config)) {
        powers_slide(&stages->moments.whole, 0, tail);
        powers_slide(&stages->moments.first, 0, tail);
    }
}

/* Both. */
DAVAR_APART static void sliding_glide_moments(stages_t *stages, const davar_t *davar, sample_t head, sample_t tail)
{
    powers_slide(&stages->moments.whole, head, tail);
    powers_slide(&stages->moments.first, newest_of_first(stages, davar), tail);
}

/* --- plain steps ------------------------------------------------------------------------------------------------- */

/* Both edges, and a sample into the ring. What costs most comes last, when nothing else is waiting for registers. */
static inline void sliding_glide(stages_t *stages, davar_t *davar, sample_t sample, bool with_moments)
{
    davar_window_t *const window = &davar->window;
    ring_put(&stages->ring, sample);
    const sample_t *const head = ring_leading(&stages->ring, window->lag + 1U);
    const sample_t *const tail = ring_trailing(&stages->ring, window->lag + 1U + window->length);
    window_glide(window);
    if (with_moments) {
        sliding_glide_moments(stages, davar, *head, *tail);
    }
    slide(&stages->allan, head, tail);
}

DAVAR_APART static void sliding_lead_plainly(stages_t *stages, davar_t *davar)
{
    davar_window_t *const window = &davar->window;
    const sample_t *const head = sliding_head(stages, window);
    allan_lead(&stages->allan, head);
    window->lag--;
    window->length++;
    sliding_lead_moments(stages, davar, *head);
}

DAVAR_APART static void sliding_trail_plainly(stages_t *stages, davar_t *davar)
{
    davar_window_t *const window = &davar->window;
    const sample_t *const tail = sliding_tail(stages, window);
    allan_trail(&stages->allan, tail);
    sliding_trail_moments(stages, davar, *tail);
    window->length--;
}

/* --- careful steps ----------------------------------------------------------------------------------------------- */

/* `twice` while the mirrored start grows on both sides at once (2.6). */
static void sliding_lead_taus(allan_t *allan, const sample_t *head, const davar_window_t *window, bool twice)
{
    const uint32_t position = window_head(window) - 1U;
    const uint32_t length = window->length;
    const uint32_t whole = smaller(length, allan->run);
    for (uint32_t t = 0U; t < allan->count; t++) {
        tau_t *const tau = &allan->tau[t];
        const uint32_t span = 2U * allan->m[t];
        tau->head += allan_any_step(allan, head, position, allan->m[t]);
        if (span <= whole) {
            sum_add_square(&tau->sum, tau->head);
        }
        if (twice && (span <= whole)) {
            sum_add_square(&tau->sum, tau->head);
        }
        if (length == span) {
            tau->tail = tau->head; /* the only span of the window: both edges see the same difference */
        }
    }
}

/* A span that has been in the sum was in the window, and no gap in it: `whole` samples are both. */
DAVAR_APART static void sliding_trail_taus(const allan_t *allan, const sample_t *tail, uint32_t whole, uint32_t length)
{
    const uint32_t *m = allan->m;
    tau_t *const end = allan->tau + allan->count;
    for (tau_t *tau = allan->tau; tau != end; tau++, m++) {
        const uint32_t span = 2U * *m;
        if (span <= whole) {
            sum_subtract_square(&tau->sum, tau->tail);
        }
        if (span < length) {
            tau->tail += allan_trail_step(tail, *m);
        }
    }
}

static void sliding_lead_carefully(stages_t *stages, davar_t *davar)
{
    davar_window_t *const window = &davar->window;
    const sample_t *const head = sliding_head(stages, window);
    allan_extend_run(&stages->allan, &davar->gaps, window, window_head(window));
    window->lag--;
    window->length++;
    sliding_lead_taus(&stages->allan, head, window, false);
    sliding_lead_moments(stages, davar, *head);
    allan_end_start(&stages->allan, window_head(window));
}

static void sliding_trail_carefully(stages_t *stages, davar_t *davar)
{
    davar_window_t *const window = &davar->window;
    const sample_t *const tail = sliding_tail(stages, window);
    sliding_trail_taus(&stages->allan, tail, smaller(window->length, stages->allan.room), window->length);
    sliding_trail_moments(stages, davar, *tail);
    window->length--;
    allan_shrink_room(&stages->allan, &davar->gaps, window, window_tail(window));
}

/* --- a step of either kind --------------------------------------------------------------------------------------- */

static void sliding_lead(stages_t *stages, davar_t *davar)
{
    if (allan_leads_freely(&stages->allan) && (davar->window.length >= allan_span_max(&stages->allan))) {
        sliding_lead_plainly(stages, davar);
    } else {
        sliding_lead_carefully(stages, davar);
    }
}

static void sliding_trail(stages_t *stages, davar_t *davar)
{
    if ((stages->allan.room == DAVAR_NO_GAP) && (davar->window.length > allan_span_max(&stages->allan))) {
        sliding_trail_plainly(stages, davar);
    } else {
        sliding_trail_carefully(stages, davar);
    }
}

/* May both edges move by one, with nothing near them? Only a careful step or a gap can change the answer. */
static bool sliding_is_free(const allan_t *allan, const davar_window_t *window)
{
    return allan_leads_freely(allan) && (allan->room == DAVAR_NO_GAP) && (window->length >= allan_span_max(allan));
}

/* Can the window glide from here on, sample by sample, as far as the law goes? */
static bool sliding_glides(const allan_t *allan, const davar_window_t *window)
{
    return sliding_is_free(allan, window) && (window->next_length == window->length);
}

/* Both edges, as far as both have to go and nothing is near them. */
DAVAR_APART static void sliding_follow(stages_t *stages, davar_t *davar, uint32_t lag, uint32_t length)
{
    davar_window_t *const window = &davar->window;
    const uint32_t tail_steps = (window->lag + window->length) - (lag + length);
    for (uint32_t both = smaller(window->lag - lag, tail_steps); both > 0U; both--) {
        if (!sliding_is_free(&stages->allan, window)) {
            return;
        }
        const sample_t *const head = sliding_head(stages, window);
        const sample_t *const tail = sliding_tail(stages, window);
        window->lag--;
        if (has_moments(davar->config)) {
            sliding_glide_moments(stages, davar, *head, *tail);
        }
        slide(&stages->allan, head, tail);
    }
}

/* Moves the edges to where the law wants them, the leading one first so that no window gets shorter than the last. While
 * the window is no longer than the segment it has no first part that could glide with it. */
static void sliding_move(stages_t *stages, davar_t *davar, uint32_t lag, uint32_t length)
{
    const davar_window_t *const window = &davar->window;
    if ((davar->config->stride > 1U) && (window->length > davar->config->segment)) {
        sliding_follow(stages, davar, lag, length);
    }
    while (window->lag != lag) {
        DAVAR_ASSERT(window->lag > lag);
        sliding_lead(stages, davar);
    }
    while (window->length != length) {
        DAVAR_ASSERT(window->length > length);
        sliding_trail(stages, davar);
    }
}

/* --- the mirrored start ------------------------------------------------------------------------------------------ */

/* The sample at `position` and its mirror image at -position - 1 come in; the first part of the full window ends `segment`
 * samples in front of `half`. */
DAVAR_RARE static void sliding_warm_moments(moments_t *moments, const davar_config_t *config, sample_t sample,
                                            uint32_t position)
{
    const uint32_t half = config->window_max / 2U;
    if (!has_moments(config)) {
        return;
    }
    powers_add(&moments->whole, sample);
    powers_add(&moments->whole, sample);
    if ((position + config->segment) < half) {
        powers_add(&moments->first, sample);
    }
    if ((position + half) >= config->segment) {
        powers_add(&moments->first, sample);
    }
}

/* The window is full: the trailing edge's differences are the mirror images of the leading edge's. */
DAVAR_RARE static void sliding_end_warm(stages_t *stages, davar_t *davar)
{
    allan_t *const allan = &stages->allan;
    for (uint32_t t = 0U; t < allan->count; t++) {
        allan->tau[t].tail = -allan->tau[t].head;
    }
    allan->warming = false;
    allan->run_doubles = false;
    allan->room = davar_gaps_after(&davar->gaps, &davar->window, window_tail(&davar->window));
}

/* Centred start: the window grows on both sides of the first sample at once, [-n - 1, n + 1), until it is full. The
 * mirror image is written into the ring for the trailing edge to find; its differences are those of the right half with
 * the sign turned, so their squares are counted twice (2.6). */
DAVAR_RARE static void sliding_warm(stages_t *stages, davar_t *davar)
{
    davar_window_t *const window = &davar->window;
    ring_t *const ring = &stages->ring;
    const uint32_t position = window_head(window);
    const sample_t *const head = ring_leading(ring, 1U);
    ring_set(ring, ring_index(ring, (2U * position) + 2U), *head);
    allan_extend_run(&stages->allan, &davar->gaps, window, position);
    window->lag--;
    window->length += 2U;
    sliding_lead_taus(&stages->allan, head, window, true);
    sliding_warm_moments(&stages->moments, davar->config, *head, position);
    allan_end_start(&stages->allan, window_head(window));
    if (window->length == davar->config->window_max) {
        sliding_end_warm(stages, davar);
    }
}

#endif
