/* davar tests - the fit of a curve: the sizes of a window and of a cascade (5.18), from exact Allan
 * variances. */
#include "fit_fixture.h"

#include "fit/plan.h"

#define WINDOW 600U
#define SHORT 7U /* octaves 1 to 64 in the window */
#define LONG 10U /* octaves 128 to 65536 in the cascade, 48 clusters each */
#define CLUSTERS 48U

/* White noise, flicker and random walk that cross at about 500 and 16000 samples. */
static const double mixed[] = {0, 1.0, 0.002, 1.2e-7, 0};
static const double white[] = {0, 1.0, 0, 0, 0};

/* A low-pass lowers the Allan variance of white noise by about as much. */
static const double after_filter[] = {-0.7, 1.0, 0, 0, 0};

static void set_hops(uint8_t t, uint32_t m)
{
    davar_adev_t *const tau = &result.tau[t];
    tau->m = m;
    tau->hops = ((t % 2U) == 0U) ? 8U : 4U;
    tau->power = 1.0F;
    tau->uneven = DAVAR_EVEN;
    tau->differences = ((CLUSTERS - 2U) * tau->hops) + 1U;
}

/* `sizes` of the cascade after `window` octaves of the window. */
static void set_curve(uint8_t window, uint8_t sizes, const double a[])
{
    uint32_t m[DAVAR_TAUS_MAX];
    set_octaves(WINDOW, (window > 0U) ? window : 1U);
    result.window_samples = (window > 0U) ? WINDOW : 0U;
    result.tau_count = window;
    for (uint8_t t = 0U; t < sizes; t++) {
        set_hops((uint8_t)(window + t), UINT32_C(128) << t);
        result.tau_count++;
    }
    for (uint8_t t = 0U; t < result.tau_count; t++) {
        m[t] = result.tau[t].m;
    }
    set_model(a);
    davar_plan_init_white(&plan, m, result.tau_count);
}

/* The flicker of `mixed` is too small for the window, and raises its white noise a little. */
static void assert_white_of_window(void)
{
    const davar_coefficient_t *const found = term(DAVAR_ANGLE_RANDOM_WALK);
    TEST_ASSERT_TRUE(found->present);
    TEST_ASSERT_DOUBLE_WITHIN(0.3, 60.0, found->value);
    TEST_ASSERT_TRUE((found->low < 60.0) && (found->high > 60.0));
}

static void test_slow_terms_come_from_the_cascade(void)
{
    set_curve(SHORT, LONG, mixed);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
    assert_white_of_window();
    assert_holds(3600.0 * sqrt(mixed[2] / 0.441271200305303), term(DAVAR_BIAS_INSTABILITY));
    assert_holds(216000.0 * sqrt(3.0 * mixed[3]), term(DAVAR_RATE_RANDOM_WALK));
    for (uint8_t t = 0U; t < result.tau_count; t++) {
        TEST_ASSERT_TRUE(result.tau[t].low < result.tau[t].adev);
        TEST_ASSERT_TRUE(result.tau[t].high > result.tau[t].adev);
        TEST_ASSERT_TRUE((t < SHORT) || ((result.tau[t].edf > 30.0) && (result.tau[t].edf < 80.0)));
    }
}

static void test_white_noise_stays_that_of_the_window(void)
{
    davar_result_t window;
    set_curve(SHORT, 0U, white);
    davar_fit(&plan, 1.0, &result);
    window = result;
    set_curve(SHORT, LONG, white);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_WHITE, result.noise);
    for (int k = DAVAR_QUANTIZATION; k <= DAVAR_ANGLE_RANDOM_WALK; k++) {
        TEST_ASSERT_EQUAL_MEMORY(&window.coefficient[k].high, &result.coefficient[k].high,
                                 sizeof(double));
    }
    TEST_ASSERT_TRUE(term(DAVAR_RATE_RANDOM_WALK)->high <
                     0.01 * window.coefficient[DAVAR_RATE_RANDOM_WALK].high);
}

/* The white noise of the cascade is five times that of the window: nothing is mixed up. */
static void test_noise_that_has_changed(void)
{
    set_curve(SHORT, LONG, white);
    for (uint8_t t = SHORT; t < result.tau_count; t++) {
        result.tau[t].adev *= 5.0;
    }
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_WHITE, result.noise);
    assert_holds(60.0, term(DAVAR_ANGLE_RANDOM_WALK));
    TEST_ASSERT_EQUAL_UINT(1U << DAVAR_ANGLE_RANDOM_WALK, present_terms());
}

/* White noise is all that a fit finds, but it does not explain the sizes. */
static void test_a_cascade_that_no_mix_explains(void)
{
    set_curve(SHORT, LONG, white);
    for (uint8_t t = SHORT; t < result.tau_count; t++) {
        result.tau[t].adev *= ((t % 2U) == 0U) ? 0.7 : 1.4;
    }
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
    TEST_ASSERT_EQUAL_UINT(1U << DAVAR_ANGLE_RANDOM_WALK, present_terms());
}

static void test_a_window_of_a_mix_keeps_its_short_terms(void)
{
    const double quantized[] = {3.0, 1.0, mixed[2], 0, 0};
    set_curve(SHORT, LONG, quantized);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
    TEST_ASSERT_TRUE(term(DAVAR_QUANTIZATION)->present);
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 1.0, term(DAVAR_QUANTIZATION)->value);
    TEST_ASSERT_TRUE(term(DAVAR_BIAS_INSTABILITY)->present);
}

static void test_few_sizes_of_a_cascade_leave_the_terms_to_the_window(void)
{
    davar_result_t window;
    set_curve(SHORT, 0U, mixed);
    davar_fit(&plan, 1.0, &result);
    window = result;
    set_curve(SHORT, 3U, mixed);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL_MEMORY(window.coefficient, result.coefficient, sizeof window.coefficient);
    TEST_ASSERT_TRUE(result.tau[SHORT].low < result.tau[SHORT].adev);
    set_curve(SHORT, 4U, mixed);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_TRUE(term(DAVAR_RATE_RAMP)->high < window.coefficient[DAVAR_RATE_RAMP].high);
    TEST_ASSERT_TRUE(isfinite(result.tau[SHORT].low));
}

/* The cascade of a stream that had gaps: a size has no difference. The window is short. */
static void test_sizes_without_differences_are_left_out(void)
{
    const double flicker[] = {0, 1.0, mixed[2], 0, 0};
    set_curve(SHORT, LONG, flicker);
    result.tau[5].differences = 0U;
    result.tau[6].differences = 0U;
    result.tau[SHORT].differences = 0U;
    result.tau[SHORT + 3U].differences = 0U;
    result.tau[SHORT + 6U].differences = 3U; /* filled again */
    result.tau[SHORT + LONG - 1U].differences = 0U;
    davar_fit(&plan, 1.0, &result);
    assert_white_of_window();
    assert_holds(3600.0 * sqrt(mixed[2] / 0.441271200305303), term(DAVAR_BIAS_INSTABILITY));
    TEST_ASSERT_TRUE(isnan(result.tau[6].low));
    TEST_ASSERT_TRUE(isnan(result.tau[SHORT].low));
    TEST_ASSERT_TRUE(isnan(result.tau[SHORT + 3U].low));
    TEST_ASSERT_TRUE(isfinite(result.tau[SHORT + 4U].low));
}

static void test_a_cascade_alone_gives_all_terms(void)
{
    set_curve(0U, LONG, mixed);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
    assert_holds(60.0, term(DAVAR_ANGLE_RANDOM_WALK));
    assert_holds(3600.0 * sqrt(mixed[2] / 0.441271200305303), term(DAVAR_BIAS_INSTABILITY));
    set_curve(0U, LONG, white);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_WHITE, result.noise);
    set_curve(0U, 1U, white);
    davar_plan_init(&plan, &result.tau[0].m, 1U); /* no filter is declared */
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->present);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 60.0, term(DAVAR_ANGLE_RANDOM_WALK)->value);
}

/* Gaps have emptied the short sizes, and the noise of the others comes from a part of their time.
 * White noise is then not significant, but it is all there is. */
static void test_a_cascade_alone_with_a_few_uneven_sizes(void)
{
    static const double adev[] = {3.869, 2.059, 0.649, 1.135, 1.939};
    static const uint32_t differences[] = {15U, 19U, 51U, 21U, 13U};
    static const float power[] = {0.494F, 0.976F, 1.314F, 1.0F, 1.0F};
    static const uint16_t uneven[] = {601U, 360U, 306U, 329U, 329U};
    set_curve(0U, LONG, white);
    for (uint8_t t = 0U; t < LONG; t++) {
        davar_adev_t *const tau = &result.tau[t];
        const bool has = (t >= 5U);
        tau->differences = has ? differences[t - 5U] : 0U;
        tau->adev = has ? adev[t - 5U] : (double)NAN;
        tau->power = has ? power[t - 5U] : 1.0F;
        tau->uneven = has ? uneven[t - 5U] : DAVAR_EVEN;
    }
    davar_fit(&plan, 1.0, &result);
    const davar_coefficient_t *const found = term(DAVAR_ANGLE_RANDOM_WALK);
    TEST_ASSERT_TRUE(!found->present || (found->value > 0.0));
    TEST_ASSERT_TRUE(found->high > 0.0);
}

static void test_a_cascade_alone_without_white_noise(void)
{
    const double walk[] = {0, 0, 0, 1e-3, 0};
    set_curve(0U, LONG, walk);
    davar_fit(&plan, 1.0, &result);
    assert_holds(216000.0 * sqrt(3.0 * walk[3]), term(DAVAR_RATE_RANDOM_WALK));
    TEST_ASSERT_FALSE(term(DAVAR_ANGLE_RANDOM_WALK)->present);
    TEST_ASSERT_TRUE(isfinite(term(DAVAR_ANGLE_RANDOM_WALK)->high));
}

static void test_a_cascade_alone_that_is_constant(void)
{
    const double nothing[] = {0, 0, 0, 0, 0};
    set_curve(0U, LONG, nothing);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_CONSTANT, result.noise);
    TEST_ASSERT_EQUAL_UINT(0U, present_terms());
    TEST_ASSERT_TRUE(isinf(result.tau[3].high));
    set_curve(0U, LONG, white);
    result.tau[0].adev = 0.0; /* one size of 0 is no constant */
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_TRUE(result.noise != DAVAR_NOISE_CONSTANT);
}

/* The window has noise, the cascade none: a rate that was constant for long. */
static void test_a_cascade_of_zeros_after_a_window(void)
{
    set_curve(SHORT, LONG, white);
    for (uint8_t t = SHORT; t < result.tau_count; t++) {
        result.tau[t].adev = 0.0;
    }
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_WHITE, result.noise);
    TEST_ASSERT_TRUE(isnan(result.tau[SHORT].low));
}

/* A filter passes no quantization noise. */
static void test_a_cascade_alone_that_contradicts_the_filter(void)
{
    const double quantized[] = {300.0, 1.0, 0, 0, 0};
    const davar_filter_t filter = {.cutoff = 0.02, .poles = 1U};
    uint32_t m[LONG];
    set_curve(0U, LONG, quantized);
    for (uint8_t t = 0U; t < LONG; t++) {
        m[t] = result.tau[t].m;
    }
    davar_plan_init_filtered(&plan, m, LONG, &filter);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_FILTERED, result.noise);
    TEST_ASSERT_EQUAL_UINT(0U, present_terms());
    TEST_ASSERT_TRUE(isinf(result.tau[0].high));
}

/* What the window withholds stays withheld. */
static void test_a_window_that_is_withheld(void)
{
    uint32_t m[SHORT + LONG];
    set_curve(SHORT, LONG, white);
    for (uint8_t t = 0U; t < result.tau_count; t++) {
        m[t] = result.tau[t].m;
        result.tau[t].adev = sqrt(avar_at((t < SHORT) ? after_filter : white, m[t]));
    }
    davar_plan_init(&plan, m, result.tau_count);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_FILTERED, result.noise);
    TEST_ASSERT_EQUAL_UINT(0U, present_terms());
    TEST_ASSERT_TRUE(isinf(result.tau[SHORT].high));
}

/* A plan is a cache, not a history. */
static void test_a_plan_that_fitted_a_window_before_gives_the_same(void)
{
    static davar_plan_t used;
    davar_result_t one;
    set_curve(SHORT, LONG, mixed);
    used = plan;
    davar_fit(&used, 1.0, &result);
    set_curve(SHORT, LONG, mixed);
    for (uint8_t t = 0U; t < SHORT; t++) {
        result.tau[t].differences = 0U;
    }
    for (uint8_t t = SHORT; t < result.tau_count; t++) {
        result.tau[t].adev *= ((t % 2U) == 0U) ? 0.8 : 1.25;
    }
    one = result;
    davar_fit(&plan, 1.0, &result);
    davar_fit(&used, 1.0, &one);
    TEST_ASSERT_EQUAL(result.noise, one.noise);
    TEST_ASSERT_EQUAL_MEMORY(result.coefficient, one.coefficient, sizeof one.coefficient);
}

/* Another fit of the window alone ignores the cascade. */
static void test_the_fit_of_white_noise_ignores_the_cascade(void)
{
    set_curve(SHORT, LONG, mixed);
    (void)davar_fit_white(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_WHITE, result.noise);
    assert_white_of_window();
    TEST_ASSERT_TRUE(isnan(result.tau[SHORT].low));
}

/* A plan for fewer sizes than the result has. */
static void test_sizes_beyond_the_plan_are_left_alone(void)
{
    uint32_t m[SHORT + LONG];
    set_curve(SHORT, LONG, mixed);
    for (uint8_t t = 0U; t < result.tau_count; t++) {
        m[t] = result.tau[t].m;
    }
    davar_plan_init_white(&plan, m, SHORT + 5U);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_TRUE(isfinite(result.tau[SHORT + 4U].low));
    TEST_ASSERT_TRUE(isnan(result.tau[SHORT + 5U].low));
}

static void test_degrees_of_freedom_for_any_noise(void)
{
    set_curve(SHORT, LONG, white);
    const davar_adev_t *const tau = &result.tau[SHORT + 1U];
    double least = INFINITY;
    for (int k = DAVAR_QUANTIZATION; k <= DAVAR_RATE_RANDOM_WALK; k++) {
        least =
            fmin(least, davar_hop_edf((davar_coefficient_kind_t)k, tau->differences, tau->hops));
    }
    TEST_ASSERT_EQUAL_DOUBLE(least, davar_edf_least(&result, SHORT + 1U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_slow_terms_come_from_the_cascade);
    RUN_TEST(test_white_noise_stays_that_of_the_window);
    RUN_TEST(test_noise_that_has_changed);
    RUN_TEST(test_a_cascade_that_no_mix_explains);
    RUN_TEST(test_a_window_of_a_mix_keeps_its_short_terms);
    RUN_TEST(test_few_sizes_of_a_cascade_leave_the_terms_to_the_window);
    RUN_TEST(test_sizes_without_differences_are_left_out);
    RUN_TEST(test_a_cascade_alone_gives_all_terms);
    RUN_TEST(test_a_cascade_alone_with_a_few_uneven_sizes);
    RUN_TEST(test_a_cascade_alone_without_white_noise);
    RUN_TEST(test_a_cascade_alone_that_is_constant);
    RUN_TEST(test_a_cascade_of_zeros_after_a_window);
    RUN_TEST(test_a_cascade_alone_that_contradicts_the_filter);
    RUN_TEST(test_a_window_that_is_withheld);
    RUN_TEST(test_a_plan_that_fitted_a_window_before_gives_the_same);
    RUN_TEST(test_the_fit_of_white_noise_ignores_the_cascade);
    RUN_TEST(test_sizes_beyond_the_plan_are_left_alone);
    RUN_TEST(test_degrees_of_freedom_for_any_noise);
    return UNITY_END();
}
