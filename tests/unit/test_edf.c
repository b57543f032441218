/* davar tests - degrees of freedom of a window, and of a cascade (11.6), compared with exact
 * covariances; chi-square limits with published tables. */
#include "davar/fit.h"
#include "fit/plan.h"
#include "unity.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>

void setUp(void) {}

void tearDown(void) {}

/* ---- chi-square ---- */

/* chi2 at 2.5 % and 97.5 %, NIST/SEMATECH e-Handbook of Statistical Methods, 1.3.6.7.4 (three
 * decimals), the first row with the digits of Abramowitz and Stegun, table 26.8. */
static const struct {
    double edf;
    double low;
    double high;
    double half_digit_low;
} chi_square_table[] = {
    {1, 0.000982069, 5.02389, 5e-10}, {2, 0.0506356, 7.37776, 5e-8}, {3, 0.216, 9.348, 5e-4},
    {4, 0.484, 11.143, 5e-4},         {5, 0.831, 12.833, 5e-4},      {7, 1.690, 16.013, 5e-4},
    {10, 3.247, 20.483, 5e-4},        {15, 6.262, 27.488, 5e-4},     {20, 9.591, 34.170, 5e-4},
    {30, 16.791, 46.979, 5e-4},       {50, 32.357, 71.420, 5e-4},    {100, 74.222, 129.561, 5e-4},
};

static void test_limits_meet_the_published_table(void)
{
    for (size_t i = 0; i < sizeof chi_square_table / sizeof chi_square_table[0]; i++) {
        const double edf = chi_square_table[i].edf;
        double low;
        double high;
        davar_chi_square_interval(edf, &low, &high);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * chi_square_table[i].high + 5e-4, chi_square_table[i].high,
                                  edf / low);
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * chi_square_table[i].low +
                                      chi_square_table[i].half_digit_low,
                                  chi_square_table[i].low, edf / high);
    }
}

/* Regularised lower incomplete gamma function P(a, x) by its power series, all terms positive. */
static double gamma_p(double a, double x)
{
    double term = 1.0 / a;
    double sum = term;
    for (int k = 1; (k < 100000) && (term > 1e-17 * sum); k++) {
        term *= x / (a + k);
        sum += term;
    }
    return sum * exp(a * log(x) - x - lgamma(a));
}

static double chi_square_cdf(double edf, double chi2)
{
    return gamma_p(0.5 * edf, 0.5 * chi2);
}

static void test_limits_are_within_a_thousandth_for_any_real_edf(void)
{
    for (unsigned i = 0U; i < 335U; i++) {
        const double edf = pow(1.03, (double)i);
        double low;
        double high;
        davar_chi_square_interval(edf, &low, &high);
        TEST_ASSERT_TRUE(chi_square_cdf(edf, edf / high * 1.001) > 0.025);
        TEST_ASSERT_TRUE(chi_square_cdf(edf, edf / high / 1.001) < 0.025);
        TEST_ASSERT_TRUE(chi_square_cdf(edf, edf / low * 1.001) > 0.975);
        TEST_ASSERT_TRUE(chi_square_cdf(edf, edf / low / 1.001) < 0.975);
    }
}

static void test_edf_below_one_counts_as_one_and_huge_edf_closes_the_interval(void)
{
    double low[3];
    double high[3];
    davar_chi_square_interval(1.0, &low[0], &high[0]);
    davar_chi_square_interval(0.01, &low[1], &high[1]);
    davar_chi_square_interval(1e12, &low[2], &high[2]);
    TEST_ASSERT_EQUAL_DOUBLE(low[0], low[1]);
    TEST_ASSERT_EQUAL_DOUBLE(high[0], high[1]);
    TEST_ASSERT_DOUBLE_WITHIN(4e-6, 1.0 - 1.96 * sqrt(2e-12), low[2]);
    TEST_ASSERT_DOUBLE_WITHIN(4e-6, 1.0 + 1.96 * sqrt(2e-12), high[2]);
}

/* ---- exact degrees of freedom ---- */

#define LENGTH 64

/* The kernel of difference p at cluster size m over LENGTH white rate samples: -1 m times, then +1
 * m times. */
static void kernel(int m, int p, int h[])
{
    for (int i = 0; i < LENGTH; i++) {
        h[i] = ((i < p) || (i >= p + 2 * m)) ? 0 : ((i < p + m) ? -1 : 1);
    }
}

static int dot(const int a[], const int b[])
{
    int sum = 0;
    for (int i = 0; i < LENGTH; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

/* Every lag at which the kernels overlap, whatever the window. */
static double overlap(int m_short, int m_long)
{
    int sum = 0;
    int fixed[LENGTH];
    kernel(m_long, LENGTH / 2 - m_long, fixed);
    for (int p = 0; p + 2 * m_short <= LENGTH; p++) {
        int moving[LENGTH];
        kernel(m_short, p, moving);
        sum += dot(fixed, moving) * dot(fixed, moving);
    }
    return sum;
}

static void test_white_overlap_is_exact(void)
{
    for (int i = 1; i <= 10; i++) {
        for (int j = i; j <= 10; j++) {
            TEST_ASSERT_EQUAL_DOUBLE(overlap(i, j), davar_noise_white_overlap(i, j));
        }
    }
}

/* Generalised autocovariance of the phase, Greenhall and Riley, "Uncertainty of stability variances
 * based on finite differences", PTTI 2003: constants and polynomials that second differences remove
 * are left out. */
static double phase_covariance(davar_coefficient_kind_t noise, double lag)
{
    const double t = fabs(lag);
    switch (noise) {
    case DAVAR_QUANTIZATION:
        return (t > 0.0) ? 0.0 : 1.0;
    case DAVAR_ANGLE_RANDOM_WALK:
        return -t;
    case DAVAR_BIAS_INSTABILITY:
        return (t > 0.0) ? t * t * log(t) : 0.0;
    case DAVAR_RATE_RANDOM_WALK:
    case DAVAR_RATE_RAMP:
    case DAVAR_COEFFICIENT_COUNT:
    default:
        return t * t * t;
    }
}

/* Covariance of two second differences of the phase, spans m_i and m_j, `lag` apart. */
static double difference_covariance(davar_coefficient_kind_t noise, int m_i, int m_j, int lag)
{
    static const double c[3] = {1.0, -2.0, 1.0};
    double sum = 0.0;
    for (int a = 0; a < 3; a++) {
        for (int b = 0; b < 3; b++) {
            sum += c[a] * c[b] * phase_covariance(noise, lag + b * m_j - a * m_i);
        }
    }
    return sum;
}

/* The same of equal spans: a fourth difference. */
static double own_covariance(davar_coefficient_kind_t noise, int m, int lag)
{
    static const double c[5] = {1.0, -4.0, 6.0, -4.0, 1.0};
    double sum = 0.0;
    for (int k = 0; k < 5; k++) {
        sum += c[k] * phase_covariance(noise, lag + (k - 2) * m);
    }
    return sum;
}

/* Variance of an Allan variance, relative to the square of its mean: every lag and its mirror
 * image. */
static double relative_variance(davar_coefficient_kind_t noise, int m, int window)
{
    const int n = window - 2 * m + 1;
    const double v = own_covariance(noise, m, 0);
    double sum = (double)n * v * v;
    for (int lag = 1; lag < n; lag++) {
        const double r = own_covariance(noise, m, lag);
        sum += 2.0 * (double)(n - lag) * r * r;
    }
    return 2.0 * sum / ((double)n * n * v * v);
}

/* Covariance of two Allan variances, relative to the product of their means. */
static double relative_covariance(davar_coefficient_kind_t noise, int m_i, int m_j, int window)
{
    const int n_i = window - 2 * m_i + 1;
    const int n_j = window - 2 * m_j + 1;
    double sum = 0.0;
    for (int lag = 1 - n_i; lag < n_j; lag++) {
        const int first = (lag > 0) ? lag : 0;
        const int last = (lag + n_i < n_j) ? lag + n_i : n_j;
        const double r = difference_covariance(noise, m_i, m_j, lag);
        sum += (double)(last - first) * r * r;
    }
    const double v_i = difference_covariance(noise, m_i, m_i, 0);
    const double v_j = difference_covariance(noise, m_j, m_j, 0);
    return 2.0 * sum / ((double)n_i * n_j * v_i * v_j);
}

static void check_edf(davar_coefficient_kind_t noise, int m, int window, double tolerance)
{
    const double exact = 2.0 / relative_variance(noise, m, window);
    TEST_ASSERT_DOUBLE_WITHIN(tolerance * exact, exact,
                              davar_edf(noise, (uint32_t)m, (uint32_t)window));
}

static void test_edf_is_within_two_percent_up_to_a_sixth_of_the_window(void)
{
    for (int window = 50; window <= 5000; window *= 10) {
        for (int m = 1; 6 * m <= window; m += 1 + m / 3) {
            check_edf(DAVAR_QUANTIZATION, m, window, 1e-9);
            check_edf(DAVAR_ANGLE_RANDOM_WALK, m, window, 0.02);
            check_edf(DAVAR_BIAS_INSTABILITY, m, window, 0.02);
            check_edf(DAVAR_RATE_RANDOM_WALK, m, window, (m > 1) ? 0.02 : 0.05);
        }
    }
}

static void test_edf_is_cautious_beyond_and_one_at_the_end(void)
{
    for (int noise = 0; noise < (int)DAVAR_COEFFICIENT_COUNT; noise++) {
        const davar_coefficient_kind_t kind = (davar_coefficient_kind_t)noise;
        for (uint32_t m = 100; m <= 300; m += 20) {
            const double exact = 2.0 / relative_variance(kind, (int)m, 600);
            TEST_ASSERT_TRUE(davar_edf(kind, m, 600) <= 1.002 * exact);
            TEST_ASSERT_TRUE(davar_edf(kind, m, 600) >= 1.0);
        }
        TEST_ASSERT_EQUAL_DOUBLE(1.0, davar_edf(kind, 300, 600));
    }
}

static double exact_correlation(davar_coefficient_kind_t noise, int m_i, int m_j)
{
    const double cross = relative_covariance(noise, m_i, m_j, 2000);
    return cross / sqrt(relative_variance(noise, m_i, 2000) * relative_variance(noise, m_j, 2000));
}

/* The table of (5.3) in long double, for every cluster size and number of differences up to 48, and
 * never below one. */
static void test_edf_is_the_formula_of_the_table(void)
{
    for (int m = 1; m <= 48; m++) {
        for (int n = 1; n <= 48; n++) {
            const long double l = m;
            const long double near = (n > m) ? n - m : 0;
            const long double far = (n > 2 * m) ? n - 2 * m : 0;
            const long double edf[DAVAR_COEFFICIENT_COUNT] = {
                36.0L * n * n / (36.0L * n + 32.0L * near + 2.0L * far),
                12.0L * l / (8.0L * l * l + 10.0L) * (n + l / 2.0L),
                1.167L * (n / l + 0.5L) * (l * l * l / (l * l * l + 1.0L / 3.0L)),
                0.927L * (n / l + 0.36L),
                0.927L * (n / l + 0.36L),
            };
            for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
                const double expected = (edf[k] > 1.0L) ? (double)edf[k] : 1.0;
                TEST_ASSERT_DOUBLE_WITHIN(1e-14 * expected, expected,
                                          davar_noise_edf((davar_coefficient_kind_t)k, m, n));
            }
        }
    }
}

static void test_correlation_between_cluster_sizes_is_close(void)
{
    for (int ratio = 1; ratio <= 16; ratio *= 2) {
        for (int noise = 0; noise < (int)DAVAR_COEFFICIENT_COUNT; noise++) {
            const davar_coefficient_kind_t kind = (davar_coefficient_kind_t)noise;
            const double exact = exact_correlation(kind, 5, 5 * ratio);
            TEST_ASSERT_DOUBLE_WITHIN(0.11, exact, davar_noise_correlation(kind, 5, 5 * ratio));
        }
    }
}

#define HOPPED 64 /* the smallest cluster */

/* Of D as a sum over the samples of white noise (is_walk: over the steps of a random walk), at a
 * lag in samples. */
static double covariance_of_sums(bool is_walk, int lag)
{
    double kernel[2 * HOPPED];
    double sum = 0.0;
    double walk = 0.0;
    for (int i = 0; i < (2 * HOPPED); i++) {
        const double box = (i < HOPPED) ? -1.0 : 1.0;
        walk += box;
        kernel[i] = is_walk ? walk : box;
    }
    for (int i = 0; (i + lag) < (2 * HOPPED); i++) {
        sum += kernel[i] * kernel[i + lag];
    }
    return sum;
}

/* Generalised covariance of the running sum of flicker noise. */
static double flicker_at(double x)
{
    return (fabs(x) > 0.0) ? (x * x * log(fabs(x))) : 0.0;
}

static double covariance_of_flicker(double x)
{
    return flicker_at(x + 2.0) - (4.0 * flicker_at(x + 1.0)) + (6.0 * flicker_at(x)) -
           (4.0 * flicker_at(x - 1.0)) + flicker_at(x - 2.0);
}

static double hop_covariance(davar_coefficient_kind_t kind, int lag)
{
    return (kind == DAVAR_BIAS_INSTABILITY)
               ? covariance_of_flicker((double)lag / (double)HOPPED)
               : covariance_of_sums(kind == DAVAR_RATE_RANDOM_WALK, lag);
}

static void check_hops(davar_coefficient_kind_t kind, double tolerance)
{
    for (uint32_t lags = 4U; lags <= 8U; lags *= 2U) {
        const int hop = HOPPED / (int)lags;
        double squares = 0.0; /* of the correlation at all lags from 1 to n - 1 */
        double weighted = 0.0;
        uint32_t l = 1U;
        for (uint32_t n = 1U; n <= 4096U; n += 1U + (n / 7U)) {
            for (; l < n; l++) {
                const int lag = (int)l * hop;
                const bool apart = (kind != DAVAR_BIAS_INSTABILITY) && (lag >= (2 * HOPPED));
                const double r =
                    apart ? 0.0 : (hop_covariance(kind, lag) / hop_covariance(kind, 0));
                squares += r * r;
                weighted += (double)l * r * r;
            }
            const double all = (double)n + (2.0 * (((double)n * squares) - weighted));
            const double edf = (double)n * (double)n / all;
            TEST_ASSERT_DOUBLE_WITHIN(tolerance * edf, edf, davar_hop_edf(kind, n, lags));
        }
    }
}

/* (5.1) is exact; hops of a cluster's eighth see the same lags. */
static void test_hops_of_quantization(void)
{
    for (uint32_t lags = 4U; lags <= 8U; lags *= 2U) {
        for (uint32_t n = 1U; n <= 4096U; n += 1U + (n / 7U)) {
            const double exact = davar_noise_edf(DAVAR_QUANTIZATION, (double)lags, (double)n);
            TEST_ASSERT_DOUBLE_WITHIN(1e-3 * exact, exact,
                                      davar_hop_edf(DAVAR_QUANTIZATION, n, lags));
        }
    }
}

static void test_hops_have_the_degrees_of_freedom_of_their_covariances(void)
{
    check_hops(DAVAR_ANGLE_RANDOM_WALK, 1e-3);
    check_hops(DAVAR_BIAS_INSTABILITY, 5e-3);
    check_hops(DAVAR_RATE_RANDOM_WALK, 1e-3);
}

/* The largest n that a cascade can have. */
static void test_no_sum_of_hops_overflows(void)
{
    for (uint32_t lags = 4U; lags <= 8U; lags *= 2U) {
        const double few = davar_hop_edf(DAVAR_RATE_RANDOM_WALK, 2048U * lags, lags);
        TEST_ASSERT_DOUBLE_WITHIN(0.01 * few, 2.0 * few,
                                  davar_hop_edf(DAVAR_RATE_RANDOM_WALK, 4096U * lags, lags));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_limits_meet_the_published_table);
    RUN_TEST(test_limits_are_within_a_thousandth_for_any_real_edf);
    RUN_TEST(test_edf_below_one_counts_as_one_and_huge_edf_closes_the_interval);
    RUN_TEST(test_white_overlap_is_exact);
    RUN_TEST(test_edf_is_within_two_percent_up_to_a_sixth_of_the_window);
    RUN_TEST(test_edf_is_cautious_beyond_and_one_at_the_end);
    RUN_TEST(test_edf_is_the_formula_of_the_table);
    RUN_TEST(test_correlation_between_cluster_sizes_is_close);
    RUN_TEST(test_hops_have_the_degrees_of_freedom_of_their_covariances);
    RUN_TEST(test_hops_of_quantization);
    RUN_TEST(test_no_sum_of_hops_overflows);
    return UNITY_END();
}
