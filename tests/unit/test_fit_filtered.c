/* davar tests - the plan and the fit of filtered noise (5.16), and of samples whose filter is unknown
 * (5.17), from exact Allan variances. */
#include "fit/plan.h"
#include "fit_fixture.h"

#define SIZES 7
#define WINDOW 600U

static const davar_filter_t filters[] = {
    {0},
    {.cutoff = 0.05, .poles = 1U},
    {.cutoff = 0.25, .poles = 1U, .uncertainty = 0.1},
    {.cutoff = 0.05, .poles = 2U},
    {.cutoff = 0.1, .poles = 2U, .uncertainty = 0.1},
    {.cutoff = 0.25, .poles = 2U},
    {.cutoff = 0.45, .poles = 2U, .uncertainty = 0.2},
    {.averages = 3U, .length = 64U, .decimation = 64U},
    {.averages = 1U, .length = 8U},
};
#define FILTERS (sizeof filters / sizeof filters[0])

static void plan_filter(const davar_filter_t *filter)
{
    uint32_t m[SIZES];
    set_octaves(WINDOW, SIZES);
    for (int t = 0; t < SIZES; t++) {
        m[t] = result.tau[t].m;
    }
    if (filter != NULL) {
        davar_plan_init_filtered(&plan, m, SIZES, filter);
    } else {
        davar_plan_init(&plan, m, SIZES);
    }
}

/* The Allan variances of a mix after a filter, rounded to counts. */
static void set_filtered(const davar_filter_t *filter, const double a[], double count)
{
    static davar_plan_t truth;
    uint32_t m[SIZES];
    for (int t = 0; t < SIZES; t++) {
        m[t] = result.tau[t].m;
    }
    davar_plan_init_filtered(&truth, m, SIZES, filter);
    result.unit_per_count = count;
    for (int t = 0; t < SIZES; t++) {
        const double size = (double)m[t];
        const double mix[] = {a[0], (a[1] * (double)truth.gain[t]) + (count * count / 12.0),
                              a[2] * pow((double)truth.flicker[t], 2.0),
                              a[3] * pow((double)truth.walk[t], 2.0), a[4]};
        result.tau[t].adev = sqrt(avar_at(mix, size));
    }
}

static double arw_of(double white)
{
    return 60.0 * sqrt(white);
}

/* ---- a declared filter ---- */

static void test_white_noise_has_the_value_before_the_filter(void)
{
    const double white[] = {0, 0.7, 0, 0, 0};
    for (size_t f = 0; f < FILTERS; f++) {
        plan_filter(&filters[f]);
        const double count = sqrt(0.7 * (double)plan.sample) / 5.0;
        for (int rounds = 0; rounds < 2; rounds++) {
            set_filtered(&filters[f], white, count * rounds);
            TEST_ASSERT_TRUE(davar_fit_white(&plan, 1.0, &result));
            assert_near(arw_of(0.7), term(DAVAR_ANGLE_RANDOM_WALK)->value, 1e-4);
            TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->low > 0.6 * arw_of(0.7));
            TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high > 1.04 * arw_of(0.7));
            TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high < 1.5 * arw_of(0.7));
        }
    }
}

/* ---- drifts that pass the filter ---- */

static void assert_mix_found(const double mix[])
{
    static const double unit[] = {1.0 / 3.0, 3600.0, 3600.0 * 3600.0 * 2.2661800709135971,
                                  3.0 * 216000.0 * 216000.0, 2.0 * 12960000.0 * 12960000.0};
    const bool shows_white = term(DAVAR_ANGLE_RANDOM_WALK)->present;
    TEST_ASSERT_EQUAL(DAVAR_NOISE_MIXED, result.noise);
    TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high > 60.0);
    for (int k = 0; k < TERMS; k++) {
        const davar_coefficient_t *const found = &result.coefficient[k];
        const double truth = sqrt(mix[k] * unit[k]);
        TEST_ASSERT_EQUAL_INT((truth > 0.0) && ((k != WHITE) || shows_white), found->present);
        if (found->present) {
            TEST_ASSERT_TRUE((found->low < truth) && (truth < found->high));
            TEST_ASSERT_TRUE(!shows_white || (fabs(found->value - truth) < (0.01 * truth)));
        }
    }
}

static void test_drifts_behind_the_filter_are_found_with_their_size(void)
{
    static const double mixes[][DAVAR_COEFFICIENT_COUNT] = {
        {0, 1.0, 0.3, 0, 0}, {0, 1.0, 0, 0.02, 0}, {0, 1.0, 0, 0, 4e-4}};
    for (size_t f = 0; f < FILTERS; f++) {
        for (size_t i = 0; i < sizeof mixes / sizeof mixes[0]; i++) {
            plan_filter(&filters[f]);
            set_filtered(&filters[f], mixes[i], (double)i * 0.02);
            davar_fit(&plan, 1.0, &result);
            assert_mix_found(mixes[i]);
        }
    }
}

/* ---- a filter that the plan does not know ---- */

static void assert_withheld(void)
{
    TEST_ASSERT_EQUAL(DAVAR_NOISE_FILTERED, result.noise);
    for (int k = 0; k < TERMS; k++) {
        TEST_ASSERT_FALSE(result.coefficient[k].present);
        TEST_ASSERT_TRUE(isinf(result.coefficient[k].high) && isnan(result.coefficient[k].low));
    }
    for (int t = 0; t < SIZES; t++) {
        TEST_ASSERT_TRUE(result.tau[t].edf >= 1.0);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, result.tau[t].low);
        TEST_ASSERT_TRUE(isinf(result.tau[t].high));
    }
}

static void test_short_sizes_that_read_low_withhold_everything(void)
{
    const double white[] = {0, 1.0, 0, 0, 0};
    const double drift[] = {0, 1.0, 0, 0.02, 0};
    for (size_t f = 1; f < FILTERS; f++) {
        if (f != 6) { /* two poles at 0.45 cannot be seen in 600 samples */
            plan_filter(NULL);
            set_filtered(&filters[f], white, 0.0);
            TEST_ASSERT_FALSE(davar_fit_white(&plan, 1.0, &result));
            assert_withheld();
            davar_fit(&plan, 1.0, &result);
            assert_withheld();
            set_filtered(&filters[f], drift, 0.0);
            davar_fit(&plan, 1.0, &result);
            assert_withheld();
        }
    }
}

/* A drift or quantization of half a count keeps a mixture from being coarse. Only its white noise
 * is then withdrawn. */
static void test_other_terms_can_scatter_a_sample_enough(void)
{
    static const struct {
        size_t filter;
        double mix[DAVAR_COEFFICIENT_COUNT]; /* in units of the white noise that rounding hides */
        davar_noise_t noise;
    } cases[] = {
        {0, {2.0, 0.5, 0, 0, 0}, DAVAR_NOISE_MIXED},
        {0, {0.3, 0.5, 0, 0, 0}, DAVAR_NOISE_COARSE},
        {0, {0, 0.5, 0, 0.505, 0}, DAVAR_NOISE_MIXED},
        {0, {0, 0.5, 0, 0.495, 0}, DAVAR_NOISE_COARSE},
        {1, {0, 0.5, 0, 0.2, 0}, DAVAR_NOISE_MIXED},
        {1, {0, 0.5, 0, 0.06, 0}, DAVAR_NOISE_COARSE},
        {8, {0, 0.5, 0.2, 0, 0}, DAVAR_NOISE_MIXED},
        {8, {0, 0.5, 0.05, 0, 0}, DAVAR_NOISE_COARSE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        plan_filter(&filters[cases[i].filter]);
        set_filtered(&filters[cases[i].filter], cases[i].mix, 1.0 / (double)plan.hidden);
        davar_fit(&plan, 1.0, &result);
        TEST_ASSERT_EQUAL(cases[i].noise, result.noise);
        TEST_ASSERT_FALSE(term(DAVAR_ANGLE_RANDOM_WALK)->present);
        TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high >= 60.0 * (1.0 - 1e-6));
    }
}

static void test_noise_of_less_than_half_a_count_is_coarse(void)
{
    for (size_t f = 0; f < FILTERS; f++) {
        for (int step = 0; step < 18; step++) {
            const double over = 0.25 + 0.1 * step;
            const double white[] = {0, 1.0, 0, 0, 0};
            plan_filter(&filters[f]);
            const double hidden = (double)plan.hidden;
            set_filtered(&filters[f], white, 1.0 / (hidden * over));
            davar_fit(&plan, 1.0, &result);
            /* Between these, the weights of filter 4 raise the limit. */
            if ((over < 0.94) || (over > 1.0)) {
                TEST_ASSERT_EQUAL((over < 1.0) ? DAVAR_NOISE_COARSE : DAVAR_NOISE_WHITE,
                                  result.noise);
            }
            TEST_ASSERT_TRUE(term(DAVAR_ANGLE_RANDOM_WALK)->high >= 59.999);
        }
    }
}

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
static double plan_covariance(int t, int u)
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
            image[t] += f[u] * plan_covariance((t < u) ? t : u, (t < u) ? u : t);
        }
    }
    const double size = sqrt(dot(f, image)); /* standard error */
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.0, dot(f, x));
    TEST_ASSERT_DOUBLE_WITHIN(1e-4 * size, (term == WHITE) ? 1.0 : 0.0, dot(f, one));
    const int end = SIZES - 1;
    const double slope = (term == WHITE) ? 0.0 : ((image[end] - image[0]) / (x[end] - x[0]));
    for (int t = 0; t < SIZES; t++) {
        const double expected = image[0] + (slope * (x[t] - x[0]));
        const double scatter = size * sqrt(plan_covariance(t, t));
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

/* ---- the plan ---- */

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_white_noise_has_the_value_before_the_filter);
    RUN_TEST(test_drifts_behind_the_filter_are_found_with_their_size);
    RUN_TEST(test_short_sizes_that_read_low_withhold_everything);
    RUN_TEST(test_noise_of_less_than_half_a_count_is_coarse);
    RUN_TEST(test_other_terms_can_scatter_a_sample_enough);
    RUN_TEST(test_the_weights_have_the_least_variance);
    RUN_TEST(test_standard_errors_include_the_cutoff);
    return UNITY_END();
}
