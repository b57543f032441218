/* davar tests - the fit of a mix of noise terms, of a window (5.4) and of a cascade (5.18), and its
 * plan: exact models in, the same coefficients out. Values that a window cannot show stay absent. */
#include "davar/fit.h"
#include "fit/mixture.h"
#include "fit/plan.h"
#include "fit_fixture.h"
#include "random.h"
#include "shape.h"

/* ---- results and their units ---- */

/* A coefficient in its unit, from a term of the Allan variance in sample units (1.2). */
static double in_its_unit(int kind, double a, double tau0)
{
    const double pi = 3.14159265358979323846;
    const double square[] = {tau0 * tau0 / 3.0, 3600.0 * tau0, 3600.0 * 3600.0 * pi / log(4.0),
                             3.0 * 216000.0 * 216000.0 / tau0,
                             2.0 * 12960000.0 * 12960000.0 / (tau0 * tau0)};
    return sqrt(a * square[kind]);
}

/* Present terms have their value within their limits, the others a limit only. */
static void test_every_mix_comes_back_in_its_unit(void)
{
    static const struct {
        uint32_t window;
        uint8_t octaves;
        double tau0;
        double mix[DAVAR_COEFFICIENT_COUNT];
    } cases[] = {
        {600U, 7U, 0.01, {0, 4.0, 0, 0, 0}},           {600U, 7U, 1.0, {0, 0, 0, 1.0, 0}},
        {100000U, 13U, 0.25, {12.0, 1.0, 0, 0, 0}},    {100000U, 13U, 0.25, {0, 1.0, 0.04, 0, 0}},
        {100000U, 13U, 0.25, {0, 1.0, 0, 0.003, 0}},   {100000U, 13U, 0.25, {0, 1.0, 0, 0, 3e-6}},
        {1000000U, 16U, 1.0, {30.0, 1.0, 0, 3e-5, 0}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        set_octaves(cases[i].window, cases[i].octaves);
        set_model(cases[i].mix);
        davar_fit(&plan, 1.0 / cases[i].tau0, &result);
        for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
            const davar_coefficient_t *const found = &result.coefficient[k];
            const double truth = in_its_unit(k, cases[i].mix[k], cases[i].tau0);
            if (truth > 0.0) {
                assert_holds(truth, found);
            } else {
                assert_absent_below(INFINITY, found);
                TEST_ASSERT_TRUE(found->high > 0.0);
            }
        }
    }
}

static void test_white_noise_limits_the_other_terms(void)
{
    const double white[] = {0, 4.0, 0, 0, 0};
    set_octaves(600, 7);
    set_model(white);
    davar_fit(&plan, 1.0 / 0.01, &result);
    assert_absent_below(0.01 * 1.0, term(DAVAR_QUANTIZATION));
    assert_absent_below(3600.0 * 0.5, term(DAVAR_BIAS_INSTABILITY));
    assert_absent_below(216000.0 * 0.5 / sqrt(0.01), term(DAVAR_RATE_RANDOM_WALK));
    assert_absent_below(12960000.0 * 0.1 / 0.01, term(DAVAR_RATE_RAMP));
}

/* ---- intervals ---- */

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

/* For white noise, the general fit must evaluate a further term like the fast path. */
static void test_general_fit_agrees_with_the_short_cut(void)
{
    const double nearly_white[] = {0.02, 1.0, 0.001, 0, 0};
    set_octaves(600, 7);
    set_model(nearly_white);
    davar_fit(&plan, 1.0, &result);
    davar_mixture_t model = {.data = &result, .plan = &plan, .end = plan.white.count};
    davar_mixture_fit(&model, 1.0, 0U);
    TEST_ASSERT_EQUAL_UINT(1U << DAVAR_ANGLE_RANDOM_WALK, model.terms);
    /* other weights: they differ by less than a hundredth of a standard error */
    TEST_ASSERT_DOUBLE_WITHIN(0.017, term(DAVAR_ANGLE_RANDOM_WALK)->value, 60.0 * sqrt(model.a[1]));
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        const double share = (double)plan.white.sigma[k] / (double)(1U << DAVAR_FIT_SHARE_BITS) *
                             (double)plan.scale[k];
        const double sigma = share * (double)plan.unit[k] * model.a[1];
        /* the weights of the short cut have the least variance */
        TEST_ASSERT_TRUE(sqrt(model.variance[k]) > 0.9999 * sigma);
        TEST_ASSERT_TRUE(sqrt(model.variance[k]) < 1.12 * sigma);
    }
}

static void test_a_superfluous_term_is_removed(void)
{
    const double walk[] = {0, 0, 0, 1.0, 0};
    set_octaves(600, 7);
    set_model(walk);
    davar_mixture_t model = {.data = &result, .plan = &plan, .end = plan.white.count};
    davar_mixture_fit(&model, 1.0, 1U << DAVAR_RATE_RAMP); /* the wrong suspect */
    TEST_ASSERT_EQUAL_UINT(1U << DAVAR_RATE_RANDOM_WALK, model.terms);
}

/* With flicker found first, the white noise of a short window may no longer be significant. */
static void test_insignificant_white_noise_is_removed(void)
{
    const double flicker[] = {0, 1.0, 0.63, 0, 0};
    set_octaves(90, 4);
    set_model(flicker);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL_UINT(1U << DAVAR_BIAS_INSTABILITY, present_terms());
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high > 60.0);
}

/* An estimate with few degrees of freedom is never far from zero in its own standard errors;
 * without it the rest is. */
static void test_an_uncertain_term_that_the_others_cannot_replace_stays(void)
{
    const double mix[] = {2.1, 1.0, 0, 0.00755579, 0};
    set_octaves(681, 6);
    set_model(mix);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_TRUE(term(DAVAR_QUANTIZATION)->present);
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->present);
}

/* An exact mix of any terms: nothing is left for the absent ones. */
static void test_in_an_exact_mix_absent_terms_are_zero(void)
{
    const double all[] = {300.0, 1.0, 4e-4, 3e-8, 3e-13};
    set_octaves(UINT32_C(1) << 24U, 22);
    for (unsigned terms = 0U; terms < 32U; terms++) {
        double mix[DAVAR_COEFFICIENT_COUNT] = {0};
        if ((terms & (1U << DAVAR_ANGLE_RANDOM_WALK)) == 0U) {
            continue;
        }
        for (unsigned k = 0U; k < (unsigned)DAVAR_COEFFICIENT_COUNT; k++) {
            mix[k] = ((terms & (1U << k)) != 0U) ? all[k] : 0.0;
        }
        set_model(mix);
        davar_mixture_t model = {.data = &result, .plan = &plan, .end = plan.white.count};
        davar_mixture_fit(&model, 1.0, 0U);
        TEST_ASSERT_EQUAL_UINT(terms, model.terms);
        for (unsigned k = 0U; k < (unsigned)DAVAR_COEFFICIENT_COUNT; k++) {
            if ((terms & (1U << k)) != 0U) {
                TEST_ASSERT_DOUBLE_WITHIN(1e-4 * mix[k], mix[k], model.a[k]);
            } else {
                TEST_ASSERT_TRUE(fabs(model.tried[k]) < (1e-3 * sqrt(model.variance[k])));
                TEST_ASSERT_TRUE(isfinite(model.variance[k]));
            }
        }
    }
}

static void test_degrees_of_freedom_of_one_term(void)
{
    uint32_t clamped = 0U;
    const uint32_t window = 64U;
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        davar_mixture_t model = {
            .data = &result, .plan = &plan, .end = plan.white.count, .terms = 1U << (unsigned)k};
        model.a[k] = 0.7;
        for (uint32_t m = 1U; m <= (window / 2U); m++) {
            const uint32_t all = window - (2U * m) + 1U;
            set_taus(window, &m, 1);
            for (uint32_t left = 1U; left <= all; left++) {
                result.tau[0].differences = left;
                const double edf =
                    davar_noise_edf((davar_coefficient_kind_t)k, m, all) * left / all;
                TEST_ASSERT_DOUBLE_WITHIN(1e-6 * edf, (edf > 1.0) ? edf : 1.0,
                                          davar_mixture_edf(&model, 0));
                clamped += (edf < 1.0) ? 1U : 0U;
            }
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT32(1000U, clamped);
}

/* ---- the plan is a cache ---- */

static void assert_same_as_fresh(const uint32_t *m, uint8_t count)
{
    davar_result_t again = result;
    davar_plan_t fresh;
    memset(&fresh, 0xA5, sizeof fresh);
    davar_plan_init_white(&fresh, m, count);
    davar_fit(&fresh, 1.0 / 0.5, &again);
    davar_fit(&plan, 1.0 / 0.5, &result);
    TEST_ASSERT_EQUAL_MEMORY(again.tau, result.tau, sizeof result.tau);
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        TEST_ASSERT_EQUAL_INT(again.coefficient[k].present, result.coefficient[k].present);
        TEST_ASSERT_EQUAL_DOUBLE(again.coefficient[k].value, result.coefficient[k].value);
        TEST_ASSERT_EQUAL_DOUBLE(again.coefficient[k].low, result.coefficient[k].low);
        TEST_ASSERT_EQUAL_DOUBLE(again.coefficient[k].high, result.coefficient[k].high);
    }
}

static void test_a_used_plan_gives_what_a_fresh_one_gives(void)
{
    static const uint32_t m[] = {1, 3, 9, 27, 81};
    static const uint32_t windows[] = {600, 600, 400, 150, 20, 150, 600, 1, 600};
    const double mix[] = {0.1, 1.0, 0, 0.001, 0};
    set_taus(600, m, 5);
    for (size_t i = 0; i < sizeof windows / sizeof windows[0]; i++) {
        result.window_samples = windows[i];
        for (int t = 0; t < 5; t++) {
            result.tau[t].differences =
                (2U * m[t] <= windows[i]) ? windows[i] - 2U * m[t] + 1U : 0U;
        }
        set_model(mix);
        assert_same_as_fresh(m, 5);
        result.tau[0].differences -=
            (result.tau[0].differences > 3U) ? 3U : 0U; /* a gap, then complete again */
        assert_same_as_fresh(m, 5);
    }
}

static void test_the_longest_window_has_the_degrees_of_freedom_of_white_noise(void)
{
    static const uint32_t m[] = {1U, 2U, 8U, UINT32_C(1) << 28U};
    const uint32_t longest = UINT32_C(1) << 31U;
    const double white[] = {0, 1.0, 0, 0, 0};
    set_taus(longest, m, 4);
    set_model(white);
    TEST_ASSERT_TRUE(davar_fit_white(&plan, 1.0, &result));
    for (int t = 0; t < 4; t++) {
        const double edf = davar_edf(DAVAR_ANGLE_RANDOM_WALK, m[t], longest);
        TEST_ASSERT_DOUBLE_WITHIN(0.02 * edf, edf, result.tau[t].edf);
    }
}

/* ---- heavy tails (5.19) ---- */

static double edf_with(double kurtosis, double dispersion)
{
    result.kurtosis = kurtosis;
    result.dispersion = dispersion;
    (void)davar_fit_white(&plan, 1.0, &result);
    return result.tau[0].edf;
}

static void test_tails_reduce_the_degrees_of_freedom(void)
{
    static const uint32_t m[] = {1, 2, 4};
    const double white[] = {0, 1.0, 0, 0, 0};
    set_taus(600, m, 3);
    set_model(white);
    const double edf = edf_with((double)NAN, (double)NAN);
    const double spread = sqrt(24.0 / 600.0);
    const struct {
        double kurtosis;
        double dispersion;
        double kappa;
    } cases[] = {
        {3.0, 9.0, 0.0},
        {1.8, 9.0, 0.0},
        {3.0 + (1.19 * spread), 1.0, 0.0}, /* by chance */
        {3.0 + (1.21 * spread), 1.0, 1.21 * spread * (1.0 + (5.0 * 1.21 * spread * spread))},
        {5.0, 1.0, 2.0 * (1.0 + (10.0 * spread))},
        {40.0, 1.0, 80.0}, /* at most */
        {(double)NAN, 1.19, 0.0},
        {(double)NAN, 1.21, 0.42},
        {(double)NAN, 2.9, 3.8},
        {(double)NAN, 3.1, 4.41}, /* the square */
        {(double)NAN, 9.9, 79.21},
        {(double)NAN, 15.9, 80.0},
        {(double)NAN, 200.0, 80.0},
        {(double)INFINITY, (double)NAN, 0.0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const double more = cases[i].kappa / (2.0 * (599.0 + 0.5));
        TEST_ASSERT_DOUBLE_WITHIN(1e-5 * edf, 1.0 / ((1.0 / edf) + more),
                                  edf_with(cases[i].kurtosis, cases[i].dispersion));
    }
    result.kurtosis = 0.0;
    result.dispersion = 0.0;
}

/* ---- the variances of the plan compared with brute force ---- */

#define LENGTH 64

/* Sum over all pairs of differences of the squared covariance, for white noise of variance 1. */
static double squared_covariances(int m_i, int m_j)
{
    double sum = 0.0;
    for (int p = 0; p + 2 * m_i <= LENGTH; p++) {
        for (int q = 0; q + 2 * m_j <= LENGTH; q++) {
            int r = 0;
            for (int i = p; i < p + 2 * m_i; i++) {
                const int sign = (i < p + m_i) ? 1 : -1;
                const bool inside = (i >= q) && (i < q + 2 * m_j);
                r += inside ? ((i < q + m_j) ? sign : -sign) : 0;
            }
            sum += (double)r * r;
        }
    }
    return sum;
}

/* Covariance of y = m avar at two cluster sizes. */
static double brute_covariance(int m_i, int m_j)
{
    const double n_i = LENGTH - 2 * m_i + 1;
    const double n_j = LENGTH - 2 * m_j + 1;
    return squared_covariances(m_i, m_j) / (2.0 * m_i * m_j * n_i * n_j);
}

/* The weight of one Allan variance in a linear functional of the fit, from the plan
 * (test_fit_white.c compares the resulting shares with the formulas); this tests its variance. */
static double weight_of(int kind, int t)
{
    return (double)plan.white.functional[kind][t] / DAVAR_FIT_FUNCTIONAL_ONE;
}

static void test_standard_errors_match_the_full_covariance(void)
{
    static const uint32_t m[] = {1, 2, 4, 7};
    const double white[] = {0, 1.0, 0, 0, 0};
    set_taus(LENGTH, m, 4);
    set_model(white);
    davar_fit(&plan, 1.0, &result);
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        double variance = 0.0;
        for (int i = 0; i < 4; i++) {
            for (int j = 0; j < 4; j++) {
                variance +=
                    weight_of(k, i) * weight_of(k, j) * brute_covariance((int)m[i], (int)m[j]);
            }
        }
        TEST_ASSERT_DOUBLE_WITHIN(0.03 * sqrt(variance), sqrt(variance),
                                  (double)plan.white.sigma[k] /
                                      (double)(1U << DAVAR_FIT_SHARE_BITS));
    }
}

#define CURVE_WINDOW 600U
#define SHORT 7U /* octaves 1 to 64 in the window */
#define LONG 10U /* octaves 128 to 65536 in the cascade, 48 clusters each */
#define CLUSTERS 48U

/* White noise, flicker and random walk that cross at about 500 and 16000 samples. */
static const double mixed_curve[] = {0, 1.0, 0.002, 1.2e-7, 0};
static const double white_curve[] = {0, 1.0, 0, 0, 0};

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
    set_octaves(CURVE_WINDOW, (window > 0U) ? window : 1U);
    result.window_samples = (window > 0U) ? CURVE_WINDOW : 0U;
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

/* The flicker of `mixed_curve` is too small for the window, and raises its white noise a little. */
static void assert_white_of_window(void)
{
    const davar_coefficient_t *const found = term(DAVAR_ANGLE_RANDOM_WALK);
    TEST_ASSERT_TRUE(found->present);
    TEST_ASSERT_DOUBLE_WITHIN(0.3, 60.0, found->value);
    TEST_ASSERT_TRUE((found->low < 60.0) && (found->high > 60.0));
}

static void test_slow_terms_come_from_the_cascade(void)
{
    set_curve(SHORT, LONG, mixed_curve);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
    assert_white_of_window();
    assert_holds(3600.0 * sqrt(mixed_curve[2] / 0.441271200305303), term(DAVAR_BIAS_INSTABILITY));
    assert_holds(216000.0 * sqrt(3.0 * mixed_curve[3]), term(DAVAR_RATE_RANDOM_WALK));
    for (uint8_t t = 0U; t < result.tau_count; t++) {
        TEST_ASSERT_TRUE(result.tau[t].low < result.tau[t].adev);
        TEST_ASSERT_TRUE(result.tau[t].high > result.tau[t].adev);
        TEST_ASSERT_TRUE((t < SHORT) || ((result.tau[t].edf > 30.0) && (result.tau[t].edf < 80.0)));
    }
}

static void test_white_noise_stays_that_of_the_window(void)
{
    davar_result_t window;
    set_curve(SHORT, 0U, white_curve);
    davar_fit(&plan, 1.0, &result);
    window = result;
    set_curve(SHORT, LONG, white_curve);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_WHITE, result.noise);
    for (int k = DAVAR_QUANTIZATION; k <= DAVAR_ANGLE_RANDOM_WALK; k++) {
        TEST_ASSERT_EQUAL_MEMORY(&window.coefficient[k].high, &result.coefficient[k].high,
                                 sizeof(double));
    }
    TEST_ASSERT_TRUE(term(DAVAR_RATE_RANDOM_WALK)->high <
                     0.01 * window.coefficient[DAVAR_RATE_RANDOM_WALK].high);
}

/* White noise is all that a fit finds, but it does not explain the sizes. */
static void test_a_cascade_that_no_mix_explains(void)
{
    set_curve(SHORT, LONG, white_curve);
    for (uint8_t t = SHORT; t < result.tau_count; t++) {
        result.tau[t].adev *= ((t % 2U) == 0U) ? 0.7 : 1.4;
    }
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
    TEST_ASSERT_EQUAL_UINT(1U << DAVAR_ANGLE_RANDOM_WALK, present_terms());
}

/* The cascade of a stream that had gaps: a size has no difference. The window is short. */
static void test_sizes_without_differences_are_left_out(void)
{
    const double flicker[] = {0, 1.0, mixed_curve[2], 0, 0};
    set_curve(SHORT, LONG, flicker);
    result.tau[5].differences = 0U;
    result.tau[6].differences = 0U;
    result.tau[SHORT].differences = 0U;
    result.tau[SHORT + 3U].differences = 0U;
    result.tau[SHORT + 6U].differences = 3U; /* filled again */
    result.tau[SHORT + LONG - 1U].differences = 0U;
    davar_fit(&plan, 1.0, &result);
    assert_white_of_window();
    assert_holds(3600.0 * sqrt(mixed_curve[2] / 0.441271200305303), term(DAVAR_BIAS_INSTABILITY));
    TEST_ASSERT_TRUE(isnan(result.tau[6].low));
    TEST_ASSERT_TRUE(isnan(result.tau[SHORT].low));
    TEST_ASSERT_TRUE(isnan(result.tau[SHORT + 3U].low));
    TEST_ASSERT_TRUE(isfinite(result.tau[SHORT + 4U].low));
}

static void test_a_cascade_alone_gives_all_terms(void)
{
    set_curve(0U, LONG, mixed_curve);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
    assert_holds(60.0, term(DAVAR_ANGLE_RANDOM_WALK));
    assert_holds(3600.0 * sqrt(mixed_curve[2] / 0.441271200305303), term(DAVAR_BIAS_INSTABILITY));
    set_curve(0U, LONG, white_curve);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_WHITE, result.noise);
    set_curve(0U, 1U, white_curve);
    davar_plan_init(&plan, &result.tau[0].m, 1U); /* no filter is declared */
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->present);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, 60.0, term(DAVAR_ANGLE_RANDOM_WALK)->value);
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
    set_curve(0U, LONG, white_curve);
    result.tau[0].adev = 0.0; /* one size of 0 is no constant */
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_TRUE(result.noise != DAVAR_NOISE_CONSTANT);
}

/* A filter passes no quantization noise. */
static void test_a_cascade_alone_that_contradicts_the_filter(void)
{
    const double quantized[] = {300.0, 1.0, 0, 0, 0};
    const shape_t filter = {.cutoff = 0.02, .poles = 1U};
    uint32_t m[LONG];
    set_curve(0U, LONG, quantized);
    for (uint8_t t = 0U; t < LONG; t++) {
        m[t] = result.tau[t].m;
    }
    plan_shape(&plan, m, LONG, &filter);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_FILTERED, result.noise);
    TEST_ASSERT_EQUAL_UINT(0U, present_terms());
    TEST_ASSERT_TRUE(isinf(result.tau[0].high));
}

/* What the window withholds stays withheld. */
static void test_a_window_that_is_withheld(void)
{
    uint32_t m[SHORT + LONG];
    set_curve(SHORT, LONG, white_curve);
    for (uint8_t t = 0U; t < result.tau_count; t++) {
        m[t] = result.tau[t].m;
        result.tau[t].adev = sqrt(avar_at((t < SHORT) ? after_filter : white_curve, m[t]));
    }
    davar_plan_init(&plan, m, result.tau_count);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_FILTERED, result.noise);
    TEST_ASSERT_EQUAL_UINT(0U, present_terms());
    TEST_ASSERT_TRUE(isinf(result.tau[SHORT].high));
}

static void test_a_window_of_a_mix_keeps_its_short_terms(void)
{
    const double quantized[] = {3.0, 1.0, mixed_curve[2], 0, 0};
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
    set_curve(SHORT, 0U, mixed_curve);
    davar_fit(&plan, 1.0, &result);
    window = result;
    set_curve(SHORT, 3U, mixed_curve);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL_MEMORY(window.coefficient, result.coefficient, sizeof window.coefficient);
    TEST_ASSERT_TRUE(result.tau[SHORT].low < result.tau[SHORT].adev);
    set_curve(SHORT, 4U, mixed_curve);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_TRUE(term(DAVAR_RATE_RAMP)->high < window.coefficient[DAVAR_RATE_RAMP].high);
    TEST_ASSERT_TRUE(isfinite(result.tau[SHORT].low));
}

static void test_degrees_of_freedom_for_any_noise(void)
{
    set_curve(SHORT, LONG, white_curve);
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
    RUN_TEST(test_every_mix_comes_back_in_its_unit);
    RUN_TEST(test_white_noise_limits_the_other_terms);
    RUN_TEST(test_edf_follows_the_dominant_noise);
    RUN_TEST(test_rounding_is_subtracted);
    RUN_TEST(test_insignificant_noise_near_half_a_count_has_no_lower_limit);
    RUN_TEST(test_noise_below_half_a_count_is_coarse);
    RUN_TEST(test_a_walk_of_counts_keeps_its_coefficient_with_hidden_noise);
    RUN_TEST(test_a_misfit_widens_the_interval);
    RUN_TEST(test_a_tone_hides_the_arw_or_leaves_it);
    RUN_TEST(test_one_tau_gives_only_arw);
    RUN_TEST(test_nearly_equal_taus_do_not_separate_terms);
    RUN_TEST(test_a_constant_input_bounds_nothing);
    RUN_TEST(test_taus_without_differences_are_skipped);
    RUN_TEST(test_a_negligible_deviation_is_absent);
    RUN_TEST(test_white_noise_of_any_size_is_found);
    RUN_TEST(test_inseparable_terms_have_limits_in_order);
    RUN_TEST(test_the_fit_of_white_noise_alone);
    RUN_TEST(test_general_fit_agrees_with_the_short_cut);
    RUN_TEST(test_a_superfluous_term_is_removed);
    RUN_TEST(test_insignificant_white_noise_is_removed);
    RUN_TEST(test_an_uncertain_term_that_the_others_cannot_replace_stays);
    RUN_TEST(test_in_an_exact_mix_absent_terms_are_zero);
    RUN_TEST(test_degrees_of_freedom_of_one_term);
    RUN_TEST(test_a_used_plan_gives_what_a_fresh_one_gives);
    RUN_TEST(test_the_longest_window_has_the_degrees_of_freedom_of_white_noise);
    RUN_TEST(test_tails_reduce_the_degrees_of_freedom);
    RUN_TEST(test_standard_errors_match_the_full_covariance);
    RUN_TEST(test_slow_terms_come_from_the_cascade);
    RUN_TEST(test_white_noise_stays_that_of_the_window);
    RUN_TEST(test_a_cascade_that_no_mix_explains);
    RUN_TEST(test_sizes_without_differences_are_left_out);
    RUN_TEST(test_a_cascade_alone_gives_all_terms);
    RUN_TEST(test_a_cascade_alone_without_white_noise);
    RUN_TEST(test_a_cascade_alone_that_is_constant);
    RUN_TEST(test_a_cascade_alone_that_contradicts_the_filter);
    RUN_TEST(test_a_window_that_is_withheld);
    RUN_TEST(test_a_window_of_a_mix_keeps_its_short_terms);
    RUN_TEST(test_few_sizes_of_a_cascade_leave_the_terms_to_the_window);
    RUN_TEST(test_degrees_of_freedom_for_any_noise);
    return UNITY_END();
}
