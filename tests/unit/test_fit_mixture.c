/* davar tests - the general fit of a mix of noise terms: which terms it includes and excludes, and
 * that it agrees with the fast path for white noise. */
#include "fit/mixture.h"
#include "fit/plan.h"
#include "fit_fixture.h"

/* For white noise, the general fit must evaluate a further term like the fast path. */
static void test_general_fit_agrees_with_the_short_cut(void)
{
    const double nearly_white[] = {0.02, 1.0, 0.001, 0, 0};
    set_octaves(600, 7);
    set_model(nearly_white);
    davar_fit(&plan, 1.0, &result);
    davar_mixture_t model = {.data = &result, .plan = &plan, .end = plan.count};
    davar_mixture_fit(&model, 1.0, 0U);
    TEST_ASSERT_EQUAL_UINT(1U << DAVAR_ANGLE_RANDOM_WALK, model.terms);
    /* other weights: they differ by less than a hundredth of a standard error */
    TEST_ASSERT_DOUBLE_WITHIN(0.017, term(DAVAR_ANGLE_RANDOM_WALK)->value, 60.0 * sqrt(model.a[1]));
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        const double share =
            (double)plan.sigma[k] / (double)(1U << DAVAR_FIT_SHARE_BITS) * (double)plan.scale[k];
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
    davar_mixture_t model = {.data = &result, .plan = &plan, .end = plan.count};
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

/* Five terms, each of which dominates some octaves: found one after the other, without an initial
 * guess, and exactly. */
static void test_all_five_terms_are_found_from_white_noise_alone(void)
{
    const double mix[] = {300.0, 1.0, 4e-4, 3e-8, 3e-13};
    set_octaves(UINT32_C(1) << 24U, 22);
    set_model(mix);
    davar_mixture_t model = {.data = &result, .plan = &plan, .end = plan.count};
    davar_mixture_fit(&model, 1.0, 0U);
    TEST_ASSERT_EQUAL_UINT((1U << DAVAR_COEFFICIENT_COUNT) - 1U, model.terms);
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * mix[k], mix[k], model.a[k]);
    }
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
        davar_mixture_t model = {.data = &result, .plan = &plan, .end = plan.count};
        davar_mixture_fit(&model, 1.0, 0U);
        TEST_ASSERT_EQUAL_UINT(terms, model.terms);
        for (unsigned k = 0U; k < (unsigned)DAVAR_COEFFICIENT_COUNT; k++) {
            if ((terms & (1U << k)) == 0U) {
                TEST_ASSERT_TRUE(fabs(model.tried[k]) < (1e-3 * sqrt(model.variance[k])));
                TEST_ASSERT_TRUE(isfinite(model.variance[k]));
            }
        }
    }
}

/* With one term the degrees of freedom are those of its noise, less the lost differences, and at
 * least one. */
/* A ramp may be a million times as large as the errors of the other terms. They still have a
 * limit. */
static void test_limits_beside_a_drift_that_is_a_million_times_as_large(void)
{
    for (int k = -12; k <= 12; k++) {
        const double a[] = {0.0, 1.0, 0.0, 0.0, pow(10.0, k)};
        set_octaves(UINT32_C(1) << 26U, 22U);
        set_model(a);
        davar_fit(&plan, 1.0, &result);
        for (int kind = 0; kind < (int)DAVAR_COEFFICIENT_COUNT; kind++) {
            TEST_ASSERT_TRUE(term((davar_coefficient_kind_t)kind)->high > 0.0);
        }
    }
}

static void test_degrees_of_freedom_of_one_term(void)
{
    uint32_t clamped = 0U;
    const uint32_t window = 64U;
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        davar_mixture_t model = {
            .data = &result, .plan = &plan, .end = plan.count, .terms = 1U << (unsigned)k};
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

/* Rounding alone scatters like white noise, with at least one degree of freedom. */
static void test_degrees_of_freedom_of_rounding(void)
{
    for (uint32_t m = 1U; m <= 32U; m++) {
        set_taus(64U, &m, 1);
        const davar_mixture_t model = {
            .data = &result, .plan = &plan, .end = plan.count, .rounding = 0.3};
        const double edf = davar_noise_edf(DAVAR_ANGLE_RANDOM_WALK, m, result.tau[0].differences);
        TEST_ASSERT_DOUBLE_WITHIN(1e-6 * edf, edf, davar_mixture_edf(&model, 0));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_general_fit_agrees_with_the_short_cut);
    RUN_TEST(test_a_superfluous_term_is_removed);
    RUN_TEST(test_insignificant_white_noise_is_removed);
    RUN_TEST(test_an_uncertain_term_that_the_others_cannot_replace_stays);
    RUN_TEST(test_all_five_terms_are_found_from_white_noise_alone);
    RUN_TEST(test_in_an_exact_mix_absent_terms_are_zero);
    RUN_TEST(test_limits_beside_a_drift_that_is_a_million_times_as_large);
    RUN_TEST(test_degrees_of_freedom_of_one_term);
    RUN_TEST(test_degrees_of_freedom_of_rounding);
    return UNITY_END();
}
