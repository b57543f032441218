/* davar - a window out of a grid: the records at its edges, wherever the law has placed them, and their differences. */
#ifndef DAVAR_SRC_GRID_WINDOW_H
#define DAVAR_SRC_GRID_WINDOW_H

#include "window/stages.h"

/* Whole steps in `back`, which keeps the rest. Not by a division, which a small core would call for: O(log). */
static uint32_t whole_steps(uint32_t *back, uint32_t step)
{
    uint32_t power = 1U;
    uint32_t steps = 0U;
    while ((step * power) <= (*back >> 1U)) {
        power <<= 1U;
    }
    for (; power > 0U; power >>= 1U) {
        if ((step * power) <= *back) {
            *back -= step * power;
            steps += power;
        }
    }
    return steps;
}

/* Slot of `position` among the records of a track, or slots when it has none of it. */
static uint32_t track_find(const track_t *track, uint32_t position)
{
    uint32_t back = track->due - position;
    const uint32_t hops = whole_steps(&back, track->hop);
    if ((back != 0U) || ((hops - 1U) >= track->slots)) {
        return track->slots;
    }
    return (track->slot >= hops) ? (track->slot - hops) : ((track->slot + track->slots) - hops);
}

/* The track that recorded `position`, and where. Null: the start of a trailing record, where running sums are 0. */
static const track_t *tracks_find(const track_t *tracks, uint8_t count, uint32_t position, uint32_t *slot)
{
    for (uint8_t i = 0U; i < count; i++) {
        *slot = track_find(&tracks[i], position);
        if (*slot < tracks[i].slots) {
            return &tracks[i];
        }
    }
    return NULL;
}

/* Finds the records of the power sums, where the window's first part ends too. */
static void grid_place_powers(grid_t *grid, uint32_t middle_at, const track_t *head, uint32_t head_slot,
                              const track_t *tail, uint32_t tail_slot)
{
    uint32_t slot = 0U;
    const track_t *const middle = tracks_find(grid->middle, grid->middle_count, middle_at, &slot);
    DAVAR_ASSERT(middle != NULL);
    grid->records.head_powers = &head->powers[head_slot];
    grid->records.middle_powers = &middle->powers[slot];
    grid->records.tail_powers = (tail == NULL) ? NULL : &tail->powers[tail_slot];
}

/* Finds the records of the window that the law has placed. */
static void grid_place(stages_t *stages, const davar_t *davar)
{
    grid_t *const grid = stages->grid;
    const uint32_t head_at = window_head(&davar->window);
    const uint32_t tail_at = window_tail(&davar->window);
    const uint32_t taus = stages->allan.count;
    uint32_t head_slot = 0U;
    uint32_t tail_slot = 0U;
    const track_t *const head = tracks_find(grid->head, grid->head_count, head_at, &head_slot);
    const track_t *const tail = tracks_find(grid->tail, grid->tail_count, tail_at, &tail_slot);
    DAVAR_ASSERT((head != NULL) && ((tail != NULL) || (tail_at == 0U)));
    grid->records.head_sums = &head->sums[(size_t)head_slot * taus];
    grid->records.tail_sums = (tail == NULL) ? NULL : &tail->sums[(size_t)tail_slot * taus];
    if (has_moments(davar->config)) {
        grid_place_powers(grid, head_at - davar->config->segment, head, head_slot, tail, tail_slot);
    }
}

/* The sum of squared differences of the window for one tau. */
static sum_t records_sum(const records_t *records, uint32_t t)
{
    const sum_t zero = {0};
    return sum_between(records->head_sums[t], (records->tail_sums == NULL) ? zero : records->tail_sums[t]);
}

#endif
