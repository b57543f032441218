/* davar tests - the results of a stream, its counters, gaps and restarts, and the series of cluster
 * sizes. */
#include "davar/davar.h"
#include "stream_fixture.h"
#include "unity.h"

#include <math.h>
#include <string.h>

static void test_results_that_were_not_taken_are_counted(void)
{
    start_q15();
    for (uint32_t i = 0U; i < 30U; i++) { /* the first result comes with sample 20 */
        const int16_t sample = ripple(i);
        davar_push_q15(&davar, &sample, 1U);
    }
    TEST_ASSERT_EQUAL_UINT32(10U, davar_health(&davar).missed);
    TEST_ASSERT_TRUE(take_fitted(&davar, &result));
    TEST_ASSERT_EQUAL_UINT64(29U, result.epoch);
    TEST_ASSERT_FALSE(result.young); /* only law glr sets it */
    TEST_ASSERT_FALSE(take_fitted(&davar, &result));
}

static void test_the_count_of_them_stays_at_its_end(void)
{
    start_q15();
    davar.health.missed = UINT32_MAX - 4U;
    (void)feed(0U, 1U);
    for (uint32_t i = 1U; i < 30U; i++) {
        const int16_t sample = ripple(i);
        davar_push_q15(&davar, &sample, 1U);
        TEST_ASSERT_EQUAL_UINT32(UINT32_MAX - ((i < 20U)   ? 4U
                                               : (i < 24U) ? (24U - i - 1U)
                                                           : 0U),
                                 davar_health(&davar).missed);
    }
}

static void test_a_block_push_stops_at_each_result(void)
{
    int16_t block[64];
    for (uint32_t i = 0U; i < 64U; i++) {
        block[i] = ripple(i);
    }
    config.stride = 10U;
    start_q15();
    TEST_ASSERT_EQUAL_size_t(0U, davar_push_until_result_q15(&davar, block, 0U));
    TEST_ASSERT_EQUAL_size_t(
        20U, davar_push_until_result_q15(&davar, block, 64U)); /* the shortest window */
    TEST_ASSERT_TRUE(take_fitted(&davar, &result));
    TEST_ASSERT_EQUAL_UINT64(19U, result.epoch);
    TEST_ASSERT_EQUAL_size_t(10U, davar_push_until_result_q15(&davar, &block[20], 44U));
    config.law = NULL; /* the window only slides */
    config.moments.segment = 0U;
    start_q15();
    (void)feed(0U, 100U);
    for (uint64_t epoch = 109U; epoch < 139U; epoch += 10U) {
        TEST_ASSERT_EQUAL_size_t(10U, davar_push_until_result_q15(&davar, block, 64U));
        TEST_ASSERT_TRUE(take_fitted(&davar, &result));
        TEST_ASSERT_EQUAL_UINT64(epoch, result.epoch);
    }
}

static void test_an_empty_push_consumes_nothing(void)
{
    const int16_t sample = 0;
    start_q15();
    TEST_ASSERT_EQUAL_size_t(0U, davar_push_until_result_q15(&davar, &sample, 0U));
    (void)feed(0U, 60U); /* the window slides now */
    TEST_ASSERT_EQUAL_size_t(0U, davar_push_until_result_q15(&davar, &sample, 0U));
    TEST_ASSERT_FALSE(take_fitted(&davar, &result));
    config.law = NULL; /* and only that happens */
    config.moments.segment = 0U;
    start_q15();
    (void)feed(0U, 120U);
    TEST_ASSERT_EQUAL_size_t(0U, davar_push_until_result_q15(&davar, &sample, 0U));
    TEST_ASSERT_FALSE(take_fitted(&davar, &result));
}

static void test_saturated_samples_are_counted_and_clamped(void)
{
    config.sample_bits = 12U;
    start_q15();
    const int16_t samples[5] = {2046, 2047, 2048, -2048, -3000};
    for (unsigned i = 0U; i < 5U; i++) {
        davar_push_q15(&davar, &samples[i], 1U);
    }
    TEST_ASSERT_EQUAL_UINT32(4U, davar_health(&davar).saturated);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q31(&davar, &config, memory, sizeof memory));
    const int32_t wide[3] = {2046, 5000, -5000};
    davar_push_q31(&davar, wide, 3U);
    TEST_ASSERT_EQUAL_UINT32(2U, davar_health(&davar).saturated);
}

static void test_counters_stay_at_their_largest_value(void)
{
    start_q15();
    davar.health.saturated = UINT32_MAX;
    const int16_t rail = INT16_MAX;
    davar_push_q15(&davar, &rail, 1U);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, davar_health(&davar).saturated);
}

static void test_a_flush_has_no_result_and_changes_nothing(void)
{
    start_q15();
    TEST_ASSERT_FALSE(davar_flush(&davar));
    TEST_ASSERT_EQUAL_UINT32(81U, feed(0U, 100U));
    TEST_ASSERT_FALSE(davar_flush(&davar));
    TEST_ASSERT_EQUAL_UINT32(1U, feed(100U, 101U));
    TEST_ASSERT_EQUAL_UINT64(100U, result.epoch);
}

static void test_moments_can_be_switched_off_with_the_fixed_window(void)
{
    config.law = NULL;
    config.moments.segment = 0U;
    config.engine = &davar_engine_grid_q15;
    for (uint32_t stride = 1U; stride < 3U; stride++) {
        config.stride = stride;
        start_q15();
        (void)feed(0U, 70U);
        TEST_ASSERT_TRUE(isnan(result.kurtosis) && isnan(result.contribution) && !result.unstable);
        TEST_ASSERT_TRUE(result.tau[0].adev > 0.0);
    }
    const double by_grid = result.tau[0].adev;
    config.engine = NULL;
    start_q15();
    (void)feed(0U, 70U);
    TEST_ASSERT_TRUE(isnan(result.kurtosis));
    TEST_ASSERT_EQUAL_DOUBLE(by_grid, result.tau[0].adev);
}

/* Differences of clusters so long that 2 m^2 n exceeds the fast path. */
static void test_the_longest_clusters(void)
{
    enum { M = 20000 };
    static const uint32_t longest[] = {M};
    static uint64_t room[(4 * (4 * M + 64)) / 8 + 200];
    config = small_config(longest, 1U);
    config.law = NULL;
    config.moments.segment = 0U;
    config.window.longest = 2U * M + 2U;
    config.window.shortest = config.window.longest;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q31(&davar, &config, room, sizeof room));
    for (uint32_t i = 0U; i < config.window.longest; i++) {
        const int32_t sample = (i <= M) ? 0 : 7;
        davar_push_q31(&davar, &sample, 1U);
    }
    TEST_ASSERT_TRUE(davar_take(&davar, &result));
    TEST_ASSERT_EQUAL_UINT32(3U, result.tau[0].differences);
    const double middle = 7.0 * M; /* the neighbours contain one sample less of the step */
    const double sum = middle * middle + 2.0 * (middle - 7.0) * (middle - 7.0);
    const double m = M;
    TEST_ASSERT_EQUAL_DOUBLE(config.unit_per_count * sqrt(sum / (2.0 * m * m * 3.0)),
                             result.tau[0].adev);
    TEST_ASSERT_TRUE(isnan(result.tau[0].edf) &&
                     isnan(result.tau[0].high)); /* nothing is fitted yet */
    TEST_ASSERT_TRUE(!result.coefficient[0].present && isinf(result.coefficient[0].high));
}

static void test_too_many_gaps_restart_the_window_and_keep_the_count_of_samples(void)
{
    config.law = NULL;
    config.window.gaps_max = 2U;
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
    /* The restart came before sample 62. The next boundary of the grid is 63, and the first window
     * of >= 20 samples ends with the block 77 .. 83. */
    uint32_t i = 63U;
    while (feed(i, i + 1U) == 0U) {
        i++;
    }
    TEST_ASSERT_EQUAL_UINT64(83U, result.epoch);
    TEST_ASSERT_EQUAL_UINT32(21U, result.window_samples);
    TEST_ASSERT_EQUAL_UINT32(0U, result.gaps_in_window);
}

static void test_a_restart_loses_a_waiting_result_and_counts_it(void)
{
    config.window.gaps_max = 0U;
    start_q15();
    for (uint32_t i = 0U; i < 20U; i++) {
        const int16_t sample = ripple(i);
        davar_push_q15(&davar, &sample, 1U);
    }
    davar_gap(&davar, 1U);
    TEST_ASSERT_EQUAL_UINT32(1U, davar_health(&davar).missed);
    TEST_ASSERT_FALSE(take_fitted(&davar, &result));
    TEST_ASSERT_EQUAL_UINT32(1U, feed(20U, 40U));
    TEST_ASSERT_EQUAL_UINT32(1U, davar_health(&davar).missed);
}

static void test_gaps_at_the_start_or_twice_in_one_place_count_at_most_once(void)
{
    config.law = NULL;
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

static uint32_t series[DAVAR_TAUS_MAX];

static void test_octaves_stop_at_a_ninth_of_the_window(void)
{
    TEST_ASSERT_EQUAL_UINT8(0U, davar_taus_octave(1U, series, DAVAR_TAUS_MAX));
    TEST_ASSERT_EQUAL_UINT8(1U, davar_taus_octave(2U, series, DAVAR_TAUS_MAX));
    TEST_ASSERT_EQUAL_UINT8(7U, davar_taus_octave(600U, series, DAVAR_TAUS_MAX));
    TEST_ASSERT_EQUAL_UINT32(64U, series[6]);
    TEST_ASSERT_EQUAL_UINT8(6U, davar_taus_octave(575U, series, DAVAR_TAUS_MAX));
    TEST_ASSERT_EQUAL_UINT8(3U, davar_taus_octave(600U, series, 3U));
}

static void test_the_geometric_series_is_distinct_and_ends_at_a_ninth_of_the_window(void)
{
    TEST_ASSERT_EQUAL_UINT8(0U, davar_taus_geometric(1U, 5U, series, DAVAR_TAUS_MAX));
    TEST_ASSERT_EQUAL_UINT8(0U, davar_taus_geometric(600U, 0U, series, DAVAR_TAUS_MAX));
    for (uint32_t window = 2U; window < 20000U; window += 1U + (window / 7U)) {
        for (uint8_t wanted = 1U; wanted <= DAVAR_TAUS_MAX; wanted++) {
            const uint8_t count = davar_taus_geometric(window, wanted, series, DAVAR_TAUS_MAX);
            TEST_ASSERT_TRUE((count >= 1U) && (count <= wanted));
            TEST_ASSERT_EQUAL_UINT32(1U, series[0]);
            for (uint8_t t = 1U; t < count; t++) {
                TEST_ASSERT_TRUE(series[t] > series[t - 1U]);
            }
            if (wanted > 1U) {
                TEST_ASSERT_EQUAL_UINT32((window < 18U) ? 1U : (window / 9U), series[count - 1U]);
            }
        }
    }
    TEST_ASSERT_EQUAL_UINT8(2U, davar_taus_geometric(5400U, 12U, series, 2U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_results_that_were_not_taken_are_counted);
    RUN_TEST(test_the_count_of_them_stays_at_its_end);
    RUN_TEST(test_a_block_push_stops_at_each_result);
    RUN_TEST(test_an_empty_push_consumes_nothing);
    RUN_TEST(test_saturated_samples_are_counted_and_clamped);
    RUN_TEST(test_counters_stay_at_their_largest_value);
    RUN_TEST(test_a_flush_has_no_result_and_changes_nothing);
    RUN_TEST(test_moments_can_be_switched_off_with_the_fixed_window);
    RUN_TEST(test_the_longest_clusters);
    RUN_TEST(test_too_many_gaps_restart_the_window_and_keep_the_count_of_samples);
    RUN_TEST(test_a_restart_loses_a_waiting_result_and_counts_it);
    RUN_TEST(test_gaps_at_the_start_or_twice_in_one_place_count_at_most_once);
    RUN_TEST(test_octaves_stop_at_a_ninth_of_the_window);
    RUN_TEST(test_the_geometric_series_is_distinct_and_ends_at_a_ninth_of_the_window);
    return UNITY_END();
}
