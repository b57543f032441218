/* davar - a block and all its results in one call. */
#include "davar/davar.h"

static void hear_result(davar_t *davar, davar_result_t *result, davar_hear_t hear, void *context)
{
    if (davar_take(davar, result)) {
        hear(context, result);
    }
}

void davar_push_all_q15(davar_t *davar, const int16_t *counts, size_t count, davar_result_t *result, davar_hear_t hear,
                        void *context)
{
    size_t done = 0U;
    for (size_t more = 1U; (done < count) && (more > 0U); done += more) {
        more = davar_push_q15(davar, &counts[done], count - done);
        hear_result(davar, result, hear, context);
    }
}

void davar_push_all_q31(davar_t *davar, const int32_t *counts, size_t count, davar_result_t *result, davar_hear_t hear,
                        void *context)
{
    size_t done = 0U;
    for (size_t more = 1U; (done < count) && (more > 0U); done += more) {
        more = davar_push_q31(davar, &counts[done], count - done);
        hear_result(davar, result, hear, context);
    }
}

void davar_push_all_f32(davar_t *davar, const float *rates, size_t count, davar_result_t *result, davar_hear_t hear,
                        void *context)
{
    size_t done = 0U;
    for (size_t more = 1U; (done < count) && (more > 0U); done += more) {
        more = davar_push_f32(davar, &rates[done], count - done);
        hear_result(davar, result, hear, context);
    }
}
