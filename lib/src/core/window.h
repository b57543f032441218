/* davar - the position and the phase of a window, and the gaps inside it.
 *
 * The first functions return what a configuration needs. If davar/options.h disables a feature, its
 * function is false at compile time, and the compiler drops the code that depends on it. */
#ifndef DAVAR_SRC_WINDOW_H
#define DAVAR_SRC_WINDOW_H

#include "davar/instance.h"

#include "core/law.h"
#include "number/real.h"

static inline bool has_law(const davar_config_t *config)
{
    return DAVAR_LAWS && (config->law != NULL);
}

/* The law takes samples before the pipeline does. */
static inline bool has_queue(const davar_config_t *config)
{
    return has_law(config) && (config->law->push != NULL);
}

static inline bool has_moments(const davar_config_t *config)
{
    return DAVAR_LAWS && (config->moments.segment != 0U);
}

/* The engine of a stride above 1; null: sums follow both edges. */
static inline const davar_engine_t *engine_of(const davar_config_t *config)
{
    const davar_engine_t *const chosen =
        ((config->engine != NULL) || !has_law(config)) ? config->engine : config->law->engine;
    return (config->stride > 1U) ? chosen : NULL;
}

/* Samples between the places where windows of the law can begin; 0: anywhere. */
static inline uint32_t law_block(const davar_config_t *config)
{
    return (has_law(config) && (config->law->block != NULL)) ? config->law->block(config) : 0U;
}

static inline uint32_t smaller(uint32_t a, uint32_t b)
{
    return (a < b) ? a : b;
}

/* Whole steps in `back`, which keeps the rest. O(log), without a division, which is a library call
 * on a small core. */
static inline uint32_t whole_steps(uint32_t *back, uint32_t step)
{
    uint32_t power = 1U;
    uint32_t steps = 0U;
    while ((step * power) <= (*back >> 1U)) {
        power <<= 1U;
    }
    for (; power > 0U; power >>= 1U) {
        if ((step * power) <= *back) {
            *back -= step * power;
            steps += power;
        }
    }
    return steps;
}

/* Samples are floats and are quantised first (2.3). */
static inline bool is_float(const davar_t *davar)
{
    return DAVAR_Q31 && davar->is_float;
}

/* deg/s per count. */
static inline double size_of_count(const davar_t *davar)
{
    return is_float(davar) ? davar_inverse_of_power(davar->counts_per_unit)
                           : davar->config->unit_per_count;
}

/* --- positions -------------------------------------------------------------------------------- */

/* The position of the oldest sample of the window. */
static inline uint32_t window_tail(const davar_window_t *window)
{
    return window->received - window->length;
}

/* Counts `count` new samples. */
static inline void window_receive(davar_window_t *window, uint32_t count)
{
    window->received += count;
    if (window->received < count) {
        window->origin += UINT64_C(1) << 32U;
    }
}

/* Samples since init. */
static inline uint64_t window_now(const davar_window_t *window)
{
    return window->origin + window->received;
}

/* --- phases ----------------------------------------------------------------------------------- */

/* How far a window is from the start of the stream:
 *
 *   SKIPPING ---> FILLING ---> SETTLING ---> RUNNING
 */
typedef enum {
    WINDOW_SKIPPING, /* after a restart: samples before the next epoch boundary are dropped */
    WINDOW_FILLING,  /* the window holds all samples so far */
    WINDOW_SETTLING, /* the window has left the start; the longest span has not */
    WINDOW_RUNNING,  /* nothing of the start is left */
    WINDOW_PHASES
} window_phase_t;

/* True if the diagram has this transition. */
static inline bool window_may_pass(window_phase_t from, window_phase_t to)
{
    return (to < WINDOW_PHASES) && ((unsigned)to == ((unsigned)from + 1U));
}

/* Writes the phase. Only the start of a stream writes it elsewhere. */
static inline void window_enter(davar_window_t *window, window_phase_t phase)
{
    DAVAR_ASSERT(window_may_pass((window_phase_t)window->phase, phase));
    window->phase = (uint8_t)phase;
}

/* Spans may reach before the first sample. */
static inline bool is_starting(const davar_window_t *window)
{
    return window->phase < (uint8_t)WINDOW_RUNNING;
}

static inline bool is_filling(const davar_window_t *window)
{
    return window->phase == (uint8_t)WINDOW_FILLING;
}

/* Windows fill until they are full, or until a law shrinks one. */
static inline void window_keep_filling(davar_window_t *window, const davar_config_t *config,
                                       bool unstable)
{
    if (is_filling(window) && (unstable || (window->length >= config->window.longest))) {
        window_enter(window, WINDOW_SETTLING);
    }
}

/* --- gaps: boundaries that no difference may span --------------------------------------------- */

/* Returned by davar_gaps_after when no boundary follows. */
#define DAVAR_NO_GAP UINT32_MAX

/* Forgets the boundaries before a window of this length, which ends where the window does. Call it
 * at least every 2^31 samples: an older boundary would seem to lie ahead. O(gaps). */
void davar_gaps_forget(davar_gaps_t *gaps, const davar_window_t *window, uint32_t length);

/* Stores the boundary before the next sample, and forgets those that a window of this length has
 * left. A boundary at the start of the stream, or one already stored, changes nothing. False: full,
 * nothing changed. O(gaps). */
bool davar_gaps_push(davar_gaps_t *gaps, const davar_window_t *window, uint32_t length);

/* Samples from `position` to the first boundary after it, or DAVAR_NO_GAP. O(log gaps). */
uint32_t davar_gaps_after(const davar_gaps_t *gaps, uint32_t position);

/* Boundaries inside [tail, head), between two of its samples. O(gaps). */
uint32_t davar_gaps_inside(const davar_gaps_t *gaps, uint32_t tail, uint32_t length);

/* How many of the spans of 2 m samples inside [tail, head) contain a boundary (1.5). O(gaps). */
uint32_t davar_gaps_spans_lost(const davar_gaps_t *gaps, uint32_t tail, uint32_t length,
                               uint32_t m);

#endif
