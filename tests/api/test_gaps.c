/* davar tests - missing samples: a boundary inside the window, or a window that begins anew. */
#include "stream_fixture.h"

static void test_too_many_gaps_restart_the_window_and_keep_the_count_of_samples(void)
{
    config.mode = DAVAR_MODE_TRAILING;
    config.policy = DAVAR_POLICY_FIXED;
    config.gaps_max = 2U;
    config.stride = 7U;
    start_q15();
    (void)feed(0U, 60U);
    for (uint32_t g = 0U; g < 3U; g++) {
        davar_gap(&davar, 5U);
        (void)feed(60U + g, 61U + g);
    }
    TEST_ASSERT_EQUAL_UINT32(1U, davar_health(&davar).restarts);
    TEST_ASSERT_EQUAL_UINT32(3U, davar_health(&davar).gaps);
    TEST_ASSERT_EQUAL_UINT32(15U, davar_health(&davar).missing);
    /* The restart came in front of sample 62; the next boundary of the grid is 63, the first window of >= 20 samples
     * ends with the block 77 .. 83. */
    uint32_t i = 63U;
    while (feed(i, i + 1U) == 0U) {
        i++;
    }
    TEST_ASSERT_EQUAL_UINT64(83U, result.epoch);
    TEST_ASSERT_EQUAL_UINT32(21U, result.window_samples);
    TEST_ASSERT_EQUAL_UINT32(0U, result.gaps_in_window);
}

static void test_a_restart_in_centred_mode_continues_the_epochs(void)
{
    config.gaps_max = 0U;
    start_q15();
    (void)feed(0U, 100U);
    davar_gap(&davar, 1U);
    TEST_ASSERT_EQUAL_UINT32(1U, davar_health(&davar).restarts);
    TEST_ASSERT_FALSE(take_fitted(&davar, &result));
    TEST_ASSERT_EQUAL_UINT32(0U, feed(100U, 119U));
    TEST_ASSERT_EQUAL_UINT32(1U, feed(119U, 120U));
    TEST_ASSERT_EQUAL_UINT64(100U, result.epoch);
}

static void test_a_restart_at_any_moment_keeps_the_grid_of_epochs(void)
{
    config.gaps_max = 0U;
    config.stride = 7U;
    for (uint32_t before = 1U; before < 160U; before++) {
        config.mode = ((before % 2U) == 0U) ? DAVAR_MODE_CENTRED : DAVAR_MODE_TRAILING;
        start_q15();
        (void)feed(0U, before / 2U + 1U);
        davar_gap(&davar, 1U);
        uint32_t i = before / 2U + 4U;
        (void)feed(before / 2U + 1U, i);
        davar_gap(&davar, 1U); /* restarts again, or falls among samples that are left out */
        while (feed(i, i + 1U) == 0U) {
            i++;
        }
        TEST_ASSERT_EQUAL_UINT64(6U, result.epoch % 7U);
    }
}

static void test_a_restart_loses_a_waiting_result_and_counts_it(void)
{
    config.gaps_max = 0U;
    start_q15();
    for (uint32_t i = 0U; i < 20U; i++) {
        const int16_t sample = ripple(i);
        (void)davar_push_q15(&davar, &sample, 1U);
    }
    davar_gap(&davar, 1U);
    TEST_ASSERT_EQUAL_UINT32(1U, davar_health(&davar).missed);
    TEST_ASSERT_FALSE(take_fitted(&davar, &result));
    TEST_ASSERT_EQUAL_UINT32(1U, feed(20U, 40U));
    TEST_ASSERT_EQUAL_UINT32(1U, davar_health(&davar).missed);
}

static void test_the_result_says_how_many_differences_a_gap_left(void)
{
    config.policy = DAVAR_POLICY_FIXED;
    start_q15();
    (void)feed(0U, 50U);
    davar_gap(&davar, 3U);
    (void)feed(50U, 70U);
    TEST_ASSERT_EQUAL_UINT64(50U, result.epoch);
    TEST_ASSERT_EQUAL_UINT32(1U, result.gaps_in_window);
    for (uint32_t t = 0U; t < TAUS; t++) {
        const uint32_t m = taus[t];
        const uint32_t spans = result.window_samples - (2U * m) + 1U;
        TEST_ASSERT_EQUAL_UINT32(spans - ((2U * m) - 1U), result.tau[t].differences);
    }
}

static void test_gaps_before_the_first_sample_or_twice_in_one_place_are_one_boundary_or_none(void)
{
    config.policy = DAVAR_POLICY_FIXED;
    start_q15();
    davar_gap(&davar, 1U);
    (void)feed(0U, 30U);
    TEST_ASSERT_EQUAL_UINT32(0U, result.gaps_in_window);
    davar_gap(&davar, 1U);
    davar_gap(&davar, UINT32_MAX);
    (void)feed(30U, 40U);
    TEST_ASSERT_EQUAL_UINT32(1U, result.gaps_in_window);
    TEST_ASSERT_EQUAL_UINT32(3U, davar_health(&davar).gaps);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, davar_health(&davar).missing);
}

static void test_a_gap_behind_the_last_sample_is_none(void)
{
    start_q15();
    (void)feed(0U, 100U);
    davar_gap(&davar, 1U);
    TEST_ASSERT_TRUE(davar_flush(&davar));
    TEST_ASSERT_TRUE(take_fitted(&davar, &result));
    TEST_ASSERT_EQUAL_UINT32(0U, result.gaps_in_window);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_too_many_gaps_restart_the_window_and_keep_the_count_of_samples);
    RUN_TEST(test_a_restart_in_centred_mode_continues_the_epochs);
    RUN_TEST(test_a_restart_at_any_moment_keeps_the_grid_of_epochs);
    RUN_TEST(test_a_restart_loses_a_waiting_result_and_counts_it);
    RUN_TEST(test_the_result_says_how_many_differences_a_gap_left);
    RUN_TEST(test_gaps_before_the_first_sample_or_twice_in_one_place_are_one_boundary_or_none);
    RUN_TEST(test_a_gap_behind_the_last_sample_is_none);
    return UNITY_END();
}
