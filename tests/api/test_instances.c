/* davar tests - several instances in parallel, with or without a shared plan. */
#include "stream_fixture.h"

#include <string.h>

static void test_instances_do_not_touch_each_other(void)
{
    static uint64_t other_memory[4096];
    davar_t other;
    start_q15();
    (void)feed(0U, 70U);
    const davar_result_t alone = result;
    start_q15();
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_f32(&other, &config, other_memory, sizeof other_memory));
    for (uint32_t i = 0U; i < 70U; i++) {
        const float rate = (float)i;
        davar_push_f32(&other, &rate, 1U);
        (void)feed(i, i + 1U);
    }
    TEST_ASSERT_EQUAL_DOUBLE(alone.tau[2].adev, result.tau[2].adev);
    TEST_ASSERT_EQUAL_DOUBLE(alone.kurtosis, result.kurtosis);
}

/* About normal, but four times as loud in every other 97 samples, so that the window changes its
 * length. */
static int16_t breathing(uint32_t i)
{
    const int32_t sum =
        ripple(i) + ripple(3U * i + 1U) + ripple(11U * i + 5U) + ripple(17U * i + 7U);
    return (int16_t)(((i / 97U) % 2U) != 0U ? 4 * sum : sum);
}

static bool take_planned(davar_t *from, davar_plan_t *plan, davar_result_t *to)
{
    const bool waits = davar_take(from, to);
    if (waits) {
        davar_fit(plan, config.rate_hz, to);
    }
    return waits;
}

/* One plan for instances with different windows and gaps, or no plan: the fit is a pure
 * function. */
static void test_results_do_not_depend_on_the_plan(void)
{
    static uint64_t planned_memory[2][1024];
    static davar_plan_t plan;
    davar_t planned[2];
    davar_result_t expected;
    uint32_t results = 0U;
    uint32_t shortest = UINT32_MAX;
    uint32_t longest = 0U;
    uint32_t gaps = 0U;
    davar_plan_init_white(&plan, config.taus, config.tau_count);
    start_q15();
    for (uint32_t k = 0U; k < 2U; k++) {
        TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&planned[k], &config, planned_memory[k],
                                                   sizeof planned_memory[k]));
    }
    for (uint32_t i = 0U; i < 600U; i++) {
        const int16_t sample = breathing(i);
        const int16_t other = ripple(i);
        if (i % 150U == 149U) {
            davar_gap(&planned[0], 3U);
            davar_gap(&davar, 3U);
        }
        davar_push_q15(&planned[1], &other, 1U);
        (void)take_planned(&planned[1], &plan, &result);
        davar_push_q15(&planned[0], &sample, 1U);
        davar_push_q15(&davar, &sample, 1U);
        memset(&expected, 0, sizeof expected);
        memset(&result, 0, sizeof result);
        const bool taken = take_planned(&planned[0], &plan, &expected);
        TEST_ASSERT_EQUAL(taken, take_fitted(&davar, &result));
        TEST_ASSERT_EQUAL_MEMORY(&expected, &result, sizeof expected);
        if (taken) {
            results++;
            shortest = (result.window_samples < shortest) ? result.window_samples : shortest;
            longest = (result.window_samples > longest) ? result.window_samples : longest;
            gaps += (result.gaps_in_window > 0U) ? 1U : 0U;
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT32(300U, results);
    TEST_ASSERT_LESS_THAN_UINT32(longest, shortest);
    TEST_ASSERT_GREATER_THAN_UINT32(20U, gaps);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_instances_do_not_touch_each_other);
    RUN_TEST(test_results_do_not_depend_on_the_plan);
    return UNITY_END();
}
