/* davar tests - how often the paper's law calls unchanged noise unstable with a stated rate, also
 * after filters. Fixed seeds. Prints the tables of lib/DESIGN.md (4.3). */
#include "davar/davar.h"
#include "davar/fit.h"
#include "filter_cases.h"
#include "filtered_noise.h"
#include "unity.h"

#include <stdio.h>

#ifndef SEED
#define SEED 1U /* any other must pass, too */
#endif

#define TRIALS 200U

void setUp(void) {}

void tearDown(void) {}

static filtered_noise_t noise;

static uint64_t memory[1 << 14];
static davar_t davar;
static davar_result_t result;

/* Percent of unstable windows. shortest = longest: of windows of this length that do not overlap;
 * else of all windows in the loop. */
static double unstable(const davar_filter_t *filter, const davar_law_t *law, uint32_t shortest,
                       uint32_t longest, double rate, uint32_t windows)
{
    static const uint32_t taus[] = {1U};
    davar_config_t config = davar_default_config;
    const bool fixed = (shortest == longest);
    uint32_t count = 0U;
    uint32_t bad = 0U;
    config.law = law;
    config.rate_hz = 100.0;
    config.unit_per_count = 1.0;
    config.window.longest = longest;
    config.window.shortest = shortest;
    config.window.grow = 1U;
    config.moments.segment = 100U;
    config.stride = fixed ? longest : 1U;
    config.taus = taus;
    config.tau_count = 1U;
    if (rate > 0.0) {
        davar_bound_unstable_rate(&config, rate, filter);
    }
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q31(&davar, &config, memory, sizeof memory));
    filtered_noise_start(&noise, filter, SEED + 2U);
    while (count < windows) {
        const int32_t sample = (int32_t)floor((1000.0 * filtered_noise_next(&noise, 1.0)) + 0.5);
        davar_push_q31(&davar, &sample, 1U);
        if (davar_take(&davar, &result) && (result.window_samples >= shortest)) {
            count++;
            bad += result.unstable ? 1U : 0U;
        }
    }
    return 100.0 * bad / windows;
}

#define WINDOWS 6000U

static void test_a_stated_rate_of_unstable_windows_holds(void)
{
    static const uint32_t lengths[] = {400U, 600U, 2000U};
    printf("| filter | 400 | 600 | 2000 | loop 400 to 600 | paper, 400 |\n");
    for (size_t c = 0U; c < CASES; c++) {
        const davar_filter_t *const filter = &cases[c].filter;
        printf("| %s |", cases[c].name);
        for (size_t l = 0U; l < 3U; l++) {
            const double share =
                unstable(filter, &davar_law_or, lengths[l], lengths[l], 0.01, WINDOWS);
            printf(" %.2f |", share);
            TEST_ASSERT_TRUE(share < 1.5 + (3.0 * 0.16));
        }
        const double loop = unstable(filter, &davar_law_or, 400U, 600U, 0.01, 200000U);
        printf(" %.2f |", loop);
        printf(" %.1f |\n", unstable(filter, &davar_law_or, 400U, 400U, 0.0, WINDOWS));
        TEST_ASSERT_TRUE(loop < 1.0);
    }
}

/* Percent of steps in white noise after which the law is unstable in a tenth more of 600 samples
 * than before. */
static double noticed(double ratio, double rate)
{
    static const uint32_t taus[] = {1U};
    davar_config_t config = davar_default_config;
    const davar_filter_t none = {.poles = 0U};
    uint32_t count = 0U;
    config.rate_hz = 100.0;
    config.unit_per_count = 1.0;
    config.window.grow = 1U;
    config.taus = taus;
    config.tau_count = 1U;
    if (rate > 0.0) {
        davar_bound_unstable_rate(&config, rate, NULL);
    }
    filtered_noise_start(&noise, &none, SEED + 3U);
    for (uint32_t t = 0U; t < TRIALS; t++) {
        double bad[2] = {0.0, 0.0};
        TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q31(&davar, &config, memory, sizeof memory));
        for (uint32_t i = 0U; i < 1800U; i++) {
            const double size = 1000.0 * ((i < 1200U) ? 1.0 : ratio);
            const int32_t sample = (int32_t)floor((size * filtered_noise_next(&noise, 1.0)) + 0.5);
            davar_push_q31(&davar, &sample, 1U);
            if (davar_take(&davar, &result) && (i >= 600U)) {
                bad[(i < 1200U) ? 0U : 1U] += result.unstable ? (1.0 / 600.0) : 0.0;
            }
        }
        count += (bad[1] > (bad[0] + 0.1)) ? 1U : 0U;
    }
    return 100.0 * count / TRIALS;
}

static void test_the_price_of_a_stated_rate(void)
{
    printf("| step | stated 1 %% | paper |\n");
    static const double ratios[] = {1.5, 2.0, 2.5, 3.0};
    for (size_t i = 0U; i < sizeof ratios / sizeof ratios[0]; i++) {
        const double ratio = ratios[i];
        printf("| x%.1f | %.0f | %.0f |\n", ratio, noticed(ratio, 0.01), noticed(ratio, 0.0));
    }
    TEST_ASSERT_TRUE(noticed(2.0, 0.01) > 90.0);
}

static void test_other_stated_rates_hold(void)
{
    static const double rates[] = {0.1, 0.03, 0.003};
    static const davar_law_t *const laws[] = {&davar_law_kurtosis, &davar_law_or, &davar_law_and};
    static const char *const names[] = {"kurtosis", "or", "and"};
    printf("| law | stated 10 %% | 3 %% | 0.3 %% |\n");
    for (size_t l = 0U; l < 3U; l++) {
        printf("| %s |", names[l]);
        for (size_t r = 0U; r < 3U; r++) {
            const double stated = 100.0 * rates[r];
            const double share = unstable(&cases[0].filter, laws[l], 600U, 600U, rates[r], 8000U);
            printf(" %.2f |", share);
            TEST_ASSERT_TRUE(share < (1.5 * stated) + (3.0 * sqrt(stated / 80.0)));
        }
        printf("\n");
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_stated_rate_of_unstable_windows_holds);
    RUN_TEST(test_the_price_of_a_stated_rate);
    RUN_TEST(test_other_stated_rates_hold);
    return UNITY_END();
}
