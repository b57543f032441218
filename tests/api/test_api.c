/* davar tests - the front door: refusals, memory, weather, results that nobody takes. */
#include "davar/davar.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define TAUS 4U

static const uint32_t taus[TAUS] = {1U, 2U, 4U, 8U};
static uint64_t memory[4096];
static davar_config_t config;
static davar_t davar;
static davar_result_t result;

void setUp(void)
{
    config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 0.01;
    config.full_scale = 300.0;
    config.window_max = 40U;
    config.window_min = 20U;
    config.segment = 5U;
    config.taus = taus;
    config.tau_count = TAUS;
}

void tearDown(void) {}

static int16_t ripple(uint32_t i)
{
    return (int16_t)(((i * 7919U) % 41U) - 20U);
}

/* Pushes samples from .. to - 1 one by one, takes every result, returns how many there were. */
static uint32_t feed(uint32_t from, uint32_t to)
{
    uint32_t results = 0U;
    for (uint32_t i = from; i < to; i++) {
        const int16_t sample = ripple(i);
        TEST_ASSERT_EQUAL_size_t(1U, davar_push_q15(&davar, &sample, 1U));
        results += davar_take(&davar, &result) ? 1U : 0U;
    }
    return results;
}

static void start_q15(void)
{
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
}

static void refused(davar_status_t expected)
{
    davar_t untouched;
    memset(&untouched, 0xA5, sizeof untouched);
    davar_t copy = untouched;
    TEST_ASSERT_EQUAL(expected, davar_init_q15(&untouched, &config, memory, sizeof memory));
    TEST_ASSERT_EQUAL_MEMORY(&copy, &untouched, sizeof copy);
    TEST_ASSERT_EQUAL_size_t(0U, davar_memory_size_q15(&config));
    setUp();
}

static void test_each_bad_setting_is_refused_with_its_own_code(void)
{
    static const uint32_t unsorted[2] = {2U, 2U};
    static const uint32_t zero[2] = {0U, 2U};
    static const uint32_t long_tau[2] = {1U, 21U};
    const double bad_numbers[] = {0.0, -1.0, (double)NAN, (double)INFINITY};
    for (unsigned i = 0U; i < 4U; i++) {
        config.rate_hz = bad_numbers[i];
        refused(DAVAR_ERR_RATE);
        config.unit_per_count = bad_numbers[i];
        refused(DAVAR_ERR_SCALE);
        config.full_scale = bad_numbers[i];
        TEST_ASSERT_EQUAL(DAVAR_ERR_SCALE, davar_init_f32(&davar, &config, memory, sizeof memory));
        setUp();
    }
    config.sample_bits = 17U, refused(DAVAR_ERR_SAMPLE_BITS);
    config.sample_bits = 1U, refused(DAVAR_ERR_SAMPLE_BITS);
    config.mode = (davar_mode_t)7, refused(DAVAR_ERR_MODE);
    config.policy = (davar_policy_t)7, refused(DAVAR_ERR_POLICY);
    config.window_max = 2U, refused(DAVAR_ERR_WINDOW_MAX);
    config.window_max = 41U, refused(DAVAR_ERR_WINDOW_ODD);
    config.window_max = 65538U, refused(DAVAR_ERR_WINDOW_MAX);
    config.window_min = 0U, refused(DAVAR_ERR_WINDOW_MIN);
    config.window_min = 21U, refused(DAVAR_ERR_WINDOW_ODD);
    config.window_min = 42U, refused(DAVAR_ERR_WINDOW_MIN);
    config.segment = 0U, refused(DAVAR_ERR_SEGMENT);
    config.segment = 20U, refused(DAVAR_ERR_SEGMENT);
    config.kurtosis_low = -1.0, refused(DAVAR_ERR_KURTOSIS);
    config.kurtosis_low = 4.0, refused(DAVAR_ERR_KURTOSIS);
    config.kurtosis_high = (double)NAN, refused(DAVAR_ERR_KURTOSIS);
    config.contribution_low = 1.0, refused(DAVAR_ERR_CONTRIBUTION);
    config.contribution_high = (double)INFINITY, refused(DAVAR_ERR_CONTRIBUTION);
    config.grow = 4U, refused(DAVAR_ERR_STEP);
    config.shrink = 1U, refused(DAVAR_ERR_STEP);
    config.mode = DAVAR_MODE_TRAILING, config.shrink = 1U << 31U, refused(DAVAR_ERR_SHRINK);
    config.stride = 0U, refused(DAVAR_ERR_STRIDE);
    config.stride = (1U << 24U) + 1U, refused(DAVAR_ERR_STRIDE);
    config.tau_count = 0U, refused(DAVAR_ERR_TAU_COUNT);
    config.tau_count = DAVAR_TAUS_MAX + 1U, refused(DAVAR_ERR_TAU_COUNT);
    config.taus = unsorted, config.tau_count = 2U, refused(DAVAR_ERR_TAU_ORDER);
    config.taus = zero, config.tau_count = 2U, refused(DAVAR_ERR_TAU_ZERO);
    config.taus = long_tau, config.tau_count = 2U, refused(DAVAR_ERR_TAU_LONG);
    config.taus = NULL, refused(DAVAR_ERR_NULL);
}

static void test_bad_pointers_and_memory_are_refused(void)
{
    TEST_ASSERT_EQUAL(DAVAR_ERR_NULL, davar_init_q15(NULL, &config, memory, sizeof memory));
    TEST_ASSERT_EQUAL(DAVAR_ERR_NULL, davar_init_q15(&davar, &config, NULL, sizeof memory));
    TEST_ASSERT_EQUAL(DAVAR_ERR_NULL, davar_init_q31(&davar, NULL, memory, sizeof memory));
    TEST_ASSERT_EQUAL(DAVAR_ERR_MEMORY_SIZE,
                      davar_init_q15(&davar, &config, memory, davar_memory_size_q15(&config) - 1U));
    TEST_ASSERT_EQUAL(DAVAR_ERR_MEMORY_ALIGN,
                      davar_init_q15(&davar, &config, (unsigned char *)memory + 4, sizeof memory - 8U));
    TEST_ASSERT_EQUAL_size_t(0U, davar_memory_size_f32(NULL));
}

static void test_sums_that_could_overflow_are_refused_and_fit_the_wider_type(void)
{
    static const uint32_t wide[2] = {1U, 7000U};
    config.window_max = 65536U;
    config.window_min = 65536U;
    config.taus = wide;
    config.tau_count = 2U;
    TEST_ASSERT_EQUAL_size_t(0U, davar_memory_size_q15(&config));
    TEST_ASSERT_EQUAL(DAVAR_ERR_TAU_OVERFLOW, davar_init_q15(&davar, &config, memory, sizeof memory));
    TEST_ASSERT_GREATER_THAN_size_t(4U * 65536U, davar_memory_size_q31(&config));
    config.sample_bits = 11U; /* 2^16 7000^2 4^11 < 2^64 */
    TEST_ASSERT_GREATER_THAN_size_t(2U * 65536U, davar_memory_size_q15(&config));
}

/* Where a size_t has 32 bits the largest grids cannot be told: they must look too large, never small. */
static void test_memory_never_shrinks_as_windows_grow(void)
{
    static uint32_t many[32];
    for (uint32_t t = 0U; t < 32U; t++) {
        many[t] = t + 1U;
    }
    config.taus = many;
    config.tau_count = 32U;
    config.stride = 2U;
    size_t before = 0U;
    for (config.window_max = 65536U; config.window_max <= 16777216U; config.window_max += 32768U) {
        const size_t bytes = davar_memory_size_q31(&config);
        TEST_ASSERT_GREATER_OR_EQUAL_size_t(before, bytes);
        before = bytes;
    }
    TEST_ASSERT_GREATER_THAN_size_t(4200000000U, before);
}

static void test_every_status_has_its_own_words(void)
{
    for (int i = DAVAR_OK; i <= DAVAR_ERR_STATE_FOREIGN; i++) {
        for (int j = DAVAR_OK; j < i; j++) {
            TEST_ASSERT_TRUE(strcmp(davar_status_text((davar_status_t)i), davar_status_text((davar_status_t)j)) != 0);
        }
    }
    TEST_ASSERT_EQUAL_STRING("unknown status", davar_status_text((davar_status_t)99));
}

static void test_the_memory_macros_hold_what_init_asks_for(void)
{
    for (uint32_t window = 20U; window <= 600U; window += 2U) {
        for (uint16_t gaps = 0U; gaps < 9U; gaps++) {
            config.window_max = window;
            config.window_min = 20U;
            config.gaps_max = gaps;
            TEST_ASSERT_LESS_OR_EQUAL_size_t(DAVAR_MEMORY_Q15(window, TAUS, gaps), davar_memory_size_q15(&config));
            TEST_ASSERT_LESS_OR_EQUAL_size_t(DAVAR_MEMORY_Q31(window, TAUS, gaps), davar_memory_size_q31(&config));
            TEST_ASSERT_LESS_OR_EQUAL_size_t(DAVAR_MEMORY_F32(window, TAUS, gaps), davar_memory_size_f32(&config));
        }
    }
}

static void test_a_memory_of_exactly_the_asked_size_is_never_left(void)
{
    for (uint32_t stride = 1U; stride < 12U; stride++) {
        config.stride = stride;
        config.mirrored_end = true;
        const size_t bytes = davar_memory_size_q15(&config);
        memset(memory, 0xA5, sizeof memory);
        TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, bytes));
        (void)feed(0U, 500U);
        while (davar_flush(&davar)) {
        }
        TEST_ASSERT_EACH_EQUAL_HEX8(0xA5, (unsigned char *)memory + bytes, 256U);
    }
}

static void test_results_that_nobody_took_are_counted(void)
{
    start_q15();
    for (uint32_t i = 0U; i < 30U; i++) { /* centred: the first result comes with sample 20 */
        const int16_t sample = ripple(i);
        (void)davar_push_q15(&davar, &sample, 1U);
    }
    TEST_ASSERT_EQUAL_UINT32(10U, davar_health(&davar).missed);
    TEST_ASSERT_TRUE(davar_take(&davar, &result));
    TEST_ASSERT_EQUAL_UINT64(10U, result.epoch);
    TEST_ASSERT_FALSE(davar_take(&davar, &result));
}

static void test_a_block_push_stops_at_each_result(void)
{
    int16_t block[64];
    for (uint32_t i = 0U; i < 64U; i++) {
        block[i] = ripple(i);
    }
    config.stride = 10U;
    start_q15();
    TEST_ASSERT_EQUAL_size_t(0U, davar_push_q15(&davar, block, 0U));
    TEST_ASSERT_EQUAL_size_t(29U, davar_push_q15(&davar, block, 64U)); /* epoch 9 needs samples to 9 + 20 - 1 */
    TEST_ASSERT_TRUE(davar_take(&davar, &result));
    TEST_ASSERT_EQUAL_UINT64(9U, result.epoch);
    TEST_ASSERT_EQUAL_size_t(10U, davar_push_q15(&davar, &block[29], 35U));
}

static void test_a_push_of_nothing_consumes_nothing(void)
{
    const int16_t sample = 0;
    start_q15();
    TEST_ASSERT_EQUAL_size_t(0U, davar_push_q15(&davar, &sample, 0U));
    (void)feed(0U, 60U); /* the window glides now */
    TEST_ASSERT_EQUAL_size_t(0U, davar_push_q15(&davar, &sample, 0U));
    TEST_ASSERT_FALSE(davar_take(&davar, &result));
}

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
    TEST_ASSERT_FALSE(davar_take(&davar, &result));
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
    TEST_ASSERT_FALSE(davar_take(&davar, &result));
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

static void test_saturated_samples_are_counted_and_clamped(void)
{
    config.sample_bits = 12U;
    start_q15();
    const int16_t samples[5] = {2046, 2047, 2048, -2048, -3000};
    for (unsigned i = 0U; i < 5U; i++) {
        (void)davar_push_q15(&davar, &samples[i], 1U);
    }
    TEST_ASSERT_EQUAL_UINT32(4U, davar_health(&davar).saturated);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q31(&davar, &config, memory, sizeof memory));
    const int32_t wide[3] = {2046, 5000, -5000};
    (void)davar_push_q31(&davar, wide, 3U);
    TEST_ASSERT_EQUAL_UINT32(2U, davar_health(&davar).saturated);
}

static void test_counters_stay_at_their_largest_value(void)
{
    start_q15();
    davar.health.saturated = UINT32_MAX;
    const int16_t rail = INT16_MAX;
    (void)davar_push_q15(&davar, &rail, 1U);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, davar_health(&davar).saturated);
}

static void test_reset_starts_anew(void)
{
    start_q15();
    (void)feed(0U, 70U);
    const davar_result_t first = result;
    davar_gap(&davar, 2U);
    davar_reset(&davar);
    TEST_ASSERT_EQUAL_UINT32(0U, davar_health(&davar).gaps);
    (void)feed(0U, 70U);
    TEST_ASSERT_EQUAL_UINT64(first.epoch, result.epoch);
    TEST_ASSERT_EQUAL_DOUBLE(first.tau[3].adev, result.tau[3].adev);
}

static void test_flush_gives_the_epochs_of_the_mirrored_end_or_says_no(void)
{
    start_q15();
    TEST_ASSERT_FALSE(davar_flush(&davar)); /* nothing there */
    TEST_ASSERT_EQUAL_UINT32(81U, feed(0U, 100U));
    uint32_t flushed = 0U;
    while (davar_flush(&davar)) {
        TEST_ASSERT_TRUE(davar_take(&davar, &result));
        flushed++;
    }
    TEST_ASSERT_EQUAL_UINT32(19U, flushed);
    TEST_ASSERT_EQUAL_UINT64(99U, result.epoch);
    config.stride = 2U; /* on a grid only when asked for */
    start_q15();
    (void)feed(0U, 100U);
    TEST_ASSERT_FALSE(davar_flush(&davar));
    config.mode = DAVAR_MODE_TRAILING;
    start_q15();
    (void)feed(0U, 100U);
    TEST_ASSERT_FALSE(davar_flush(&davar));
}

static void test_a_gap_behind_the_last_sample_is_none(void)
{
    start_q15();
    (void)feed(0U, 100U);
    davar_gap(&davar, 1U);
    TEST_ASSERT_TRUE(davar_flush(&davar));
    TEST_ASSERT_TRUE(davar_take(&davar, &result));
    TEST_ASSERT_EQUAL_UINT32(0U, result.gaps_in_window);
}

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
        (void)davar_push_f32(&other, &rate, 1U);
        (void)feed(i, i + 1U);
    }
    TEST_ASSERT_EQUAL_DOUBLE(alone.tau[2].adev, result.tau[2].adev);
    TEST_ASSERT_EQUAL_DOUBLE(alone.kurtosis, result.kurtosis);
}

/* About normal, and four times as loud in every other 97 samples: the window changes its length. */
static int16_t breathing(uint32_t i)
{
    const int32_t sum = ripple(i) + ripple(3U * i + 1U) + ripple(11U * i + 5U) + ripple(17U * i + 7U);
    return (int16_t)(((i / 97U) % 2U) != 0U ? 4 * sum : sum);
}

/* One plan for instances whose windows and gaps differ, or none at all: the fit is a pure function. */
static void test_results_do_not_depend_on_the_plan(void)
{
    static uint64_t planned_memory[2][1024];
    static davar_fit_plan_t plan;
    davar_t planned[2];
    davar_result_t expected;
    uint32_t results = 0U;
    uint32_t shortest = UINT32_MAX;
    uint32_t longest = 0U;
    uint32_t gaps = 0U;
    davar_config_t with_plan = config; /* an instance keeps the pointer: each way needs a configuration of its own */
    with_plan.fit_plan = &plan;
    start_q15();
    for (uint32_t k = 0U; k < 2U; k++) {
        TEST_ASSERT_EQUAL(DAVAR_OK,
                          davar_init_q15(&planned[k], &with_plan, planned_memory[k], sizeof planned_memory[k]));
    }
    for (uint32_t i = 0U; i < 600U; i++) {
        const int16_t sample = breathing(i);
        const int16_t other = ripple(i);
        if (i % 150U == 149U) {
            davar_gap(&planned[0], 3U);
            davar_gap(&davar, 3U);
        }
        (void)davar_push_q15(&planned[1], &other, 1U);
        (void)davar_take(&planned[1], &result);
        (void)davar_push_q15(&planned[0], &sample, 1U);
        (void)davar_push_q15(&davar, &sample, 1U);
        memset(&expected, 0, sizeof expected);
        memset(&result, 0, sizeof result);
        const bool taken = davar_take(&planned[0], &expected);
        TEST_ASSERT_EQUAL(taken, davar_take(&davar, &result));
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

static void test_moments_can_be_switched_off_with_the_fixed_window(void)
{
    config.policy = DAVAR_POLICY_FIXED;
    config.segment = 0U;
    for (uint32_t stride = 1U; stride < 3U; stride++) {
        config.stride = stride;
        start_q15();
        (void)feed(0U, 70U);
        TEST_ASSERT_TRUE(isnan(result.kurtosis) && isnan(result.contribution) && !result.unstable);
        TEST_ASSERT_TRUE(result.tau[0].adev > 0.0);
    }
}

static void test_a_constant_rail_has_no_kurtosis_and_a_zero_deviation(void)
{
    start_q15();
    for (uint32_t i = 0U; i < 60U; i++) {
        const int16_t rail = INT16_MIN;
        (void)davar_push_q15(&davar, &rail, 1U);
    }
    TEST_ASSERT_TRUE(davar_take(&davar, &result));
    TEST_ASSERT_TRUE(isnan(result.kurtosis) && isnan(result.contribution) && !result.unstable);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, result.tau[3].adev);
    TEST_ASSERT_EQUAL_UINT32(60U, davar_health(&davar).saturated);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_each_bad_setting_is_refused_with_its_own_code);
    RUN_TEST(test_bad_pointers_and_memory_are_refused);
    RUN_TEST(test_sums_that_could_overflow_are_refused_and_fit_the_wider_type);
    RUN_TEST(test_memory_never_shrinks_as_windows_grow);
    RUN_TEST(test_every_status_has_its_own_words);
    RUN_TEST(test_the_memory_macros_hold_what_init_asks_for);
    RUN_TEST(test_a_memory_of_exactly_the_asked_size_is_never_left);
    RUN_TEST(test_results_that_nobody_took_are_counted);
    RUN_TEST(test_a_block_push_stops_at_each_result);
    RUN_TEST(test_a_push_of_nothing_consumes_nothing);
    RUN_TEST(test_too_many_gaps_restart_the_window_and_keep_the_count_of_samples);
    RUN_TEST(test_a_restart_in_centred_mode_continues_the_epochs);
    RUN_TEST(test_a_restart_at_any_moment_keeps_the_grid_of_epochs);
    RUN_TEST(test_a_restart_loses_a_waiting_result_and_counts_it);
    RUN_TEST(test_the_result_says_how_many_differences_a_gap_left);
    RUN_TEST(test_gaps_before_the_first_sample_or_twice_in_one_place_are_one_boundary_or_none);
    RUN_TEST(test_saturated_samples_are_counted_and_clamped);
    RUN_TEST(test_counters_stay_at_their_largest_value);
    RUN_TEST(test_reset_starts_anew);
    RUN_TEST(test_flush_gives_the_epochs_of_the_mirrored_end_or_says_no);
    RUN_TEST(test_a_gap_behind_the_last_sample_is_none);
    RUN_TEST(test_instances_do_not_touch_each_other);
    RUN_TEST(test_results_do_not_depend_on_the_plan);
    RUN_TEST(test_moments_can_be_switched_off_with_the_fixed_window);
    RUN_TEST(test_a_constant_rail_has_no_kurtosis_and_a_zero_deviation);
    return UNITY_END();
}
