/* davar - dynamic Allan variance on the device.
 *
 *   sample -> push -> [ring -> sliding Allan variance -> moments -> window law] -> take -> fit -> result
 *
 * Each step is a call of its own: what a program does not call is not linked, and options.h leaves out more.
 *
 * Three number types share one shape: _q15 (int16 counts), _q31 (int32 counts, 24 significant bits by default) and
 * _f32 (float, quantised once at the door with a power-of-two quantum and then exact for ever). Everything between
 * push and the result is integer and exact: a result equals a recomputation of its window bit for bit, whatever the
 * stream did before (DESIGN 2).
 *
 * Threads and interrupts: one producer may call davar_push_*, davar_gap (an interrupt, say), one consumer davar_take,
 * davar_health (the main loop). take retries while a push interrupts it; push never waits. Everything else (init,
 * reset, flush) needs both quiet. Instances share nothing. No function allocates, blocks or reads a clock. */
#ifndef DAVAR_DAVAR_H
#define DAVAR_DAVAR_H

#include "davar/fit.h"
#include "davar/instance.h"
#include "davar/law.h"
#include "davar/state.h"
#include "davar/types.h"
#include "davar/version.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The paper's parameters ([SONG18] section 4): 600/400/100, 2.5:3.3, 0:0.07, OR, centred, every sample. Copy and edit;
 * rate_hz, unit_per_count (or full_scale), taus and tau_count have no default. */
extern const davar_config_t davar_default_config;

/* The cause in words, for people; never null. */
const char *davar_status_text(davar_status_t status);

/* Bytes of memory that init needs for this configuration (the exact formula is in DESIGN 6; DAVAR_MEMORY_Q15 and
 * friends in instance.h give it at compile time). 0 when init would refuse the configuration. */
size_t davar_memory_size_q15(const davar_config_t *config);
size_t davar_memory_size_q31(const davar_config_t *config);
size_t davar_memory_size_f32(const davar_config_t *config);

/* Starts an instance. `config` and `memory` (8-byte aligned) belong to the caller and must outlive the instance.
 * Returns DAVAR_OK or the first cause of refusal, one code each; nothing is touched on refusal. O(T^2 + memory). */
davar_status_t davar_init_q15(davar_t *davar, const davar_config_t *config, void *memory, size_t bytes);
davar_status_t davar_init_q31(davar_t *davar, const davar_config_t *config, void *memory, size_t bytes);
davar_status_t davar_init_f32(davar_t *davar, const davar_config_t *config, void *memory, size_t bytes);

/* Pushes a block of samples: counts, or deg/s for _f32. It always takes the whole block, and the newest result that the block
 * completes waits for davar_take. A result that is replaced before it was taken counts in davar_health_t.missed. How samples are split
 * into blocks changes no result.
 * A type other than that of init, or a push after davar_flush, is a caller's bug: it is asserted, and without asserts the samples
 * count as missing.
 * Threads: producer; may interrupt davar_take. Cost: O(T) per sample, bounded, no division, no floating point in _q15 and _q31.
 * Policy glr: a result is one block late, and on a grid one sample may process three blocks that have waited. After a gap one sample also
 * does what davar_gap does for the other policies; if that restarts the window, it divides. */
void davar_push_q15(davar_t *davar, const int16_t *counts, size_t count);
void davar_push_q31(davar_t *davar, const int32_t *counts, size_t count);
void davar_push_f32(davar_t *davar, const float *rates, size_t count);

/* Pushes samples up to and including the one that completes a result, for a caller that wants every result of a block: take, then
 * call again with the rest. Returns how many samples it took: at least 1 unless count is 0; all of them after a caller's bug (see
 * davar_push_*). Threads and cost as above. */
DAVAR_NODISCARD size_t davar_push_until_result_q15(davar_t *davar, const int16_t *counts, size_t count);
DAVAR_NODISCARD size_t davar_push_until_result_q31(davar_t *davar, const int32_t *counts, size_t count);
DAVAR_NODISCARD size_t davar_push_until_result_f32(davar_t *davar, const float *rates, size_t count);

/* Says that `missing` samples (>= 1; the number is only counted) were lost before the next one. Differences that span
 * the gap are left out of every sum. It completes no result. Policy glr: up to three blocks of samples before it that were not
 * accepted yet are left out too. O(gaps_max), when it restarts the window O(T), with one 64-bit division. */
void davar_gap(davar_t *davar, uint32_t missing);

/* Takes the newest result, if one is waiting. False: none. Evaluates kurtosis, contribution and ADEV here, not in push;
 * intervals and coefficients are absent until davar_fit_white or davar_fit. On a grid the result stays valid for K samples,
 * otherwise until the next push (take always returns a consistent one). Cost: O(T), O(T gaps) while gaps are inside. It reads
 * integers first and again when a push has come between: now and then that stretch (O(T gaps), a few hundred to a thousand
 * instructions without gaps) must pass without a push. */
#define davar_take DAVAR_SIZED(davar_take)
bool davar_take(davar_t *davar, davar_result_t *result);

/* Completes the next result after the last sample. Centred mode mirrors the end; policy glr uses the samples that wait, except a possible
 * shock. Returns true if a result waits: take it and call again. False at the end, and at once if the record is shorter than
 * window_max / 2 or a grid was configured without mirrored_end. In both cases push no sample before davar_reset (asserted). Trailing
 * without glr it does nothing and returns false, and pushing may go on. Stopped: no push or take at the same time. O(K T). */
bool davar_flush(davar_t *davar);

/* Back to the state after init; counters too. O(memory). */
void davar_reset(davar_t *davar);

/* The weather so far. */
davar_health_t davar_health(const davar_t *davar);

#ifdef __cplusplus
}
#endif

#endif
