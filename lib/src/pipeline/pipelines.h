/* davar - what the front door knows of the number types' pipelines, and what those share. */
#ifndef DAVAR_SRC_NUMBER_TABLE_H
#define DAVAR_SRC_NUMBER_TABLE_H

#include "davar/instance.h"

/* Significant bits of a float sample after the door: full_scale <= 2^30 quanta (2.3). */
#define DAVAR_FLOAT_BITS 31U

typedef struct davar_number {
    bool wide;                                               /* q31, f32 */
    bool (*collect)(davar_t *davar, davar_result_t *result); /* false: no result waits */
    uint32_t sum_bits;
    uint32_t sample_bits_max;
    uint32_t sample_bits_default;
    uint32_t window_max;
} davar_number_t;

extern const davar_number_t davar_number_q15;
extern const davar_number_t davar_number_q31;

/* The pipelines, function by function: what nobody calls is not linked. */
#define NUMBER_PIPELINE(type)                                                                                          \
    size_t davar_##type##_memory_size(const davar_config_t *config);                                                   \
    void davar_##type##_start(davar_t *davar, void *memory);                                                           \
    void davar_##type##_gap(davar_t *davar);                                                                           \
    bool davar_##type##_flush(davar_t *davar);                                                                         \
    void davar_##type##_resume(davar_t *davar); /* its memory has been read back: lay it out anew */

NUMBER_PIPELINE(q15)
NUMBER_PIPELINE(q31)

size_t davar_q31_push(davar_t *davar, const int32_t *samples, size_t count);

/* davar->accepts. */
#define ACCEPTS_NONE 0U
#define ACCEPTS_Q15 1U
#define ACCEPTS_Q31 2U
#define ACCEPTS_F32 3U

/* Which of them an instance has. */
static inline bool is_wide(const davar_t *davar)
{
    return DAVAR_Q31 && (!DAVAR_Q15 || davar->number->wide);
}

/* A counter of weather, one up; it stays at its largest value. */
static inline void davar_count(uint32_t *counter)
{
    if (*counter < UINT32_MAX) {
        (*counter)++;
    }
}

/* Samples that no sum will hold. */
static inline void davar_count_missing(davar_t *davar, size_t missing)
{
    const uint32_t room = UINT32_MAX - davar->health.missing;
    davar->health.missing += (missing < room) ? (uint32_t)missing : room;
}

/* Does this instance accept a push of this type now? It does unless the caller has a bug; then the samples are counted. */
static inline bool davar_accepts(davar_t *davar, uint8_t type, size_t count)
{
    const bool accepts = (davar->accepts == type);
    DAVAR_ASSERT(accepts);
    if (!accepts) {
        davar_count_missing(davar, count);
    }
    return accepts;
}

static inline void davar_produce(davar_t *davar)
{
    davar->ready = true;
    davar->produced = davar->produced + 1U;
}

#endif
