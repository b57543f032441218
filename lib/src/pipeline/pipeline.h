/* davar - one number type's pipeline, the story of a sample in the order of the data:
 *
 *   sample -> (tracker) -> [1] ring -> [2] allan, [3a] moments (sliding or grid) -> [3b] stationarity -> [4] law -> result
 *
 * Included once per number type, after its number header. */
#ifndef DAVAR_SRC_PIPELINE_H
#define DAVAR_SRC_PIPELINE_H

#include "pipeline/tracked.h"

/* --- samples in ------------------------------------------------------------------------------------------------- */

/* Takes samples up to the one that completes a result. */
static inline size_t pipeline_push(davar_t *davar, const sample_t *samples, size_t count)
{
    stages_t *const stages = davar->stages;
    return is_tracked(stages) ? push_tracked(stages, davar, samples, count)
                              : push_steadily(stages, davar, samples, count);
}

DAVAR_APART static void push_block(davar_t *davar, const sample_t *samples, size_t count)
{
    for (size_t taken = 0U; taken < count;) {
        const size_t n = pipeline_push(davar, &samples[taken], count - taken);
        DAVAR_ASSERT((n > 0U) && (n <= (count - taken)));
        taken += n;
    }
}

/* Takes all samples; the newest result stays. A single one, as an interrupt pushes it, is spared the loop. */
static inline void pipeline_push_all(davar_t *davar, const sample_t *samples, size_t count)
{
    if (count == 1U) {
        (void)pipeline_push(davar, samples, 1U);
    } else {
        push_block(davar, samples, count);
    }
}

DAVAR_RARE void NUMBER(gap)(davar_t *davar)
{
    const stages_t *const stages = davar->stages;
    if (is_tracked(stages)) {
        tracker_gap(stages->tracker);
    } else {
        window_gap(davar);
    }
}

/* The memory has been read back: every pointer in it is set anew, the rest stands. */
DAVAR_RARE void NUMBER(resume)(davar_t *davar)
{
    stages_t *const stages = davar->stages;
    (void)carve(stages, davar, davar->config, stages);
    accept(davar);
    if (on_grid(stages) && davar->ready) {
        grid_place(stages, davar);
    }
}

/* --- the end of a record ----------------------------------------------------------------------------------------- */

/* The last epochs of centred windows: time goes on, and no sample comes. */
DAVAR_RARE static bool flush_about(stages_t *stages, davar_t *davar)
{
    tracker_t *const tracker = stages->tracker;
    davar_window_t *const window = &davar->window;
    while ((tracker->behind + window->wait) <= tracker->half) {
        DAVAR_ASSERT(window->wait > 0U);
        tracker->behind += window->wait;
        window_receive(window, window->wait);
        window->wait = 0U;
        if (step_end(stages, davar)) {
            davar_produce(davar);
            return true;
        }
    }
    return false;
}

/* Hands on what waits, until an epoch is complete. False: nothing is left. */
DAVAR_RARE static bool flush_tracked(stages_t *stages, davar_t *davar)
{
    tracker_end(stages->tracker);
    davar->accepts = ACCEPTS_NONE;
    bool complete = false;
    while ((stages->tracker->accepted > 0U) && !complete) {
        complete = pass_on(stages, davar, UINT32_MAX);
    }
    return complete || (tracks_about(davar->config) && flush_about(stages, davar));
}

DAVAR_RARE static void finish(stages_t *stages, davar_t *davar)
{
    davar_window_t *const window = &davar->window;
    const uint32_t head = on_grid(stages) ? window->received : window_head(window);
    davar_gaps_forget_last(&davar->gaps, window->received);
    window->finished = true;
    davar->accepts = ACCEPTS_NONE;
    window->end = window->received;
    const uint32_t after = davar_gaps_after(&davar->gaps, window, head - 1U);
    stages->allan.to_gap = (after == DAVAR_NO_GAP) ? DAVAR_NO_GAP : (after - 1U);
    stages->allan.room = davar_gaps_after(&davar->gaps, window, window_tail(window));
}

/* Pushes what waits for the detector, or the mirror image of the record, until an epoch is complete. False: none is left. */
DAVAR_RARE bool NUMBER(flush)(davar_t *davar)
{
    stages_t *const stages = davar->stages;
    davar_window_t *const window = &davar->window;
    const uint32_t half = davar->config->window_max / 2U;
    if (is_tracked(stages)) {
        return flush_tracked(stages, davar);
    }
    if (!is_finished(window)) {
        finish(stages, davar);
    }
    while ((window->received - window->end) < (half - 1U)) {
        const uint32_t age = (2U * (window->received - window->end)) + 1U;
        ring_put(&stages->ring, stages->ring.sample[ring_index(&stages->ring, age)]);
        step_carefully(stages, davar);
        if (step_end(stages, davar)) {
            davar_produce(davar);
            return true;
        }
    }
    return false;
}

/* --- a result out ------------------------------------------------------------------------------------------------ */

static bool pipeline_collect(davar_t *davar, davar_result_t *result)
{
    readings_t readings;
    uint32_t before;
    uint32_t produced;
    bool waits;
    do {
        before = davar_read_begin(davar);
        produced = davar->produced;
        waits = davar_result_waits(davar);
        if (waits) {
            read_stages(davar, result, &readings);
        }
    } while (davar_read_torn(davar, before));
    davar->health.missed = davar_missed(davar, produced, waits);
    davar->seen = produced;
    if (waits) {
        evaluate(davar, &readings, result);
        davar->alarms_seen = readings.alarms;
    }
    return waits;
}

#define PIPELINE_NUMBER(wide)                                                                                          \
    {                                                                                                                  \
        wide, pipeline_collect, NUMBER_SUM_BITS, NUMBER_SAMPLE_BITS_MAX, NUMBER_SAMPLE_BITS_DEFAULT, NUMBER_WINDOW_MAX \
    }

#endif
