/* davar tests - the coefficient fit: exact models in, the same coefficients out; what a window cannot show stays absent. */
#include "davar/confidence.h"
#include "davar/fit.h"
#include "fit_mixture.h"
#include "fit_plan.h"
#include "noise.h"
#include "unity.h"

#include <math.h>
#include <string.h>

static davar_fit_plan_t plan;
static davar_result_t result;

void setUp(void)
{
    memset(&plan, 0, sizeof plan);
    memset(&result, 0, sizeof result);
}

void tearDown(void) {}

/* The Allan variance of a mix in sample units, a[k] m^(k - 2), DESIGN (1.2). */
static double avar_at(const double a[], double m)
{
    return a[0] / (m * m) + a[1] / m + a[2] + a[3] * m + a[4] * m * m;
}

static void set_taus(uint32_t window, const uint32_t *m, uint8_t count)
{
    result.window_samples = window;
    result.tau_count = count;
    for (int t = 0; t < count; t++) {
        result.tau[t].m = m[t];
        result.tau[t].differences = (2U * m[t] <= window) ? window - 2U * m[t] + 1U : 0U;
    }
    davar_fit_plan(&plan, m, count);
}

static void set_octaves(uint32_t window, uint8_t count)
{
    uint32_t m[DAVAR_TAUS_MAX];
    for (int t = 0; t < count; t++) {
        m[t] = UINT32_C(1) << (unsigned)t;
    }
    set_taus(window, m, count);
}

static void set_model(const double a[])
{
    for (int t = 0; t < result.tau_count; t++) {
        result.tau[t].adev = sqrt(avar_at(a, result.tau[t].m));
    }
}

static const davar_coefficient_t *term(davar_coefficient_kind_t kind)
{
    return &result.coefficient[kind];
}

static unsigned present_terms(void)
{
    unsigned found = 0U;
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        found |= (result.coefficient[k].present ? 1U : 0U) << (unsigned)k;
    }
    return found;
}

static void assert_holds(double truth, const davar_coefficient_t *c)
{
    TEST_ASSERT_TRUE(c->present);
    TEST_ASSERT_DOUBLE_WITHIN(1e-6 * truth, truth, c->value);
    TEST_ASSERT_TRUE(c->low < truth);
    TEST_ASSERT_TRUE(c->high > truth);
}

static void assert_absent_below(double bound, const davar_coefficient_t *c)
{
    TEST_ASSERT_FALSE(c->present);
    TEST_ASSERT_TRUE(isnan(c->value));
    TEST_ASSERT_TRUE(isnan(c->low));
    TEST_ASSERT_TRUE(c->high <= bound);
}

/* ---- what comes out, in which unit ---- */

static void test_white_noise_is_arw_and_nothing_else(void)
{
    const double white[] = {0, 4.0, 0, 0, 0};
    set_octaves(600, 7);
    set_model(white);
    davar_fit(&plan, 0.01, &result);
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
    davar_fit(&plan, tau0, &result);
    assert_holds(0.5, term(DAVAR_QUANTIZATION));
    assert_holds(60.0 * sqrt(tau0), term(DAVAR_ANGLE_RANDOM_WALK));
    set_model(instability);
    davar_fit(&plan, tau0, &result);
    assert_holds(3600.0 * 0.3, term(DAVAR_BIAS_INSTABILITY));
    assert_holds(60.0 * sqrt(tau0), term(DAVAR_ANGLE_RANDOM_WALK));
    set_model(walk);
    davar_fit(&plan, tau0, &result);
    assert_holds(216000.0 * 0.2, term(DAVAR_RATE_RANDOM_WALK));
    assert_holds(60.0 * sqrt(tau0), term(DAVAR_ANGLE_RANDOM_WALK));
    set_model(ramp);
    davar_fit(&plan, tau0, &result);
    assert_holds(12960000.0 * 0.01, term(DAVAR_RATE_RAMP));
    assert_holds(60.0 * sqrt(tau0), term(DAVAR_ANGLE_RANDOM_WALK));
}

static void test_three_terms_at_once(void)
{
    const double mix[] = {30.0, 1.0, 0, 3e-5, 0};
    set_octaves(1000000, 16);
    set_model(mix);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL_UINT(
        (1U << DAVAR_QUANTIZATION) | (1U << DAVAR_ANGLE_RANDOM_WALK) | (1U << DAVAR_RATE_RANDOM_WALK), present_terms());
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
    TEST_ASSERT_DOUBLE_WITHIN(3.0, ratio * davar_edf(DAVAR_RATE_RANDOM_WALK, 8, 600), result.tau[3].edf);
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

/* A term of 1.5 standard errors is not resolved, yet N may be smaller by it: only the lower limit knows. */
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

/* Every other estimate half as large: no sum of these terms does that, and the interval must say so. */
static void test_a_misfit_widens_the_interval(void)
{
    const double white[] = {0, 1.0, 0, 0, 0};
    set_octaves(100000, 13);
    set_model(white);
    davar_fit(&plan, 1.0, &result);
    const davar_coefficient_t good = *term(DAVAR_ANGLE_RANDOM_WALK);
    for (int t = 0; t < 13; t += 2) {
        result.tau[t].adev *= 0.9;
    }
    davar_fit(&plan, 1.0, &result);
    const davar_coefficient_t *bad = term(DAVAR_ANGLE_RANDOM_WALK);
    TEST_ASSERT_TRUE(bad->high / bad->value > 1.0 + 5.0 * (good.high / good.value - 1.0));
}

/* ---- windows that show little ---- */

static void test_one_tau_gives_arw_and_knows_nothing_of_the_rest(void)
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

static void test_taus_that_are_nearly_equal_tell_no_terms_apart(void)
{
    const uint32_t m[] = {1U << 20U, (1U << 20U) + 1U};
    set_taus(1U << 24U, m, 2);
    result.tau[0].adev = 1e-3;
    result.tau[1].adev = 1e-2;
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL_UINT(1U << DAVAR_ANGLE_RANDOM_WALK, present_terms());
    TEST_ASSERT_TRUE(isinf(term(DAVAR_RATE_RANDOM_WALK)->high));
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high > 2.0 * term(DAVAR_ANGLE_RANDOM_WALK)->value); /* a misfit */
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

static void test_taus_without_differences_are_left_out(void)
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
    davar_fit(&plan, 1e-4, &result);
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high > 0.0);
    set_octaves(1U << 24U, 24);
    set_model(mix);
    davar_fit(&plan, 1e-4, &result);
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->present);
    TEST_ASSERT_TRUE(isfinite(term(DAVAR_RATE_RAMP)->high));
    TEST_ASSERT_TRUE(isfinite(term(DAVAR_ANGLE_RANDOM_WALK)->low));
}

/* ---- the plan is a memo ---- */

static void assert_same_as_fresh(const uint32_t *m, uint8_t count)
{
    davar_result_t again = result;
    davar_fit_plan_t fresh;
    memset(&fresh, 0xA5, sizeof fresh);
    davar_fit_plan(&fresh, m, count);
    davar_fit(&fresh, 0.5, &again);
    davar_fit(&plan, 0.5, &result);
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
            result.tau[t].differences = (2U * m[t] <= windows[i]) ? windows[i] - 2U * m[t] + 1U : 0U;
        }
        set_model(mix);
        assert_same_as_fresh(m, 5);
        result.tau[0].differences -= (result.tau[0].differences > 3U) ? 3U : 0U; /* a gap, then whole again */
        assert_same_as_fresh(m, 5);
    }
}

/* ---- the variances of the plan against brute force ---- */

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
static double covariance(int m_i, int m_j)
{
    const double n_i = LENGTH - 2 * m_i + 1;
    const double n_j = LENGTH - 2 * m_j + 1;
    return squared_covariances(m_i, m_j) / (2.0 * m_i * m_j * n_i * n_j);
}

/* The weight of one Allan variance in a linear functional of the fit: the answer to y = 1 there and 0 elsewhere. */
static double weight_of(int kind, int t)
{
    return (double)plan.functional[kind][t] / DAVAR_FIT_FUNCTIONAL_ONE;
}

static void test_standard_errors_meet_the_full_covariance(void)
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
                variance += weight_of(k, i) * weight_of(k, j) * covariance((int)m[i], (int)m[j]);
            }
        }
        TEST_ASSERT_DOUBLE_WITHIN(0.03 * sqrt(variance), sqrt(variance),
                                  (double)plan.sigma[k] / (double)DAVAR_FIT_SHARE_ONE);
    }
}

/* No unit is too large or too small, nor an ADEV beside another: one that no float could hold beside the rest is 0. */
static void test_a_deviation_that_vanishes_beside_the_others_is_none(void)
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

/* ---- the general fit ---- */

/* The general fit of white noise must judge a further term as the short cut does. */
static void test_general_fit_agrees_with_the_short_cut(void)
{
    const double nearly_white[] = {0.02, 1.0, 0.001, 0, 0};
    set_octaves(600, 7);
    set_model(nearly_white);
    davar_fit(&plan, 1.0, &result);
    davar_mixture_t model = {
        .data = &result, .weight = plan.weight, .count = 7, .misfit_spread = (double)plan.misfit_spread};
    davar_mixture_fit(&model, 1.0, 0U);
    TEST_ASSERT_EQUAL_UINT(1U << DAVAR_ANGLE_RANDOM_WALK, model.terms);
    TEST_ASSERT_DOUBLE_WITHIN(0.002, term(DAVAR_ANGLE_RANDOM_WALK)->value, 60.0 * sqrt(model.a[1]));
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        const double share = (double)plan.sigma[k] / (double)DAVAR_FIT_SHARE_ONE * (double)plan.scale[k];
        const double sigma = share * (double)plan.unit[k] * model.a[1];
        TEST_ASSERT_DOUBLE_WITHIN(0.05 * sigma, sigma, sqrt(model.variance[k]));
    }
}

static void test_a_superfluous_term_is_taken_out_again(void)
{
    const double walk[] = {0, 0, 0, 1.0, 0};
    set_octaves(600, 7);
    set_model(walk);
    davar_mixture_t model = {
        .data = &result, .weight = plan.weight, .count = 7, .misfit_spread = (double)plan.misfit_spread};
    davar_mixture_fit(&model, 1.0, 1U << DAVAR_RATE_RAMP); /* the wrong suspect */
    TEST_ASSERT_EQUAL_UINT(1U << DAVAR_RATE_RANDOM_WALK, model.terms);
}

/* Beside flicker found first, the white noise of a short window may no longer stand out. */
static void test_white_noise_that_does_not_stand_out_is_taken_out(void)
{
    const double flicker[] = {0, 1.0, 0.63, 0, 0};
    set_octaves(90, 4);
    set_model(flicker);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL_UINT(1U << DAVAR_BIAS_INSTABILITY, present_terms());
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high > 60.0);
}

/* An estimate with few degrees of freedom is never far from zero in its own standard errors; without it the rest is. */
static void test_an_uncertain_term_that_the_others_cannot_replace_stays(void)
{
    const double mix[] = {2.1, 1.0, 0, 0.00755579, 0};
    set_octaves(681, 6);
    set_model(mix);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_TRUE(term(DAVAR_QUANTIZATION)->present);
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->present);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_white_noise_is_arw_and_nothing_else);
    RUN_TEST(test_every_term_comes_back_in_its_unit);
    RUN_TEST(test_three_terms_at_once);
    RUN_TEST(test_pure_drift_has_no_arw_but_an_upper_bound);
    RUN_TEST(test_adev_intervals_are_chi_square_with_the_edf_of_the_noise);
    RUN_TEST(test_edf_follows_the_dominant_noise);
    RUN_TEST(test_missing_differences_cost_degrees_of_freedom);
    RUN_TEST(test_edf_is_never_below_one);
    RUN_TEST(test_an_unresolved_term_lowers_the_arw_limit_alone);
    RUN_TEST(test_a_doubt_can_leave_nothing_of_the_arw);
    RUN_TEST(test_a_misfit_widens_the_interval);
    RUN_TEST(test_one_tau_gives_arw_and_knows_nothing_of_the_rest);
    RUN_TEST(test_two_taus_resolve_two_terms_and_no_third);
    RUN_TEST(test_taus_that_are_nearly_equal_tell_no_terms_apart);
    RUN_TEST(test_a_constant_input_bounds_nothing);
    RUN_TEST(test_some_zero_variances_are_no_trap);
    RUN_TEST(test_taus_without_differences_are_left_out);
    RUN_TEST(test_no_differences_at_all_is_no_knowledge_at_all);
    RUN_TEST(test_no_cluster_sizes_at_all_is_no_knowledge_at_all);
    RUN_TEST(test_the_longest_windows_and_lists_stay_finite);
    RUN_TEST(test_a_used_plan_gives_what_a_fresh_one_gives);
    RUN_TEST(test_standard_errors_meet_the_full_covariance);
    RUN_TEST(test_a_deviation_that_vanishes_beside_the_others_is_none);
    RUN_TEST(test_white_noise_of_any_size_is_found);
    RUN_TEST(test_general_fit_agrees_with_the_short_cut);
    RUN_TEST(test_a_superfluous_term_is_taken_out_again);
    RUN_TEST(test_white_noise_that_does_not_stand_out_is_taken_out);
    RUN_TEST(test_an_uncertain_term_that_the_others_cannot_replace_stays);
    return UNITY_END();
}
