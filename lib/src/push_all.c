/* davar - a block and all its results in one call. */
#include "davar/davar.h"

static void report(davar_t *davar, davar_result_t *result, davar_on_result_t on_result, void *context)
{
    if (davar_take(davar, result)) {
        on_result(context, result);
    }
}

void davar_push_all_q15(davar_t *davar, const int16_t *counts, size_t count, davar_result_t *result,
                        davar_on_result_t on_result, void *context)
{
    size_t done = 0U;
    while (done < count) {
        const size_t n = davar_push_until_result_q15(davar, &counts[done], count - done);
        DAVAR_ASSERT((n > 0U) && (n <= (count - done)));
        done += n;
        report(davar, result, on_result, context);
    }
}

void davar_push_all_q31(davar_t *davar, const int32_t *counts, size_t count, davar_result_t *result,
                        davar_on_result_t on_result, void *context)
{
    size_t done = 0U;
    while (done < count) {
        const size_t n = davar_push_until_result_q31(davar, &counts[done], count - done);
        DAVAR_ASSERT((n > 0U) && (n <= (count - done)));
        done += n;
        report(davar, result, on_result, context);
    }
}

void davar_push_all_f32(davar_t *davar, const float *rates, size_t count, davar_result_t *result,
                        davar_on_result_t on_result, void *context)
{
    size_t done = 0U;
    while (done < count) {
        const size_t n = davar_push_until_result_f32(davar, &rates[done], count - done);
        DAVAR_ASSERT((n > 0U) && (n <= (count - done)));
        done += n;
        report(davar, result, on_result, context);
    }
}
