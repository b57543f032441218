/* davar tests - the plan of a fit for filtered noise: its weights, standard errors and sizes (5.4)
 * (5.16), and short windows. */
#include "filtered_fixture.h"

/* ---- the weights (5.4) ---- */

static double functional(int term, int t)
{
    const double one =
        (term == WHITE) ? (double)(UINT32_C(1) << plan.white_bits) : (double)plan.scale[term];
    return (double)plan.functional[term][t] / DAVAR_FIT_FUNCTIONAL_ONE * one;
}

static double shape(int term, int t)
{
    const double m = (double)plan.m[t];
    const double u = m / (double)plan.m[SIZES - 1];
    const double passed[] = {(double)plan.m[0] / m, (double)plan.gain[t],
                             u * pow((double)plan.flicker[t], 2.0),
                             u * u * pow((double)plan.walk[t], 2.0), u * u * u};
    return passed[term] / (double)plan.gain[t];
}

/* Covariance of m avar / gain for N = 1, in a window of nine longest sizes, with the offset of an
 * uncertain cutoff and 1e-4 of the diagonal. */
static double covariance(int t, int u)
{
    const double differences = (9.0 * (double)plan.m[SIZES - 1]) + 1.0 - (1.5 * (double)plan.m[t]);
    const double offset = (double)plan.offset[t] * (double)plan.offset[u];
    const double whole = ((double)plan.covariance[plan_pair(t, u)] / differences) + offset;
    return whole * ((t == u) ? 1.0001 : 1.0);
}

static double dot(const double a[], const double b[])
{
    double sum = 0.0;
    for (int t = 0; t < SIZES; t++) {
        sum += a[t] * b[t];
    }
    return sum;
}

/* Generalised least squares: among the functionals with the same gain of every shape, the variance
 * is least, so that the covariance times the functional is a sum of the shapes. */
static void assert_least_squares(int term)
{
    double f[SIZES];
    double x[SIZES];
    double one[SIZES];
    double image[SIZES];
    for (int t = 0; t < SIZES; t++) {
        f[t] = functional(term, t);
        x[t] = shape(term, t);
        one[t] = 1.0;
    }
    for (int t = 0; t < SIZES; t++) {
        image[t] = 0.0;
        for (int u = 0; u < SIZES; u++) {
            image[t] += f[u] * covariance((t < u) ? t : u, (t < u) ? u : t);
        }
    }
    const double size = sqrt(dot(f, image)); /* standard error */
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.0, dot(f, x));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4 * size, (term == WHITE) ? 1.0 : 0.0, dot(f, one));
    const int end = SIZES - 1;
    const double slope = (term == WHITE) ? 0.0 : ((image[end] - image[0]) / (x[end] - x[0]));
    for (int t = 0; t < SIZES; t++) {
        const double expected = image[0] + (slope * (x[t] - x[0]));
        const double scatter = size * sqrt(covariance(t, t));
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * scatter, expected, image[t]);
    }
}

static void test_the_weights_have_the_least_variance(void)
{
    for (size_t f = 0; f < FILTERS; f++) {
        plan_filter(&filters[f]);
        for (int k = 0; k < TERMS; k++) {
            assert_least_squares(k);
        }
    }
}

/* The standard error of a term in the window: covariances over the effective differences of the
 * shorter size, less the rounding that they include, and the cutoff. */
static double expected_sigma(int term, double *by_cutoff)
{
    double variance = 0.0;
    double rounding = 0.0;
    double moved = 0.0;
    for (int u = 0; u < SIZES; u++) {
        for (int t = 0; t < SIZES; t++) {
            const int first = (t < u) ? t : u;
            const double effective = (double)WINDOW + 1.0 - (1.5 * (double)plan.m[first]);
            const int pair = plan_pair(first, (t < u) ? u : t);
            variance += functional(term, t) * functional(term, u) * (double)plan.covariance[pair] /
                        effective;
        }
        rounding += functional(WHITE, u) / (double)plan.gain[u];
        moved += functional(term, u) * (double)plan.offset[u];
    }
    *by_cutoff = moved * moved;
    return sqrt((variance * pow(1.0 + ((double)plan.floor * rounding), -2.0)) + *by_cutoff);
}

static void test_standard_errors_include_the_cutoff(void)
{
    for (size_t f = 0; f < FILTERS; f++) {
        plan_filter(&filters[f]);
        davar_fit_prepare(&plan, &result);
        for (int k = 0; k < TERMS; k++) {
            double by_cutoff;
            const double scale = (k == WHITE) ? 1.0 : (double)plan.scale[k];
            const double expected = expected_sigma(k, &by_cutoff) / scale;
            const double found = (double)plan.sigma[k] / (double)(1U << DAVAR_FIT_SHARE_BITS);
            TEST_ASSERT_DOUBLE_WITHIN((1e-3 * expected) + 2e-6, expected, found);
            TEST_ASSERT_DOUBLE_WITHIN(1e-3 * by_cutoff, by_cutoff,
                                      (double)plan.offset_variance[k] * scale * scale);
        }
    }
}

/* What a size contributes: the factor to N^2, the degrees of freedom, the doubt by the cutoff and
 * the rounding that the estimate of N^2 does not take off. */
static void test_sizes_have_their_own_factors(void)
{
    for (size_t f = 0; f < FILTERS; f++) {
        double moved = 0.0;
        double rounding = 0.0;
        plan_filter(&filters[f]);
        for (int t = 0; t < SIZES; t++) {
            moved += functional(WHITE, t) * (double)plan.offset[t];
            rounding += functional(WHITE, t) / (double)plan.gain[t];
        }
        assert_near(rounding, (double)plan.rounding, 1e-5);
        for (int t = 0; t < SIZES; t++) {
            const double gain = (double)plan.gain[t];
            const double floor = (double)plan.floor / gain;
            const double freedom =
                2.0 * pow(1.0 + floor, 2.0) / (double)plan.covariance[plan_pair(t, t)];
            assert_near((double)plan.m[t] / gain, (double)plan.to_white[t], 1e-6);
            assert_near(freedom, (double)plan.freedom[t], 1e-5);
            TEST_ASSERT_DOUBLE_WITHIN(1e-6, 0.5 * pow((double)plan.offset[t] - moved, 2.0),
                                      (double)plan.doubtful[t]);
            TEST_ASSERT_DOUBLE_WITHIN((0.51 / 512.0) + (1e-6 / gain), 1.0 / gain,
                                      (double)plan.inverse_gain[t] / 512.0);
        }
    }
}

/* At least 2^-32, also where a filter makes it negative, and at most 2^20, also where the sizes
 * hardly differ. */
static void test_centres_fit_a_shift(void)
{
    static const uint32_t alike[] = {4000000U, 4000001U};
    plan_filter(&filters[4]);
    TEST_ASSERT_EQUAL_HEX32(davar_bits_of_float(ldexpf(1.0F, -32)),
                            davar_bits_of_float(plan.centre[DAVAR_QUANTIZATION]));
    TEST_ASSERT_TRUE(plan.centre[DAVAR_BIAS_INSTABILITY] > 0.1F);
    davar_plan_init(&plan, alike, 2U);
    TEST_ASSERT_EQUAL_HEX32(davar_bits_of_float(ldexpf(1.0F, 20)),
                            davar_bits_of_float(plan.centre[DAVAR_QUANTIZATION]));
}

/* ---- the plan ---- */

static void test_no_filter_declared_is_white(void)
{
    const davar_filter_t none = {0};
    const double white[] = {0, 1.0, 0, 0, 0};
    plan_filter(&none);
    set_model(white);
    davar_result_t again = result;
    davar_fit(&plan, 1.0, &result);
    set_octaves(WINDOW, SIZES);
    davar_fit(&plan, 1.0, &again);
    TEST_ASSERT_TRUE(plan.declared);
    assert_near(again.coefficient[WHITE].value, result.coefficient[WHITE].value, 1e-6);
    assert_near(again.coefficient[WHITE].low, result.coefficient[WHITE].low, 1e-4);
    assert_near(again.coefficient[WHITE].high, result.coefficient[WHITE].high, 1e-4);
    for (int t = 0; t < SIZES; t++) {
        assert_near(again.tau[t].high, result.tau[t].high, 1e-4);
    }
}

static void test_a_plan_solved_for_fewer_sizes_and_back_has_the_same_bits(void)
{
    for (size_t f = 0; f < FILTERS; f++) {
        davar_plan_t before;
        plan_filter(&filters[f]);
        memcpy(&before, &plan, sizeof plan);
        for (uint8_t count = 1U; count < SIZES; count++) {
            davar_plan_solve(&plan, count);
            TEST_ASSERT_EQUAL_UINT8(count, plan.count);
            davar_plan_solve(&plan, SIZES);
            TEST_ASSERT_EQUAL_MEMORY(plan.functional, before.functional, sizeof plan.functional);
            TEST_ASSERT_EQUAL_MEMORY(plan.variance, before.variance, sizeof plan.variance);
            TEST_ASSERT_EQUAL_MEMORY(plan.weight, before.weight, sizeof plan.weight);
            TEST_ASSERT_EQUAL_MEMORY(plan.freedom, before.freedom, sizeof plan.freedom);
            TEST_ASSERT_EQUAL_FLOAT(before.rounding, plan.rounding);
            TEST_ASSERT_EQUAL_UINT64(before.misfit_limit, plan.misfit_limit);
        }
    }
}

/* Here the covariance is none, so the second size gets no weight, and no other term is resolved. */
static void test_a_covariance_that_is_none_gives_finite_weights(void)
{
    plan_filter(&filters[0]);
    plan.covariance[plan_pair(0, 1)] = 2.0F * plan.covariance[plan_pair(1, 1)];
    davar_plan_solve(&plan, 2U);
    TEST_ASSERT_TRUE(isfinite((double)plan.rounding));
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 1.0, functional(WHITE, 0));
    TEST_ASSERT_EQUAL_INT32(0, plan.functional[WHITE][1]);
    for (int k = 0; k < TERMS; k++) {
        TEST_ASSERT_TRUE(isfinite((double)plan.offset_variance[k]));
        for (int t = 0; (k != WHITE) && (t < 2); t++) {
            TEST_ASSERT_EQUAL_INT32(0, plan.functional[k][t]);
            TEST_ASSERT_EQUAL_INT32(0, plan.variance[k][t]);
        }
    }
}

/* A short window fits its sizes as a plan for these alone does. */
static void test_a_short_window_uses_its_sizes_alone(void)
{
    const double white[] = {0, 1.0, 0, 0, 0};
    for (size_t f = 0; f < FILTERS; f++) {
        davar_plan_t short_plan;
        uint32_t m[SIZES];
        plan_filter(&filters[f]);
        set_filtered(&filters[f], white, 0.0);
        for (int t = 0; t < SIZES; t++) {
            m[t] = result.tau[t].m;
            result.tau[t].differences = (t < 4) ? (101U - (2U * m[t])) : ((f % 2U == 0U) ? 0U : 9U);
        }
        result.tau_count = (f % 2U == 0U) ? SIZES : 4U; /* the others are left from before */
        result.window_samples = 100U;
        davar_plan_init_filtered(&short_plan, m, 4U, &filters[f]);
        davar_result_t again = result;
        davar_fit(&plan, 1.0, &result);
        davar_fit(&short_plan, 1.0, &again);
        TEST_ASSERT_TRUE(result.coefficient[WHITE].present);
        assert_near(again.coefficient[WHITE].value, result.coefficient[WHITE].value, 1e-4);
        assert_near(again.coefficient[WHITE].high, result.coefficient[WHITE].high, 1e-3);
        TEST_ASSERT_TRUE((f % 2U != 0U) || isnan(result.tau[4].edf));
    }
}

static void test_a_mixture_in_a_short_window_leaves_the_other_sizes_absent(void)
{
    const double drift[] = {0, 1.0, 0, 0.5, 0};
    plan_filter(&filters[0]);
    set_model(drift);
    for (int t = 0; t < SIZES; t++) {
        result.tau[t].differences = (t < 5) ? (101U - (2U * result.tau[t].m)) : 0U;
    }
    result.window_samples = 100U;
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
    TEST_ASSERT_TRUE(result.tau[4].edf >= 1.0);
    TEST_ASSERT_TRUE(isnan(result.tau[5].edf) && isnan(result.tau[5].low));
}

/* Sizes that the plan does not know are absent; the others are fitted. */
static void test_sizes_beyond_the_plan_are_absent(void)
{
    const double white[] = {0, 1.0, 0, 0, 0};
    uint32_t m[DAVAR_TAUS_MAX];
    set_octaves(4000U, 9U);
    set_model(white);
    for (int t = 0; t < 9; t++) {
        m[t] = result.tau[t].m;
    }
    davar_plan_init_white(&plan, m, SIZES);
    davar_fit(&plan, 1.0, &result);
    assert_near(60.0, term(DAVAR_ANGLE_RANDOM_WALK)->value, 1e-5);
    TEST_ASSERT_TRUE(result.tau[SIZES - 1].edf > 1.0);
    for (int t = SIZES; t < 9; t++) {
        TEST_ASSERT_TRUE(isnan(result.tau[t].edf) && isnan(result.tau[t].low));
    }
    TEST_ASSERT_FALSE(davar_fit_white(&plan, 1.0, &result)); /* it fits all sizes or none */
    TEST_ASSERT_EQUAL(DAVAR_NOISE_UNKNOWN, result.noise);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_the_weights_have_the_least_variance);
    RUN_TEST(test_standard_errors_include_the_cutoff);
    RUN_TEST(test_sizes_have_their_own_factors);
    RUN_TEST(test_centres_fit_a_shift);
    RUN_TEST(test_no_filter_declared_is_white);
    RUN_TEST(test_a_plan_solved_for_fewer_sizes_and_back_has_the_same_bits);
    RUN_TEST(test_a_covariance_that_is_none_gives_finite_weights);
    RUN_TEST(test_a_short_window_uses_its_sizes_alone);
    RUN_TEST(test_a_mixture_in_a_short_window_leaves_the_other_sizes_absent);
    RUN_TEST(test_sizes_beyond_the_plan_are_absent);
    return UNITY_END();
}
