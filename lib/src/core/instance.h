/* davar - internals of an instance: the pipelines of the number types, counters, the sequence lock.
 * The fields are in davar/instance.h. */
#ifndef DAVAR_SRC_INSTANCE_H
#define DAVAR_SRC_INSTANCE_H

#include "davar/instance.h"

#include "core/law.h"

#include "number/machine.h"
#include "number/sequence.h"

struct davar_central;
struct davar_rough;

typedef struct davar_number {
    bool wide;                                               /* q31, f32 */
    bool (*collect)(davar_t *davar, davar_result_t *result); /* false: no result waits */
    uint32_t sum_bits;
    uint32_t sample_bits_max;
    uint32_t sample_bits_default;
    uint32_t window_max;
    /* two: of the window, if it has at least window.shortest samples, and of its first part */
    void (*central)(const davar_t *davar, struct davar_central *central);
    void (*first)(const davar_t *davar, struct davar_rough *first); /* of that part */
} davar_number_t;

extern const davar_number_t davar_number_q15;
extern const davar_number_t davar_number_q31;

/* The functions of each pipeline, so that the linker drops those that are not called.
 *   resume    after its memory has been read back: sets every pointer again
 * For a law with a queue:
 *   boundary  a gap that is not counted; false: no room for it, ignored
 *   flows     the next samples need no care: none is near a gap or the start */
#define NUMBER_PIPELINE(type)                                                                      \
    size_t davar_##type##_memory_size(const davar_config_t *config);                               \
    void davar_##type##_start(davar_t *davar, void *memory);                                       \
    void davar_##type##_gap(davar_t *davar);                                                       \
    void davar_##type##_resume(davar_t *davar);                                                    \
    bool davar_##type##_boundary(davar_t *davar);                                                  \
    bool davar_##type##_flows(const davar_t *davar);

NUMBER_PIPELINE(q15)
NUMBER_PIPELINE(q31)

/* Takes samples up to the one that completes a result, without the law's queue. */
size_t davar_q15_feed(davar_t *davar, const int16_t *samples, size_t count);
size_t davar_q31_feed(davar_t *davar, const int32_t *samples, size_t count);

/* The same through the law's queue, if it has one. */
size_t davar_q31_push(davar_t *davar, const int32_t *samples, size_t count);

/* DAVAR_OK or the first reason to reject a configuration, in the order of davar_status_t. */
davar_status_t davar_config_check(const davar_config_t *config, const davar_number_t *number,
                                  bool is_float);

/* davar_init_q31 or, without its scale, davar_init_f32. */
davar_status_t davar_init_wide(davar_t *davar, const davar_config_t *config, void *memory,
                               size_t bytes, bool is_float);

/* davar_gap inside a push. */
void davar_gap_now(davar_t *davar, uint32_t missing);

/* davar->accepts. */
#define ACCEPTS_NONE 0U
#define ACCEPTS_Q15 1U
#define ACCEPTS_Q31 2U
#define ACCEPTS_F32 3U

/* The instance has the pipeline of q31. */
static inline bool is_wide(const davar_t *davar)
{
    return DAVAR_Q31 && (!DAVAR_Q15 || davar->number->wide);
}

/* The largest sample that is not saturated, plus 1; the smallest is its negative. */
static inline int32_t davar_highest(const davar_t *davar)
{
    const uint32_t given = davar->config->sample_bits;
    const davar_number_t *const number = davar->number;
    const uint32_t counts = (given == 0U) ? number->sample_bits_default : given;
    const uint32_t bits = davar->is_float ? number->sample_bits_max : counts;
    return (int32_t)((UINT32_C(1) << (bits - 1U)) - 1U);
}

/* Counts samples that enter no sum. */
static inline void davar_count_missing(davar_t *davar, size_t missing)
{
    davar_count_many(&davar->health.missing, missing);
}

/* False if the caller has a bug: another type, or a push after davar_flush. The samples are counted
 * as missing. */
static inline bool davar_accepts(davar_t *davar, uint8_t type, size_t count)
{
    const bool accepts = (davar->accepts == type);
    DAVAR_ASSERT(accepts);
    if (!accepts) {
        davar_count_missing(davar, count);
    }
    return accepts;
}

/* Clamps a sample to -highest - 1 .. highest. Samples at either end count as saturated. */
static inline int32_t davar_clamp(davar_t *davar, int32_t highest, int32_t sample)
{
    const uint32_t half = (uint32_t)highest;
    if (((uint32_t)sample + half) < (2U * half)) { /* -highest .. highest - 1 */
        return sample;
    }
    davar_count(&davar->health.saturated);
    return (sample < 0) ? (-highest - 1) : highest;
}

static inline void davar_produce(davar_t *davar)
{
    davar->ready = true;
    davar->produced = davar->produced + 1U;
}

/* --- the sequence lock ------------------------------------------------------------------------ */

/* number/sequence.h; `sequence` is odd during a push. */

static inline void davar_change_begin(davar_t *davar)
{
    davar_sequence_begin(&davar->sequence);
}

static inline void davar_change_end(davar_t *davar)
{
    davar_sequence_end(&davar->sequence);
}

static inline uint32_t davar_read_begin(const davar_t *davar)
{
    return davar_sequence_read(&davar->sequence);
}

static inline bool davar_read_torn(const davar_t *davar, uint32_t before)
{
    return davar_sequence_torn(&davar->sequence, before);
}

static inline bool davar_result_waits(const davar_t *davar)
{
    return davar->ready && (davar->produced != davar->seen);
}

/* Results up to `produced` that no take returns. `waits`: the last of them is still available. */
static inline uint32_t davar_missed(const davar_t *davar, uint32_t produced, bool waits)
{
    const uint32_t more = (produced - davar->seen) - (waits ? 1U : 0U);
    const uint32_t room = UINT32_MAX - davar->health.missed;
    return davar->health.missed + ((more < room) ? more : room);
}

#endif
