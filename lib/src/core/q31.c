/* davar - the pipeline of the number type q31. */
#include "number/q31.inc"

#include "number/q31_moments.inc"

#include "core/pages.inc"
#include "davar/davar.h"

_Static_assert(sizeof(stages_t) <= DAVAR_STAGES_BYTES(2U), "DAVAR_STAGES_BYTES is too small");
_Static_assert(sizeof(tau_t) <= 32U, "DAVAR_MEMORY counts too little per tau");

const davar_number_t davar_number_q31 = PIPELINE_NUMBER(true);

/* For float samples, after core/f32.c has converted them to counts. */
size_t davar_q31_push(davar_t *davar, const sample_t *samples, size_t count)
{
    return pipeline_push(davar, samples, count);
}

size_t davar_push_until_result_q31(davar_t *davar, const int32_t *counts, size_t count)
{
    if (!davar_accepts(davar, ACCEPTS_Q31, count)) {
        return count;
    }
    davar_change_begin(davar);
    const size_t taken = pipeline_push(davar, counts, count);
    davar_change_end(davar);
    return taken;
}

void davar_push_q31(davar_t *davar, const int32_t *counts, size_t count)
{
    if (davar_accepts(davar, ACCEPTS_Q31, count)) {
        davar_change_begin(davar);
        pipeline_push_all(davar, counts, count);
        davar_change_end(davar);
    }
}
