/* davar - one number type's pipeline, the story of a sample in the order of the data:
 *
 *   sample -> [1] ring -> [2] allan, [3a] moments (sliding or grid) -> [3b] stationarity -> [4] law -> result
 *
 * Included once per number type, after its number header. */
#ifndef DAVAR_SRC_PIPELINE_H
#define DAVAR_SRC_PIPELINE_H

#include "grid.h"
#include "grid_setup.h"
#include "number.h"
#include "sliding.h"

#include <math.h>

/* --- memory ------------------------------------------------------------------------------------------------------ */

/* A shrunk centred window lags behind the newest sample, and its longest span may reach further back than itself. */
static uint32_t ring_capacity(const davar_config_t *config)
{
    const uint32_t span_max = 2U * config->taus[config->tau_count - 1U];
    const bool whole_window = (config->stride == 1U) || config->mirrored_end;
    const uint32_t lag = (config->stride == 1U) ? head_reach(config) : 0U;
    const uint32_t span = lag + span_max;
    return ((whole_window && (config->window_max > span)) ? config->window_max : span) + 1U;
}

static size_t carve(stages_t *stages, davar_t *davar, const davar_config_t *config, void *memory)
{
    davar_arena_t arena = {memory, 0U};
    (void)davar_arena_take(&arena, 1U, sizeof(stages_t));
    stages->allan.tau = davar_arena_take(&arena, config->tau_count, sizeof(tau_t));
    stages->ring.capacity = ring_capacity(config);
    stages->ring.sample = davar_arena_take(&arena, stages->ring.capacity, sizeof(sample_t));
    davar->gaps.position = davar_arena_take(&arena, config->gaps_max, sizeof(uint32_t));
    davar->gaps.capacity = config->gaps_max;
    davar->plan = davar_arena_take(&arena, 1U, sizeof(davar_fit_plan_t));
    stages->grid = NULL;
    if (config->stride > 1U) {
        grid_t laid_out = {0};
        stages->grid = davar_arena_take(&arena, 1U, sizeof(grid_t));
        grid_carve(&arena, &laid_out, config);
        if (stages->grid != NULL) {
            *stages->grid = laid_out;
        }
    }
    return arena.used;
}

static size_t pipeline_memory_size(const davar_config_t *config)
{
    stages_t stages;
    davar_t davar;
    return carve(&stages, &davar, config, NULL);
}

/* --- start ------------------------------------------------------------------------------------------------------- */

static void start_samples(stages_t *stages, const davar_config_t *config, bool is_float)
{
    const uint32_t given = (config->sample_bits == 0U) ? NUMBER_SAMPLE_BITS_DEFAULT : config->sample_bits;
    const uint32_t bits = is_float ? NUMBER_SAMPLE_BITS_MAX : given;
    const uint32_t significant = is_float ? DAVAR_FLOAT_BITS : given;
    stages->highest = (sample_t)((INT64_C(1) << (bits - 1U)) - 1);
    stages->lowest = (sample_t)(-(INT64_C(1) << (bits - 1U)));
    stages->moments.shift = (significant > NUMBER_MOMENT_BITS) ? (significant - NUMBER_MOMENT_BITS) : 0U;
    stages->moments.segment = config->segment;
    stages->ring.next = 0U;
}

static void start_allan(allan_t *allan, const davar_config_t *config)
{
    const bool centred = (config->mode == DAVAR_MODE_CENTRED);
    allan->count = config->tau_count;
    allan->span_max = 2U * config->taus[config->tau_count - 1U];
    allan->run = 0U;
    allan->run_step = centred ? 2U : 1U;
    allan->to_gap = DAVAR_NO_GAP;
    allan->room = DAVAR_NO_GAP;
    allan->starting = true;
    allan->mirrored = centred;
    allan->warming = centred && (config->stride == 1U);
    allan->plain = false;
    for (uint32_t t = 0U; t < allan->count; t++) {
        const tau_t zero = {0};
        allan->tau[t] = zero;
        allan->tau[t].m = config->taus[t];
    }
}

static void start_window(davar_window_t *window, const davar_config_t *config)
{
    const bool centred = (config->mode == DAVAR_MODE_CENTRED);
    const bool longest = centred || (config->stride > config->window_max);
    const davar_window_t start = {
        .epoch = (uint64_t)config->stride - 1U,
        .length = longest ? config->window_max : config->stride,
        .due = centred ? ((config->stride - 1U) + (config->window_max / 2U)) : config->stride,
        .filling = !centred,
        .at_start = centred,
    };
    *window = start;
}

static void pipeline_start(davar_t *davar, void *memory)
{
    const davar_config_t *const config = davar->config;
    stages_t *const stages = memory;
    davar->stages = stages;
    (void)carve(stages, davar, config, memory);
    davar->gaps.count = 0U;
    start_samples(stages, config, davar->is_float);
    start_allan(&stages->allan, config);
    const powers_t zero = {0};
    stages->moments.whole = zero;
    stages->moments.first = zero;
    start_window(&davar->window, config);
    if (stages->grid != NULL) {
        grid_start(stages->grid, config, &stages->allan);
    }
}

/* --- a sample in ------------------------------------------------------------------------------------------------- */

static powers_t window_powers(const stages_t *stages, bool first_part)
{
    if (stages->grid == NULL) {
        return first_part ? stages->moments.first : stages->moments.whole;
    }
    const records_t *const records = &stages->grid->records;
    return grid_powers(stages->grid, first_part ? records->middle_powers : records->head_powers);
}

static verdict_t window_verdict(const stages_t *stages, const davar_t *davar)
{
    const uint32_t length = davar->window.head - davar->window.tail;
    const powers_t whole = window_powers(stages, false);
    const powers_t first = window_powers(stages, true);
    verdict_t verdict = {.whole = moments_central(&whole, length),
                         .first = moments_central(&first, length - stages->moments.segment)};
    verdict.unstable = davar_stationarity_unstable(davar->config, &verdict.whole, &verdict.first);
    return verdict;
}

/* The window of the epoch that is due: where the law puts it. */
static void window_move(stages_t *stages, davar_t *davar)
{
    davar_window_t *const window = &davar->window;
    const uint32_t head = davar_law_head(davar->config, window->due, window->length);
    const uint32_t tail = head - window->length;
    if (stages->grid != NULL) {
        window->head = head;
        window->tail = tail;
    } else if (stages->allan.warming) {
        sliding_end_warm(stages, davar);
    } else {
        sliding_move(stages, davar, head, tail);
    }
    window->at_start = window->at_start && ((int32_t)window->tail < 0);
}

/* An epoch is complete: its window, its flag, the length of the next. True when the window is long enough to report. */
static bool epoch_complete(stages_t *stages, davar_t *davar)
{
    davar_window_t *const window = &davar->window;
    const davar_config_t *const config = davar->config;
    window_move(stages, davar);
    window->due += config->stride;
    window->epoch += config->stride;
    const uint32_t length = window->length;
    const bool reported = (length >= config->window_min);
    if (reported && (stages->grid != NULL)) {
        grid_place(stages, davar);
    }
    const bool adapts = (config->policy != DAVAR_POLICY_FIXED);
    if (!adapts && (length == config->window_max)) {
        return true;
    }
    bool unstable = false;
    if (reported && adapts) {
        stages->newest = window_verdict(stages, davar);
        unstable = stages->newest.unstable;
    }
    window->filling = window->filling && !unstable && (length < config->window_max);
    window->length = davar_law_next(config, length, unstable, window->filling);
    return reported;
}

static bool pipeline_step(stages_t *stages, davar_t *davar, sample_t sample)
{
    davar_window_t *const window = &davar->window;
    ring_put(&stages->ring, sample);
    window->received++;
    if (stages->grid != NULL) {
        grid_advance(stages, davar);
    } else if (stages->allan.warming) {
        sliding_warm(stages, davar);
    }
    return (window->received == window->due) && epoch_complete(stages, davar);
}

static sample_t limited(const stages_t *stages, davar_t *davar, sample_t sample)
{
    if ((sample > stages->lowest) && (sample < stages->highest)) {
        return sample;
    }
    davar_count(&davar->health.saturated);
    if (sample < stages->lowest) {
        return stages->lowest;
    }
    return (sample > stages->highest) ? stages->highest : sample;
}

/* Takes samples up to the one that completes a result. */
static size_t pipeline_push(davar_t *davar, const sample_t *samples, size_t count)
{
    stages_t *const stages = davar->stages;
    size_t consumed = 0U;
    bool complete = false;
    while ((consumed < count) && !complete) {
        const sample_t sample = limited(stages, davar, samples[consumed]);
        consumed++;
        if (davar->window.skip > 0U) {
            davar->window.skip--;
        } else {
            complete = pipeline_step(stages, davar, sample);
        }
    }
    if (complete) {
        davar_produce(davar);
    }
    return consumed;
}

/* --- weather ----------------------------------------------------------------------------------------------------- */

/* Throws the window away and starts again at the next boundary of the grid of epochs. */
static void pipeline_restart(davar_t *davar)
{
    const uint64_t stride = davar->config->stride;
    const uint64_t now = davar_window_now(davar);
    const uint64_t skip = (stride - (now % stride)) % stride;
    davar_count(&davar->health.restarts);
    davar_discard(davar);
    pipeline_start(davar, davar->stages);
    davar->window.skip = (uint32_t)skip;
    davar->window.epoch += now + skip;
}

/* A boundary behind the newest result and in front of the next window, which a long stride leaves between them. */
static bool between_windows(const davar_t *davar)
{
    const davar_window_t *const window = &davar->window;
    const uint32_t next_tail = window->due - davar->config->window_max;
    return (davar->config->stride > 1U) && ((int32_t)(next_tail - window->received) >= 0);
}

static void pipeline_gap(davar_t *davar)
{
    stages_t *const stages = davar->stages;
    davar_window_t *const window = &davar->window;
    allan_t *const allan = &stages->allan;
    allan->plain = false;
    if (between_windows(davar)) {
        allan->to_gap = 0U; /* ends the run, and no window needs to remember it */
        return;
    }
    if (!davar_gaps_push(&davar->gaps, window)) {
        pipeline_restart(davar);
        return;
    }
    const uint32_t head = (stages->grid == NULL) ? window->head : window->received;
    if (davar->gaps.count == 0U) {
        return; /* in front of the first sample: no boundary */
    }
    if (allan->to_gap == DAVAR_NO_GAP) {
        allan->to_gap = window->received - head;
    }
    if ((allan->room == DAVAR_NO_GAP) && !allan->warming) {
        allan->room = davar_gaps_after(&davar->gaps, window, window->tail);
    }
}

/* --- the end of a record ----------------------------------------------------------------------------------------- */

static void finish(stages_t *stages, davar_t *davar)
{
    davar_window_t *const window = &davar->window;
    const uint32_t head = (stages->grid == NULL) ? window->head : window->received;
    davar_gaps_forget_last(&davar->gaps, window->received);
    window->finished = true;
    window->end = window->received;
    const uint32_t after = davar_gaps_after(&davar->gaps, window, head - 1U);
    stages->allan.to_gap = (after == DAVAR_NO_GAP) ? DAVAR_NO_GAP : (after - 1U);
    stages->allan.room = davar_gaps_after(&davar->gaps, window, window->tail);
    stages->allan.plain = false;
}

/* Pushes the mirror image of the record until an epoch is complete. False: none is left. */
static bool pipeline_flush(davar_t *davar)
{
    stages_t *const stages = davar->stages;
    davar_window_t *const window = &davar->window;
    const uint32_t half = davar->config->window_max / 2U;
    if (!window->finished) {
        finish(stages, davar);
    }
    while ((window->received - window->end) < (half - 1U)) {
        const uint32_t age = (2U * (window->received - window->end)) + 1U;
        if (pipeline_step(stages, davar, stages->ring.sample[ring_index(&stages->ring, age)])) {
            davar_produce(davar);
            return true;
        }
    }
    return false;
}

/* --- a result out ------------------------------------------------------------------------------------------------ */

static davar_adev_t collect_tau(const stages_t *stages, const davar_t *davar, uint32_t t)
{
    const davar_window_t *const window = &davar->window;
    const tau_t *const tau = &stages->allan.tau[t];
    const uint32_t length = window->head - window->tail;
    const uint32_t span = 2U * tau->m;
    davar_adev_t adev = {.m = tau->m, .adev = (double)NAN, .low = (double)NAN, .high = (double)NAN};
    if (length >= span) {
        adev.differences = (length - span + 1U) - davar_gaps_spans_lost(&davar->gaps, window, tau->m);
    }
    if (adev.differences > 0U) {
        const sum_t sum = (stages->grid == NULL) ? tau->sum : grid_sum(stages->grid, t);
        const double m = (double)tau->m;
        adev.adev = davar->unit_per_count * sqrt(sum_to_double(sum) / (2.0 * m * m * (double)adev.differences));
    }
    return adev;
}

/* An adaptive policy has needed the verdict already. */
static void collect_stationarity(const stages_t *stages, const davar_t *davar, davar_result_t *result)
{
    result->unstable = false;
    result->kurtosis = (double)NAN;
    result->contribution = (double)NAN;
    if (stages->moments.segment != 0U) {
        const bool adapts = (davar->config->policy != DAVAR_POLICY_FIXED);
        const verdict_t verdict = adapts ? stages->newest : window_verdict(stages, davar);
        result->unstable = verdict.unstable;
        result->kurtosis = davar_stationarity_kurtosis(&verdict.whole);
        result->contribution = davar_stationarity_contribution(&verdict.whole, &verdict.first);
    }
}

static void pipeline_collect(const davar_t *davar, davar_result_t *result)
{
    const stages_t *const stages = davar->stages;
    const davar_window_t *const window = &davar->window;
    result->epoch = window->epoch - davar->config->stride;
    result->window_samples = window->head - window->tail;
    result->gaps_in_window = davar_gaps_inside(&davar->gaps, window);
    result->tau_count = davar->config->tau_count;
    for (uint32_t t = 0U; t < stages->allan.count; t++) {
        result->tau[t] = collect_tau(stages, davar, t);
    }
    collect_stationarity(stages, davar, result);
}

#define PIPELINE_NUMBER                                                                                                \
    {                                                                                                                  \
        pipeline_memory_size, pipeline_start, pipeline_gap, pipeline_flush, pipeline_collect, NUMBER_SUM_BITS,         \
            NUMBER_SAMPLE_BITS_MAX, NUMBER_SAMPLE_BITS_DEFAULT, NUMBER_WINDOW_MAX                                      \
    }

#endif
