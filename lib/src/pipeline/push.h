/* davar - a sample and what hangs on it: the epoch when it is due, the window where the law wants it, the verdict; and a gap in
 * front of a sample. */
#ifndef DAVAR_SRC_PUSH_H
#define DAVAR_SRC_PUSH_H

#include "pipeline/collect.h"
#include "pipeline/start.h"
#include "window/sliding.h"

/* --- a sample in ------------------------------------------------------------------------------------------------- */

/* Puts the window of the epoch that is due where the law wants it. */
static void window_move(stages_t *stages, davar_t *davar)
{
    davar_window_t *const window = &davar->window;
    uint32_t lag = davar_law_lag(davar->config, window->next_length);
    if (tracks_about(davar->config)) { /* by what has been heard up to now */
        tracker_about(stages->tracker, davar->config, window);
        lag = window->lag;
    } else if (is_tracked(stages) && on_grid(stages)) {
        window->next_length = tracker_next(stages->tracker, davar->config, window, true);
    }
    if (on_grid(stages)) {
        window->lag = lag;
        window->length = window->next_length;
    } else {
        sliding_move(stages, davar, lag, window->next_length);
    }
    window->at_start = at_start(window) && ((int32_t)window_tail(window) < 0);
}

#define YOUNG 8U /* blocks */

/* What the detector has found by this epoch. A change that is told while samples behind it still wait is 0 samples old. */
static void tracker_judge(tracker_t *tracker, const davar_t *davar)
{
    const uint32_t age = davar->window.received - tracker->cut;
    tracker->age = ((int32_t)age > 0) ? age : 0U;
    tracker->young = (davar->health.cuts > 0U) &&
                     ((tracker->age <= (YOUNG * davar->config->block)) || (tracker->age < davar->window.length));
    tracker->was_cut = false;
    tracker->left_out = 0U;
}

/* The verdict on the window, and with it the length of the next (4.1). */
DAVAR_APART static void window_judge(stages_t *stages, davar_t *davar)
{
    davar_window_t *const window = &davar->window;
    const davar_config_t *const config = davar->config;
    bool unstable = false;
    if (is_tracked(stages)) {
        unstable = stages->tracker->was_cut;
        tracker_judge(stages->tracker, davar);
    } else if (is_judged(config) && (window->length >= config->window_min)) {
        davar_central_t whole;
        davar_central_t first;
        powers_t room;
        powers_central(window_whole(&room, stages), window->length, &whole);
        powers_central(window_first(&room, stages), window->length - config->segment, &first);
        unstable = davar_stationarity_unstable(config, &whole, &first);
    }
    davar->unstable = unstable;
    window->filling = window->filling && !unstable && (window->length < config->window_max);
    if (!is_tracked(stages)) {
        window->next_length = davar_law_next(config, window->length, unstable, window->filling);
    } else if (!on_grid(stages)) {
        window->next_length = tracker_next(stages->tracker, config, window, false);
    }
}

/* Windows of policy glr may begin earlier again: their gaps are kept as long as the longest reaches. */
static uint32_t reach_of_gaps(const davar_t *davar)
{
    return is_tracked(davar->stages) ? davar->config->window_max : davar->window.length;
}

/* The window of the epoch that is due. True when it is long enough to report. */
DAVAR_APART static bool window_complete(stages_t *stages, davar_t *davar)
{
    davar_window_t *const window = &davar->window;
    window_move(stages, davar);
    davar_gaps_forget(&davar->gaps, window, reach_of_gaps(davar));
    window->wait = davar->config->stride;
    const bool early =
        tracks_about(davar->config) && !stages->tracker->full && (window->received <= stages->tracker->half);
    const bool reported = !early && (window->length >= davar->config->window_min);
    if (reported && on_grid(stages)) {
        grid_place(stages, davar);
    }
    return reported;
}

static steady_t steadiness(const stages_t *stages, const davar_t *davar)
{
    const davar_window_t *const window = &davar->window;
    if (on_grid(stages)) {
        return allan_leads_freely(&stages->allan) ? STEADY_GRID : STEADY_NOT;
    }
    if ((davar->config->stride > 1U) || is_warming(&stages->allan) || !sliding_glides(&stages->allan, window)) {
        return STEADY_NOT;
    }
    return (has_moments(davar->config) || is_adaptive(davar->config) || at_start(window)) ? STEADY_GLIDING
                                                                                          : STEADY_PLAIN;
}

/* What comes after samples that did not glide: the epoch, when it is due, and how to go on. True when it is reported. */
static bool step_end(stages_t *stages, davar_t *davar)
{
    bool reported = false;
    if (davar->window.wait == 0U) {
        reported = window_complete(stages, davar);
        window_judge(stages, davar);
    }
    stages->steady = (uint8_t)steadiness(stages, davar);
    return reported;
}

/* One sample, which is in the ring already. */
DAVAR_APART static void step_carefully(stages_t *stages, davar_t *davar)
{
    davar_window_t *const window = &davar->window;
    if (on_grid(stages)) {
        grid_advance_carefully(stages, davar);
    } else {
        window_receive(window, 1U);
        if (is_warming(&stages->allan)) {
            sliding_warm(stages, davar);
        }
    }
    window->wait--;
}

/* One sample while the window glides: it completes an epoch. */
static inline void push_gliding(stages_t *stages, davar_t *davar, sample_t sample)
{
    davar_window_t *const window = &davar->window;
    sliding_glide(stages, davar, limited(stages->highest, davar, sample), has_moments(davar->config));
    if (at_start(window)) {
        window->at_start = (int32_t)window_tail(window) < 0;
        stages->steady = (uint8_t)steadiness(stages, davar);
    }
    if (is_adaptive(davar->config)) {
        window_judge(stages, davar);
        if (window->next_length != window->length) {
            stages->steady = STEADY_NOT;
        }
    }
    davar_produce(davar);
}

/* Into the ring, from stretch to stretch of its memory. */
static void put_block(stages_t *stages, davar_t *davar, const sample_t *samples, uint32_t count)
{
    ring_t *const ring = &stages->ring;
    const sample_t highest = stages->highest; /* not asked again for every sample that is written */
    const sample_t *const end = samples + count;
    while (samples != end) {
        const uint32_t again = ring_again(ring);
        const uint32_t n = smaller((uint32_t)(end - samples), ring_stretch(ring));
        DAVAR_ASSERT((n > 0U) && (n <= (uint32_t)(end - samples)));
        sample_t *to = &ring->sample[ring->next];
        DAVAR_UNROLLED
        for (const sample_t *const stop = samples + n; samples != stop; samples++, to++) {
            const sample_t sample = limited(highest, davar, *samples);
            *to = sample;
            to[again] = sample;
        }
        ring_advance(ring, n);
    }
}

/* Up to `count` samples, as many as can go together; returns how many. */
DAVAR_APART static uint32_t step_grid(stages_t *stages, davar_t *davar, const sample_t *samples, size_t count)
{
    davar_window_t *const window = &davar->window;
    const uint32_t n = grid_block(stages, window, (count < window->wait) ? (uint32_t)count : window->wait);
    if (n == 1U) {
        ring_put(&stages->ring, limited(stages->highest, davar, samples[0]));
    } else {
        put_block(stages, davar, samples, n);
    }
    grid_advance_plainly(stages, davar, n);
    window->wait -= n;
    return n;
}

/* Takes in the first of `count` samples, and more when they can go together; returns how many. */
static size_t step(stages_t *stages, davar_t *davar, const sample_t *samples, size_t count)
{
    if (DAVAR_GRID && (stages->steady == STEADY_GRID)) {
        return step_grid(stages, davar, samples, count);
    }
    ring_put(&stages->ring, limited(stages->highest, davar, samples[0]));
    step_carefully(stages, davar);
    return 1U;
}

/* Samples in front of the next boundary of the grid of epochs after a restart are limited, and left out. */
static size_t skip(const stages_t *stages, davar_t *davar, sample_t sample)
{
    (void)limited(stages->highest, davar, sample);
    davar->window.skip--;
    return 1U;
}

/* Samples while more happens than a window that glides. */
DAVAR_APART static size_t push_any(stages_t *stages, davar_t *davar, const sample_t *samples, size_t count)
{
    if ((stages->steady == STEADY_GLIDING) && (count > 0U)) {
        push_gliding(stages, davar, samples[0]);
        return 1U;
    }
    size_t consumed = 0U;
    bool complete = false;
    while ((consumed < count) && !complete) {
        if (davar->window.skip > 0U) {
            consumed += skip(stages, davar, samples[consumed]);
        } else {
            const size_t n = step(stages, davar, &samples[consumed], count - consumed);
            DAVAR_ASSERT((n > 0U) && (n <= (count - consumed)));
            consumed += n;
            complete = step_end(stages, davar);
        }
    }
    if (complete) {
        davar_produce(davar);
    }
    return consumed;
}

/* Takes samples up to the one that completes a result. */
static inline size_t push_steadily(stages_t *stages, davar_t *davar, const sample_t *samples, size_t count)
{
    if ((stages->steady != STEADY_PLAIN) || (count == 0U)) {
        return push_any(stages, davar, samples, count);
    }
    sliding_glide(stages, davar, limited(stages->highest, davar, samples[0]), false);
    davar_produce(davar);
    return 1U;
}

/* --- weather ----------------------------------------------------------------------------------------------------- */

/* Samples to the next boundary of the grid of epochs: the wait for an epoch falls by one with each sample, and by whole
 * strides from epoch to epoch. */
static uint32_t to_boundary(const davar_t *davar)
{
    const uint32_t stride = davar->config->stride;
    const uint32_t since = (first_wait(davar->config) - davar->window.wait) % stride;
    return (since == 0U) ? 0U : (stride - since);
}

/* Throws the window away and starts again, with the next epoch where it was due: at the boundary of the grid of epochs before it.
 * Windows of policy glr begin at any block, so no sample need be left out. Never while samples in front of a boundary are left out: a gap
 * there is no boundary between samples. */
DAVAR_RARE static void pipeline_restart(davar_t *davar)
{
    const bool tracked = is_tracked(davar->stages);
    const uint32_t skipped = tracked ? 0U : to_boundary(davar);
    const uint32_t wait = tracked ? davar->window.wait : first_wait(davar->config);
    const uint32_t received = davar->window.received;
    davar_count(&davar->health.restarts);
    davar->ready = false;
    start_stages(davar, window_now(&davar->window) + skipped, skipped, wait);
    if (tracked) {
        tracker_rebase(((stages_t *)davar->stages)->tracker, received);
    }
}

/* A boundary between the newest window and the next: where the stride equals window_max, directly after an epoch; or in front of the first
 * of centred windows, where the stride is longer than half of window_max. */
static bool between_windows(const davar_t *davar)
{
    const davar_window_t *const window = &davar->window;
    return on_grid(davar->stages) && (window->wait >= davar->config->window_max);
}

/* A boundary in front of the sample that comes next. False: no room to remember it, nothing changed. */
static bool window_boundary(davar_t *davar)
{
    stages_t *const stages = davar->stages;
    const davar_window_t *const window = &davar->window;
    allan_t *const allan = &stages->allan;
    stages->steady = STEADY_NOT;
    if (between_windows(davar)) {
        allan->to_gap = 0U; /* ends the run, and no window needs to remember it */
        return true;
    }
    if (!davar_gaps_push(&davar->gaps, window, reach_of_gaps(davar))) {
        return false;
    }
    if (davar->gaps.count == 0U) {
        return true; /* in front of the first sample: no boundary */
    }
    if (allan->to_gap == DAVAR_NO_GAP) {
        allan->to_gap = on_grid(stages) ? 0U : window->lag;
    }
    if ((allan->room == DAVAR_NO_GAP) && !is_warming(allan)) {
        allan->room = davar_gaps_after(&davar->gaps, window, window_tail(window));
    }
    return true;
}

DAVAR_APART DAVAR_RARE static void window_gap(davar_t *davar)
{
    if (!window_boundary(davar)) {
        pipeline_restart(davar);
    }
}

#endif
