/* davar tests - the coefficient fit: exact models in, the same coefficients out. Values that a
 * window cannot show stay absent. */
#include "davar/fit.h"
#include "fit_fixture.h"
#include "random.h"

/* ---- results and their units ---- */

static void test_white_noise_is_arw_and_nothing_else(void)
{
    const double white[] = {0, 4.0, 0, 0, 0};
    set_octaves(600, 7);
    set_model(white);
    davar_fit(&plan, 1.0 / 0.01, &result);
    assert_holds(60.0 * 2.0 * sqrt(0.01), term(DAVAR_ANGLE_RANDOM_WALK));
    TEST_ASSERT_EQUAL_UINT(1U << DAVAR_ANGLE_RANDOM_WALK, present_terms());
    assert_absent_below(0.01 * 1.0, term(DAVAR_QUANTIZATION));
    assert_absent_below(3600.0 * 0.5, term(DAVAR_BIAS_INSTABILITY));
    assert_absent_below(216000.0 * 0.5 / sqrt(0.01), term(DAVAR_RATE_RANDOM_WALK));
    assert_absent_below(12960000.0 * 0.1 / 0.01, term(DAVAR_RATE_RAMP));
}

static void test_every_term_comes_back_in_its_unit(void)
{
    const double tau0 = 0.25;
    const double quantization[] = {3.0 * 0.5 * 0.5 / (tau0 * tau0), 1.0, 0, 0, 0};
    const double instability[] = {0, 1.0, 2.0 * log(2.0) / acos(-1.0) * 0.09, 0, 0};
    const double walk[] = {0, 1.0, 0, 0.04 * tau0 / 3.0, 0};
    const double ramp[] = {0, 1.0, 0, 0, 0.01 * 0.01 * tau0 * tau0 / 2.0};
    set_octaves(100000, 13);
    set_model(quantization);
    davar_fit(&plan, 1.0 / tau0, &result);
    assert_holds(0.5, term(DAVAR_QUANTIZATION));
    assert_holds(60.0 * sqrt(tau0), term(DAVAR_ANGLE_RANDOM_WALK));
    set_model(instability);
    davar_fit(&plan, 1.0 / tau0, &result);
    assert_holds(3600.0 * 0.3, term(DAVAR_BIAS_INSTABILITY));
    assert_holds(60.0 * sqrt(tau0), term(DAVAR_ANGLE_RANDOM_WALK));
    set_model(walk);
    davar_fit(&plan, 1.0 / tau0, &result);
    assert_holds(216000.0 * 0.2, term(DAVAR_RATE_RANDOM_WALK));
    assert_holds(60.0 * sqrt(tau0), term(DAVAR_ANGLE_RANDOM_WALK));
    set_model(ramp);
    davar_fit(&plan, 1.0 / tau0, &result);
    assert_holds(12960000.0 * 0.01, term(DAVAR_RATE_RAMP));
    assert_holds(60.0 * sqrt(tau0), term(DAVAR_ANGLE_RANDOM_WALK));
}

static void test_three_terms_together(void)
{
    const double mix[] = {30.0, 1.0, 0, 3e-5, 0};
    set_octaves(1000000, 16);
    set_model(mix);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL_UINT((1U << DAVAR_QUANTIZATION) | (1U << DAVAR_ANGLE_RANDOM_WALK) |
                               (1U << DAVAR_RATE_RANDOM_WALK),
                           present_terms());
    assert_holds(sqrt(10.0), term(DAVAR_QUANTIZATION));
    assert_holds(60.0, term(DAVAR_ANGLE_RANDOM_WALK));
    assert_holds(216000.0 * sqrt(9e-5), term(DAVAR_RATE_RANDOM_WALK));
}

static void test_pure_drift_has_no_arw_but_an_upper_bound(void)
{
    const double walk[] = {0, 0, 0, 1.0, 0};
    set_octaves(600, 7);
    set_model(walk);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL_UINT(1U << DAVAR_RATE_RANDOM_WALK, present_terms());
    assert_absent_below(60.0, term(DAVAR_ANGLE_RANDOM_WALK));
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high > 0.0);
}

/* ---- intervals ---- */

static void test_adev_intervals_are_chi_square_with_the_edf_of_the_noise(void)
{
    const double white[] = {0, 1.0, 0, 0, 0};
    set_octaves(600, 7);
    set_model(white);
    davar_fit(&plan, 1.0, &result);
    for (int t = 0; t < result.tau_count; t++) {
        const davar_adev_t *tau = &result.tau[t];
        const double edf = davar_edf(DAVAR_ANGLE_RANDOM_WALK, tau->m, 600);
        double low;
        double high;
        davar_chi_square_interval(edf, &low, &high);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * edf, edf, tau->edf);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, tau->adev * sqrt(low), tau->low);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6, tau->adev * sqrt(high), tau->high);
    }
}

static void test_edf_follows_the_dominant_noise(void)
{
    const double walk[] = {0, 1.0, 0, 1.0, 0};
    set_octaves(600, 7);
    set_model(walk);
    davar_fit(&plan, 1.0, &result);
    const double edf = davar_edf(DAVAR_RATE_RANDOM_WALK, 64, 600);
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * edf, edf, result.tau[6].edf);
    TEST_ASSERT_TRUE(result.tau[0].edf < davar_edf(DAVAR_RATE_RANDOM_WALK, 1, 600));
    TEST_ASSERT_TRUE(result.tau[0].edf > davar_edf(DAVAR_ANGLE_RANDOM_WALK, 1, 600));
}

static void test_missing_differences_cost_degrees_of_freedom(void)
{
    const double white[] = {0, 1.0, 0, 0, 0};
    const double walk[] = {0, 1.0, 0, 1.0, 0};
    set_octaves(600, 4);
    set_model(white);
    davar_fit(&plan, 1.0, &result);
    const double whole = result.tau[3].edf;
    const double width = term(DAVAR_ANGLE_RANDOM_WALK)->high;
    for (int t = 0; t < 4; t++) {
        result.tau[t].differences /= 2U;
    }
    davar_fit(&plan, 1.0, &result);
    const double ratio = (double)result.tau[3].differences / (600.0 - 16.0 + 1.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4 * whole, whole * ratio, result.tau[3].edf);
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high > width);
    set_model(walk);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_DOUBLE_WITHIN(3.0, ratio * davar_edf(DAVAR_RATE_RANDOM_WALK, 8, 600),
                              result.tau[3].edf);
}

static void test_edf_is_never_below_one(void)
{
    const double white[] = {0, 1.0, 0, 0, 0};
    const double walk[] = {0, 0, 0, 1.0, 0};
    const uint32_t m[] = {1, 2, 300};
    set_taus(600, m, 3);
    set_model(white);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, result.tau[2].edf);
    set_model(walk);
    result.tau[1].differences = 1U;
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL_DOUBLE(1.0, result.tau[1].edf);
}

/* --- rounding to counts of 1: its variance is 1 / 12, and half a count shows as 1 / 3 --- */

static void fit_counts(double white, double walk)
{
    const double model[] = {0, white, 0, walk, 0};
    set_octaves(600, 7);
    set_model(model);
    result.unit_per_count = 1.0;
    davar_fit(&plan, 1.0, &result);
}

static void test_rounding_is_subtracted(void)
{
    fit_counts(10.0, 0.0);
    assert_holds(60.0 * sqrt(10.0 - (1.0 / 12.0)), term(DAVAR_ANGLE_RANDOM_WALK));
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->low > 170.0);
    fit_counts(10.0, 1.0);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 60.0 * sqrt(10.0 - (1.0 / 12.0)),
                              term(DAVAR_ANGLE_RANDOM_WALK)->value);
}

static void test_insignificant_noise_near_half_a_count_has_no_lower_limit(void)
{
    fit_counts(0.31, 0.0);
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->present);
    TEST_ASSERT_EQUAL_DOUBLE(0.0, term(DAVAR_ANGLE_RANDOM_WALK)->low);
}

static void assert_coarse(void)
{
    TEST_ASSERT_EQUAL(DAVAR_NOISE_COARSE, result.noise);
    TEST_ASSERT_EQUAL_UINT(0U, present_terms());
    TEST_ASSERT_TRUE(isinf(result.tau[0].high) && isinf(term(DAVAR_RATE_RANDOM_WALK)->high));
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 30.0, term(DAVAR_ANGLE_RANDOM_WALK)->high);
}

static void test_a_count_far_above_the_noise_is_coarse(void)
{
    const double model[] = {0, 1.0, 0, 0, 0};
    for (int power = 1; power < 12; power++) {
        set_octaves(600, 7);
        set_model(model);
        result.unit_per_count = pow(10.0, power);
        davar_fit(&plan, 1.0, &result);
        TEST_ASSERT_EQUAL(DAVAR_NOISE_COARSE, result.noise);
        TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high >=
                         30.0 * result.unit_per_count * (1.0 - 1e-6));
    }
}

static void test_noise_below_half_a_count_is_coarse(void)
{
    fit_counts(0.2, 0.0);
    assert_coarse();
    fit_counts(0.1, 0.01); /* a slow walk does not help: it appears as stairs */
    assert_coarse();
    (void)davar_fit_white(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6, 30.0, term(DAVAR_ANGLE_RANDOM_WALK)->high);
}

static void test_a_walk_of_counts_keeps_its_coefficient_with_hidden_noise(void)
{
    fit_counts(0.1, 1.0);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
    TEST_ASSERT_TRUE(term(DAVAR_RATE_RANDOM_WALK)->present);
    TEST_ASSERT_FALSE(term(DAVAR_ANGLE_RANDOM_WALK)->present);
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high >= 30.0 - 1e-6);
    fit_counts(0.3, 0.1);
    TEST_ASSERT_FALSE(term(DAVAR_ANGLE_RANDOM_WALK)->present);
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high >= 30.0 - 1e-6);
}

/* White noise, and beside a walk: with a count so fine that it takes nothing off, and where it
 * begins to. */
static void test_a_fine_count_changes_nothing(void)
{
    static const double units[] = {1e-300, 1e-30, 1e-9, 1e-6, 2e-5, 4e-5, 1e-4, 1e-3};
    for (unsigned i = 0U; i < 16U; i++) {
        const double model[] = {0, 1.0, 0, (i % 2U == 0U) ? 0.0 : 0.01, 0};
        set_octaves(6000, 10);
        set_model(model);
        result.unit_per_count = 0.0;
        davar_fit(&plan, 1.0, &result);
        const davar_coefficient_t whole = *term(DAVAR_ANGLE_RANDOM_WALK);
        result.unit_per_count = units[i / 2U];
        davar_fit(&plan, 1.0, &result);
        TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->present);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * whole.value, whole.value,
                                  term(DAVAR_ANGLE_RANDOM_WALK)->value);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * whole.value, whole.low,
                                  term(DAVAR_ANGLE_RANDOM_WALK)->low);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * whole.value, whole.high,
                                  term(DAVAR_ANGLE_RANDOM_WALK)->high);
    }
}

/* A term of 1.5 standard errors is not resolved, yet N may be smaller by it: only the lower limit
 * knows. */
static void test_an_unresolved_term_lowers_the_arw_limit_alone(void)
{
    const double white[] = {0, 1.0, 0, 0, 0};
    const double doubtful[] = {0.2, 0.9, 0, 0, 0};
    set_octaves(600, 7);
    set_model(white);
    davar_fit(&plan, 1.0, &result);
    const davar_coefficient_t sure = *term(DAVAR_ANGLE_RANDOM_WALK);
    set_model(doubtful);
    davar_fit(&plan, 1.0, &result);
    const davar_coefficient_t *unsure = term(DAVAR_ANGLE_RANDOM_WALK);
    TEST_ASSERT_EQUAL_UINT(1U << DAVAR_ANGLE_RANDOM_WALK, present_terms());
    TEST_ASSERT_TRUE(unsure->low / unsure->value < sure.low / sure.value - 0.02);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, sure.high / sure.value, unsure->high / unsure->value);
    TEST_ASSERT_TRUE(unsure->low < 60.0 * sqrt(0.9));
}

static void test_a_doubt_can_leave_nothing_of_the_arw(void)
{
    const double nearly_quantization[] = {0.75, 0.25, 0, 0, 0};
    set_octaves(16, 3);
    set_model(nearly_quantization);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL_UINT(1U << DAVAR_ANGLE_RANDOM_WALK, present_terms());
    TEST_ASSERT_EQUAL_DOUBLE(0.0, term(DAVAR_ANGLE_RANDOM_WALK)->low);
}

/* Every other estimate a tenth smaller, from m = 8 on, so that the short sizes do not read low: no
 * sum of these terms does that, and the interval must say so. */
static void test_a_misfit_widens_the_interval(void)
{
    const double white[] = {0, 1.0, 0, 0, 0};
    set_octaves(100000, 13);
    set_model(white);
    davar_fit(&plan, 1.0, &result);
    const davar_coefficient_t good = *term(DAVAR_ANGLE_RANDOM_WALK);
    for (int t = 3; t < 13; t += 2) {
        result.tau[t].adev *= 0.9;
    }
    davar_fit(&plan, 1.0, &result);
    const davar_coefficient_t *bad = term(DAVAR_ANGLE_RANDOM_WALK);
    TEST_ASSERT_TRUE(bad->high / bad->value > 1.0 + 5.0 * (good.high / good.value - 1.0));
}

/* Allan variance of a sinusoid of amplitude 1, f cycles per sample, summed over samples. */
static double tone_avar(double f, double m)
{
    const double pi = 3.14159265358979323846;
    const double sine = sin(pi * f * m);
    return (sine * sine * sine * sine) / (m * m * sin(pi * f) * sin(pi * f));
}

/* A rotor's tone in white noise. No term explains it, so the fit gives an ARW near the true one,
 * or only its limit. */
static void test_a_tone_hides_the_arw_or_leaves_it(void)
{
    int hidden = 0;
    int total = 0;
    for (int i = 0; i < 58; i++) {
        for (int k = 0; k < 14; k++) {
            const double f = 0.002 * pow(1.1, i);
            const double amplitude = 0.1 * pow(1.7, k);
            set_octaves(6000, 10);
            for (int t = 0; t < 10; t++) {
                const double m = ldexp(1.0, t);
                result.tau[t].adev = sqrt(1.0 / m + amplitude * amplitude * tone_avar(f, m));
            }
            davar_fit(&plan, 1.0, &result);
            const davar_coefficient_t *walk = term(DAVAR_ANGLE_RANDOM_WALK);
            TEST_ASSERT_TRUE(walk->present || (walk->high >= 60.0));
            TEST_ASSERT_TRUE(!walk->present || (fabs(walk->value / 60.0 - 1.0) < 0.3));
            hidden += walk->present ? 0 : 1;
            total++;
        }
    }
    TEST_ASSERT_TRUE((hidden > 0) && (hidden < total));
}

/* ---- windows that show little ---- */

static void test_one_tau_gives_only_arw(void)
{
    const uint32_t m[] = {4};
    set_taus(600, m, 1);
    result.tau[0].adev = 0.5;
    davar_fit(&plan, 1.0, &result);
    assert_holds(60.0, term(DAVAR_ANGLE_RANDOM_WALK));
    TEST_ASSERT_EQUAL_UINT(1U << DAVAR_ANGLE_RANDOM_WALK, present_terms());
    TEST_ASSERT_TRUE(isinf(term(DAVAR_QUANTIZATION)->high));
    TEST_ASSERT_TRUE(isinf(term(DAVAR_BIAS_INSTABILITY)->high));
    TEST_ASSERT_TRUE(isinf(term(DAVAR_RATE_RANDOM_WALK)->high));
    TEST_ASSERT_TRUE(isinf(term(DAVAR_RATE_RAMP)->high));
}

static void test_two_taus_resolve_two_terms_and_no_third(void)
{
    const double walk[] = {0, 1.0, 0, 0.5, 0};
    const uint32_t m[] = {1, 60};
    set_taus(600, m, 2);
    set_model(walk);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->present);
    TEST_ASSERT_TRUE(isinf(term(DAVAR_QUANTIZATION)->high));
}

static void test_nearly_equal_taus_do_not_separate_terms(void)
{
    const uint32_t m[] = {1U << 20U, (1U << 20U) + 1U};
    set_taus(1U << 24U, m, 2);
    result.tau[0].adev = 1e-3;
    result.tau[1].adev = 1e-2;
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL_UINT(0U, present_terms()); /* no term explains both */
    TEST_ASSERT_TRUE(isinf(term(DAVAR_RATE_RANDOM_WALK)->high));
}

static void test_a_constant_input_bounds_nothing(void)
{
    const double nothing[] = {0, 0, 0, 0, 0};
    set_octaves(600, 7);
    set_model(nothing);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL_UINT(0U, present_terms());
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        TEST_ASSERT_TRUE(isinf(result.coefficient[k].high));
    }
    TEST_ASSERT_EQUAL_DOUBLE(0.0, result.tau[3].low);
    TEST_ASSERT_TRUE(isinf(result.tau[3].high));
    TEST_ASSERT_EQUAL_INT(DAVAR_NOISE_CONSTANT, result.noise);
}

static void test_some_zero_variances_are_no_trap(void)
{
    set_octaves(600, 7);
    for (int t = 0; t < 7; t++) {
        result.tau[t].adev = (t % 2 == 0) ? 0.0 : 1.0;
    }
    davar_fit(&plan, 1.0, &result);
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        TEST_ASSERT_FALSE(isnan(result.coefficient[k].high));
    }
}

static void test_taus_without_differences_are_skipped(void)
{
    const double white[] = {0, 1.0, 0, 0, 0};
    set_octaves(20, 7);
    set_model(white);
    result.tau[4].adev = (double)NAN;
    result.tau[5].adev = (double)NAN;
    result.tau[6].adev = (double)NAN;
    TEST_ASSERT_EQUAL_UINT32(0U, result.tau[4].differences);
    davar_fit(&plan, 1.0, &result);
    assert_holds(60.0, term(DAVAR_ANGLE_RANDOM_WALK));
    TEST_ASSERT_TRUE(isfinite(result.tau[3].high));
    TEST_ASSERT_TRUE(isnan(result.tau[4].edf));
    TEST_ASSERT_TRUE(isnan(result.tau[4].low));
    TEST_ASSERT_TRUE(isnan(result.tau[6].high));
}

static void test_no_differences_at_all_is_no_knowledge_at_all(void)
{
    set_octaves(600, 3);
    for (int t = 0; t < 3; t++) {
        result.tau[t].differences = 0U;
        result.tau[t].adev = (double)NAN;
    }
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL_UINT(0U, present_terms());
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        TEST_ASSERT_TRUE(isinf(result.coefficient[k].high));
    }
    TEST_ASSERT_TRUE(isnan(result.tau[0].low));
}

static void test_no_cluster_sizes_at_all_is_no_knowledge_at_all(void)
{
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL_UINT(0U, present_terms());
    TEST_ASSERT_TRUE(isinf(term(DAVAR_ANGLE_RANDOM_WALK)->high));
}

static void test_the_longest_windows_and_lists_stay_finite(void)
{
    uint32_t m[DAVAR_TAUS_MAX];
    for (int t = 0; t < DAVAR_TAUS_MAX; t++) {
        m[t] = (UINT32_C(1) << 23U) - (uint32_t)(DAVAR_TAUS_MAX - 1 - t);
    }
    const double mix[] = {0, 1.0, 0, 0, 1e-20};
    set_taus(1U << 24U, m, DAVAR_TAUS_MAX);
    set_model(mix);
    davar_fit(&plan, 1.0 / 1e-4, &result);
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high > 0.0);
    set_octaves(1U << 24U, 24);
    set_model(mix);
    davar_fit(&plan, 1.0 / 1e-4, &result);
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->present);
    TEST_ASSERT_TRUE(isfinite(term(DAVAR_RATE_RAMP)->high));
    TEST_ASSERT_TRUE(isfinite(term(DAVAR_ANGLE_RANDOM_WALK)->low));
}

/* ---- numbers of any size ---- */

/* ---- whatever the list ---- */

static void assert_in_order(void)
{
    for (int t = 0; t < result.tau_count; t++) {
        TEST_ASSERT_TRUE((result.tau[t].low <= result.tau[t].adev) &&
                         (result.tau[t].adev <= result.tau[t].high));
    }
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        const davar_coefficient_t *const c = &result.coefficient[k];
        TEST_ASSERT_TRUE(c->high > 0.0);
        TEST_ASSERT_TRUE(!c->present ||
                         ((0.0 <= c->low) && (c->low <= c->value) && (c->value <= c->high)));
    }
}

static void test_limits_are_numbers_in_order_whatever_the_list(void)
{
    random_t random = random_seeded(5U);
    for (unsigned trial = 0U; trial < 300U; trial++) {
        uint32_t m[DAVAR_TAUS_MAX];
        const unsigned steps = 1U + (unsigned)(random_next(&random) % DAVAR_TAUS_MAX);
        const double ratio = 1.0 + ((trial % 2U == 0U) ? 0.0 : random_uniform(&random));
        uint8_t count = 0U;
        double size = 1.0 + (double)(random_next(&random) % 40U);
        do {
            m[count++] = (uint32_t)size;
            size = floor(size * ratio) + 1.0;
        } while ((count < steps) && (size < 1e6));
        set_taus((2U * m[count - 1U]) + 1U + (uint32_t)(random_next(&random) % 3000U), m, count);
        for (int t = 0; t < count; t++) {
            const double noise = 1.0 + (0.3 * random_gauss(&random));
            const double walk = (trial % 5U == 0U) ? (double)m[t] / 1000.0 : 0.0;
            result.tau[t].adev = fabs(noise) / sqrt((double)m[t]) + walk;
        }
        davar_fit(&plan, 1.0 / 0.01, &result);
        assert_in_order();
    }
}

/* Cluster sizes so alike, or so few, that terms are hardly separable. */
static void test_inseparable_terms_have_limits_in_order(void)
{
    static const struct {
        uint32_t window;
        uint8_t count;
        uint32_t m[3];
        uint32_t differences[3];
        double adev[3];
    } cases[] = {
        {52U, 3U, {15U, 16U, 17U}, {18U, 21U, 19U}, {0.39383, 0.35178, 0.36170}},
        {16110U, 2U, {12U, 7661U}, {16087U, 789U}, {0.358833, 0.148395}},
        {1728U, 3U, {30U, 31U, 32U}, {1669U, 1667U, 1665U}, {0.2630568, 0.2577470, 0.2712503}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        set_taus(cases[i].window, cases[i].m, cases[i].count);
        for (int t = 0; t < cases[i].count; t++) {
            result.tau[t].differences = cases[i].differences[t];
            result.tau[t].adev = cases[i].adev[t];
        }
        davar_fit(&plan, 1.0 / 0.01, &result);
        assert_in_order();
    }
}

/* No unit is too large or too small, nor an ADEV beside another: one that no float could hold
 * beside the rest is 0. */
static void test_a_negligible_deviation_is_absent(void)
{
    static const double tiny[] = {1e-160, 0.0};
    davar_coefficient_t found[2][DAVAR_COEFFICIENT_COUNT];
    for (int i = 0; i < 2; i++) {
        const double white[] = {0, 1e300, 0, 0, 0};
        set_octaves(600, 7);
        set_model(white);
        result.tau[0].adev = tiny[i];
        davar_fit(&plan, 1.0, &result);
        memcpy(found[i], result.coefficient, sizeof found[i]);
    }
    TEST_ASSERT_EQUAL_MEMORY(found[1], found[0], sizeof found[0]);
}

static void test_white_noise_of_any_size_is_found(void)
{
    for (int decade = -100; decade <= 100; decade += 10) {
        const double n = pow(10.0, decade);
        const double white[] = {0, n * n, 0, 0, 0};
        set_octaves(600, 7);
        set_model(white);
        davar_fit(&plan, 1.0, &result);
        assert_holds(60.0 * n, term(DAVAR_ANGLE_RANDOM_WALK));
        TEST_ASSERT_EQUAL_UINT(1U << DAVAR_ANGLE_RANDOM_WALK, present_terms());
    }
}

/* White noise alone: the same as davar_fit where it explains all, otherwise an upper limit that the
 * truth is below. */
static void test_the_fit_of_white_noise_alone(void)
{
    const double white[] = {0.0, 4.0, 0.0, 0.0, 0.0};
    const double drifting[] = {0.0, 4.0, 0.0, 0.3, 0.0};
    davar_result_t whole;
    set_octaves(600U, 7U);
    set_model(white);
    whole = result;
    TEST_ASSERT_TRUE(davar_fit_white(&plan, 50.0, &result));
    davar_fit(&plan, 50.0, &whole);
    TEST_ASSERT_EQUAL_INT(DAVAR_NOISE_WHITE, result.noise);
    TEST_ASSERT_EQUAL_INT(DAVAR_NOISE_WHITE, whole.noise);
    TEST_ASSERT_EQUAL_MEMORY(whole.tau, result.tau, 7U * sizeof result.tau[0]);
    TEST_ASSERT_EQUAL_MEMORY(whole.coefficient, result.coefficient, sizeof result.coefficient);
    set_model(drifting);
    whole = result;
    TEST_ASSERT_FALSE(davar_fit_white(&plan, 50.0, &result));
    davar_fit(&plan, 50.0, &whole);
    TEST_ASSERT_EQUAL_INT(DAVAR_NOISE_MIXED, result.noise);
    TEST_ASSERT_EQUAL_INT(DAVAR_NOISE_MIXED, whole.noise);
    const davar_coefficient_t *arw = term(DAVAR_ANGLE_RANDOM_WALK);
    TEST_ASSERT_FALSE(arw->present);
    TEST_ASSERT_TRUE((arw->high > 60.0 * sqrt(4.0 / 50.0)) &&
                     (arw->high < 1.3 * 60.0 * sqrt(4.3 / 50.0)));
    TEST_ASSERT_TRUE(isinf(term(DAVAR_RATE_RANDOM_WALK)->high) && isnan(result.tau[0].low) &&
                     isnan(result.tau[6].edf));
    memset(&result, 0, sizeof result);
    set_octaves(1U, 3U);
    TEST_ASSERT_FALSE(davar_fit_white(&plan, 50.0, &result));
    TEST_ASSERT_EQUAL_INT(DAVAR_NOISE_UNKNOWN, result.noise);
    TEST_ASSERT_TRUE(isinf(arw->high));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_white_noise_is_arw_and_nothing_else);
    RUN_TEST(test_every_term_comes_back_in_its_unit);
    RUN_TEST(test_three_terms_together);
    RUN_TEST(test_pure_drift_has_no_arw_but_an_upper_bound);
    RUN_TEST(test_adev_intervals_are_chi_square_with_the_edf_of_the_noise);
    RUN_TEST(test_edf_follows_the_dominant_noise);
    RUN_TEST(test_missing_differences_cost_degrees_of_freedom);
    RUN_TEST(test_edf_is_never_below_one);
    RUN_TEST(test_rounding_is_subtracted);
    RUN_TEST(test_insignificant_noise_near_half_a_count_has_no_lower_limit);
    RUN_TEST(test_a_count_far_above_the_noise_is_coarse);
    RUN_TEST(test_noise_below_half_a_count_is_coarse);
    RUN_TEST(test_a_walk_of_counts_keeps_its_coefficient_with_hidden_noise);
    RUN_TEST(test_a_fine_count_changes_nothing);
    RUN_TEST(test_an_unresolved_term_lowers_the_arw_limit_alone);
    RUN_TEST(test_a_doubt_can_leave_nothing_of_the_arw);
    RUN_TEST(test_a_misfit_widens_the_interval);
    RUN_TEST(test_a_tone_hides_the_arw_or_leaves_it);
    RUN_TEST(test_one_tau_gives_only_arw);
    RUN_TEST(test_two_taus_resolve_two_terms_and_no_third);
    RUN_TEST(test_nearly_equal_taus_do_not_separate_terms);
    RUN_TEST(test_a_constant_input_bounds_nothing);
    RUN_TEST(test_some_zero_variances_are_no_trap);
    RUN_TEST(test_taus_without_differences_are_skipped);
    RUN_TEST(test_no_differences_at_all_is_no_knowledge_at_all);
    RUN_TEST(test_no_cluster_sizes_at_all_is_no_knowledge_at_all);
    RUN_TEST(test_the_longest_windows_and_lists_stay_finite);
    RUN_TEST(test_a_negligible_deviation_is_absent);
    RUN_TEST(test_white_noise_of_any_size_is_found);
    RUN_TEST(test_limits_are_numbers_in_order_whatever_the_list);
    RUN_TEST(test_inseparable_terms_have_limits_in_order);
    RUN_TEST(test_the_fit_of_white_noise_alone);
    return UNITY_END();
}
