/* davar - where the edges of a grid's windows can be, and the tracks that record there. Runs at start only. */
#ifndef DAVAR_SRC_GRID_SETUP_H
#define DAVAR_SRC_GRID_SETUP_H

#include "common/arena.h"
#include "grid/grid.h"

/* Edge positions are K apart; window_max and window_min (and the start, while a trailing window fills) may put them on
 * different residues modulo K. Policy glr: where windows begin, and centred ones end, is between two blocks, whatever the stride.
 * Signed: a centred window starts in the mirrored past. Within 32 bits: windows and strides are at most 2^24. */
typedef struct {
    int32_t first[TRACKS_MAX];
    uint32_t hop[TRACKS_MAX];
    uint32_t reach
        [TRACKS_MAX]; /* samples back from the newest record that one may be needed: for a stride until it is taken */
    uint8_t count;
} residues_t;

/* How far `value` is above a multiple of the stride. Without a signed division, which a small core would call for. */
static uint32_t above_multiple(int32_t value, uint32_t stride)
{
    const uint32_t rest = ((value < 0) ? (0U - (uint32_t)value) : (uint32_t)value) % stride;
    return ((value < 0) && (rest > 0U)) ? (stride - rest) : rest;
}

/* Adds the first position >= at_least of the residue of `position`. */
static void residues_put(residues_t *residues, int32_t position, int32_t at_least, uint32_t hop, uint32_t reach)
{
    residues->first[residues->count] = at_least + (int32_t)above_multiple(position - at_least, hop);
    residues->hop[residues->count] = hop;
    residues->reach[residues->count] = reach;
    residues->count++;
}

/* ... unless that residue is there already. All are of one hop. */
DAVAR_RARE static void residues_add(residues_t *residues, int32_t position, int32_t at_least, uint32_t hop,
                                    uint32_t reach)
{
    for (uint8_t i = 0U; i < residues->count; i++) {
        if (above_multiple(residues->first[i] - position, hop) == 0U) {
            return;
        }
    }
    residues_put(residues, position, at_least, hop, reach);
}

/* Centred, first epoch K - 1: edges at half a window from it. Trailing: the head is at multiples of K. */
DAVAR_RARE static residues_t residues_of_tail(const davar_config_t *config)
{
    residues_t residues = {.count = 0U};
    const int32_t longest = (int32_t)config->window_max;
    const int32_t shortest = (int32_t)config->window_min;
    if (is_centred(config)) {
        const int32_t epoch = (int32_t)config->stride - 1;
        residues_add(&residues, epoch - (longest / 2), epoch - (longest / 2), config->stride, config->window_max);
        if (is_adaptive(config)) {
            residues_add(&residues, epoch - (shortest / 2), epoch - (longest / 2), config->stride, config->window_max);
        }
        return residues;
    }
    if (has_tracker(config)) {
        residues_put(&residues, 0, 0, config->block, config->window_max + config->stride);
        return residues;
    }
    residues_add(&residues, -longest, 0, config->stride, config->window_max);
    if (is_adaptive(config)) {
        residues_add(&residues, -shortest, 0, config->stride, config->window_max);
        residues_add(&residues, 0, 0, config->stride, config->window_max);
    }
    return residues;
}

/* How far the leading edge can be behind the newest sample. */
static uint32_t head_reach(const davar_config_t *config)
{
    const bool lags = is_centred(config) && is_adaptive(config);
    if (tracks_about(config)) {
        return half_in_samples(config);
    }
    return lags ? ((config->window_max - config->window_min) / 2U) : 0U;
}

/* The leading edge less `lag` samples: 0 for the head, the short segment for the middle. `wait`: samples to the first epoch of policy
 * glr, whose windows end there or, centred, between two blocks before it. */
DAVAR_RARE static residues_t residues_of_head(const davar_config_t *config, int32_t lag, uint32_t wait)
{
    residues_t residues = {.count = 0U};
    const uint32_t reach = head_reach(config) + (uint32_t)lag;
    if (is_centred(config)) {
        const int32_t epoch = (int32_t)config->stride - 1;
        const int32_t first = epoch + ((int32_t)config->window_max / 2) - lag;
        residues_add(&residues, first, first, config->stride, reach);
        if (is_adaptive(config)) {
            residues_add(&residues, epoch + ((int32_t)config->window_min / 2) - lag, first, config->stride, reach);
        }
        return residues;
    }
    residues_put(&residues, (has_tracker(config) ? (int32_t)wait : 0) - lag, 0, config->stride, (uint32_t)lag);
    if (tracks_about(config)) {
        residues_put(&residues, -lag, 0, config->block, reach + config->stride);
    }
    return residues;
}

/* Records of a track that reach `reach` samples back from the newest. */
static uint32_t slots_for(uint32_t reach, uint32_t hop)
{
    return (reach / hop) + 2U;
}

/* Hops that cover a distance, which is not negative. */
static uint32_t hops_over(int32_t distance, uint32_t hop)
{
    return ((uint32_t)distance + hop - 1U) / hop;
}

/* Starts the records of one track at its first position; those in front of the start come from their mirror images. */
static void track_start(track_t *track, int32_t first, const allan_t *allan)
{
    const uint32_t hop = track->hop;
    track->slot = 0U;
    track->due = (uint32_t)first;
    if (first < 0) {
        const uint32_t before = hops_over(-first, hop);
        track->slot = before % track->slots;
        track->due = (uint32_t)first + (before * hop);
        track->mirrored_left = before;
        track->mirrored_due = hop - track->due;
        track->mirrored_slot = slot_before(track, track->slot);
    }
    for (uint32_t t = 0U; (track->sum_due != NULL) && (t < allan->count); t++) {
        const int32_t m = (int32_t)allan->m[t];
        const int32_t begin = (first < -m) ? -m : first;
        const uint32_t steps = hops_over(begin - first, hop);
        track->sum_due[t] = (uint32_t)first + (steps * hop) + (2U * allan->m[t]) - 1U;
        track->sum_slot[t] = steps % track->slots;
    }
}

/* What is due before the first sample: everything is 0 there. */
static void track_record_zero(track_t *track, const allan_t *allan)
{
    const powers_t no_powers = {0};
    const sum_t no_sum = {0};
    if (track->due == 0U) {
        if (track->powers != NULL) {
            track->powers[track->slot] = no_powers;
        }
        track->due += track->hop;
        track->slot = slot_after(track, track->slot);
    }
    for (uint32_t t = 0U; (track->sum_due != NULL) && (t < allan->count); t++) {
        if (track->sum_due[t] == 0U) {
            track->sums[(track->sum_slot[t] * allan->count) + t] = no_sum;
            track->sum_due[t] += track->hop;
            track->sum_slot[t] = slot_after(track, track->sum_slot[t]);
        }
    }
}

DAVAR_RARE static void tracks_start(track_t *tracks, const residues_t *residues, const allan_t *allan)
{
    for (uint8_t i = 0U; i < residues->count; i++) {
        track_start(&tracks[i], residues->first[i], allan);
        track_record_zero(&tracks[i], allan);
    }
}

/* All tracks back to the start of a record, whose first epoch is `wait` samples away. */
DAVAR_RARE static void grid_start(grid_t *grid, const davar_config_t *config, const allan_t *allan, uint32_t wait)
{
    const residues_t tail = residues_of_tail(config);
    const residues_t head = residues_of_head(config, 0, wait);
    const residues_t middle = residues_of_head(config, (int32_t)config->segment, wait);
    tracks_start(grid->tail, &tail, allan);
    tracks_start(grid->head, &head, allan);
    tracks_start(grid->middle, &middle, allan);
    grid_schedule(grid, 0U);
}

DAVAR_RARE static void tracks_carve(davar_arena_t *arena, const davar_config_t *config, track_t *tracks,
                                    const residues_t *residues, uint32_t sums)
{
    const bool has_powers = has_moments(config) || !has_tracker(config);
    for (uint8_t i = 0U; i < residues->count; i++) {
        tracks[i].hop = residues->hop[i];
        tracks[i].slots = slots_for(residues->reach[i], tracks[i].hop);
        tracks[i].powers = has_powers ? davar_arena_take(arena, tracks[i].slots, sizeof(powers_t)) : NULL;
        tracks[i].sums = davar_arena_take(arena, (size_t)tracks[i].slots * sums, sizeof(sum_t));
    }
}

DAVAR_RARE static void tracks_carve_dues(davar_arena_t *arena, track_t *tracks, uint8_t count, uint32_t taus)
{
    for (uint8_t i = 0U; i < count; i++) {
        tracks[i].sum_due = davar_arena_take(arena, taus, sizeof(uint32_t));
        tracks[i].sum_slot = davar_arena_take(arena, taus, sizeof(uint32_t));
    }
}

/* Lays the tracks out in the caller's memory (or only counts, when the arena has none). */
DAVAR_RARE static void grid_carve(davar_arena_t *arena, grid_t *grid, const davar_config_t *config)
{
    const residues_t tail = residues_of_tail(config);
    const residues_t head = residues_of_head(config, 0, config->stride);
    const residues_t middle = residues_of_head(config, (int32_t)config->segment, config->stride);
    grid->tail_count = tail.count;
    grid->head_count = head.count;
    grid->middle_count = middle.count;
    tracks_carve(arena, config, grid->tail, &tail, config->tau_count);
    tracks_carve(arena, config, grid->head, &head, config->tau_count);
    tracks_carve(arena, config, grid->middle, &middle, 0U);
    tracks_carve_dues(arena, grid->tail, grid->tail_count, config->tau_count);
}

#endif
