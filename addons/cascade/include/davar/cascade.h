/** @file
 * davar - cascade: the Allan deviation at long cluster sizes, from minutes to days, in a few
 * kilobytes.
 *
 * The core (davar/davar.h) keeps every sample of its window, so its memory grows with the longest
 * cluster. The cascade remembers a running sum of the samples at sparse positions. Each further
 * octave of cluster size costs about 110 bytes (q15). Push the same samples to both.
 *
 * ```
 * static const davar_cascade_config_t config = {.rate_hz = 100.0, .unit_per_count = 0.061,
 *                                               .shortest = 256, .tau_count = 16, .clusters = 32};
 * static uint64_t memory[DAVAR_CASCADE_MEMORY(Q15, 16) / 8];
 * static davar_cascade_t cascade;
 *
 * davar_cascade_init_q15(&cascade, &config, memory, sizeof memory);
 * davar_cascade_push_q15(&cascade, samples, count);    // in the interrupt, as davar_push_q15
 * ...
 * davar_take(&axis, &result);                          // the short sizes
 * davar_cascade_append(&cascade, &result);             // the long ones
 * davar_fit(&plan, 100.0, &result);                    // five terms of the whole curve
 * ```
 *
 * Arithmetic: every sum is exact, and every target computes the same bits. No function allocates
 * memory, blocks or reads a clock. Formulas: addons/cascade/DESIGN.md (section 11).
 *
 * Threads: one producer calls push and gap, one consumer append and health. The producer may
 * interrupt the consumer and never waits. "Stopped" functions need both to be idle.
 *
 * Cost: T cluster sizes. Instructions: addons/cascade/DESIGN.md (11.7). */
#ifndef DAVAR_CASCADE_H
#define DAVAR_CASCADE_H

#include "davar/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Why davar_cascade_init_* failed: one code per cause, with a value that never changes. */
typedef enum {
    DAVAR_CASCADE_OK = 0,           /**< no error */
    DAVAR_CASCADE_ERR_NULL = 1,     /**< a required pointer is null */
    DAVAR_CASCADE_ERR_BUILD = 2,    /**< number type disabled in this build (options.h) */
    DAVAR_CASCADE_ERR_RATE = 3,     /**< rate_hz not a positive finite number */
    DAVAR_CASCADE_ERR_SCALE = 4,    /**< unit_per_count (f32: full_scale) not positive and finite */
    DAVAR_CASCADE_ERR_SHORTEST = 5, /**< shortest not a multiple of 4 in 64..262140 */
    DAVAR_CASCADE_ERR_CLUSTERS = 6, /**< clusters not a power of two in 4..2048 */
    /** tau_count outside 1..24, or the longest cluster size above 2^31 samples or too long for the
     * exact sums of this type */
    DAVAR_CASCADE_ERR_TAUS = 7,
    DAVAR_CASCADE_ERR_MEMORY_SIZE = 8, /**< memory smaller than DAVAR_CASCADE_MEMORY */
    DAVAR_CASCADE_ERR_MEMORY_ALIGN = 9 /**< memory not aligned to 8 bytes */
} davar_cascade_status_t;

/** Describes a status in English.
 * @return A text that is never null and must not be changed. Threads: any. Cost: O(1). */
const char *davar_cascade_status_text(davar_cascade_status_t status);

/** Largest number of cluster sizes of a cascade. */
#define DAVAR_CASCADE_TAUS_MAX 24

/** Settings. They may be const in flash and must outlive the cascade. */
typedef struct {
    double rate_hz;        /**< samples per second, 1e-50 to 1e50 */
    double unit_per_count; /**< q15, q31: deg/s per count, 1e-50 to 1e50 */
    /** f32: largest |rate| expected, deg/s, 1e-20 to 1e20; from here on samples saturate */
    double full_scale;
    /** smallest cluster size in samples, a multiple of 4 from 64 to 262140. Twice the largest
     * cluster size of the core continues its octaves */
    uint32_t shortest;
    /** number of cluster sizes, 1 to DAVAR_CASCADE_TAUS_MAX: each is twice the previous one */
    uint8_t tau_count;
    /** how much each cluster size remembers, in clusters of that size: clusters + 2 to
     * 2 clusters + 2, once it has seen them. A power of two from 4 to 2048; 32 is
     * usual. Larger: narrower intervals, slower to follow a change (11.5) */
    uint16_t clusters;
} davar_cascade_config_t;

/** Bytes of memory for `taus` cluster sizes, as a constant. type: Q15, Q31 or F32. Two sizes
 * share a stage: 15 and 16 sizes take the same. Source: DESIGN (11.7). */
#define DAVAR_CASCADE_MEMORY(type, taus)                                                           \
    ((((size_t)(taus) + 1U) / 2U) * DAVAR_CASCADE_STAGE_BYTES_##type)
/** @cond */
#define DAVAR_CASCADE_STAGE_BYTES_Q15 224U
#define DAVAR_CASCADE_STAGE_BYTES_Q31 256U
#define DAVAR_CASCADE_STAGE_BYTES_F32 256U
/** @endcond */

/** Counts of input faults since the last reset. They stop at their largest value. */
typedef struct {
    uint32_t gaps;    /**< calls of davar_cascade_gap, and runs of NaN or inf */
    uint32_t missing; /**< samples lost in those gaps, or pushed as another type */
    /** f32: samples at or above full_scale; they are used, clamped. davar_push_* counts saturated
     * counts */
    uint32_t saturated;
    uint32_t not_finite; /**< NaN or inf in float input; each run is a gap */
} davar_cascade_health_t;

/** One cascade of one sensor axis. The caller owns it. Fields are private. */
typedef struct davar_cascade {
    /** @privatesection */
    uint32_t until; /* samples until the next event, at least 1 */
    int32_t part;   /* q15: sum of the samples since the newest hop */
    uint64_t sum;   /* of all samples modulo 2^64; q15: up to the newest hop */
    uint32_t step;  /* samples between the previous event and the next */
    uint32_t left;  /* samples from the previous event to the next hop */
    uint32_t age;   /* of the next hop: hops since the newest gap */
    /* power of the newest cluster of the shortest size; its count and sum of squares then (11.9) */
    uint32_t power;
    uint32_t seen_count;
    uint64_t seen[2];
    uint16_t ready; /* bit k: stage k has a hop to serve */
    uint8_t stage_count;
    uint8_t shift;         /* log2 of config.clusters */
    uint8_t accepts;       /* the one number type that may be pushed */
    bool in_gap;           /* f32: inside a run of NaN or inf */
    float counts_per_unit; /* f32, as limit: full_scale */
    float limit;
    volatile uint32_t sequence; /* odd while a push changes what append reads */
    void *stages;               /* cascade_stage_t[], in the caller's memory */
    void *tops;                 /* after them: upper bits of the running sums at their hops */
    uint32_t memory_bytes;      /* of both */
    const davar_cascade_config_t *config;
    davar_cascade_health_t health;
} davar_cascade_t;

/** @{ */
/** Starts a cascade.
 * The caller owns config and memory (8-byte aligned, DAVAR_CASCADE_MEMORY bytes). Both must outlive
 * the cascade, config unchanged.
 * @return DAVAR_CASCADE_OK, or the first error found; on error nothing is written:
 * - DAVAR_CASCADE_ERR_NULL, DAVAR_CASCADE_ERR_BUILD, DAVAR_CASCADE_ERR_RATE,
 *   DAVAR_CASCADE_ERR_SCALE: as davar_init_*
 * - DAVAR_CASCADE_ERR_SHORTEST: shortest out of range or not a multiple of 4
 * - DAVAR_CASCADE_ERR_CLUSTERS: clusters out of range or not a power of two
 * - DAVAR_CASCADE_ERR_TAUS: tau_count out of range, or the longest cluster size m above 2^31
 *   samples; q31: clusters m^2 above 2^60; f32: above 2^62 (11.4)
 * - DAVAR_CASCADE_ERR_MEMORY_SIZE, DAVAR_CASCADE_ERR_MEMORY_ALIGN: as davar_init_*
 *
 * Threads: stopped. Cost: O(bytes). */
DAVAR_NODISCARD davar_cascade_status_t davar_cascade_init_q15(davar_cascade_t *cascade,
                                                              const davar_cascade_config_t *config,
                                                              void *memory, size_t bytes);
DAVAR_NODISCARD davar_cascade_status_t davar_cascade_init_q31(davar_cascade_t *cascade,
                                                              const davar_cascade_config_t *config,
                                                              void *memory, size_t bytes);
DAVAR_NODISCARD davar_cascade_status_t davar_cascade_init_f32(davar_cascade_t *cascade,
                                                              const davar_cascade_config_t *config,
                                                              void *memory, size_t bytes);
/** @} */

/** @{ */
/** Pushes a block of samples of any size: counts (of any width), or deg/s for _f32.
 * Results do not depend on how samples are split into blocks. A type other than the one of init is
 * an assertion failure; without asserts the samples count as missing.
 * Threads: producer. Cost: O(1) per sample, at most one difference; no division; _q15, _q31: no
 * floating point. */
void davar_cascade_push_q15(davar_cascade_t *cascade, const int16_t *counts, size_t count);
void davar_cascade_push_q31(davar_cascade_t *cascade, const int32_t *counts, size_t count);
void davar_cascade_push_f32(davar_cascade_t *cascade, const float *rates, size_t count);
/** @} */

/** Reports that `missing` samples (at least 1; the number is only counted) were lost before the
 * next one. Differences that span the gap are excluded from every sum. What each cluster size
 * remembers, and how long, stays.
 * Threads: producer. Cost: O(1). */
void davar_cascade_gap(davar_cascade_t *cascade, uint32_t missing);

/** Adds the differences that are complete but still queued: a push adds one at a time, so up to T
 * wait. Call it at the end of a recording; pushes may follow.
 * Threads: stopped. Cost: O(T). */
void davar_cascade_flush(davar_cascade_t *cascade);

/** Adds the present cluster sizes of the cascade to a result of davar_take of the same samples, or
 * to a zeroed one. davar_fit then fits the whole curve, if its plan was made for all sizes: first
 * the sizes of the window, then the sizes of the cascade.
 *
 * Appends all its entries to tau[], with intervals absent, and updates tau_count and
 * unit_per_count. tau_count is then at most DAVAR_TAUS_MAX, and the sizes of the window are below
 * config.shortest (both asserted). As in davar_take, the Allan deviations of counts include
 * rounding.
 * @return False if no cluster size of the cascade has a difference yet.
 *
 * Threads: consumer; if a push interrupts it, it reads the stage concerned again, which is two
 * sizes. Stages may then end at different hops. Cost: O(T), about 30 products per size. */
#define davar_cascade_append DAVAR_SIZED(davar_cascade_append)
bool davar_cascade_append(const davar_cascade_t *cascade, davar_result_t *result);

/** Returns to the state after init, counters included. Threads: stopped. Cost: O(bytes). */
void davar_cascade_reset(davar_cascade_t *cascade);

/** Returns the counts of input faults since the last reset. If a push or a gap interrupts it, one
 * counter may be newer than another. Threads: consumer. Cost: O(1). */
davar_cascade_health_t davar_cascade_health(const davar_cascade_t *cascade);

#ifdef __cplusplus
}
#endif

#endif
