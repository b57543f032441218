/* davar - what the front door knows of a number type's pipeline, and what the pipelines share. */
#ifndef DAVAR_SRC_NUMBER_TABLE_H
#define DAVAR_SRC_NUMBER_TABLE_H

#include "davar/fit.h"
#include "davar/instance.h"

/* Significant bits of a float sample after the door: full_scale <= 2^30 quanta (2.3). */
#define DAVAR_FLOAT_BITS 31U

typedef struct davar_number {
    size_t (*memory_size)(const davar_config_t *config);
    void (*start)(davar_t *davar, void *memory);
    void (*resume)(davar_t *davar); /* its memory has been read back: lay it out anew */
    void (*gap)(davar_t *davar);
    bool (*flush)(davar_t *davar);
    /* All but the fit, for which the plan is prepared; false: no result waits. */
    bool (*collect)(davar_t *davar, davar_fit_plan_t *plan, davar_result_t *result);
    uint32_t sum_bits;
    uint32_t sample_bits_max;
    uint32_t sample_bits_default;
    uint32_t window_max;
} davar_number_t;

extern const davar_number_t davar_number_q15;
extern const davar_number_t davar_number_q31;

size_t davar_q31_push(davar_t *davar, const int32_t *samples, size_t count);

/* A counter of weather, one up; it stays at its largest value. */
static inline void davar_count(uint32_t *counter)
{
    if (*counter < UINT32_MAX) {
        (*counter)++;
    }
}

static inline void davar_produce(davar_t *davar)
{
    davar->ready = true;
    davar->produced = davar->produced + 1U;
}

#endif
