/* davar - how a pipeline lies in the caller's memory, and how it begins. */
#ifndef DAVAR_SRC_START_H
#define DAVAR_SRC_START_H

#include "grid/grid_setup.h"
#include "pipeline/tracker.h"

#include <string.h>

/* --- memory ------------------------------------------------------------------------------------------------------ */

/* Samples that go in at once. */
static uint32_t ring_block(const davar_config_t *config)
{
    return has_grid(config) ? GRID_BLOCK : 1U;
}

/* A shrunk centred window lags behind the newest sample, and its longest span may reach further back than itself. Edges that
 * are followed have a stride to catch up when a result is due. */
static uint32_t ring_capacity(const davar_config_t *config)
{
    const uint32_t span_max = 2U * config->taus[config->tau_count - 1U];
    const bool follows = !has_grid(config);
    const bool whole_window = follows || config->mirrored_end;
    const uint32_t span = (follows ? head_reach(config) : 0U) + span_max;
    const uint32_t reach = (whole_window && (config->window_max > span)) ? config->window_max : span;
    return reach + (follows ? config->stride : ring_block(config));
}

DAVAR_RARE static size_t carve(stages_t *stages, davar_t *davar, const davar_config_t *config, void *memory)
{
    davar_arena_t arena = {memory, 0U};
    (void)davar_arena_take(&arena, 1U, sizeof(stages_t));
    stages->allan.tau = davar_arena_take(&arena, config->tau_count, sizeof(tau_t));
    stages->ring.capacity = ring_capacity(config);
    stages->ring.reach = 2U * config->taus[config->tau_count - 1U];
    stages->ring.repeated = stages->ring.reach + ring_block(config) - 1U;
    stages->ring.sample =
        davar_arena_take(&arena, (size_t)stages->ring.capacity + stages->ring.repeated, sizeof(sample_t));
    davar->gaps.position = davar_arena_take(&arena, config->gaps_max, sizeof(uint32_t));
    davar->gaps.capacity = config->gaps_max;
    stages->allan.m = config->taus;
    stages->grid = NULL;
    if (has_grid(config)) {
        grid_t only_counted;
        stages->grid = davar_arena_take(&arena, 1U, sizeof(grid_t));
        grid_carve(&arena, (memory == NULL) ? &only_counted : stages->grid, config);
    }
    stages->tracker = NULL;
    if (has_tracker(config)) {
        stages->tracker = tracker_carve(&arena, config, memory == NULL);
    }
    return arena.used;
}

DAVAR_RARE size_t NUMBER(memory_size)(const davar_config_t *config)
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
    stages->highest = (sample_t)((UINT32_C(1) << (bits - 1U)) - 1U);
}

DAVAR_RARE static bool are_octaves(const davar_config_t *config)
{
    for (uint32_t t = 1U; t < config->tau_count; t++) {
        if (config->taus[t] != (2U * config->taus[t - 1U])) {
            return false;
        }
    }
    return true;
}

static void start_allan(allan_t *allan, const davar_config_t *config)
{
    const bool centred = is_centred(config);
    allan->count = config->tau_count;
    allan->run = 0U;
    allan->to_gap = DAVAR_NO_GAP;
    allan->room = DAVAR_NO_GAP;
    allan->starting = true;
    allan->mirrored = centred;
    allan->run_doubles = centred;
    allan->warming = centred && !has_grid(config);
    allan->octaves = are_octaves(config);
    memset(allan->tau, 0, allan->count * sizeof *allan->tau);
}

/* Samples up to the first epoch of a record. Policy glr, centred: epochs are half a window behind, and before the start at first. */
static uint32_t first_wait(const davar_config_t *config)
{
    if (is_centred(config)) {
        return (config->stride - 1U) + (config->window_max / 2U);
    }
    const uint32_t rest = tracks_about(config) ? (half_in_samples(config) % config->stride) : 0U;
    return (rest > 0U) ? rest : config->stride;
}

static void start_window(davar_window_t *window, const davar_config_t *config, uint64_t origin, uint32_t skip,
                         uint32_t wait)
{
    const bool centred = is_centred(config);
    const davar_window_t start = {
        .origin = origin,
        .skip = skip,
        .next_length = centred ? config->window_max : config->stride,
        .wait = wait,
        .filling = !centred,
        .at_start = centred,
    };
    *window = start;
}

/* `skip`: samples to leave out; `wait`: then up to the first epoch. */
DAVAR_RARE static void start_stages(davar_t *davar, uint64_t origin, uint32_t skip, uint32_t wait)
{
    const davar_config_t *const config = davar->config;
    stages_t *const stages = davar->stages;
    davar->gaps.count = 0U;
    stages->steady = STEADY_NOT;
    stages->ring.next = 0U;
    start_allan(&stages->allan, config);
    memset(&stages->moments, 0, sizeof stages->moments);
    start_window(&davar->window, config, origin, skip, wait);
    if (on_grid(stages)) {
        grid_start(stages->grid, config, &stages->allan, wait);
    }
}

static void accept(davar_t *davar)
{
    const uint8_t counts = (NUMBER_SAMPLE_BITS_MAX == 16U) ? ACCEPTS_Q15 : ACCEPTS_Q31;
    const uint8_t type = is_float(davar) ? ACCEPTS_F32 : counts;
    const stages_t *const stages = davar->stages;
    const bool ended = is_tracked(stages) && stages->tracker->ended;
    davar->accepts = (is_finished(&davar->window) || ended) ? ACCEPTS_NONE : type;
}

DAVAR_RARE void NUMBER(start)(davar_t *davar, void *memory)
{
    davar->stages = memory;
    memset(memory, 0, carve(davar->stages, davar, davar->config, memory));
    (void)carve(davar->stages, davar, davar->config, memory);
    start_samples(davar->stages, davar->config, davar->is_float);
    start_stages(davar, 0U, 0U, first_wait(davar->config));
    if (is_tracked(davar->stages)) {
        tracker_start(((stages_t *)davar->stages)->tracker, davar->config);
    }
    accept(davar);
}

#endif
