/** @file
 * davar - dynamic Allan variance on the device.
 *
 * ```
 * sample -> push -> [ring, Allan variance, window law] -> take -> fit -> result
 * ```
 *
 * Each step is a separate call: what a program does not call is not linked, and options.h
 * disables more. The fit, and with it the angle random walk, is in davar/fit.h.
 *
 * Number types: _q15 (int16 counts), _q31 (int32 counts, 24 significant bits by default) and _f32
 * (floats, each rounded once on entry). A result equals a fresh computation of its window, bit for
 * bit (DESIGN 2).
 *
 * Threads: one producer calls davar_push_* and davar_gap, one consumer davar_take, davar_health and
 * davar_glr_report. The producer may interrupt the consumer and never waits. "Stopped" functions
 * need both to be idle. Instances share nothing. No function allocates memory, blocks or reads a
 * clock.
 *
 * Cost: T cluster sizes, G window.gaps_max, K stride. Instructions for each core: docs/COST.md. */
#ifndef DAVAR_DAVAR_H
#define DAVAR_DAVAR_H

#include "davar/instance.h"
#include "davar/types.h"
#include "davar/version.h"

#ifdef __cplusplus
extern "C" {
#endif

/** The parameters of [SONG18] section 4 (windows of 400 to 600 samples, A-DAVAR), trailing, a
 * result at every sample. Copy it, then set the fields without a default: rate_hz, unit_per_count
 * (f32: full_scale), taus and tau_count. */
extern const davar_config_t davar_default_config;

/** Describes a status in English.
 * @return A text that is never null and must not be changed. Threads: any. Cost: O(1). */
const char *davar_status_text(davar_status_t status);

/** @{ */
/** Computes the bytes of memory that davar_init_* needs.
 * For static arrays use DAVAR_MEMORY (instance.h).
 * @return 0 if davar_init_* would reject the configuration.
 *
 * Threads: any. Cost: O(T). Source: DESIGN 6. */
size_t davar_memory_size_q15(const davar_config_t *config);
size_t davar_memory_size_q31(const davar_config_t *config);
size_t davar_memory_size_f32(const davar_config_t *config);
/** @} */

/** @{ */
/** Starts an instance.
 * The caller owns config and memory (8-byte aligned). Both must outlive the instance, unchanged.
 * @return DAVAR_OK, or the first error found; on error nothing is written, and no other function may
 *         be called with the instance.
 *
 * Threads: stopped. Cost: O(T^2 + bytes). */
DAVAR_NODISCARD davar_status_t davar_init_q15(davar_t *davar, const davar_config_t *config,
                                              void *memory, size_t bytes);
DAVAR_NODISCARD davar_status_t davar_init_q31(davar_t *davar, const davar_config_t *config,
                                              void *memory, size_t bytes);
DAVAR_NODISCARD davar_status_t davar_init_f32(davar_t *davar, const davar_config_t *config,
                                              void *memory, size_t bytes);
/** @} */

/** @{ */
/** Pushes a block of samples: counts, or deg/s for _f32.
 * The newest result that the block completes waits for davar_take. Replaced results are counted in
 * davar_health_t.missed. Results do not depend on how samples are split into blocks.
 * A type other than the one of init, or a push after davar_flush, is an assertion failure; without
 * asserts the samples count as missing.
 * Threads: producer. Cost: O(T) per sample, bounded; no division; _q15, _q31: no floating point.
 * Law glr: a result is one block late, and on a grid one sample may process three blocks. After a
 * gap one sample also does what davar_gap does otherwise; if that restarts the window, it
 * divides. */
void davar_push_q15(davar_t *davar, const int16_t *counts, size_t count);
void davar_push_q31(davar_t *davar, const int32_t *counts, size_t count);
void davar_push_f32(davar_t *davar, const float *rates, size_t count);
/** @} */

/** @{ */
/** Pushes samples up to and including the one that completes a result, for a caller that needs
 * every result of a block: take, then call it again with the rest.
 * @return Samples consumed: at least 1 unless count is 0; all of them after an error of the caller
 *         (see davar_push_*).
 *
 * Threads, cost: as davar_push_*. */
DAVAR_NODISCARD size_t davar_push_until_result_q15(davar_t *davar, const int16_t *counts,
                                                   size_t count);
DAVAR_NODISCARD size_t davar_push_until_result_q31(davar_t *davar, const int32_t *counts,
                                                   size_t count);
DAVAR_NODISCARD size_t davar_push_until_result_f32(davar_t *davar, const float *rates,
                                                   size_t count);
/** @} */

/** Reports that `missing` samples (at least 1; the number is only counted) were lost before the
 * next one. Differences that span the gap are excluded from every sum. It completes no result. Law
 * glr: up to three blocks before it that were not accepted yet are excluded too. After davar_flush
 * it is an assertion failure; without asserts the samples count as missing.
 * Threads: producer. Cost: O(G); if it restarts the window O(T), with one 64-bit division. */
void davar_gap(davar_t *davar, uint32_t missing);

/** Takes the newest result, if one is waiting, and evaluates its kurtosis, contribution and Allan
 * deviations. Intervals and coefficients are absent until davar_fit_white or davar_fit.
 * @return False if no result is waiting.
 *
 * Threads: consumer; if a push interrupts it, it re-reads until its copy is consistent, so that
 * from time to time O(T G) instructions (a few hundred to a thousand without gaps; 6000 at a
 * stride of 1 while the sensor repeats its last sample) must pass without a push. With a stride above 1 the result stays available for K samples.
 * Cost: O(T), with gaps O(T G). */
#define davar_take DAVAR_SIZED(davar_take)
bool davar_take(davar_t *davar, davar_result_t *result);

/** Completes the next result after the last sample, for law glr: it uses the samples in its queue,
 * except a possible shock.
 * @return True if a result waits: take it and call again. False at the end; then push no sample
 *         before davar_reset (asserted). With other laws it returns false and changes nothing.
 *
 * Threads: stopped. Cost: O(K T). */
bool davar_flush(davar_t *davar);

/** Returns to the state after init, counters included. Threads: stopped. Cost: O(memory). */
void davar_reset(davar_t *davar);

/** Returns the counts of input faults and missed results since the last reset. Threads: consumer.
 * Cost: O(1). */
davar_health_t davar_health(const davar_t *davar);

#ifdef __cplusplus
}
#endif

#endif
