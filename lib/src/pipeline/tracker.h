/* davar - policy glr: samples wait in front of the pipeline until the detector has heard their block, a shock is dropped and leaves
 * a gap, and a cut moves the window's trailing edge (10.11).
 *
 *   sample -> [ accepted | a shock? | block that fills ] -> detector
 *                 |
 *                 v  one for each that comes, two to catch up; on a grid all
 *              pipeline
 */
#ifndef DAVAR_SRC_TRACKER_H
#define DAVAR_SRC_TRACKER_H

#include "common/arena.h"
#include "grid/grid_window.h"
#include "pipeline/limit.h"
#include "track/window.h"
#include "window/stages.h"

typedef struct tracker {
    davar_glr_config_t config;
    davar_glr_t detector;
    block_t block;     /* of the samples that came last, */
    uint32_t filled;   /* so many */
    sample_t *waiting; /* the oldest at `first`, in a ring of their own */
    uint32_t capacity;
    uint32_t first;
    uint32_t count;
    uint32_t accepted; /* of them, the first ones: to be passed on */
    uint32_t shock;    /* samples that were dropped in front of the next accepted one */
    uint32_t tail;     /* position where the detector wants the window to begin */
    uint32_t cut;      /* position of the newest change */
    uint32_t end;      /* position of the end of what was accepted when a block was last heard */
    uint32_t longest;  /* whole strides of a window */
    bool full;         /* as many samples as the longest window has come */
    bool was_cut;      /* since the newest epoch */
    bool news;         /* the tail is older than the end */
} tracker_t;

/* A block that fills, what may be a shock with the block that tells, and as many accepted as that leaves when it was none. */
static uint32_t tracker_capacity(const davar_config_t *config)
{
    return (config->shock_blocks + 3U) * config->block;
}

DAVAR_RARE static tracker_t *tracker_carve(davar_arena_t *arena, const davar_config_t *config, bool is_counted_only)
{
    tracker_t *const tracker = davar_arena_take(arena, 1U, sizeof(tracker_t));
    sample_t *const waiting = davar_arena_take(arena, tracker_capacity(config), sizeof(sample_t));
    if (!is_counted_only) {
        tracker->waiting = waiting;
        tracker->capacity = tracker_capacity(config);
    }
    return tracker;
}

/* Everything from the beginning, the detector too. */
DAVAR_RARE static void tracker_start(tracker_t *tracker, const davar_config_t *config)
{
    const davar_glr_wish_t wish = {.rate_hz = config->rate_hz,
                                   .false_alarms_per_hour = config->false_alarms_per_hour,
                                   .cut_interval_s = config->cut_interval_s,
                                   .longest = config->window_max,
                                   .block = config->block,
                                   .shock = config->shock_blocks};
    davar_glr_start(&tracker->config, &wish);
    davar_glr_reset(&tracker->detector);
    tracker->longest = (config->window_max / config->stride) * config->stride;
}

static uint32_t tracker_index(const tracker_t *tracker, uint32_t ahead)
{
    const uint32_t index = tracker->first + ahead;
    return (index >= tracker->capacity) ? (index - tracker->capacity) : index;
}

/* The oldest `dropped` samples go: while it was open whether they are a shock, all accepted ones have gone on. */
DAVAR_RARE static void tracker_drop(tracker_t *tracker, uint32_t dropped)
{
    for (uint32_t i = dropped; i < tracker->count; i++) {
        tracker->waiting[tracker_index(tracker, i - dropped)] = tracker->waiting[tracker_index(tracker, i)];
    }
    tracker->count -= dropped;
    tracker->shock = dropped;
}

/* The detector has heard the block that is full. */
static void tracker_hear(tracker_t *tracker, davar_t *davar, const davar_glr_event_t *event)
{
    const davar_glr_t *const detector = &tracker->detector;
    const uint32_t block = tracker->config.block;
    if (event->dropped > 0U) {
        tracker_drop(tracker, event->dropped * block);
        davar_count(&davar->health.shocks);
    }
    tracker->accepted += (event->resolved - event->dropped) * block;
    tracker->end = davar->window.received + tracker->accepted;
    tracker->cut = tracker->end - ((detector->now.sum.blocks - detector->cut.sum.blocks) * block);
    tracker->news = true;
    if (event->is_cut) {
        tracker->was_cut = true;
        davar_count(&davar->health.cuts);
    }
    if (event->is_alarm) {
        davar_count(&davar->health.alarms);
    }
}

/* Samples come, to the end of their block at most; returns how many were taken. */
static uint32_t tracker_take_in(tracker_t *tracker, davar_t *davar, sample_t highest, const sample_t *samples,
                                size_t count)
{
    const uint32_t at = tracker_index(tracker, tracker->count);
    const uint32_t room = smaller(tracker->config.block - tracker->filled, tracker->capacity - at);
    const uint32_t n = (count < room) ? (uint32_t)count : room;
    block_t block;
    block_copy(&block, &tracker->block);
    sample_t *to = &tracker->waiting[at];
    for (const sample_t *const end = samples + n; samples != end; samples++, to++) {
        const sample_t sample = limited(highest, davar, *samples);
        *to = sample;
        block_add(&block, sample);
    }
    block_copy(&tracker->block, &block);
    tracker->count += n;
    tracker->filled += n;
    if (tracker->filled == tracker->config.block) {
        davar_glr_event_t event;
        block_tell(&block, &tracker->detector, &tracker->config, &event);
        block_clear(&tracker->block);
        tracker->filled = 0U;
        tracker_hear(tracker, davar, &event);
    }
    return n;
}

/* Where the window that the detector wants begins; asked for when an epoch is due, once for each block at most. */
static uint32_t tracker_tail(tracker_t *tracker)
{
    if (tracker->news) {
        davar_glr_window_t window;
        davar_glr_trailing(&tracker->detector, &tracker->config, &window);
        tracker->tail = tracker->end - (window.blocks * tracker->config.block);
        tracker->news = false;
    }
    return tracker->tail;
}

/* Length of the next window (10.11): up to what the detector wants. The sums that follow both edges go there step by step. */
static uint32_t tracker_next(tracker_t *tracker, const davar_config_t *config, const davar_window_t *window,
                             bool at_once)
{
    const uint32_t head = window->received + config->stride;
    const uint32_t since = head - tracker_tail(tracker);
    const uint32_t wanted = ((int32_t)since < (int32_t)config->window_min) ? config->window_min : since;
    tracker->full = tracker->full || (head >= config->window_max);
    const uint32_t most = smaller(wanted, tracker->full ? config->window_max : head);
    if (at_once) {
        uint32_t rest = most;
        const uint32_t whole = whole_strides(&rest, config->stride) * config->stride;
        return smaller((rest > 0U) ? (whole + config->stride) : whole, tracker->longest);
    }
    if (most > window->length) {
        return window->length + 1U;
    }
    const uint32_t shorter = (window->length > config->shrink) ? (window->length - config->shrink) : 1U;
    return (shorter > most) ? shorter : most;
}

#endif
