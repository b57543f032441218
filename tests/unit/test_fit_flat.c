/* davar tests - white noise from the flat part of exact Allan variances (5.23): which sizes are used,
 * and where there is no value. tests/statistics/flat.c has its intervals. */
#include "davar/fit.h"
#include "fit_fixture.h"

#define ARW DAVAR_ANGLE_RANDOM_WALK

/* N of white noise of variance 1 per sample, in deg/sqrt(h) at 1 Hz. */
#define N 60.0

static bool fit(void)
{
    (void)davar_fit_white(&plan, 1.0, &result);
    return davar_fit_flat(&plan, 1.0, &result);
}

static void expect_value(uint32_t from, uint32_t to)
{
    const davar_coefficient_t *const arw = &result.coefficient[ARW];
    TEST_ASSERT_TRUE(arw->present);
    TEST_ASSERT_TRUE((arw->low < arw->value) && (arw->value < arw->high));
    TEST_ASSERT_TRUE((arw->low < N) && (N < arw->high));
    assert_near(N, arw->value, 0.03);
    TEST_ASSERT_EQUAL_UINT32(from, result.flat_from);
    TEST_ASSERT_EQUAL_UINT32(to, result.flat_to);
}

static void test_a_ramp_leaves_all_sizes(void)
{
    set_octaves(4440U, 9U);
    set_model((double[]){0.0, 1.0, 0.0, 0.0, 0.002});
    TEST_ASSERT_TRUE(fit());
    TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
    expect_value(1U, 256U);
    assert_near(N, result.coefficient[ARW].value, 1e-4);
}

/* Motion that ends after some samples: a ramp at short sizes, less at long ones. */
static void test_faster_motion_leaves_the_short_sizes(void)
{
    set_octaves(4440U, 9U);
    for (int t = 0; t < 9; t++) {
        const double m = (double)result.tau[t].m;
        const double turn =
            pow(sin(3.14159265358979 * 0.004 * m), 4.0) / pow(3.14159265358979 * 0.004 * m, 2.0);
        result.tau[t].adev = sqrt((1.0 / m) + (400.0 * turn));
    }
    TEST_ASSERT_TRUE(fit());
    TEST_ASSERT_TRUE((result.flat_to >= 8U) && (result.flat_to <= 64U));
    expect_value(1U, result.flat_to);
}

/* Lines of rotors near 95 Hz and motion, from the signal `flight` of bench/signals.py: eight samples
 * are nearly a period, so m avar at m = 8 is a quarter to a third of that of its neighbours. The
 * kurtosis of the motion looks like heavy tails. */
static void test_lines_and_motion_leave_none(void)
{
    static const double root_m_adev[] = {5.51, 11.65, 17.09, 8.77, 15.53, 32.33, 73.84};
    uint32_t m[7];
    davar_filter_t filter = {.uncertainty = 0.0};
    set_octaves(400U, 7U);
    for (int t = 0; t < 7; t++) {
        m[t] = result.tau[t].m;
        result.tau[t].adev = root_m_adev[t] / sqrt((double)m[t]);
    }
    result.kurtosis = 4.88;
    davar_filter_biquad(&filter, 0.25);
    davar_plan_init_filtered(&plan, m, 7U, &filter);
    TEST_ASSERT_FALSE(fit());
}

/* A ramp explains them up to 32 samples, but no longer without the last octave. */
static void test_sizes_that_hardly_fit_leave_none(void)
{
    static const double root_m_adev[] = {0.9819, 0.9792, 1.0505,  1.1407, 1.5866,
                                         3.5765, 8.6002, 24.5199, 64.5878};
    set_octaves(4440U, 9U);
    for (int t = 0; t < 9; t++) {
        result.tau[t].adev = root_m_adev[t] / sqrt((double)result.tau[t].m);
    }
    TEST_ASSERT_FALSE(fit());
}

/* As davar_fit leaves a result of a cascade alone: the plan still has the sizes of the window before,
 * and nothing is in them. */
static void test_a_window_without_differences_has_none(void)
{
    set_octaves(4440U, 9U);
    set_model((double[]){0.0, 1.0, 0.0, 0.0, 0.002});
    TEST_ASSERT_TRUE(fit());
    for (int t = 0; t < 9; t++) {
        result.tau[t].differences = 0U;
        result.tau[t].adev = (double)NAN;
    }
    result.noise = DAVAR_NOISE_MIXED;
    result.coefficient[ARW].present = false;
    TEST_ASSERT_FALSE(davar_fit_flat(&plan, 1.0, &result));
}

/* After a filter that is not declared, m avar lacks 1 / m. */
static void test_long_sizes_have_what_a_filter_leaves(void)
{
    uint32_t m[9];
    set_octaves(4440U, 9U);
    for (int t = 0; t < 9; t++) {
        m[t] = result.tau[t].m;
        result.tau[t].adev = sqrt((1.0 - (0.7 / m[t])) / m[t]);
    }
    davar_plan_init(&plan, m, 9U);
    TEST_ASSERT_TRUE(fit());
    TEST_ASSERT_EQUAL(DAVAR_NOISE_FILTERED, result.noise);
    TEST_ASSERT_TRUE(result.flat_from >= 16U);
    expect_value(result.flat_from, 256U);
}

/* The same excess is a limit if the filter is unknown. */
static void test_motion_after_an_unknown_filter_is_a_limit(void)
{
    uint32_t m[9];
    set_octaves(4440U, 9U);
    for (int t = 0; t < 9; t++) {
        m[t] = result.tau[t].m;
    }
    set_model((double[]){0.0, 1.0, 0.0, 0.0, 0.002});
    davar_plan_init(&plan, m, 9U);
    TEST_ASSERT_FALSE(fit());
    TEST_ASSERT_TRUE(result.coefficient[ARW].high >= N);
    TEST_ASSERT_EQUAL_UINT32(0U, result.flat_to);
}

static void test_few_sizes_test_nothing(void)
{
    for (uint8_t count = 1U; count < 4U; count++) {
        set_octaves(4440U, count);
        set_model((double[]){0.0, 1.0, 0.0, 0.0, 0.9});
        TEST_ASSERT_FALSE(fit() && (result.noise == DAVAR_NOISE_MIXED));
        TEST_ASSERT_EQUAL_UINT32(0U, result.flat_to);
    }
}

static void test_white_noise_stays(void)
{
    set_octaves(600U, 7U);
    set_model((double[]){0.0, 1.0, 0.0, 0.0, 0.0});
    (void)davar_fit_white(&plan, 1.0, &result);
    const davar_result_t before = result;
    TEST_ASSERT_TRUE(davar_fit_flat(&plan, 1.0, &result));
    TEST_ASSERT_EQUAL_MEMORY(&before.coefficient[ARW], &result.coefficient[ARW],
                             sizeof before.coefficient[ARW]);
    TEST_ASSERT_EQUAL_UINT32(0U, result.flat_to);
}

/* Contradicting ends: short sizes of a motion, long ones that settle higher. */
static void test_ends_that_contradict_each_other_are_a_limit(void)
{
    static const double y[] = {1.0,  1.02, 1.15, 2.2,  10.0, 40.0,
                               60.0, 60.0, 60.0, 60.0, 60.0, 60.0};
    set_octaves(40000U, 12U);
    for (int t = 0; t < 12; t++) {
        result.tau[t].adev = sqrt(y[t] / (double)result.tau[t].m);
    }
    (void)fit();
    TEST_ASSERT_FALSE(result.coefficient[ARW].present);
    TEST_ASSERT_TRUE(result.coefficient[ARW].high > N * sqrt(60.0));
}

/* Less than half a count is no value, in motion either. */
static void test_coarse_counts_are_a_limit(void)
{
    set_octaves(4440U, 9U);
    result.unit_per_count = 4.0;
    for (int t = 0; t < 9; t++) {
        const double m = (double)result.tau[t].m;
        result.tau[t].adev = sqrt(((1.0 + (16.0 / 12.0)) / m) + (0.02 * m * m));
    }
    TEST_ASSERT_FALSE(fit());
    TEST_ASSERT_TRUE(result.coefficient[ARW].high >= N);
}

/* A count of the newest samples that exceeds the window: all of it repeats one sample. */
static void test_a_window_of_equal_samples_is_constant(void)
{
    set_octaves(600U, 7U);
    set_model((double[]){0.0, 1.0, 0.0, 0.0, 0.0});
    result.unit_per_count = 0.1;
    result.equal_samples = 600U;
    TEST_ASSERT_FALSE(fit());
    TEST_ASSERT_EQUAL(DAVAR_NOISE_CONSTANT, result.noise);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_ramp_leaves_all_sizes);
    RUN_TEST(test_faster_motion_leaves_the_short_sizes);
    RUN_TEST(test_lines_and_motion_leave_none);
    RUN_TEST(test_sizes_that_hardly_fit_leave_none);
    RUN_TEST(test_a_window_without_differences_has_none);
    RUN_TEST(test_long_sizes_have_what_a_filter_leaves);
    RUN_TEST(test_motion_after_an_unknown_filter_is_a_limit);
    RUN_TEST(test_few_sizes_test_nothing);
    RUN_TEST(test_white_noise_stays);
    RUN_TEST(test_ends_that_contradict_each_other_are_a_limit);
    RUN_TEST(test_coarse_counts_are_a_limit);
    RUN_TEST(test_a_window_of_equal_samples_is_constant);
    return UNITY_END();
}
