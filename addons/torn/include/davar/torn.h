/** @file
 * davar - torn: replaces torn register reads by gaps.
 *
 * If a driver reads the bytes of a register while the sensor renews it, one byte is old, and the
 * sample is off by a power of two in counts. This filter belongs between the sensor and davar. It
 * delivers each sample when the next one arrives. In the place of a torn read it reports a gap.
 *
 * The filter cannot distinguish a torn read from a shock of one sample that happens to be a power
 * of two (addons/torn/DESIGN.md, section 12). Use it if your bus tears reads, and fix the driver: read in one burst, or
 * latch the registers (block data update).
 *
 * Threads: one davar_torn_t belongs to one thread or interrupt. */
#ifndef DAVAR_TORN_H
#define DAVAR_TORN_H

#include "davar/options.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** What davar_torn_push delivers. */
typedef enum {
    DAVAR_TORN_NOTHING = 0, /**< nothing: the first sample after init or a gap waits */
    DAVAR_TORN_SAMPLE = 1,  /**< the sample before the pushed one: push it */
    DAVAR_TORN_READ = 2     /**< the sample before the pushed one was torn: davar_gap(.., 1) */
} davar_torn_step_t;

/** The filter of one axis. Fields are private. */
typedef struct {
    /** @privatesection */
    uint32_t sum;     /* 64 times the running mean of |x[i] - x[i-1]| (12.2) */
    int32_t previous; /* the newest sample delivered */
    int32_t waiting;  /* the sample to test */
    uint32_t reads;   /* torn */
    uint8_t held;     /* of the two samples above: 0, 1 (waiting) or 2 */
    uint8_t learned;  /* differences in sum, up to 64 */
    bool calm;        /* the difference before `previous` is within 4 times the noise */
} davar_torn_t;

/** Starts a filter. It learns the noise from the first 65 samples and delivers all of them. */
static inline void davar_torn_init(davar_torn_t *torn)
{
    const davar_torn_t empty = {0U, 0, 0, 0U, 0U, 0U, false};
    *torn = empty;
}

/** @cond */
static inline uint32_t davar_torn_distance(int32_t a, int32_t b)
{
    return (a > b) ? ((uint32_t)a - (uint32_t)b) : ((uint32_t)b - (uint32_t)a);
}

/* Is the waiting sample, which is `step` away from the previous one, torn if `next` follows it?
 * (12.1) */
static inline bool davar_torn_is(const davar_torn_t *torn, uint32_t step, uint32_t noise,
                                 int32_t next)
{
    const uint32_t back = davar_torn_distance(torn->waiting, next);
    if (((torn->waiting > torn->previous) != (torn->waiting > next)) || (torn->learned < 64U) ||
        !torn->calm) {
        return false;
    }
    const uint64_t reach = 4U * (uint64_t)noise;
    const uint64_t most = ((step < back) ? step : back) + reach;
    uint64_t power = 1U;
    while ((2U * power) <= most) {
        power *= 2U;
    }
    return (power >= (8U * reach)) && ((power + reach) >= ((step < back) ? back : step));
}

/* The running mean of the differences (12.2). */
static inline void davar_torn_learn(davar_torn_t *torn, uint32_t step, uint32_t noise)
{
    torn->calm = (step <= (4U * noise));
    if (torn->learned < 64U) {
        torn->learned++;
        torn->sum += (step < (1U << 26U)) ? step : ((1U << 26U) - 1U);
    } else {
        const uint32_t limit = 8U * noise;
        const uint32_t most = (limit < (1U << 26U)) ? limit : ((1U << 26U) - 1U);
        torn->sum += ((step < most) ? step : most) - (torn->sum / 64U);
    }
}
/** @endcond */

/** Pushes one sample, in counts. `before` receives the sample before it, unless the result is
 * DAVAR_TORN_NOTHING.
 *
 * A sample that is not torn is delivered unchanged. Cost: O(1), no division; a jump of more than 28
 * times the noise costs up to 33 turns of a short loop. Source: DESIGN 12. */
static inline davar_torn_step_t davar_torn_push(davar_torn_t *torn, int32_t sample, int32_t *before)
{
    davar_torn_step_t step = (torn->held > 0U) ? DAVAR_TORN_SAMPLE : DAVAR_TORN_NOTHING;
    if (torn->held == 2U) {
        const uint32_t noise = (torn->sum / 64U) + 1U;
        const uint32_t distance = davar_torn_distance(torn->waiting, torn->previous);
        if ((distance >= (28U * noise)) && davar_torn_is(torn, distance, noise, sample)) {
            step = DAVAR_TORN_READ;
        } else {
            davar_torn_learn(torn, distance, noise);
        }
    }
    if (step == DAVAR_TORN_READ) {
        *before = torn->waiting;
        torn->reads += (torn->reads < UINT32_MAX) ? 1U : 0U;
    } else if (step == DAVAR_TORN_SAMPLE) {
        *before = torn->waiting;
        torn->previous = torn->waiting;
        torn->held = 2U;
    } else {
        torn->held = 1U;
    }
    torn->waiting = sample;
    return step;
}

/** Ends a run of samples: call it before davar_gap, and at the end of a recording.
 * @return True if a sample waits. It is then in *last, and must be pushed before the gap. Without
 *         two neighbours it cannot be tested. */
static inline bool davar_torn_gap(davar_torn_t *torn, int32_t *last)
{
    const bool waits = (torn->held > 0U);
    if (waits) {
        *last = torn->waiting;
    }
    torn->held = 0U;
    torn->calm = false;
    return waits;
}

/** Returns the number of torn reads since init, at most 2^32 - 1. */
static inline uint32_t davar_torn_reads(const davar_torn_t *torn)
{
    return torn->reads;
}

#ifdef __cplusplus
}
#endif

#endif
