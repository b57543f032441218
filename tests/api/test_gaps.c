/* davar tests - missing samples: a boundary inside the window, or a restart of the window. */
#include "stream_fixture.h"

#include <math.h>
#include <string.h>

static void test_too_many_gaps_restart_the_window_and_keep_the_count_of_samples(void)
{
    config.window.mode = DAVAR_MODE_TRAILING;
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

static void test_a_restart_in_centred_mode_continues_the_epochs(void)
{
    config.window.gaps_max = 0U;
    start_q15();
    (void)feed(0U, 100U);
    davar_gap(&davar, 1U);
    TEST_ASSERT_EQUAL_UINT32(1U, davar_health(&davar).restarts);
    TEST_ASSERT_FALSE(take_fitted(&davar, &result));
    TEST_ASSERT_EQUAL_UINT32(0U, feed(100U, 119U));
    TEST_ASSERT_EQUAL_UINT32(1U, feed(119U, 120U));
    TEST_ASSERT_EQUAL_UINT64(100U, result.epoch);
}

static void restart_at_any_moment(davar_engine_t engine)
{
    config.engine = engine;
    for (uint32_t before = 1U; before < 160U; before++) {
        config.window.mode = ((before % 2U) == 0U) ? DAVAR_MODE_CENTRED : DAVAR_MODE_TRAILING;
        start_q15();
        (void)feed(0U, before / 2U + 1U);
        davar_gap(&davar, 1U);
        uint32_t i = before / 2U + 4U;
        (void)feed(before / 2U + 1U, i);
        davar_gap(&davar, 1U); /* restarts again, or falls among skipped samples */
        while (feed(i, i + 1U) == 0U) {
            i++;
        }
        TEST_ASSERT_EQUAL_UINT64(6U, result.epoch % 7U);
    }
}

static void test_a_restart_at_any_moment_keeps_the_grid_of_epochs(void)
{
    config.window.gaps_max = 0U;
    config.stride = 7U;
    restart_at_any_moment(DAVAR_ENGINE_AUTO);
    restart_at_any_moment(DAVAR_ENGINE_GRID);
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

static void test_the_result_counts_the_differences_at_a_gap(void)
{
    config.law = NULL;
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

#define MIRRORED 40U /* largest number of results of a flush */

static void test_a_gap_after_the_last_sample_does_not_count(void)
{
    static davar_result_t whole[MIRRORED];
    for (uint32_t lost = 0U; lost < 2U; lost++) {
        uint32_t results = 0U;
        start_q15();
        (void)feed(0U, 100U);
        if (lost > 0U) {
            davar_gap(&davar, lost);
        }
        while (davar_flush(&davar)) {
            TEST_ASSERT_LESS_THAN_UINT32(MIRRORED, results);
            memset(&result, 0, sizeof result);
            TEST_ASSERT_TRUE(take_fitted(&davar, &result));
            TEST_ASSERT_EQUAL_UINT32(0U, result.gaps_in_window);
            if (lost == 0U) {
                whole[results] = result;
            }
            TEST_ASSERT_EQUAL_MEMORY(&whole[results], &result, sizeof result);
            results++;
        }
        TEST_ASSERT_GREATER_THAN_UINT32(5U, results);
    }
}

/* ---- brute force: gaps near both ends of a record, and their mirror images ---- */

#define RECORD 100
#define GAPS 5U

static const int32_t gap_at[GAPS] = {7, 12, 13, 88, 95};

static double mirrored(int32_t i)
{
    const int32_t inside = (i < 0) ? (-1 - i) : ((i >= RECORD) ? ((2 * RECORD) - 1 - i) : i);
    return ripple((uint32_t)inside);
}

static bool is_crossed(int32_t begin, int32_t end)
{
    for (uint32_t k = 0U; k < GAPS; k++) {
        const int32_t images[3] = {-gap_at[k], gap_at[k], (2 * RECORD) - gap_at[k]};
        for (uint32_t i = 0U; i < 3U; i++) {
            if ((begin < images[i]) && (images[i] < end)) {
                return true;
            }
        }
    }
    return false;
}

/* Compares the result with all differences of its window that span no gap and no mirror image of a
 * gap. */
static void compare_with_brute_force(void)
{
    const int32_t begin = (int32_t)result.epoch - (int32_t)(result.window_samples / 2U);
    const int32_t end = begin + (int32_t)result.window_samples;
    for (uint32_t t = 0U; t < TAUS; t++) {
        const int32_t m = (int32_t)taus[t];
        double sum = 0.0;
        uint32_t n = 0U;
        for (int32_t i = begin; (i + (2 * m)) <= end; i++) {
            double difference = 0.0;
            for (int32_t k = 0; k < m; k++) {
                difference += mirrored(i + m + k) - mirrored(i + k);
            }
            sum += is_crossed(i, i + (2 * m)) ? 0.0 : (difference * difference);
            n += is_crossed(i, i + (2 * m)) ? 0U : 1U;
        }
        TEST_ASSERT_EQUAL_UINT32(n, result.tau[t].differences);
        if (n > 0U) {
            const double adev = config.unit_per_count * sqrt(sum / (2.0 * m * m * n));
            TEST_ASSERT_DOUBLE_WITHIN(1e-12 * adev, adev, result.tau[t].adev);
        }
    }
}

static void test_gaps_are_mirrored_at_both_ends_of_the_record(void)
{
    uint32_t results = 0U;
    config.law = NULL;
    config.window.gaps_max = 8U;
    config.window.mirrored_end = true;
    start_q15();
    for (uint32_t i = 0U; i < (uint32_t)RECORD; i++) {
        for (uint32_t k = 0U; k < GAPS; k++) {
            if (gap_at[k] == (int32_t)i) {
                davar_gap(&davar, 1U);
            }
        }
        if (feed(i, i + 1U) > 0U) {
            compare_with_brute_force();
            results++;
        }
    }
    while (davar_flush(&davar)) {
        if (take_fitted(&davar, &result)) {
            compare_with_brute_force();
            results++;
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT32((uint32_t)RECORD - 2U, results);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_too_many_gaps_restart_the_window_and_keep_the_count_of_samples);
    RUN_TEST(test_a_restart_in_centred_mode_continues_the_epochs);
    RUN_TEST(test_a_restart_at_any_moment_keeps_the_grid_of_epochs);
    RUN_TEST(test_a_restart_loses_a_waiting_result_and_counts_it);
    RUN_TEST(test_the_result_counts_the_differences_at_a_gap);
    RUN_TEST(test_gaps_at_the_start_or_twice_in_one_place_count_at_most_once);
    RUN_TEST(test_a_gap_after_the_last_sample_does_not_count);
    RUN_TEST(test_gaps_are_mirrored_at_both_ends_of_the_record);
    return UNITY_END();
}
