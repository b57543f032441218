/* davar - the pipeline of the number type q15. */
#include "number/q15.inc"

#include "number/q15_moments.inc"

#include "core/pages.inc"
#include "davar/davar.h"

_Static_assert(sizeof(stages_t) <= DAVAR_STAGES_BYTES(1U), "DAVAR_STAGES_BYTES is too small");
_Static_assert(sizeof(tau_t) <= 16U, "DAVAR_MEMORY counts too little per tau");

const davar_number_t davar_number_q15 = PIPELINE_NUMBER(false);

size_t davar_push_until_result_q15(davar_t *davar, const int16_t *counts, size_t count)
{
    if (!davar_accepts(davar, ACCEPTS_Q15, count)) {
        return count;
    }
    davar_change_begin(davar);
    const size_t taken = pipeline_push(davar, counts, count);
    davar_change_end(davar);
    return taken;
}

void davar_push_q15(davar_t *davar, const int16_t *counts, size_t count)
{
    if (davar_accepts(davar, ACCEPTS_Q15, count)) {
        davar_change_begin(davar);
        pipeline_push_all(davar, counts, count);
        davar_change_end(davar);
    }
}
