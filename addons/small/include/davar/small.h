/** @file
 * davar - small: the angle random walk of one axis of int16 counts in the least flash and RAM.
 *
 * A fixed window of octaves (1, 2, 4 and so on) whose length, stride and filter are constants that
 * tools/davar-plan decided. A gap restarts the window. For such a window the results are those of
 * davar_push_q15, davar_take and davar_fit_white with window.gaps_max 0, bit for bit.
 * Use it through the setup that tools/davar-plan writes; it checks no configuration.
 *
 * Threads: one producer calls davar_small_push and davar_small_gap, one consumer davar_small_take
 * and davar_small_health. The producer may interrupt the consumer and never waits. */
#ifndef DAVAR_SMALL_H
#define DAVAR_SMALL_H

#include "davar/davar.h"
#include "davar/fit.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What is constant, as tools/davar-plan writes it. */
typedef struct {
    double unit_per_count;  /**< size of a count, deg/s */
    uint32_t stride;        /**< samples between two results, at least 2 */
    davar_white_plan_t fit; /**< of windows that are a multiple of the stride, at least twice */
} davar_small_plan_t;

/** A cluster size of a stream. Fields are private. */
typedef struct {
    /** @privatesection */
    uint64_t sum;  /* of D^2 over the window */
    uint64_t kept; /* the sum of the newest result */
    int32_t head;  /* D at the leading edge */
    int32_t tail;  /* ... at the trailing edge */
} davar_small_tau_t;

/** One stream. The caller owns it; when it starts, everything except `plan` and `ring` is 0.
 * Fields are private. */
typedef struct {
    /** @privatesection */
    const davar_small_plan_t *plan;
    int16_t *ring; /* the last window + 1 samples */
    uint64_t now;  /* samples so far */
    /* The newest result. */
    uint64_t epoch;
    uint32_t kept_equal;
    bool unstable;
    bool ready; /* it is of a full window */
    /* The window. */
    uint32_t newest;   /* index of the newest sample in the ring */
    uint32_t length;   /* samples in the window */
    uint32_t waited;   /* samples since the last epoch */
    uint32_t skip;     /* samples to omit until the next epoch after a restart */
    uint32_t equal;    /* newest samples that are equal */
    uint32_t level[2]; /* of the first sum of two windows, half a window apart (4.5); 0: none */
    uint32_t past;     /* samples until the next one is kept */
    /* Counters of davar_health_t, and the sequence lock. */
    uint32_t gaps;
    uint32_t missing;
    uint32_t saturated;
    uint32_t restarts;
    uint32_t missed;
    volatile uint32_t sequence;
    volatile uint32_t produced;
    uint32_t seen;
    davar_small_tau_t tau[DAVAR_TAUS_MAX];
} davar_small_t;

/** Starts an instance in static memory, which is 0. It checks nothing. ring: window + 1 samples.
 * Threads: stopped. Cost: O(1). */
#define davar_small_start DAVAR_SIZED(davar_small_start)
void davar_small_start(davar_small_t *small, const davar_small_plan_t *plan, int16_t *ring);

/** Pushes a block of samples. Threads: producer. Cost: O(T) per sample. */
#define davar_small_push DAVAR_SIZED(davar_small_push)
void davar_small_push(davar_small_t *small, const int16_t *counts, size_t count);

/** Reports that `missing` samples were lost before the next one. The window restarts; the next
 * result stays due where it was. Threads: producer. Cost: O(1). */
#define davar_small_gap DAVAR_SIZED(davar_small_gap)
void davar_small_gap(davar_small_t *small, uint32_t missing);

/** Takes the newest result, if one is waiting, with its fit of white noise.
 * @return False if no result is waiting.
 *
 * Threads: consumer. Cost: O(T). */
#define davar_small_take DAVAR_SIZED(davar_small_take)
bool davar_small_take(davar_small_t *small, davar_result_t *result);

/** Returns to the state after the start, counters included. Threads: stopped. Cost: O(T). */
#define davar_small_restart DAVAR_SIZED(davar_small_restart)
void davar_small_restart(davar_small_t *small);

/** Returns the counts of input faults and missed results. Threads: consumer. Cost: O(1). */
#define davar_small_health DAVAR_SIZED(davar_small_health)
davar_health_t davar_small_health(const davar_small_t *small);

#ifdef __cplusplus
}
#endif

#endif
