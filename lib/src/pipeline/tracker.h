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
#include "number/real.h"
#include "pipeline/limit.h"
#include "track/window.h"
#include "window/stages.h"

/* Samples that a window shrinks at least, one step: what is in front of a cut must not stay in it. */
#define TRACKER_SHRINK 64U

/* The second channel: what clusters of samples do, told from the sums of blocks (10.13). */
typedef struct {
    davar_glr_config_t config;
    davar_glr_t detector;
    difference_t waiting[GLR_SHOCK_MAX + 1U]; /* sums of the blocks that the first channel has not accepted yet */
    difference_t hop[8];                      /* sums of a quarter of a cluster each, a ring */
    difference_t sum;                         /* of the hop that fills */
    uint32_t waits;                           /* blocks */
    uint32_t filled;                          /* samples of the hop that fills */
    uint32_t hops; /* since the last gap; modulo 8 the place of the next, from 8 on all are there */
} clusters_t;

/* A boundary between two samples that wait, or in front of the next one to come. */
typedef struct {
    uint32_t ahead;    /* accepted samples in front of it */
    uint32_t left_out; /* samples that take their time there: a shock, or what was not accepted when a gap came */
    bool is_gap;       /* the producer's, which may restart the window */
} mark_t;

/* Between two of them is an accepted block at least, and of those tracker_capacity() wait at most. */
#define MARKS_MAX (GLR_SHOCK_MAX + 4U)

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
    mark_t mark[MARKS_MAX];
    uint32_t marks;
    uint32_t left_out;    /* samples that belong to no sum and took their time since the newest epoch */
    uint32_t tail;        /* position where the detector wants the window to begin */
    uint32_t cut;         /* position of the newest change */
    uint32_t end;         /* position of the end of what was accepted when a block was last heard */
    uint32_t age;         /* samples from the newest change to the newest epoch */
    uint32_t half;        /* samples from the epoch of a centred window to its end; 0: trailing */
    uint32_t behind;      /* samples of time that have gone by behind the end of the record */
    clusters_t *clusters; /* null: none */
    davar_spread_t older; /* in front of the newest change that was told */
    int32_t gain;         /* which told it from what is behind, GAIN_DIGITS */
    uint32_t changed;     /* cluster that it was of: 1, or of the second channel; 0: nothing was told */
    bool full;            /* as many samples as the longest window has come */
    bool ended;           /* the record has: nothing comes any more */
    bool was_cut;         /* since the newest epoch */
    bool young;           /* its window was cut at most YOUNG blocks before it, or is to be (10.14) */
    bool news;            /* the tail is older than the end */
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
    clusters_t *clusters = NULL;
    if (config->long_cluster != 0U) {
        clusters = davar_arena_take(arena, 1U, sizeof(clusters_t));
    }
    if (!is_counted_only) {
        tracker->waiting = waiting;
        tracker->capacity = tracker_capacity(config);
        tracker->clusters = clusters;
    }
    return tracker;
}

/* Everything from the beginning, the detector too. Two channels share the rate of false alarms. */
DAVAR_RARE static void tracker_start(tracker_t *tracker, const davar_config_t *config)
{
    const double share = (config->long_cluster != 0U) ? 0.5 : 1.0;
    davar_glr_wish_t wish = {.rate_hz = config->rate_hz,
                             .false_alarms_per_hour = davar_scale(config->false_alarms_per_hour, share),
                             .cut_interval_s = config->cut_interval_s,
                             .longest = config->window_max,
                             .block = config->block,
                             .shock = config->shock_blocks,
                             .is_centred = looks_back(config)};
    davar_glr_start(&tracker->config, &wish);
    davar_glr_reset(&tracker->detector);
    if (config->long_cluster != 0U) {
        wish.block = config->long_cluster / 4U;
        davar_glr_start_clusters(&tracker->clusters->config, &wish);
        davar_glr_reset(&tracker->clusters->detector);
    }
    tracker->half = tracker->config.half * config->block;
}

static uint32_t tracker_index(const tracker_t *tracker, uint32_t ahead)
{
    const uint32_t index = tracker->first + ahead;
    return (index >= tracker->capacity) ? (index - tracker->capacity) : index;
}

/* A boundary behind the accepted samples. */
DAVAR_RARE static void tracker_mark(tracker_t *tracker, uint32_t left_out, bool is_gap)
{
    const uint32_t marks = tracker->marks;
    const bool is_known = (marks > 0U) && (tracker->mark[marks - 1U].ahead == tracker->accepted);
    DAVAR_ASSERT(is_known || (marks < MARKS_MAX));
    mark_t *const mark = &tracker->mark[is_known ? (marks - 1U) : marks];
    if (!is_known) {
        mark->ahead = tracker->accepted;
        mark->left_out = 0U;
        mark->is_gap = false;
        tracker->marks++;
    }
    mark->left_out += left_out;
    mark->is_gap = mark->is_gap || is_gap;
}

/* The oldest `dropped` samples that are not accepted go. */
DAVAR_RARE static void tracker_drop(tracker_t *tracker, uint32_t dropped, bool is_gap)
{
    const uint32_t kept = tracker->accepted + dropped;
    for (uint32_t i = kept; i < tracker->count; i++) {
        tracker->waiting[tracker_index(tracker, i - dropped)] = tracker->waiting[tracker_index(tracker, i)];
    }
    tracker->count -= dropped;
    tracker_mark(tracker, dropped, is_gap);
}

/* The window begins anew, and positions count from here. The detector's places in the past are below 0 then. */
DAVAR_RARE static void tracker_rebase(tracker_t *tracker, uint32_t received)
{
    tracker->tail -= received;
    tracker->end -= received;
    tracker->cut -= received;
    tracker->full = false;
}

/* A change has been told. */
DAVAR_RARE static void tracker_note(tracker_t *tracker, davar_t *davar, const davar_glr_event_t *event, uint32_t m)
{
    spread_copy(&tracker->older, &event->older);
    tracker->gain = event->gain;
    tracker->changed = m;
    davar_count(&davar->health.alarms);
}

/* The sum of the next block of accepted samples. */
static void clusters_push(tracker_t *tracker, davar_t *davar, difference_t sum)
{
    clusters_t *const clusters = tracker->clusters;
    clusters->sum += sum;
    clusters->filled += tracker->config.block;
    if (clusters->filled < clusters->config.block) {
        return;
    }
    const uint32_t at = clusters->hops;
    clusters->hop[at % 8U] = clusters->sum;
    clusters->hops = (at == 15U) ? 8U : (at + 1U);
    clusters->filled = 0U;
    clusters->sum = 0;
    if (clusters->hops < 8U) {
        return;
    }
    difference_t difference = 0;
    for (uint32_t i = 0U; i < 4U; i++) {
        difference += clusters->hop[(at - i) % 8U] - clusters->hop[(at + 4U - i) % 8U];
    }
    davar_glr_event_t event;
    clusters_tell(difference, &clusters->detector, &clusters->config, &event);
    if (event.is_alarm) {
        tracker_note(tracker, davar, &event, clusters->config.floor);
    }
}

/* No cluster spans a gap. */
static void clusters_gap(clusters_t *clusters)
{
    clusters->hops = 0U;
    clusters->filled = 0U;
    clusters->sum = 0;
    clusters->waits = 0U;
}

/* The first channel has heard a block of this sum. Of a change that it has told nothing is left to tell. */
static void clusters_hear(tracker_t *tracker, davar_t *davar, difference_t sum, const davar_glr_event_t *event)
{
    clusters_t *const clusters = tracker->clusters;
    clusters->waiting[clusters->waits] = sum;
    clusters->waits++;
    if (event->is_alarm) {
        davar_glr_begin_anew(&clusters->detector);
    }
    if (event->resolved == 0U) {
        return;
    }
    const uint32_t blocks = clusters->waits;
    if (event->dropped > 0U) {
        clusters_gap(clusters);
    }
    for (uint32_t i = event->dropped; i < blocks; i++) {
        clusters_push(tracker, davar, clusters->waiting[i]);
    }
    clusters->waits = 0U;
}

/* The detector has heard the block that is full. */
static void tracker_hear(tracker_t *tracker, davar_t *davar, const davar_glr_event_t *event)
{
    const davar_glr_t *const detector = &tracker->detector;
    const uint32_t block = tracker->config.block;
    if (event->dropped > 0U) {
        tracker_drop(tracker, event->dropped * block, false);
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
        tracker_note(tracker, davar, event, 1U);
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
        if (tracker->clusters != NULL) {
            clusters_hear(tracker, davar, block.sum, &event);
        }
    }
    return n;
}

/* The record ends: samples of a block that is not full go on unheard, unless a shock may have begun in front of them. */
DAVAR_RARE static void tracker_end(tracker_t *tracker)
{
    if (!tracker->ended && (tracker->detector.pending == 0U)) {
        tracker->accepted = tracker->count;
    }
    tracker->ended = true;
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

/* Up to whole blocks. */
static uint32_t up_to_blocks(uint32_t samples, uint32_t block)
{
    uint32_t rest = samples;
    const uint32_t whole = whole_steps(&rest, block) * block;
    return (rest > 0U) ? (whole + block) : whole;
}

/* Length of the window (10.11) that ends here on a grid: it begins where the detector wants it, or as many blocks away as window_min and
 * `most` require. */
static uint32_t tracker_length(const davar_config_t *config, uint32_t since, uint32_t most)
{
    uint32_t length = since;
    if ((int32_t)since < (int32_t)config->window_min) {
        length += up_to_blocks(config->window_min - since, config->block);
    }
    return (length > most) ? (length - up_to_blocks(length - most, config->block)) : length;
}

/* Length of the window (10.11). On a grid of the one that ends here; the sums that follow both edges go step by step, with the next
 * sample. */
static uint32_t tracker_next(tracker_t *tracker, const davar_config_t *config, const davar_window_t *window,
                             bool at_once)
{
    const uint32_t head = window->received + (at_once ? 0U : 1U);
    const uint32_t since = head - tracker_tail(tracker);
    tracker->full = tracker->full || (head >= config->window_max);
    const uint32_t room = tracker->full ? config->window_max : head;
    if (at_once) {
        return tracker_length(config, since, room);
    }
    const uint32_t wanted = ((int32_t)since < (int32_t)config->window_min) ? config->window_min : since;
    const uint32_t most = smaller(wanted, room);
    if (most > window->length) {
        return window->length + 1U;
    }
    const uint32_t shrink = (config->shrink > TRACKER_SHRINK) ? config->shrink : TRACKER_SHRINK;
    const uint32_t shorter = (window->length > shrink) ? (window->length - shrink) : 1U;
    return (shorter > most) ? shorter : most;
}

/* Blocks that have been accepted since the place `half` samples back, the one that holds it too. More may have been heard than
 * has come on, and at the end of a record less. */
static uint32_t tracker_back(const tracker_t *tracker, const davar_window_t *window)
{
    const int32_t block = (int32_t)tracker->config.block;
    int32_t ahead = (int32_t)(tracker->end - window->received);
    uint32_t blocks = tracker->config.half + 1U;
    for (; ahead >= block; ahead -= block) {
        blocks++;
    }
    for (; (ahead < 0) && (blocks > 1U); ahead += block) {
        blocks--;
    }
    return blocks;
}

/* The window about the epoch that is due, on the grid (10.15): what the detector wants, and the epoch in it. Where that is shorter than
 * window_min it takes newer blocks as far as they have come, then older ones. `back` and `lag`: of its edges, from now. */
static void tracker_about(tracker_t *tracker, const davar_config_t *config, davar_window_t *window)
{
    const uint32_t block = config->block;
    const uint32_t half = tracker->half;
    const uint32_t age = davar_glr_age_of(&tracker->detector, tracker_back(tracker, window));
    const uint32_t newest = (tracker->behind > 0U) ? (window->received - tracker->end) : 0U;
    davar_glr_window_t wanted;
    uint32_t back = window->received;
    uint32_t lag = newest;
    if (davar_glr_centred(&tracker->detector, &tracker->config, age, &wanted)) {
        const uint32_t since = window->received - (tracker->end - (wanted.after * block));
        back = since + (wanted.blocks * block);
        lag = ((int32_t)since > (int32_t)newest) ? since : newest;
    }
    tracker->full = tracker->full || (window->received >= config->window_max);
    const uint32_t most = tracker->full ? config->window_max : window->received;
    back += ((int32_t)back <= (int32_t)half) ? up_to_blocks((half + 1U) - back, block) : 0U;
    lag -= (lag > half) ? smaller(up_to_blocks(lag - half, block), lag - newest) : 0U;
    back -= (back > most) ? up_to_blocks(back - most, block) : 0U;
    if ((back - lag) < config->window_min) {
        lag -= smaller(up_to_blocks(config->window_min - (back - lag), block), lag - newest);
    }
    if ((back - lag) < config->window_min) {
        back += up_to_blocks(config->window_min - (back - lag), block);
        back -= (back > most) ? up_to_blocks(back - most, block) : 0U;
    }
    window->lag = lag;
    window->next_length = back - lag;
}

#endif
