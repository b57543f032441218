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

/* The leading edge of one cluster size takes in n samples that follow one another in memory, as do their taps. */
DAVAR_APART static void grid_run(tau_t *tau, const sample_t *newest, const sample_t *middle, const sample_t *oldest,
                                 uint32_t n)
{
    difference_t head = tau->head;
    sum_t sum = tau->sum;
    for (const sample_t *const end = newest + n; newest != end; newest++, middle++, oldest++) {
        head += *newest - (2 * (difference_t)*middle) + *oldest;
        sum_add_square(&sum, head);
    }
    tau->head = head;
    tau->sum = sum;
}

static void grid_record_sum(track_t *track, const allan_t *allan, uint32_t t, uint32_t slot)
{
    sum_copy(&track->sums[(slot * allan->count) + t], &allan->tau[t].sum);
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
DAVAR_RARE static void track_record_mirrored(track_t *track, const stages_t *stages, uint32_t received, uint32_t stride)
{
    const allan_t *const allan = &stages->allan;
    static const powers_t no_powers = {0};
    static const sum_t no_sum = {0};
    powers_between(&track->powers[track->mirrored_slot], &no_powers, &stages->moments.head);
    for (uint32_t t = 0U; (track->sum_due != NULL) && (t < allan->count); t++) {
        if (received > allan->m[t]) {
            track->sums[(track->mirrored_slot * allan->count) + t] = sum_between(no_sum, allan->tau[t].sum);
        }
    }
    track->mirrored_left--;
    track->mirrored_due += stride;
    track->mirrored_slot = slot_before(track, track->mirrored_slot);
}

static void track_record_powers(track_t *track, const stages_t *stages, uint32_t stride)
{
    powers_copy(&track->powers[track->slot], &stages->moments.head);
    if ((track->sums != NULL) && (track->sum_due == NULL)) {
        for (uint32_t t = 0U; t < stages->allan.count; t++) {
            grid_record_sum(track, &stages->allan, t, track->slot);
        }
    }
    track->due += stride;
    track->slot = slot_after(track, track->slot);
}

static void tracks_record_sum(grid_t *grid, const allan_t *allan, uint32_t t, uint32_t received, uint32_t stride)
{
    for (uint8_t i = 0U; i < grid->tail_count; i++) {
        track_t *const track = &grid->tail[i];
        if (track->sum_due[t] == received) {
            grid_record_sum(track, allan, t, track->sum_slot[t]);
            track->sum_due[t] += stride;
            track->sum_slot[t] = slot_after(track, track->sum_slot[t]);
        }
    }
}

/* Samples from `received` to the next record of one cluster size's sum at a trailing edge, at most `most`. */
static uint32_t tracks_sum_wait(const grid_t *grid, uint32_t t, uint32_t received, uint32_t most)
{
    uint32_t wait = most;
    for (uint8_t i = 0U; i < grid->tail_count; i++) {
        wait = smaller(wait, grid->tail[i].sum_due[t] - received);
    }
    return wait;
}

static void track_record(track_t *track, const stages_t *stages, uint32_t received, uint32_t stride)
{
    if ((track->mirrored_left > 0U) && (track->mirrored_due == received)) {
        track_record_mirrored(track, stages, received, stride);
    }
    if (track->due == received) {
        track_record_powers(track, stages, stride);
    }
}

/* Samples from `received` to this track's next record of the powers, at most `most`. */
static uint32_t track_wait(const track_t *track, uint32_t received, uint32_t most)
{
    const uint32_t wait = smaller(most, track->due - received);
    return (track->mirrored_left > 0U) ? smaller(wait, track->mirrored_due - received) : wait;
}

static uint32_t tracks_wait(const track_t *tracks, uint8_t count, uint32_t received, uint32_t most)
{
    uint32_t wait = most;
    for (uint8_t i = 0U; i < count; i++) {
        wait = track_wait(&tracks[i], received, wait);
    }
    return wait;
}

static void grid_schedule_sums(grid_t *grid, const allan_t *allan, uint32_t received)
{
    uint32_t wait = UINT32_MAX;
    for (uint32_t t = 0U; t < allan->count; t++) {
        wait = tracks_sum_wait(grid, t, received, wait);
    }
    grid->sum_next = received + wait;
}

static void grid_schedule(grid_t *grid, uint32_t received)
{
    uint32_t wait = tracks_wait(grid->tail, grid->tail_count, received, UINT32_MAX);
    wait = tracks_wait(grid->head, grid->head_count, received, wait);
    wait = tracks_wait(grid->middle, grid->middle_count, received, wait);
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
    grid_schedule(grid, received);
}

/* --- samples in, which lie in the ring already, the first at `index`; the window does not know of them yet -------- */

/* One cluster size, from record to record of its sum. */
static void grid_run_tau(stages_t *stages, const davar_t *davar, uint32_t t, uint32_t index, uint32_t count)
{
    const ring_t *const ring = &stages->ring;
    const uint32_t m = stages->allan.m[t];
    const uint32_t end = davar->window.received + count;
    uint32_t newest = index;
    uint32_t middle = ring_before(ring, newest, m);
    uint32_t oldest = ring_before(ring, middle, m);
    uint32_t left = count;
    uint32_t to_record = tracks_sum_wait(stages->grid, t, end - left, left);
    while (left > 0U) {
        uint32_t n = smaller(to_record, ring_stretch(ring, newest));
        n = smaller(n, smaller(ring_stretch(ring, middle), ring_stretch(ring, oldest)));
        grid_run(&stages->allan.tau[t], &ring->sample[newest], &ring->sample[middle], &ring->sample[oldest], n);
        newest = ring_behind(ring, newest, n);
        middle = ring_behind(ring, middle, n);
        oldest = ring_behind(ring, oldest, n);
        left -= n;
        to_record -= n;
        if (to_record == 0U) {
            tracks_record_sum(stages->grid, &stages->allan, t, end - left, davar->config->stride);
            to_record = tracks_sum_wait(stages->grid, t, end - left, left);
        }
    }
}

static void grid_run_moments(stages_t *stages, uint32_t index, uint32_t count)
{
    const ring_t *const ring = &stages->ring;
    if (count == 1U) {
        powers_add(&stages->moments.head, ring->sample[index]);
        return;
    }
    const uint32_t straight = smaller(count, ring_stretch(ring, index));
    powers_add_run(&stages->moments.head, &ring->sample[index], straight);
    powers_add_run(&stages->moments.head, ring->sample, count - straight);
}

/* Running sums are recorded where an edge can be. */
static void grid_receive(stages_t *stages, davar_t *davar, uint32_t count)
{
    window_receive(&davar->window, count);
    if (stages->grid->next == davar->window.received) {
        grid_record(stages, davar->window.received, davar->config->stride);
    }
}

/* Samples that may come at once: up to the next record of the powers, and as many as the ring has beside the spans. */
static uint32_t grid_block(const stages_t *stages, const davar_window_t *window, uint32_t most)
{
    const uint32_t room = stages->ring.capacity - allan_span_max(&stages->allan);
    return smaller(most, smaller(room, stages->grid->next - window->received));
}

/* No gap near, no span in front of the start: cluster size after cluster size. */
static void grid_advance_plainly(stages_t *stages, davar_t *davar, uint32_t count)
{
    const uint32_t index = ring_index(&stages->ring, count);
    const bool quiet = (stages->grid->sum_next - davar->window.received) > count;
    if (quiet && (count == 1U)) {
        allan_lead(&stages->allan, allan_leading(&stages->ring, index));
    } else {
        for (uint32_t t = 0U; t < stages->allan.count; t++) {
            grid_run_tau(stages, davar, t, index, count);
        }
    }
    if (!quiet) {
        grid_schedule_sums(stages->grid, &stages->allan, davar->window.received + count);
    }
    if (davar->config->segment != 0U) {
        grid_run_moments(stages, index, count);
    }
    grid_receive(stages, davar, count);
}

/* One sample. */
static void grid_advance_carefully(stages_t *stages, davar_t *davar)
{
    allan_t *const allan = &stages->allan;
    const uint32_t index = ring_index(&stages->ring, 1U);
    const uint32_t position = davar->window.received;
    allan_extend_run(allan, &davar->gaps, &davar->window, position);
    for (uint32_t t = 0U; t < allan->count; t++) {
        tau_t *const tau = &allan->tau[t];
        tau->head += allan_any_step(allan, &stages->ring, index, position, allan->m[t]);
        if (allan->run >= (2U * allan->m[t])) {
            sum_add_square(&tau->sum, tau->head);
        }
        tracks_record_sum(stages->grid, allan, t, position + 1U, davar->config->stride);
    }
    grid_schedule_sums(stages->grid, allan, position + 1U);
    if (davar->config->segment != 0U) {
        grid_run_moments(stages, index, 1U);
    }
    allan_end_start(allan, position + 1U);
    grid_receive(stages, davar, 1U);
}

/* --- a window out ------------------------------------------------------------------------------------------------ */

/* Whole strides in `back`, which keeps the rest. Not by a division, which a small core would call for: O(log). */
static uint32_t whole_strides(uint32_t *back, uint32_t stride)
{
    uint32_t power = 1U;
    uint32_t strides = 0U;
    while ((stride * power) <= (*back >> 1U)) {
        power <<= 1U;
    }
    for (; power > 0U; power >>= 1U) {
        if ((stride * power) <= *back) {
            *back -= stride * power;
            strides += power;
        }
    }
    return strides;
}

/* Slot of `position` among the records of a track, or slots when it is not one of its positions. */
static uint32_t track_find(const track_t *track, uint32_t position, uint32_t stride)
{
    uint32_t back = track->due - position;
    const uint32_t strides = whole_strides(&back, stride);
    if (back != 0U) {
        return track->slots;
    }
    return (track->slot >= strides) ? (track->slot - strides) : ((track->slot + track->slots) - strides);
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
    const uint32_t head_at = window_head(&davar->window);
    const uint32_t stride = davar->config->stride;
    const uint32_t taus = stages->allan.count;
    uint32_t slot = 0U;
    const track_t *const head = tracks_find(grid->head, grid->head_count, head_at, stride, &slot);
    grid->records.head_powers = &head->powers[slot];
    grid->records.head_sums = &head->sums[(size_t)slot * taus];
    const uint32_t middle_position = head_at - davar->config->segment;
    const track_t *const middle = tracks_find(grid->middle, grid->middle_count, middle_position, stride, &slot);
    grid->records.middle_powers = &middle->powers[slot];
    const track_t *const tail = tracks_find(grid->tail, grid->tail_count, window_tail(&davar->window), stride, &slot);
    grid->records.tail_powers = (tail == NULL) ? NULL : &tail->powers[slot];
    grid->records.tail_sums = (tail == NULL) ? NULL : &tail->sums[(size_t)slot * taus];
}

/* The sum of squared differences of the window for one tau. */
static sum_t records_sum(const records_t *records, uint32_t t)
{
    const sum_t zero = {0};
    return sum_between(records->head_sums[t], (records->tail_sums == NULL) ? zero : records->tail_sums[t]);
}

#endif
