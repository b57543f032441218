/** @file
 * davar - average: turns a fast stream into a slow one, which costs less to process.
 *
 * Adds the counts of each block of n samples, and davar gets the sums: an 8 kHz gyro becomes a
 * stream of 1 kHz. Nothing is rounded, so coarse counts keep their resolution. Push the sums with
 * davar_push_q31, with rate_hz and unit_per_count divided by n, and declare the low-pass of the
 * gyro and then davar_filter_sum(&filter, n) (davar/filter.h).
 *
 * Threads: one davar_average_t belongs to one thread or interrupt. */
#ifndef DAVAR_AVERAGE_H
#define DAVAR_AVERAGE_H

#include "davar/options.h"

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A block that is being added up. Fields are private. */
typedef struct {
    /** @privatesection */
    int64_t sum;
    uint16_t length;
    uint16_t count; /* samples in sum */
} davar_average_t;

/** Begins a block. length: samples in a block, 1 to 4096 (asserted). */
static inline void davar_average_init(davar_average_t *average, uint16_t length)
{
    DAVAR_ASSERT((length >= 1U) && (length <= 4096U));
    *average = (davar_average_t){0, length, 0U};
}

/** Adds one sample, in counts.
 * @return True if it completes a block, whose sum is then in *sum. A sum of more than 32 bits is
 *         limited to them; davar counts it as saturated. Samples of 20 bits never reach that.
 *
 * Cost: O(1), a 64-bit addition. */
static inline bool davar_average_push(davar_average_t *average, int32_t sample, int32_t *sum)
{
    average->sum += sample;
    average->count++;
    if (average->count < average->length) {
        return false;
    }
    const int64_t whole = average->sum;
    const int64_t above = (whole < INT32_MAX) ? whole : INT32_MAX;
    *sum = (int32_t)((above > INT32_MIN) ? above : INT32_MIN);
    average->sum = 0;
    average->count = 0U;
    return true;
}

/** Drops the block that a gap of `missing` samples interrupts. The next sample begins a block.
 * @return The number of sums that are missing, at least 1, to the nearest whole one: pass it to
 *         davar_gap. */
static inline uint32_t davar_average_gap(davar_average_t *average, uint32_t missing)
{
    const uint64_t lost = (uint64_t)missing + average->count + (average->length / 2U);
    const uint64_t sums = lost / average->length;
    average->sum = 0;
    average->count = 0U;
    return (sums > 1U) ? ((sums < UINT32_MAX) ? (uint32_t)sums : UINT32_MAX) : 1U;
}

#ifdef __cplusplus
}
#endif

#endif
