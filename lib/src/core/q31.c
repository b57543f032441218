/* davar - the pipeline of the number type q31. */
#include "number/q31.inc"

#include "davar/davar.h"
#include "number/q31_moments.inc"

#define PUSH davar_push_q31
#define PUSH_UNTIL_RESULT davar_push_until_result_q31
#define ACCEPTS ACCEPTS_Q31

#include "core/pages.inc"

_Static_assert(sizeof(stages_t) <= DAVAR_STAGES_BYTES(2U), "DAVAR_STAGES_BYTES is too small");
_Static_assert(sizeof(tau_t) <= 32U, "DAVAR_MEMORY counts too little per tau");

const davar_number_t davar_number_q31 = PIPELINE_NUMBER(true);

/* For float samples, after core/f32.c has converted them to counts. */
size_t davar_q31_push(davar_t *davar, const sample_t *samples, size_t count)
{
    return pipeline_push(davar, samples, count);
}
