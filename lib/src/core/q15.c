/* davar - the pipeline of the number type q15. */
#include "number/q15.inc"

#include "davar/davar.h"
#include "number/q15_moments.inc"

#define PUSH davar_push_q15
#define PUSH_UNTIL_RESULT davar_push_until_result_q15
#define ACCEPTS ACCEPTS_Q15

#include "core/pages.inc"

_Static_assert(sizeof(stages_t) <= DAVAR_STAGES_BYTES(1U), "DAVAR_STAGES_BYTES is too small");
_Static_assert((sizeof(tau_t) == 16U) && (offsetof(tau_t, head) == 8U),
               "fours_avx2 and DAVAR_MEMORY count on this layout");

const davar_number_t davar_number_q15 = PIPELINE_NUMBER(false);
