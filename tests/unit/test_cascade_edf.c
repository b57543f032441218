/* davar tests - the degrees of freedom of the cascade (11.6) against the covariances of its
 * differences, computed from the definition of each noise. */
#include "fit/plan.h"
#include "unity.h"

#include <math.h>

#define M 64 /* the smallest cluster */

void setUp(void) {}
void tearDown(void) {}

/* Of D as a sum over the samples of white noise (is_walk: over the steps of a random walk), at a
 * lag in samples. */
static double covariance_of_sums(bool is_walk, int lag)
{
    double kernel[2 * M];
    double sum = 0.0;
    double walk = 0.0;
    for (int i = 0; i < (2 * M); i++) {
        const double box = (i < M) ? -1.0 : 1.0;
        walk += box;
        kernel[i] = is_walk ? walk : box;
    }
    for (int i = 0; (i + lag) < (2 * M); i++) {
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

static double covariance(davar_coefficient_kind_t kind, int lag)
{
    return (kind == DAVAR_BIAS_INSTABILITY)
               ? covariance_of_flicker((double)lag / (double)M)
               : covariance_of_sums(kind == DAVAR_RATE_RANDOM_WALK, lag);
}

static void check(davar_coefficient_kind_t kind, double tolerance)
{
    static double square[4096];
    for (uint32_t lags = 4U; lags <= 8U; lags *= 2U) {
        const int hop = M / (int)lags;
        for (int l = 0; l < 4096; l++) {
            const bool apart = (kind != DAVAR_BIAS_INSTABILITY) && ((l * hop) >= (2 * M));
            const double r = apart ? 0.0 : (covariance(kind, l * hop) / covariance(kind, 0));
            square[l] = r * r;
        }
        for (uint32_t n = 1U; n <= 4096U; n += 1U + (n / 7U)) {
            double all = (double)n;
            for (uint32_t l = 1U; l < n; l++) {
                all += 2.0 * (double)(n - l) * square[l];
            }
            const double edf = (double)n * (double)n / all;
            TEST_ASSERT_DOUBLE_WITHIN(tolerance * edf, edf, davar_hop_edf(kind, n, lags));
        }
    }
}

static void test_white_noise(void)
{
    check(DAVAR_ANGLE_RANDOM_WALK, 1e-3);
}

static void test_flicker(void)
{
    check(DAVAR_BIAS_INSTABILITY, 5e-3);
}

/* (5.1) is exact; hops of a cluster's eighth see the same lags. */
static void test_quantization(void)
{
    for (uint32_t lags = 4U; lags <= 8U; lags *= 2U) {
        for (uint32_t n = 1U; n <= 4096U; n += 1U + (n / 7U)) {
            const double exact = davar_noise_edf(DAVAR_QUANTIZATION, (double)lags, (double)n);
            TEST_ASSERT_DOUBLE_WITHIN(1e-3 * exact, exact,
                                      davar_hop_edf(DAVAR_QUANTIZATION, n, lags));
        }
    }
}

static void test_random_walk(void)
{
    check(DAVAR_RATE_RANDOM_WALK, 1e-3);
}

/* (5.1), at every sample, is itself within 2 % for these sizes. */
static void test_hops_lose_little_against_full_overlap(void)
{
    for (int k = DAVAR_ANGLE_RANDOM_WALK; k <= DAVAR_RATE_RANDOM_WALK; k++) {
        const davar_coefficient_kind_t kind = (davar_coefficient_kind_t)k;
        for (uint32_t lags = 4U; lags <= 8U; lags *= 2U) {
            for (uint32_t clusters = 9U; clusters <= 300U; clusters *= 2U) {
                const uint32_t n = ((clusters - 2U) * lags) + 1U;
                const double full = davar_edf(kind, M, clusters * M);
                const double hops = davar_hop_edf(kind, n, lags);
                TEST_ASSERT_TRUE((hops / full) > 0.92);
                TEST_ASSERT_TRUE((hops / full) < 1.04);
            }
        }
    }
}

/* The largest n that a cascade can have. */
static void test_no_sum_overflows(void)
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
    RUN_TEST(test_white_noise);
    RUN_TEST(test_flicker);
    RUN_TEST(test_quantization);
    RUN_TEST(test_random_walk);
    RUN_TEST(test_hops_lose_little_against_full_overlap);
    RUN_TEST(test_no_sum_overflows);
    return UNITY_END();
}
