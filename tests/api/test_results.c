/* davar tests - the counters of a stream, its longest clusters, and the series of cluster sizes. */
#include "davar/davar.h"
#include "davar/fit.h"
#include "stream_fixture.h"
#include "unity.h"

#include <math.h>

static void push_untaken(uint32_t from, uint32_t to)
{
    for (uint32_t i = from; i < to; i++) {
        const int16_t sample = ripple(i);
        davar_push_q15(&davar, &sample, 1U);
    }
}

static void test_results_that_were_not_taken_or_lost_to_a_restart_are_counted(void)
{
    config.window.gaps_max = 0U;
    start_q15();
    push_untaken(0U, 30U); /* the first result comes with sample 20 */
    TEST_ASSERT_EQUAL_UINT32(10U, davar_health(&davar).missed);
    TEST_ASSERT_TRUE(take_fitted(&davar, &result));
    TEST_ASSERT_EQUAL_UINT64(29U, result.epoch);
    TEST_ASSERT_FALSE(result.chosen); /* only law glr sets it */
    TEST_ASSERT_FALSE(take_fitted(&davar, &result));
    push_untaken(30U, 31U);
    davar_gap(&davar, 1U);
    TEST_ASSERT_EQUAL_UINT32(11U, davar_health(&davar).missed);
    TEST_ASSERT_FALSE(take_fitted(&davar, &result));
    TEST_ASSERT_EQUAL_UINT32(1U, feed(31U, 51U));
    TEST_ASSERT_EQUAL_UINT32(11U, davar_health(&davar).missed);
}

static void test_counters_stay_at_their_largest_value(void)
{
    start_q15();
    davar.health.saturated = UINT32_MAX;
    davar.health.missed = UINT32_MAX - 4U;
    const int16_t rail = INT16_MAX;
    davar_push_q15(&davar, &rail, 1U);
    for (uint32_t i = 1U; i < 30U; i++) {
        const uint32_t left = (i < 20U) ? 4U : ((i < 24U) ? (24U - i - 1U) : 0U);
        push_untaken(i, i + 1U);
        TEST_ASSERT_EQUAL_UINT32(UINT32_MAX - left, davar_health(&davar).missed);
    }
    davar_gap(&davar, 1U);
    davar_gap(&davar, UINT32_MAX);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, davar_health(&davar).missing);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, davar_health(&davar).saturated);
}

/* Also where the window slides, and where only that happens. */
static void test_an_empty_push_consumes_nothing(void)
{
    const int16_t sample = 0;
    for (uint32_t turn = 0U; turn < 2U; turn++) {
        start_q15();
        TEST_ASSERT_EQUAL_size_t(0U, davar_push_until_result_q15(&davar, &sample, 0U));
        (void)feed(0U, 120U);
        TEST_ASSERT_EQUAL_size_t(0U, davar_push_until_result_q15(&davar, &sample, 0U));
        TEST_ASSERT_FALSE(take_fitted(&davar, &result));
        config.law = NULL;
        config.moments.segment = 0U;
    }
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
    RUN_TEST(test_results_that_were_not_taken_or_lost_to_a_restart_are_counted);
    RUN_TEST(test_counters_stay_at_their_largest_value);
    RUN_TEST(test_an_empty_push_consumes_nothing);
    RUN_TEST(test_saturated_samples_are_counted_and_clamped);
    RUN_TEST(test_the_longest_clusters);
    RUN_TEST(test_octaves_stop_at_a_ninth_of_the_window);
    RUN_TEST(test_the_geometric_series_is_distinct_and_ends_at_a_ninth_of_the_window);
    return UNITY_END();
}
