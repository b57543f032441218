/* davar tests - noise rounded to counts: how often the interval of the angle random walk, or its
 * upper limit, contains the value before rounding. Monte Carlo through the complete library over
 * independent windows, fixed seed. Prints the table of DESIGN (5.15). */
#include "davar/davar.h"
#include "random.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

#define WINDOW_MOST 20000U

typedef enum {
    ANYWHERE,
    ON_A_COUNT,
    BETWEEN,
    DRIFTING
} mean_t; /* where the mean lies between two counts */

typedef struct {
    /* percent of windows whose statement, interval or upper limit, contains the true value */
    double held;
    double intervals; /* percent of windows with an interval */
    double within;    /* percent of these that contain it */
    double bias;      /* mean value of these over the true value, less 1, percent */
} coverage_t;

static uint64_t memory[DAVAR_MEMORY_Q15(WINDOW_MOST, 2048U, 12U, 4U) / 8U];
static int16_t counts[WINDOW_MOST];
static davar_t davar;
static davar_plan_t plan;
static davar_result_t result;
static random_t rng;
static bool white_only;

void setUp(void)
{
    rng = random_seeded(20180805U);
    white_only = false;
}

void tearDown(void) {}

static davar_config_t config_of(uint32_t window, uint32_t *taus)
{
    davar_config_t config = davar_default_config;
    config.window.mode = DAVAR_MODE_CENTRED;
    config.rate_hz = 100.0;
    config.unit_per_count = 0.01;
    config.window.mode = DAVAR_MODE_TRAILING;
    config.law = NULL;
    config.window.longest = window;
    config.window.shortest = window;
    config.moments.segment = 0U;
    config.taus = taus;
    config.tau_count = davar_taus_octave(window, taus, 12U);
    return config;
}

static void make_counts(uint32_t window, double sigma, mean_t mean)
{
    const double start = random_uniform(&rng);
    const double drift = (mean == DRIFTING) ? (4.0 * random_uniform(&rng) / window) : 0.0;
    for (uint32_t i = 0U; i < window; i++) {
        const double centre =
            (mean == ON_A_COUNT) ? 0.0 : ((mean == BETWEEN) ? 0.5 : (start + (drift * i)));
        counts[i] = (int16_t)lround(centre + (sigma * random_gauss(&rng)));
    }
}

static void count_window(double truth, coverage_t *coverage)
{
    const davar_coefficient_t *const walk = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
    const bool holds = (!walk->present || (walk->low <= truth)) && (truth <= walk->high);
    coverage->held += holds ? 1.0 : 0.0;
    if (walk->present) {
        coverage->intervals += 1.0;
        coverage->within += holds ? 1.0 : 0.0;
        coverage->bias += (walk->value / truth) - 1.0;
    }
}

static void fit(double rate_hz)
{
    if (white_only) {
        (void)davar_fit_white(&plan, rate_hz, &result);
    } else {
        davar_fit(&plan, rate_hz, &result);
    }
}

static void one_window(const davar_config_t *config, double sigma, mean_t mean)
{
    davar_reset(&davar);
    make_counts(config->window.longest, sigma, mean);
    davar_push_q15(&davar, counts, config->window.longest);
    TEST_ASSERT_TRUE(davar_take(&davar, &result));
    fit(config->rate_hz);
}

static void to_percent(coverage_t *coverage, unsigned windows)
{
    const double intervals = (coverage->intervals > 0.0) ? coverage->intervals : 1.0;
    coverage->held *= 100.0 / windows;
    coverage->within *= 100.0 / intervals;
    coverage->bias *= 100.0 / intervals;
    coverage->intervals *= 100.0 / windows;
}

static coverage_t measured(uint32_t window, double sigma, mean_t mean, unsigned windows)
{
    static const char *const name[] = {"anywhere", "on a count", "between two", "drifting"};
    uint32_t taus[12];
    const davar_config_t config = config_of(window, taus);
    coverage_t coverage = {0};
    davar_plan_init_white(&plan, taus, config.tau_count);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
    for (unsigned i = 0U; i < windows; i++) {
        one_window(&config, sigma, mean);
        count_window(60.0 * sigma * config.unit_per_count / sqrt(config.rate_hz), &coverage);
    }
    to_percent(&coverage, windows);
    printf("%5.2f | %5u | %-11s | %5.1f | %5.1f | %5.1f | %+5.1f\n", sigma, (unsigned)window,
           name[mean], coverage.held, coverage.intervals, coverage.within, coverage.bias);
    return coverage;
}

static const double sigmas[] = {0.05, 0.1, 0.2, 0.3, 0.4, 0.45, 0.5,
                                0.55, 0.6, 0.8, 1.0, 2.0, 5.0,  30.0};
#define SIGMAS (sizeof sigmas / sizeof sigmas[0])

/* A standard error is 0.6 at 1000 windows and 96 %, 1 at 300. Of few intervals no share can be
 * estimated; their errors count in `held`. */
static void check_every_sigma(uint32_t window, mean_t mean, unsigned windows)
{
    for (size_t i = 0U; i < SIGMAS; i++) {
        const coverage_t coverage = measured(window, sigmas[i], mean, windows);
        TEST_ASSERT_TRUE(coverage.held >= 93.0);
        TEST_ASSERT_TRUE((coverage.intervals < 20.0) || (coverage.within >= 93.0));
        TEST_ASSERT_TRUE((sigmas[i] > 0.4) || (coverage.intervals < 1.0));
        TEST_ASSERT_TRUE((sigmas[i] < 0.6) || (coverage.intervals > 99.0));
        TEST_ASSERT_TRUE((sigmas[i] < 0.6) || (fabs(coverage.bias) < 1.0));
    }
}

static void test_short_windows(void)
{
    check_every_sigma(600U, ANYWHERE, 1000U);
    check_every_sigma(600U, DRIFTING, 1000U);
}

static void test_means_where_rounding_is_furthest_from_its_average(void)
{
    check_every_sigma(600U, ON_A_COUNT, 1000U);
    check_every_sigma(600U, BETWEEN, 1000U);
    check_every_sigma(6000U, ON_A_COUNT, 300U);
    check_every_sigma(6000U, BETWEEN, 300U);
}

static void test_long_windows(void)
{
    check_every_sigma(6000U, ANYWHERE, 300U);
    check_every_sigma(6000U, DRIFTING, 300U);
}

static void test_the_fit_of_white_noise_alone(void)
{
    white_only = true;
    for (size_t i = 0U; i < SIGMAS; i++) {
        TEST_ASSERT_TRUE(measured(600U, sigmas[i], ANYWHERE, 1000U).held >= 93.0);
        TEST_ASSERT_TRUE(measured(600U, sigmas[i], DRIFTING, 1000U).held >= 93.0);
    }
}

/* Large noise: the same interval as without rounding, less q^2 / 12. */
static void test_with_large_noise_rounding_only_subtracts_its_variance(void)
{
    uint32_t taus[12];
    const davar_config_t config = config_of(600U, taus);
    davar_plan_init_white(&plan, taus, config.tau_count);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
    for (unsigned i = 0U; i < 200U; i++) {
        one_window(&config, (i % 2U == 0U) ? 5.0 : 30.0, ANYWHERE);
        const davar_coefficient_t rounded = result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
        result.unit_per_count = 0.0;
        fit(config.rate_hz);
        const davar_coefficient_t whole = result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
        const double off =
            3600.0 * config.unit_per_count * config.unit_per_count / (12.0 * config.rate_hz);
        TEST_ASSERT_TRUE(rounded.present == whole.present);
        /* In a mixture, rounding is part of the model and changes its weights a little. */
        const double near = (result.noise == DAVAR_NOISE_WHITE) ? 1.0 : 100.0;
        TEST_ASSERT_DOUBLE_WITHIN(2e-6 * near * whole.value,
                                  sqrt((whole.value * whole.value) - off), rounded.value);
        TEST_ASSERT_DOUBLE_WITHIN(1e-5 * near * whole.high, sqrt((whole.high * whole.high) - off),
                                  rounded.high);
        TEST_ASSERT_DOUBLE_WITHIN(1e-5 * near * whole.high, sqrt((whole.low * whole.low) - off),
                                  rounded.low);
    }
}

/* A walk of a count and more per sample, with noise too small to be resolved next to its
 * rounding. */
static void test_a_walk_that_is_rounded_keeps_its_coefficient(void)
{
    uint32_t taus[12];
    const davar_config_t config = config_of(600U, taus);
    const double step = 3.0;
    const double truth = 216000.0 * step * config.unit_per_count * sqrt(config.rate_hz);
    unsigned held = 0U;
    unsigned walks = 0U;
    davar_plan_init_white(&plan, taus, config.tau_count);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
    for (unsigned i = 0U; i < 1000U; i++) {
        double walk = 0.0;
        for (uint32_t n = 0U; n < config.window.longest; n++) {
            walk += step * random_gauss(&rng);
            counts[n] = (int16_t)lround(walk);
        }
        davar_reset(&davar);
        davar_push_q15(&davar, counts, config.window.longest);
        TEST_ASSERT_TRUE(davar_take(&davar, &result));
        fit(config.rate_hz);
        const davar_coefficient_t *const rrw = &result.coefficient[DAVAR_RATE_RANDOM_WALK];
        walks += rrw->present ? 1U : 0U;
        held += ((!rrw->present || (rrw->low <= truth)) && (truth <= rrw->high)) ? 1U : 0U;
    }
    TEST_ASSERT_TRUE(walks > 900U);
    TEST_ASSERT_TRUE(held > 930U);
}

/* Slow noise of less than a count, which rounding turns into stairs: no number, but the reason. */
static void test_noise_below_half_a_count_has_a_reason_and_a_limit(void)
{
    uint32_t taus[12];
    const davar_config_t config = config_of(600U, taus);
    const double half = 60.0 * 0.5 * config.unit_per_count / sqrt(config.rate_hz);
    davar_plan_init_white(&plan, taus, config.tau_count);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
    for (unsigned i = 0U; i < 500U; i++) {
        one_window(&config, 0.02 * (double)(i % 20U), (mean_t)(i % 4U));
        TEST_ASSERT_TRUE((result.noise == DAVAR_NOISE_COARSE) ||
                         (result.noise == DAVAR_NOISE_CONSTANT));
        for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
            TEST_ASSERT_FALSE(result.coefficient[k].present);
            TEST_ASSERT_TRUE((k == (int)DAVAR_ANGLE_RANDOM_WALK) ||
                             isinf(result.coefficient[k].high));
        }
        TEST_ASSERT_TRUE(result.coefficient[DAVAR_ANGLE_RANDOM_WALK].high >= half * (1.0 - 1e-9));
        TEST_ASSERT_TRUE(isinf(result.tau[0].high));
    }
}

int main(void)
{
    printf("sigma, counts | window | mean | statements that hold %% | with an interval %% | of "
           "these hold %% | bias %%\n");
    UNITY_BEGIN();
    RUN_TEST(test_short_windows);
    RUN_TEST(test_means_where_rounding_is_furthest_from_its_average);
    RUN_TEST(test_long_windows);
    RUN_TEST(test_the_fit_of_white_noise_alone);
    RUN_TEST(test_with_large_noise_rounding_only_subtracts_its_variance);
    RUN_TEST(test_a_walk_that_is_rounded_keeps_its_coefficient);
    RUN_TEST(test_noise_below_half_a_count_has_a_reason_and_a_limit);
    return UNITY_END();
}
