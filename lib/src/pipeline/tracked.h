/* davar - samples that the detector has heard go on into the pipeline (10.11): see tracker.h. */
#ifndef DAVAR_SRC_TRACKED_H
#define DAVAR_SRC_TRACKED_H

#include "pipeline/push.h"

/* Samples that go by and belong to no sum. */
static void leave_out(tracker_t *tracker, davar_t *davar, uint32_t samples)
{
    davar->window.origin += samples;
    tracker->left_out += samples;
}

/* By members: a compiler makes a call of memmove of whole ones. */
static void mark_copy(mark_t *to, const mark_t *from)
{
    to->ahead = from->ahead;
    to->left_out = from->left_out;
    to->is_gap = from->is_gap;
}

/* What was left out in front of the next sample takes its time, and no difference spans the place. With more gaps than the window can
 * remember, it begins anew behind a gap; the neighbours of a shock are joined: no differences are lost then, and a few span the joint. */
DAVAR_RARE static void pass_mark(tracker_t *tracker, davar_t *davar)
{
    const mark_t mark = tracker->mark[0];
    tracker->marks--;
    for (uint32_t i = 0U; i < tracker->marks; i++) {
        mark_copy(&tracker->mark[i], &tracker->mark[i + 1U]);
    }
    leave_out(tracker, davar, mark.left_out);
    if (mark.is_gap) {
        window_gap(davar);
    } else {
        (void)window_boundary(davar);
    }
}

/* The next accepted samples up to a boundary, where they lie in a row, at most `most`; returns how many went on. */
static uint32_t pass_row(stages_t *stages, davar_t *davar, uint32_t most)
{
    tracker_t *const tracker = stages->tracker;
    const uint32_t straight = tracker->capacity - tracker->first;
    const uint32_t row = (tracker->marks > 0U) ? smaller(straight, tracker->mark[0].ahead) : straight;
    const uint32_t saturated = davar->health.saturated; /* counted when they came */
    const sample_t *const next = &tracker->waiting[tracker->first];
    const uint32_t n = (uint32_t)push_steadily(stages, davar, next, smaller(most, row));
    davar->health.saturated = saturated;
    tracker->first = tracker_index(tracker, n);
    tracker->count -= n;
    tracker->accepted -= n;
    for (uint32_t i = 0U; i < tracker->marks; i++) {
        tracker->mark[i].ahead -= n;
    }
    return n;
}

/* Accepted samples go on, at most `most` of them. True: up to one that completed a result. */
static bool pass_on(stages_t *stages, davar_t *davar, uint32_t most)
{
    tracker_t *const tracker = stages->tracker;
    const uint32_t before = davar->produced;
    for (uint32_t left = smaller(most, tracker->accepted); (left > 0U) && (davar->produced == before);) {
        if ((tracker->marks > 0U) && (tracker->mark[0].ahead == 0U)) {
            pass_mark(tracker, davar);
        }
        const uint32_t n = pass_row(stages, davar, left);
        DAVAR_ASSERT((n > 0U) && (n <= left));
        left -= n;
    }
    return davar->produced != before;
}

/* One for each that comes, and two to catch up, of which the second brings the result. */
static bool pass_in_step(stages_t *stages, davar_t *davar)
{
    const uint32_t before = davar->produced;
    if (stages->tracker->accepted > stages->tracker->config.block) {
        (void)pass_on(stages, davar, 1U);
        davar->produced = before;
    }
    return pass_on(stages, davar, 1U);
}

/* What the detector has heard when a sample goes on depends on nothing but the stream: on a grid all accepted ones go on before more
 * than one comes. */
DAVAR_APART static size_t push_tracked(stages_t *stages, davar_t *davar, const sample_t *samples, size_t count)
{
    tracker_t *const tracker = stages->tracker;
    const bool grid = on_grid(stages);
    size_t consumed = 0U;
    bool complete = false;
    while ((consumed < count) && !complete) {
        const size_t most = (grid && (tracker->accepted == 0U)) ? (count - consumed) : 1U;
        const uint32_t n = tracker_take_in(tracker, davar, stages->highest, &samples[consumed], most);
        DAVAR_ASSERT((n > 0U) && (n <= most));
        consumed += n;
        complete = grid ? pass_on(stages, davar, UINT32_MAX) : pass_in_step(stages, davar);
    }
    return consumed;
}

/* In front of a gap what is not accepted is left out, with the block that has the gap in it. What is accepted goes on with the samples
 * that follow, so that each of its results can be taken. */
DAVAR_RARE static void tracker_gap(tracker_t *tracker)
{
    davar_glr_event_t event;
    tracker_drop(tracker, tracker->count - tracker->accepted, true);
    davar_glr_skip(&tracker->detector, &tracker->config, &event);
    block_clear(&tracker->block);
    tracker->filled = 0U;
    if (tracker->clusters != NULL) {
        clusters_gap(tracker->clusters);
    }
}

#endif
