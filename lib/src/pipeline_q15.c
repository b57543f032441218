/* davar - the pipeline of the number type q15. */
#include "number_q15.h"

#include "pipeline.h"

_Static_assert(sizeof(stages_t) <= DAVAR_STAGES_BYTES_Q15, "DAVAR_STAGES_BYTES_Q15 is too small");
_Static_assert(sizeof(tau_t) <= 16U, "DAVAR_MEMORY_Q15 counts too little per tau");

const davar_number_t davar_number_q15 = PIPELINE_NUMBER;

size_t davar_q15_push(davar_t *davar, const sample_t *samples, size_t count)
{
    return pipeline_push(davar, samples, count);
}
