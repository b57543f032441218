/* davar - the state of one pipeline, as it lies in the caller's memory. */
#ifndef DAVAR_SRC_STAGES_H
#define DAVAR_SRC_STAGES_H

#include "change/moments.h"
#include "common/choice.h"
#include "window/allan.h"
#include "window/window.h"

/* Running sums recorded at the positions first, first + hop, first + 2 hop ... (grid, 2.7). */
typedef struct {
    powers_t *powers;   /* slots entries; null: policy glr without moments */
    sum_t *sums;        /* slots x taus; null for the middle track */
    uint32_t *sum_due;  /* per tau: value of `received` at the next record; null when recorded with the powers */
    uint32_t *sum_slot; /* per tau: slot of that record */
    uint32_t slots;
    uint32_t hop;          /* samples from record to record: the stride; policy glr: of its edges the block */
    uint32_t due;          /* value of `received` at the next record of the powers: its position */
    uint32_t slot;         /* slot of that record */
    uint32_t mirrored_due; /* value of `received` that gives a position in the mirrored start */
    uint32_t mirrored_slot;
    uint32_t mirrored_left; /* how many of those are still to come */
} track_t;

#define GRID_BLOCK 64U /* samples that a grid takes in at once */
#define TRACKS_MAX 3U  /* residues of an edge modulo K: window_max, window_min, and 0 while a trailing window fills */

/* The sums of one window, as differences of records. */
typedef struct {
    const powers_t *head_powers;
    const powers_t *middle_powers;
    const powers_t *tail_powers; /* null: the start, where all running sums are 0 */
    const sum_t *head_sums;
    const sum_t *tail_sums;
} records_t;

typedef struct {
    track_t tail[TRACKS_MAX];
    track_t head[TRACKS_MAX];
    track_t middle[TRACKS_MAX];
    uint8_t tail_count;
    uint8_t head_count;
    uint8_t middle_count;
    uint32_t sum_next; /* value of `received` at the next record of any sum at a trailing edge */
    uint32_t next;     /* value of `received` at the next record of any track */
    records_t records;
} grid_t;

/* How the next sample may be taken in. */
typedef enum {
    STEADY_NOT = 0, /* with care: a gap, the start, or an edge on its way is near */
    STEADY_PLAIN,   /* the window glides, both edges by one, and nothing else happens */
    STEADY_GLIDING, /* ... with moments, a verdict, or the start in it */
    STEADY_GRID     /* running sums run on, many samples at once */
} steady_t;

typedef struct {
    ring_t ring;
    allan_t allan;
    moments_t moments;
    grid_t *grid;            /* null: a value at every sample */
    struct tracker *tracker; /* null: no policy glr */
    sample_t highest;        /* samples at or beyond it, or its complement, are saturated */
    uint8_t steady;          /* a steady_t */
} stages_t;

/* Samples wait in front of the pipeline until the detector has heard them. */
static inline bool is_tracked(const stages_t *stages)
{
    return DAVAR_TRACKING && (stages->tracker != NULL);
}

/* Results come from records on a grid, not from sums that follow both edges. */
static inline bool on_grid(const stages_t *stages)
{
    return DAVAR_GRID && (stages->grid != NULL);
}

#endif
