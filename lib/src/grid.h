/* davar - a result every K samples: running sums since the start and records of them at the positions where a window
 * edge can be. The sum over any window is one subtraction; no trailing edge is ever computed, and the ring holds the
 * longest span, not the window (2.7).
 *
 *   received   0 . . . . . . K . . . . . . 2K . . . . . . 3K
 *   tail track     T(q)          T(q + K)       T(q + 2K)        recorded for tau m at q + 2 m - 1
 *   head track           T(e)           T(e + K)                 recorded at e
 */
#ifndef DAVAR_SRC_GRID_H
#define DAVAR_SRC_GRID_H

#include "law.h"
#include "stages.h"

/* All spans shorter than the run, none reaching in front of the start: the usual case. */
static void grid_advance_plain(allan_t *allan, const ring_t *ring, uint32_t index)
{
    const sample_t *const x = ring->sample;
    const difference_t newest = x[index];
    difference_t far = newest;
    uint32_t far_lag = 0U;
    for (uint32_t t = 0U; t < allan->count; t++) {
        tau_t *const tau = &allan->tau[t];
        const difference_t middle = (tau->m == far_lag) ? far : x[ring_before(ring, index, tau->m)];
        far_lag = 2U * tau->m;
        far = x[ring_before(ring, index, far_lag)];
        tau->head += newest - (2 * middle) + far;
        sum_add_square(&tau->sum, tau->head);
    }
}

static void grid_advance_careful(allan_t *allan, const ring_t *ring, uint32_t index, uint32_t position)
{
    for (uint32_t t = 0U; t < allan->count; t++) {
        tau_t *const tau = &allan->tau[t];
        tau->head += allan->starting ? allan_start_step(ring, index, position, tau->m, allan->mirrored)
                                     : allan_step(ring, index, tau->m);
        if (allan->run >= (2U * tau->m)) {
            sum_add_square(&tau->sum, tau->head);
        }
    }
}

static void grid_record_sum(track_t *track, const allan_t *allan, uint32_t t, uint32_t slot)
{
    track->sums[(slot * allan->count) + t] = allan->tau[t].sum;
}

static uint32_t slot_after(const track_t *track, uint32_t slot)
{
    return ((slot + 1U) == track->slots) ? 0U : (slot + 1U);
}

static uint32_t slot_before(const track_t *track, uint32_t slot)
{
    return ((slot == 0U) ? track->slots : slot) - 1U;
}

/* A position -received in the mirrored start: running sums there are the negatives of those here (2.8). Spans that
 * straddle the start are recorded as they come, so only those wholly in front of it (received > m) are taken here. */
static void track_record_mirrored(track_t *track, const stages_t *stages, uint32_t received, uint32_t stride)
{
    const allan_t *const allan = &stages->allan;
    const powers_t zero = {0};
    track->powers[track->mirrored_slot] = zero;
    powers_subtract(&track->powers[track->mirrored_slot], &stages->moments.whole);
    for (uint32_t t = 0U; (track->sum_due != NULL) && (t < allan->count); t++) {
        if (received > allan->tau[t].m) {
            track->sums[(track->mirrored_slot * allan->count) + t] = sum_negated(allan->tau[t].sum);
        }
    }
    track->mirrored_left--;
    track->mirrored_due += stride;
    track->mirrored_slot = slot_before(track, track->mirrored_slot);
}

static void track_record_powers(track_t *track, const stages_t *stages, uint32_t stride)
{
    track->powers[track->slot] = stages->moments.whole;
    if ((track->sums != NULL) && (track->sum_due == NULL)) {
        for (uint32_t t = 0U; t < stages->allan.count; t++) {
            grid_record_sum(track, &stages->allan, t, track->slot);
        }
    }
    track->due += stride;
    track->slot = slot_after(track, track->slot);
}

static void track_record_sums(track_t *track, const stages_t *stages, uint32_t received, uint32_t stride)
{
    for (uint32_t t = 0U; t < stages->allan.count; t++) {
        if (track->sum_due[t] == received) {
            grid_record_sum(track, &stages->allan, t, track->sum_slot[t]);
            track->sum_due[t] += stride;
            track->sum_slot[t] = slot_after(track, track->sum_slot[t]);
        }
    }
}

static void track_record(track_t *track, const stages_t *stages, uint32_t received, uint32_t stride)
{
    if ((track->mirrored_left > 0U) && (track->mirrored_due == received)) {
        track_record_mirrored(track, stages, received, stride);
    }
    if (track->due == received) {
        track_record_powers(track, stages, stride);
    }
    if (track->sum_due != NULL) {
        track_record_sums(track, stages, received, stride);
    }
}

/* The smaller of `wait` and the samples from `received` to this track's next record. */
static uint32_t track_wait(const track_t *track, const allan_t *allan, uint32_t received, uint32_t wait)
{
    uint32_t shortest = wait;
    if ((track->due - received) < shortest) {
        shortest = track->due - received;
    }
    if ((track->mirrored_left > 0U) && ((track->mirrored_due - received) < shortest)) {
        shortest = track->mirrored_due - received;
    }
    for (uint32_t t = 0U; (track->sum_due != NULL) && (t < allan->count); t++) {
        if ((track->sum_due[t] - received) < shortest) {
            shortest = track->sum_due[t] - received;
        }
    }
    return shortest;
}

static uint32_t tracks_wait(const track_t *tracks, uint8_t count, const allan_t *allan, uint32_t received,
                            uint32_t wait)
{
    uint32_t shortest = wait;
    for (uint8_t i = 0U; i < count; i++) {
        shortest = track_wait(&tracks[i], allan, received, shortest);
    }
    return shortest;
}

static void grid_schedule(grid_t *grid, const allan_t *allan, uint32_t received)
{
    uint32_t wait = tracks_wait(grid->tail, grid->tail_count, allan, received, UINT32_MAX);
    wait = tracks_wait(grid->head, grid->head_count, allan, received, wait);
    wait = tracks_wait(grid->middle, grid->middle_count, allan, received, wait);
    grid->next = received + wait;
}

static void tracks_record(track_t *tracks, uint8_t count, const stages_t *stages, uint32_t received, uint32_t stride)
{
    for (uint8_t i = 0U; i < count; i++) {
        track_record(&tracks[i], stages, received, stride);
    }
}

static void grid_record(stages_t *stages, uint32_t received, uint32_t stride)
{
    grid_t *const grid = stages->grid;
    tracks_record(grid->tail, grid->tail_count, stages, received, stride);
    tracks_record(grid->head, grid->head_count, stages, received, stride);
    tracks_record(grid->middle, grid->middle_count, stages, received, stride);
    grid_schedule(grid, &stages->allan, received);
}

/* One sample in: the running sums move on, and are recorded where an edge can be. */
static void grid_advance(stages_t *stages, davar_t *davar)
{
    const davar_window_t *const window = &davar->window;
    allan_t *const allan = &stages->allan;
    const uint32_t index = ring_index(&stages->ring, 1U);
    const uint32_t position = window->received - 1U;
    allan_extend_run(allan, &davar->gaps, window, position);
    if ((allan->run >= allan->span_max) && !allan->starting) {
        grid_advance_plain(allan, &stages->ring, index);
    } else {
        grid_advance_careful(allan, &stages->ring, index, position);
        allan_end_start(allan, window->received);
    }
    if (stages->moments.segment != 0U) {
        const powers_t powers = powers_of(stages->ring.sample[index], stages->moments.shift);
        powers_add(&stages->moments.whole, &powers);
    }
    if (stages->grid->next == window->received) {
        grid_record(stages, window->received, davar->config->stride);
    }
}

/* Slot of `position` among the records of a track, or slots when it is not one of its positions. */
static uint32_t track_find(const track_t *track, uint32_t position, uint32_t stride)
{
    uint32_t slot = track->slot;
    uint32_t back = track->due - position;
    while (back >= stride) {
        back -= stride;
        slot = slot_before(track, slot);
    }
    return (back == 0U) ? slot : track->slots;
}

/* The track that recorded `position`, and where. Null: the start of a trailing record, where running sums are 0. */
static const track_t *tracks_find(const track_t *tracks, uint8_t count, uint32_t position, uint32_t stride,
                                  uint32_t *slot)
{
    for (uint8_t i = 0U; i < count; i++) {
        *slot = track_find(&tracks[i], position, stride);
        if (*slot < tracks[i].slots) {
            return &tracks[i];
        }
    }
    return NULL;
}

/* Finds the records of the window that the law has placed. */
static void grid_place(stages_t *stages, const davar_t *davar)
{
    grid_t *const grid = stages->grid;
    const davar_window_t *const window = &davar->window;
    const uint32_t stride = davar->config->stride;
    const uint32_t taus = stages->allan.count;
    uint32_t slot = 0U;
    const track_t *const head = tracks_find(grid->head, grid->head_count, window->head, stride, &slot);
    grid->records.head_powers = &head->powers[slot];
    grid->records.head_sums = &head->sums[(size_t)slot * taus];
    const uint32_t middle_position = window->head - stages->moments.segment;
    const track_t *const middle = tracks_find(grid->middle, grid->middle_count, middle_position, stride, &slot);
    grid->records.middle_powers = &middle->powers[slot];
    const track_t *const tail = tracks_find(grid->tail, grid->tail_count, window->tail, stride, &slot);
    grid->records.tail_powers = (tail == NULL) ? NULL : &tail->powers[slot];
    grid->records.tail_sums = (tail == NULL) ? NULL : &tail->sums[(size_t)slot * taus];
}

/* The sum of squared differences of the window for one tau. */
static sum_t grid_sum(const grid_t *grid, uint32_t t)
{
    const sum_t zero = {0};
    const sum_t *const tail = grid->records.tail_sums;
    return sum_between(grid->records.head_sums[t], (tail == NULL) ? zero : tail[t]);
}

/* Power sums from the trailing edge to `later`. */
static powers_t grid_powers(const grid_t *grid, const powers_t *later)
{
    powers_t powers = *later;
    if (grid->records.tail_powers != NULL) {
        powers_subtract(&powers, grid->records.tail_powers);
    }
    return powers;
}

#endif
