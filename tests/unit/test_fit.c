/* davar tests - the fit of a mix of noise terms, of a window (5.4) and of a cascade (5.18), and its
 * plan: exact models in, the same coefficients out. Values that a window cannot show stay absent. */
#include "davar/fit.h"
#include "fit/mixture.h"
#include "fit/plan.h"
#include "fit_fixture.h"
#include "random.h"

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
            if ((terms & (1U << k)) != 0U) {
                TEST_ASSERT_DOUBLE_WITHIN(1e-4 * mix[k], mix[k], model.a[k]);
            } else {
                TEST_ASSERT_TRUE(fabs(model.tried[k]) < (1e-3 * sqrt(model.variance[k])));
                TEST_ASSERT_TRUE(isfinite(model.variance[k]));
            }
        }
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
                variance +=
                    weight_of(k, i) * weight_of(k, j) * brute_covariance((int)m[i], (int)m[j]);
            }
        }
        TEST_ASSERT_DOUBLE_WITHIN(0.03 * sqrt(variance), sqrt(variance),
                                  (double)plan.sigma[k] / (double)(1U << DAVAR_FIT_SHARE_BITS));
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

#define Q (1U << DAVAR_QUANTIZATION)
#define N (1U << DAVAR_ANGLE_RANDOM_WALK)
#define B (1U << DAVAR_BIAS_INSTABILITY)
#define K (1U << DAVAR_RATE_RANDOM_WALK)

/* The window shows the short terms and the cascade the slow ones; a cascade alone shows all. A
 * flicker that is too small for the window raises its white noise a little. */
static void test_window_and_cascade_share_the_terms(void)
{
    static const struct {
        uint8_t window;
        uint8_t sizes;
        double mix[DAVAR_COEFFICIENT_COUNT];
        davar_noise_t noise;
        unsigned present;
        double white_error; /* relative, and of the other terms */
        double error;
    } cases[] = {
        {SHORT, LONG, {0, 1.0, 0.002, 1.2e-7, 0}, DAVAR_NOISE_MIXED, N | B | K, 5e-3, 1e-6},
        {SHORT, LONG, {3.0, 1.0, 0.002, 0, 0}, DAVAR_NOISE_MIXED, Q | N | B, 0.02, 0.01},
        {0U, LONG, {0, 1.0, 0.002, 1.2e-7, 0}, DAVAR_NOISE_MIXED, N | B | K, 1e-6, 1e-6},
        {0U, LONG, {0, 1.0, 0, 0, 0}, DAVAR_NOISE_WHITE, N, 1e-6, 0.0},
        {0U, LONG, {0, 0, 0, 1e-3, 0}, DAVAR_NOISE_MIXED, K, 0.0, 1e-6},
        {0U, LONG, {0, 0, 0, 0, 0}, DAVAR_NOISE_CONSTANT, 0U, 0.0, 0.0},
        {SHORT, 0U, {0, 0, 0, 0, 0}, DAVAR_NOISE_CONSTANT, 0U, 0.0, 0.0},
    };
    for (size_t i = 0U; i < sizeof cases / sizeof cases[0]; i++) {
        set_curve(cases[i].window, cases[i].sizes, cases[i].mix);
        davar_fit(&plan, 1.0, &result);
        TEST_ASSERT_EQUAL(cases[i].noise, result.noise);
        TEST_ASSERT_EQUAL_UINT(cases[i].present, present_terms());
        for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
            const davar_coefficient_t *const found = &result.coefficient[k];
            const double truth = in_its_unit(k, cases[i].mix[k], 1.0);
            if (found->present) {
                const double error =
                    (k == DAVAR_ANGLE_RANDOM_WALK) ? cases[i].white_error : cases[i].error;
                TEST_ASSERT_DOUBLE_WITHIN(error * truth, truth, found->value);
                TEST_ASSERT_TRUE((found->low < truth) && (truth < found->high));
            } else {
                TEST_ASSERT_EQUAL(cases[i].noise == DAVAR_NOISE_CONSTANT, isinf(found->high) != 0);
            }
        }
        for (uint8_t t = 0U; t < result.tau_count; t++) {
            const bool is_constant = (cases[i].noise == DAVAR_NOISE_CONSTANT);
            TEST_ASSERT_TRUE((result.tau[t].low < result.tau[t].adev) || is_constant);
            TEST_ASSERT_TRUE(result.tau[t].high > result.tau[t].adev);
        }
    }
}

/* The variance of rounding to counts of 1 is 1 / 12. */
static void test_rounding_is_subtracted(void)
{
    const double white[] = {0, 10.0, 0, 0, 0};
    set_octaves(600, 7);
    set_model(white);
    result.unit_per_count = 1.0;
    davar_fit(&plan, 1.0, &result);
    assert_holds(60.0 * sqrt(10.0 - (1.0 / 12.0)), term(DAVAR_ANGLE_RANDOM_WALK));
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

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_every_mix_comes_back_in_its_unit);
    RUN_TEST(test_a_tone_hides_the_arw_or_leaves_it);
    RUN_TEST(test_one_tau_gives_only_arw);
    RUN_TEST(test_taus_without_differences_are_skipped);
    RUN_TEST(test_white_noise_of_any_size_is_found);
    RUN_TEST(test_in_an_exact_mix_absent_terms_are_zero);
    RUN_TEST(test_the_longest_window_has_the_degrees_of_freedom_of_white_noise);
    RUN_TEST(test_tails_reduce_the_degrees_of_freedom);
    RUN_TEST(test_standard_errors_match_the_full_covariance);
    RUN_TEST(test_window_and_cascade_share_the_terms);
    RUN_TEST(test_rounding_is_subtracted);
    RUN_TEST(test_white_noise_stays_that_of_the_window);
    RUN_TEST(test_a_cascade_that_no_mix_explains);
    RUN_TEST(test_sizes_without_differences_are_left_out);
    RUN_TEST(test_a_cascade_alone_that_contradicts_the_filter);
    RUN_TEST(test_a_window_that_is_withheld);
    RUN_TEST(test_few_sizes_of_a_cascade_leave_the_terms_to_the_window);
    return UNITY_END();
}
