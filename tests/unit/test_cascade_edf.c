/* davar tests - the degrees of freedom of the cascade (11.6) against the covariances of its
 * differences, computed from the definition of each noise. */
#include "cascade/stage.h"
#include "davar/fit.h"
#include "unity.h"

#include <math.h>

#define M 64 /* the smallest cluster */

#define WHITE (UINT32_C(1) << (CASCADE_GROWTH_BITS - 1U))
#define FLICKER (UINT32_C(1) << CASCADE_GROWTH_BITS)
#define WALK (UINT32_C(2) << CASCADE_GROWTH_BITS)

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

static double covariance(uint32_t growth, int lag)
{
    return (growth == FLICKER) ? covariance_of_flicker((double)lag / (double)M)
                               : covariance_of_sums(growth == WALK, lag);
}

static void check(uint32_t growth, double tolerance)
{
    static double square[4096];
    for (uint32_t lags = 4U; lags <= 8U; lags *= 2U) {
        const int hop = M / (int)lags;
        for (int l = 0; l < 4096; l++) {
            const bool apart = (growth != FLICKER) && ((l * hop) >= (2 * M));
            const double r = apart ? 0.0 : (covariance(growth, l * hop) / covariance(growth, 0));
            square[l] = r * r;
        }
        for (uint32_t n = 1U; n <= 4096U; n += 1U + (n / 7U)) {
            double all = (double)n;
            for (uint32_t l = 1U; l < n; l++) {
                all += 2.0 * (double)(n - l) * square[l];
            }
            const double edf = (double)n * (double)n / all;
            TEST_ASSERT_DOUBLE_WITHIN(tolerance * edf, edf, davar_cascade_edf(growth, n, lags));
        }
    }
}

static void test_white_noise(void)
{
    check(WHITE, 1e-3);
}

static void test_flicker(void)
{
    check(FLICKER, 5e-3);
}

static void test_random_walk(void)
{
    check(WALK, 1e-3);
}

/* Steeper or flatter than these three kinds counts as one of them. Between white noise and flicker
 * edf falls; a little random walk in flicker hardly changes it. */
static void test_any_growth_has_its_degrees_of_freedom(void)
{
    TEST_ASSERT_EQUAL_DOUBLE(davar_cascade_edf(WHITE, 100U, 8U), davar_cascade_edf(0U, 100U, 8U));
    TEST_ASSERT_EQUAL_DOUBLE(davar_cascade_edf(WALK, 100U, 8U),
                             davar_cascade_edf(UINT32_MAX, 100U, 8U));
    for (uint32_t growth = WHITE; growth < FLICKER; growth += 16U) {
        TEST_ASSERT_TRUE(davar_cascade_edf(growth, 100U, 8U) >
                         davar_cascade_edf(growth + 16U, 100U, 8U));
    }
    for (uint32_t growth = FLICKER; growth < WALK; growth += 16U) {
        const double edf = davar_cascade_edf(growth, 100U, 8U);
        TEST_ASSERT_TRUE(edf < (1.02 * davar_cascade_edf(FLICKER, 100U, 8U)));
        TEST_ASSERT_TRUE(edf > davar_cascade_edf(WALK, 100U, 8U));
    }
}

/* (5.1), at every sample, is itself within 2 % for these sizes. */
static void test_hops_lose_little_against_full_overlap(void)
{
    static const struct {
        uint32_t growth;
        davar_coefficient_kind_t kind;
    } noise[] = {{WHITE, DAVAR_ANGLE_RANDOM_WALK},
                 {FLICKER, DAVAR_BIAS_INSTABILITY},
                 {WALK, DAVAR_RATE_RANDOM_WALK}};
    for (size_t i = 0U; i < (sizeof noise / sizeof noise[0]); i++) {
        for (uint32_t lags = 4U; lags <= 8U; lags *= 2U) {
            for (uint32_t clusters = 9U; clusters <= 300U; clusters *= 2U) {
                const uint32_t n = ((clusters - 2U) * lags) + 1U;
                const double full = davar_edf(noise[i].kind, M, clusters * M);
                const double hops = davar_cascade_edf(noise[i].growth, n, lags);
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
        const double few = davar_cascade_edf(WALK, 2048U * lags, lags);
        TEST_ASSERT_DOUBLE_WITHIN(0.01 * few, 2.0 * few,
                                  davar_cascade_edf(WALK, 4096U * lags, lags));
    }
}

/* --- the kind of noise, from the slope of the curve ------------------------------------------- */

#define TAUS 6U
#define N 100U

static const davar_cascade_config_t config = {
    .rate_hz = 1.0, .unit_per_count = 1.0, .shortest = 64U, .tau_count = TAUS, .clusters = 2048U};
static uint64_t memory[DAVAR_CASCADE_MEMORY(Q15, TAUS) / 8U];
static davar_cascade_t cascade;
static davar_cascade_result_t result;

/* The Allan variance of each size, in units of 2^20; 0xFFFFFFFF: no difference. */
static void take_curve(const uint32_t avar[TAUS])
{
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_cascade_init_q15(&cascade, &config, memory, sizeof memory));
    cascade_stage_t *const stages = cascade.stages;
    for (uint32_t t = 0U; t < TAUS; t++) {
        const uint64_t m = (uint64_t)64U << t;
        cascade_stage_t *const stage = &stages[t / CASCADE_TAUS];
        if (avar[t] != UINT32_MAX) {
            stage->count[(size_t)2U * (t % CASCADE_TAUS)] = N;
            stage->squares[(size_t)2U * (t % CASCADE_TAUS)].low = (2U * m * m * N * avar[t]) << 20U;
        }
    }
    (void)davar_cascade_take(&cascade, &result);
}

static void assert_growth(uint32_t t, uint32_t growth)
{
    TEST_ASSERT_EQUAL_DOUBLE(davar_cascade_edf(growth, N, 4U << (t % CASCADE_TAUS)),
                             result.tau[t].edf);
}

static void test_the_slope_comes_from_both_sides(void)
{
    const uint32_t avar[TAUS] = {64U, 400U, 36U, 36U, 49U, 49U};
    take_curve(avar);
    assert_growth(0U, (768U * 6U) / 5U); /* the root of 36 / 64 */
    assert_growth(1U, (768U * 6U) / 5U);
    assert_growth(2U, (307U * 6U) / 5U);  /* 36 / 400 */
    assert_growth(3U, (1195U * 6U) / 5U); /* 49 / 36 */
    assert_growth(4U, (1195U * 6U) / 5U);
    assert_growth(5U, (1195U * 6U) / 5U);
}

static void test_a_size_without_differences_ends_the_curve(void)
{
    const uint32_t avar[TAUS] = {64U, 100U, 36U, 144U, UINT32_MAX, UINT32_MAX};
    take_curve(avar);
    assert_growth(2U, (1229U * 6U) / 5U); /* 144 / 100 */
    assert_growth(3U, (1229U * 6U) / 5U);
    TEST_ASSERT_TRUE(isnan(result.tau[4].edf));
}

static void test_without_a_slope_the_noise_counts_as_random_walk(void)
{
    const uint32_t two[TAUS] = {64U, 32U, UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX};
    const uint32_t below[TAUS] = {0U, 32U, 16U, 16U, 8U, 8U};
    const uint32_t above[TAUS] = {64U, 32U, 0U, 16U, 8U, 8U};
    const uint32_t hole[TAUS] = {64U, 32U, UINT32_MAX, 16U, 8U, 8U};
    take_curve(two);
    assert_growth(0U, WALK);
    assert_growth(1U, WALK);
    take_curve(below);
    assert_growth(0U, WALK);
    assert_growth(1U, WALK);
    assert_growth(3U, (724U * 6U) / 5U); /* 8 / 16 */
    take_curve(above);
    assert_growth(1U, WALK);
    assert_growth(3U, WALK);
    take_curve(hole);
    assert_growth(1U, WALK);
    assert_growth(3U, WALK);
    assert_growth(4U, (724U * 6U) / 5U);
}

/* Entries of the result beyond the configured sizes are not read. */
static void test_two_sizes_have_no_slope(void)
{
    static davar_cascade_config_t two; /* the cascade keeps it */
    two = config;
    two.tau_count = 2U;
    result.tau[2].adev = 1.0;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_cascade_init_q15(&cascade, &two, memory, sizeof memory));
    cascade_stage_t *const stage = cascade.stages;
    for (uint32_t t = 0U; t < 2U; t++) {
        stage->count[(size_t)2U * t] = N;
        stage->squares[(size_t)2U * t].low = UINT64_C(1) << 40U;
    }
    TEST_ASSERT_TRUE(davar_cascade_take(&cascade, &result));
    assert_growth(0U, WALK);
    assert_growth(1U, WALK);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_white_noise);
    RUN_TEST(test_flicker);
    RUN_TEST(test_random_walk);
    RUN_TEST(test_any_growth_has_its_degrees_of_freedom);
    RUN_TEST(test_hops_lose_little_against_full_overlap);
    RUN_TEST(test_no_sum_overflows);
    RUN_TEST(test_the_slope_comes_from_both_sides);
    RUN_TEST(test_a_size_without_differences_ends_the_curve);
    RUN_TEST(test_two_sizes_have_no_slope);
    RUN_TEST(test_without_a_slope_the_noise_counts_as_random_walk);
    return UNITY_END();
}
