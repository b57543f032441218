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

#include "change/law.h"
#include "window/stages.h"

/* One cluster size, or two of which the second is twice the first, and the taps of both: 0, m, 2 m and 4 m samples back. */
typedef struct {
    tau_t *tau;
    const sample_t *newest;
    const sample_t *middle;
    const sample_t *oldest;
    const sample_t *eldest; /* of two only */
    uint32_t wait[2];       /* samples to the next record of each one's sum at a trailing edge */
    uint32_t t;
    bool two;
} group_t;

/* The leading edge of one cluster size takes in n samples that follow one another in memory, as do their taps, the first
 * `from` samples behind where the group stands. */
DAVAR_APART static void grid_run(const group_t *group, uint32_t from, uint32_t n)
{
    tau_t *const tau = group->tau;
    tau->head = sum_add_run(&tau->sum, tau->head, group->newest + from, group->middle + from, group->oldest + from, n);
}

/* ... of two: what is oldest to the first is in the middle of the second. */
DAVAR_APART static void grid_run_two(const group_t *group, uint32_t from, uint32_t n)
{
    tau_t *const tau = group->tau;
    const sample_t *newest = group->newest + from;
    const sample_t *middle = group->middle + from;
    const sample_t *oldest = group->oldest + from;
    const sample_t *eldest = group->eldest + from;
    difference_t head = tau[0].head;
    difference_t wider = tau[1].head;
    sum_t sum = tau[0].sum;
    sum_t wider_sum = tau[1].sum;
    DAVAR_UNROLLED
    for (const sample_t *const end = newest + n; newest != end; newest++, middle++, oldest++, eldest++) {
        const difference_t shared = (difference_t)*oldest;
        head += *newest - (2 * (difference_t)*middle) + shared;
        wider += *newest - (2 * shared) + *eldest;
        sum_add_square(&sum, head);
        sum_add_square(&wider_sum, wider);
    }
    tau[0].head = head;
    tau[1].head = wider;
    tau[0].sum = sum;
    tau[1].sum = wider_sum;
}

static void grid_record_sum(track_t *track, const allan_t *allan, uint32_t t, uint32_t slot)
{
    sum_copy(&track->sums[(slot * allan->count) + t], &allan->tau[t].sum);
}

static void grid_record_all_sums(track_t *track, const allan_t *allan, uint32_t slot)
{
    const tau_t *const end = allan->tau + allan->count;
    sum_t *to = &track->sums[(size_t)slot * allan->count];
    for (const tau_t *tau = allan->tau; tau != end; tau++, to++) {
        sum_copy(to, &tau->sum);
    }
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
DAVAR_RARE static void track_record_mirrored(track_t *track, const stages_t *stages, uint32_t received)
{
    const allan_t *const allan = &stages->allan;
    static const powers_t no_powers = {0};
    static const sum_t no_sum = {0};
    powers_between(&track->powers[track->mirrored_slot], &no_powers, &stages->moments.whole);
    for (uint32_t t = 0U; (track->sum_due != NULL) && (t < allan->count); t++) {
        if (received > allan->m[t]) {
            track->sums[(track->mirrored_slot * allan->count) + t] = sum_between(no_sum, allan->tau[t].sum);
        }
    }
    track->mirrored_left--;
    track->mirrored_due += track->hop;
    track->mirrored_slot = slot_before(track, track->mirrored_slot);
}

static void track_record_powers(track_t *track, const stages_t *stages)
{
    if (track->powers != NULL) {
        powers_copy(&track->powers[track->slot], &stages->moments.whole);
    }
    if ((track->sums != NULL) && (track->sum_due == NULL)) {
        grid_record_all_sums(track, &stages->allan, track->slot);
    }
    track->due += track->hop;
    track->slot = slot_after(track, track->slot);
}

/* One cluster size's sum, where it is due at a trailing edge; returns the samples to where it is due next. */
DAVAR_APART static uint32_t tracks_record_sum(stages_t *stages, uint32_t t, uint32_t received)
{
    grid_t *const grid = stages->grid;
    uint32_t wait = UINT32_MAX;
    for (uint8_t i = 0U; i < grid->tail_count; i++) {
        track_t *const track = &grid->tail[i];
        uint32_t due = track->sum_due[t];
        if (due == received) {
            const uint32_t slot = track->sum_slot[t];
            track->sum_slot[t] = slot_after(track, slot);
            due += track->hop;
            track->sum_due[t] = due;
            grid_record_sum(track, &stages->allan, t, slot);
        }
        wait = smaller(wait, due - received);
    }
    return wait;
}

/* Every cluster size's, and when the next one is due. */
static void grid_record_sums(stages_t *stages, uint32_t received)
{
    uint32_t wait = UINT32_MAX;
    for (uint32_t t = 0U; t < stages->allan.count; t++) {
        wait = smaller(wait, tracks_record_sum(stages, t, received));
    }
    stages->grid->sum_next = received + wait;
}

static uint32_t tracks_sum_wait(const grid_t *grid, uint32_t t, uint32_t received)
{
    uint32_t wait = grid->tail[0].sum_due[t] - received;
    for (uint8_t i = 1U; i < grid->tail_count; i++) {
        wait = smaller(wait, grid->tail[i].sum_due[t] - received);
    }
    return wait;
}

static void track_record(track_t *track, const stages_t *stages, uint32_t received)
{
    if ((track->mirrored_left > 0U) && (track->mirrored_due == received)) {
        track_record_mirrored(track, stages, received);
    }
    if (track->due == received) {
        track_record_powers(track, stages);
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

static void grid_schedule(grid_t *grid, uint32_t received)
{
    uint32_t wait = tracks_wait(grid->tail, grid->tail_count, received, UINT32_MAX);
    wait = tracks_wait(grid->head, grid->head_count, received, wait);
    wait = tracks_wait(grid->middle, grid->middle_count, received, wait);
    grid->next = received + wait;
}

static void tracks_record(track_t *tracks, uint8_t count, const stages_t *stages, uint32_t received)
{
    for (uint8_t i = 0U; i < count; i++) {
        track_record(&tracks[i], stages, received);
    }
}

static void grid_record(stages_t *stages, uint32_t received)
{
    grid_t *const grid = stages->grid;
    tracks_record(grid->tail, grid->tail_count, stages, received);
    tracks_record(grid->head, grid->head_count, stages, received);
    tracks_record(grid->middle, grid->middle_count, stages, received);
    grid_schedule(grid, received);
}

/* --- samples in, which lie in the ring already, the first at `index`; the window does not know of them yet -------- */

/* `count` samples, the first at `position`: from record to record. */
DAVAR_APART static void grid_run_group(stages_t *stages, group_t *group, uint32_t position, uint32_t count)
{
    for (uint32_t done = 0U; done != count;) {
        const uint32_t n = smaller(count - done, smaller(group->wait[0], group->wait[1]));
        DAVAR_ASSERT(n > 0U); /* a record that is due lies ahead */
        if (group->two) {
            grid_run_two(group, done, n);
        } else {
            grid_run(group, done, n);
        }
        done += n;
        group->wait[0] -= n;
        group->wait[1] -= n;
        if (group->wait[0] == 0U) {
            group->wait[0] = tracks_record_sum(stages, group->t, position + done);
        }
        if (group->wait[1] == 0U) {
            group->wait[1] = tracks_record_sum(stages, group->t + 1U, position + done);
        }
    }
}

/* Cluster size after cluster size, two at a time where they share taps. */
static void grid_run_taus(stages_t *stages, const davar_t *davar, const sample_t *head, uint32_t count)
{
    const allan_t *const allan = &stages->allan;
    const uint32_t received = davar->window.received;
    uint32_t wait = UINT32_MAX;
    group_t group;
    group.newest = head;
    for (uint32_t t = 0U; t < allan->count; t += group.two ? 2U : 1U) {
        const size_t m = allan->m[t];
        const bool another = DAVAR_MANY_REGISTERS && ((t + 1U) < allan->count);
        group.tau = &allan->tau[t];
        group.middle = head - m;
        group.oldest = group.middle - m;
        group.t = t;
        group.two = another && (allan->m[t + 1U] == (2U * m));
        group.eldest = group.two ? (group.oldest - (2U * m)) : group.oldest;
        group.wait[0] = tracks_sum_wait(stages->grid, t, received);
        group.wait[1] = group.two ? tracks_sum_wait(stages->grid, t + 1U, received) : UINT32_MAX;
        grid_run_group(stages, &group, received, count);
        wait = smaller(wait, smaller(group.wait[0], group.wait[1]));
    }
    stages->grid->sum_next = received + count + wait;
}

static void grid_run_moments(stages_t *stages, const sample_t *head, uint32_t count)
{
    if (count == 1U) {
        powers_add(&stages->moments.whole, *head);
    } else {
        powers_add_run(&stages->moments.whole, head, count);
    }
}

/* Running sums are recorded where an edge can be. */
static void grid_receive(stages_t *stages, davar_t *davar, uint32_t count)
{
    window_receive(&davar->window, count);
    if (stages->grid->next == davar->window.received) {
        grid_record(stages, davar->window.received);
    }
}

/* Samples that may come at once: up to the next record of the powers, and as many as the ring has room for. */
static uint32_t grid_block(const stages_t *stages, const davar_window_t *window, uint32_t most)
{
    return smaller(most, smaller(GRID_BLOCK, stages->grid->next - window->received));
}

/* No gap near, no span in front of the start. */
static void grid_advance_plainly(stages_t *stages, davar_t *davar, uint32_t count)
{
    const sample_t *const head = ring_leading(&stages->ring, count);
    const uint32_t received = davar->window.received + count;
    if (count > 1U) {
        grid_run_taus(stages, davar, head, count);
    } else {
        allan_lead(&stages->allan, head);
        if (stages->grid->sum_next == received) {
            grid_record_sums(stages, received);
        }
    }
    if (has_moments(davar->config)) {
        grid_run_moments(stages, head, count);
    }
    grid_receive(stages, davar, count);
}

/* One sample. */
static void grid_advance_carefully(stages_t *stages, davar_t *davar)
{
    allan_t *const allan = &stages->allan;
    const sample_t *const head = ring_leading(&stages->ring, 1U);
    const uint32_t position = davar->window.received;
    allan_extend_run(allan, &davar->gaps, &davar->window, position);
    for (uint32_t t = 0U; t < allan->count; t++) {
        tau_t *const tau = &allan->tau[t];
        tau->head += allan_any_step(allan, head, position, allan->m[t]);
        if (allan->run >= (2U * allan->m[t])) {
            sum_add_square(&tau->sum, tau->head);
        }
    }
    grid_record_sums(stages, position + 1U);
    if (has_moments(davar->config)) {
        powers_add(&stages->moments.whole, *head);
    }
    allan_end_start(allan, position + 1U);
    grid_receive(stages, davar, 1U);
}

#endif
