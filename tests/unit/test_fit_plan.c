/* davar tests - the plan of a fit: a cache that changes no result. Its standard errors are those of
 * brute force. */
#include "fit/plan.h"
#include "fit_fixture.h"

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
    const double edf = result.tau[0].edf;
    result.cut_age_samples = UINT32_MAX; /* not more than twice the window */
    TEST_ASSERT_TRUE(davar_fit_white(&plan, 1.0, &result));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9 * edf, edf, result.tau[0].edf);
    result.cut_age_samples = 0U;
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
static double covariance(int m_i, int m_j)
{
    const double n_i = LENGTH - 2 * m_i + 1;
    const double n_j = LENGTH - 2 * m_j + 1;
    return squared_covariances(m_i, m_j) / (2.0 * m_i * m_j * n_i * n_j);
}

/* The weight of one Allan variance in a linear functional of the fit, from the plan
 * (test_fit_white.c compares the resulting shares with the formulas); this tests its variance. */
static double weight_of(int kind, int t)
{
    return (double)plan.functional[kind][t] / DAVAR_FIT_FUNCTIONAL_ONE;
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
                variance += weight_of(k, i) * weight_of(k, j) * covariance((int)m[i], (int)m[j]);
            }
        }
        TEST_ASSERT_DOUBLE_WITHIN(0.03 * sqrt(variance), sqrt(variance),
                                  (double)plan.sigma[k] / (double)(1U << DAVAR_FIT_SHARE_BITS));
    }
}

/* (5.9): under white noise the misfit has the mean count - 1 and the variance 2 sum r^2 over all
 * pairs; five of its standard deviations are not a misfit. Twice that, because errors are squared
 * as edf (y - 1)^2. */
static void test_the_limit_of_the_misfit_is_five_standard_deviations(void)
{
    static const uint32_t m[] = {1, 2, 4, 7, 15, 40};
    for (uint8_t count = 1U; count <= 6U; count++) {
        double variance = 0.0;
        for (int i = 0; i < count; i++) {
            for (int j = 0; j < count; j++) {
                const double r =
                    davar_noise_white_overlap((int)m[(i < j) ? i : j], (int)m[(i < j) ? j : i]) /
                    sqrt(davar_noise_white_overlap((int)m[i], (int)m[i]) *
                         davar_noise_white_overlap((int)m[j], (int)m[j]));
                variance += 2.0 * r * r;
            }
        }
        davar_plan_init_white(&plan, m, count);
        const double limit = 2.0 * ((count - 1.0) + (5.0 * sqrt(variance)));
        TEST_ASSERT_DOUBLE_WITHIN(1e-5 * limit, limit,
                                  (double)plan.misfit_limit / DAVAR_FIT_MISFIT_ONE);
    }
}

/* Of numbers far below the largest, no bit is left. */
static void test_aligned_numbers_lose_the_bits_below_the_last_one_of_the_largest(void)
{
    for (int32_t below = 0; below < 40; below++) {
        scaled_t value[] = {{UINT32_C(0x80000001), 5}, {UINT32_C(0xFFFFFFFF), 5 - below}};
        TEST_ASSERT_EQUAL_INT32(9, davar_align(value, 2));
        TEST_ASSERT_EQUAL_HEX32(UINT32_C(0x08000000), value[0].mantissa);
        TEST_ASSERT_EQUAL_HEX32((below > 27) ? 0U : (UINT32_C(0x0FFFFFFF) >> (unsigned)below),
                                value[1].mantissa);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_used_plan_gives_what_a_fresh_one_gives);
    RUN_TEST(test_the_longest_window_has_the_degrees_of_freedom_of_white_noise);
    RUN_TEST(test_tails_reduce_the_degrees_of_freedom);
    RUN_TEST(test_standard_errors_match_the_full_covariance);
    RUN_TEST(test_the_limit_of_the_misfit_is_five_standard_deviations);
    RUN_TEST(test_aligned_numbers_lose_the_bits_below_the_last_one_of_the_largest);
    return UNITY_END();
}
