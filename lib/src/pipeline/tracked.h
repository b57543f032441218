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

/* The shock that was dropped takes its time and leaves a gap. With more gaps than the window can remember its neighbours are joined:
 * no differences are lost then, and a few span the joint. */
DAVAR_RARE static void pass_shock(tracker_t *tracker, davar_t *davar)
{
    leave_out(tracker, davar, tracker->shock);
    tracker->shock = 0U;
    (void)window_boundary(davar);
}

/* Accepted samples go on, at most `most` of them. True: up to one that completed a result. */
static bool pass_on(stages_t *stages, davar_t *davar, uint32_t most)
{
    tracker_t *const tracker = stages->tracker;
    const uint32_t before = davar->produced;
    for (uint32_t left = smaller(most, tracker->accepted); (left > 0U) && (davar->produced == before);) {
        if (tracker->shock > 0U) {
            pass_shock(tracker, davar);
        }
        const uint32_t straight = tracker->capacity - tracker->first;
        const sample_t *const next = &tracker->waiting[tracker->first];
        const uint32_t saturated = davar->health.saturated; /* counted when they came */
        const uint32_t n = (uint32_t)push_steadily(stages, davar, next, smaller(left, straight));
        davar->health.saturated = saturated;
        tracker->first = tracker_index(tracker, n);
        tracker->count -= n;
        tracker->accepted -= n;
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
        consumed += tracker_take_in(tracker, davar, stages->highest, &samples[consumed], most);
        complete = grid ? pass_on(stages, davar, UINT32_MAX) : pass_in_step(stages, davar);
    }
    return consumed;
}

/* In front of a gap: what is accepted goes on, what is not is left out, with the block that has the gap in it. */
DAVAR_RARE static void tracker_gap(stages_t *stages, davar_t *davar)
{
    tracker_t *const tracker = stages->tracker;
    davar_glr_event_t event;
    while (tracker->accepted > 0U) {
        (void)pass_on(stages, davar, UINT32_MAX);
    }
    leave_out(tracker, davar, tracker->count);
    davar_glr_skip(&tracker->detector, &tracker->config, &event);
    block_clear(&tracker->block);
    tracker->filled = 0U;
    tracker->count = 0U;
    if (tracker->clusters != NULL) {
        clusters_gap(tracker->clusters);
    }
}

#endif
