/* davar - the pipeline of the number type q31. */
#include "number_q31.h"

#include "pipeline.h"

_Static_assert(sizeof(stages_t) <= DAVAR_STAGES_BYTES_Q31, "DAVAR_STAGES_BYTES_Q31 is too small");
_Static_assert(sizeof(tau_t) <= 32U, "DAVAR_MEMORY_Q31 counts too little per tau");

const davar_number_t davar_number_q31 = PIPELINE_NUMBER;

size_t davar_q31_push(davar_t *davar, const sample_t *samples, size_t count)
{
    return pipeline_push(davar, samples, count);
}
