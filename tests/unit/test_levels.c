/* davar tests - the level since the last alarm (10.18): its interval against the mixture that it
 * approximates, and where the stretch begins. */
#include "davar/davar.h"
#include "davar/glr.h"
#include "laws/glr.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define BLOCK 10U
#define NU 9.0
#define FLOOR 180U  /* b of rounding: that in the samples, and the constant */
#define UNIT 1080.0 /* 12 K nu: b of a variance of one count */
#define PRIOR 100.0 /* a of the gamma mixture */
#define LEVEL 0.05  /* alpha */
#define ONE_F 4096U

void setUp(void) {}

void tearDown(void) {}

static davar_steady_t steady_of(double variance, uint32_t blocks, uint32_t f, double shocks,
                                uint32_t shock_blocks)
{
    davar_config_t config = davar_default_config;
    davar_glr_copy_t copy = {.dispersion = f};
    davar_glr_report_t report = {.young = false};
    const double sum = blocks * ((UNIT * variance) + FLOOR);
    copy.steady.high = (uint32_t)(sum / 18446744073709551616.0);
    copy.steady.low = (uint64_t)(sum - (copy.steady.high * 18446744073709551616.0));
    copy.steady.blocks = blocks;
    copy.shocks.low = (uint64_t)shocks;
    copy.shocks.blocks = shock_blocks;
    davar_glr_evaluate(&config, 0.5, &copy, &report);
    return report.steady;
}

/* ln of the mixture's likelihood ratio for n degrees of freedom and q = n times the ratio of the
 * observed variance to the one tested. */
static double mixture(double n, double q)
{
    const double b = PRIOR + (0.5 * n);
    return (PRIOR * log(PRIOR)) - lgamma(PRIOR) + lgamma(b) - (b * log(PRIOR + (0.5 * q))) +
           (0.5 * q);
}

/* The ratio at which it meets 1 / alpha; `from` is inside, `to` outside. */
static double edge(double n, double from, double to)
{
    for (int i = 0; i < 200; i++) {
        const double middle = 0.5 * (from + to);
        const bool inside = mixture(n, n * middle) < log(1.0 / LEVEL);
        from = inside ? middle : from;
        to = inside ? to : middle;
    }
    return 0.5 * (from + to);
}

static void test_the_interval_is_that_of_the_gamma_mixture(void)
{
    static const double factors[] = {1.0, 1.5, 5.0};
    unsigned compared = 0U;
    for (uint32_t i = 16U; i < 120U; i++) {
        const uint32_t blocks = (uint32_t)pow(2.0, 0.25 * i);
        for (int k = 0; k < 3; k++) {
            const double f = factors[k];
            const double n = NU * blocks / (1.0 + (1.5 * (f - 1.0)));
            const davar_steady_t steady = steady_of(400.0, blocks, (uint32_t)(f * ONE_F), 0.0, 0U);
            if (steady.samples == 0U) {
                TEST_ASSERT_TRUE(n < 85.0);
                continue;
            }
            TEST_ASSERT_TRUE(n > 75.0);
            compared++;
            const double total = 400.0 + (FLOOR / UNIT);
            const double low = 0.5 * sqrt((total / edge(n, 1.0, 100.0)) - (FLOOR / UNIT));
            const double high = 0.5 * sqrt((total / edge(n, 1.0, 0.0)) - (FLOOR / UNIT));
            TEST_ASSERT_DOUBLE_WITHIN(1e-8, 10.0, steady.level);
            TEST_ASSERT_EQUAL_UINT64((uint64_t)blocks * BLOCK, steady.samples);
            /* Never narrower by more than a two-hundredth of the half width, and from 1000 on not
             * wider by more than a fiftieth. */
            const double below = (10.0 - steady.low) / (10.0 - low);
            const double above = (steady.high - 10.0) / (high - 10.0);
            const double rounding = 1e-6 / (high - 10.0);
            TEST_ASSERT_TRUE((below > 0.995 - rounding) && (above > 0.995 - rounding));
            TEST_ASSERT_TRUE((n < 1000.0) || (fmax(below, above) < 1.02 + rounding));
        }
    }
    TEST_ASSERT_TRUE(compared > 250U);
}

static void test_shocks_raise_the_upper_limit_alone(void)
{
    const davar_steady_t without = steady_of(400.0, 1000U, ONE_F, 0.0, 0U);
    const davar_steady_t with = steady_of(400.0, 1000U, ONE_F, 1000.0 * UNIT * 400.0, 1U);
    TEST_ASSERT_EQUAL_DOUBLE(without.level, with.level);
    TEST_ASSERT_EQUAL_DOUBLE(without.low, with.low);
    TEST_ASSERT_DOUBLE_WITHIN(0.01 * without.high, sqrt(2.0) * without.high, with.high);
}

static void test_few_blocks_and_noise_near_the_rounding_have_no_interval(void)
{
    static const struct {
        double variance;
        uint32_t blocks;
        uint32_t f;
        uint64_t samples;
    } cases[] = {
        {400.0, 0U, ONE_F, 0U},  {400.0, 5U, ONE_F, 0U},     {400.0, 40U, 4U * ONE_F, 0U},
        {0.0, 1000U, ONE_F, 0U}, {0.48, 100000U, ONE_F, 0U}, {0.50, 100000U, ONE_F, 1000000U},
    };
    for (size_t i = 0U; i < sizeof cases / sizeof cases[0]; i++) {
        const davar_steady_t steady =
            steady_of(cases[i].variance, cases[i].blocks, cases[i].f, 0.0, 0U);
        TEST_ASSERT_EQUAL_UINT64(cases[i].samples, steady.samples);
    }
}

/* ---- where the stretch begins ---- */

static davar_glr_t detector;
static davar_glr_config_t config;
static davar_steady_sums_t sums;
static davar_glr_event_t event;

static void begin(void)
{
    const davar_glr_wish_t wish = {100.0, 0.01, 300.0, 600U, BLOCK, 2U};
    davar_glr_start(&config, &wish);
    davar_glr_reset(&detector);
    memset(&event, 0, sizeof event);
    memset(&sums, 0, sizeof sums);
    davar_steady_restart(&sums, &detector);
}

/* A block of the sum b, past the scan. */
static void take(uint64_t b)
{
    const davar_spread_t block = {b, 0U, 1U};
    spread_add(&detector.now.sum, &block);
    detector.now.at++;
    event.resolved = 1U;
    davar_steady_push(&sums, &detector, &config, &event);
}

static uint32_t blocks_now(void)
{
    return detector.now.sum.blocks - sums.since.blocks;
}

/* The halves differ by `ratio`. Restarted by the end of the second half? */
static bool restarts(uint32_t blocks, double ratio)
{
    begin();
    for (uint32_t i = 0U; i < (2U * blocks); i++) {
        take((uint64_t)(1e6 * ((i < blocks) ? 1.0 : ratio)));
        if ((i > 0U) && (blocks_now() == 0U)) {
            return true;
        }
    }
    return false;
}

static void test_it_restarts_where_its_halves_differ(void)
{
    static const uint32_t halves[] = {256U, 4096U, 65536U};
    begin();
    const double h = config.alarm / 65536.0;
    for (int i = 0; i < 3; i++) {
        const double step = sqrt(h * 8.0 / (NU * halves[i]));
        TEST_ASSERT_FALSE(restarts(halves[i], exp(0.98 * step)));
        TEST_ASSERT_TRUE(restarts(halves[i], exp(1.05 * step)));
        TEST_ASSERT_FALSE(restarts(halves[i], exp(-0.98 * step)));
        TEST_ASSERT_TRUE(restarts(halves[i], exp(-1.05 * step)));
        TEST_ASSERT_TRUE(restarts(halves[i], 1000.0));
    }
}

static void test_it_restarts_before_its_counts_wrap(void)
{
    begin();
    take(1000000U);
    detector.now.sum.blocks += UINT32_C(0x3FFFFF00);
    detector.now.sum.low += UINT64_C(0x3FFFFF00) * 1000000U;
    sums.middle = detector.now.sum; /* nothing to compare yet */
    uint32_t longest = 0U;
    for (uint32_t i = 0U; i < 512U; i++) {
        take(1000000U);
        longest = (blocks_now() > longest) ? blocks_now() : longest;
    }
    TEST_ASSERT_TRUE(longest < UINT32_C(0x40000040));
    TEST_ASSERT_TRUE(blocks_now() < 512U);
    begin();
    detector.now.sum.high = UINT32_C(0x40000000);
    detector.now.sum.blocks = 8U;
    for (uint32_t i = 0U; i < 63U; i++) {
        take(1000000U);
    }
    TEST_ASSERT_EQUAL_UINT32(0U, blocks_now());
}

static void test_it_restarts_before_the_sum_of_shocks_wraps(void)
{
    begin();
    event.dropped = 1U;
    event.shock = (davar_spread_t){0U, UINT32_C(0x10000000), 1U};
    for (uint32_t i = 0U; i < 63U; i++) {
        event.shock.high = (i < 4U) ? UINT32_C(0x10000000) : 0U;
        take(1000000U);
    }
    TEST_ASSERT_EQUAL_UINT32(0U, blocks_now());
    TEST_ASSERT_EQUAL_UINT32(0U, sums.shocks.high);
}

/* f is 5 at phi = 27/8 (10.3). It is compared every 64 blocks. */
static void test_heavy_tails_withhold_the_interval_for_2_to_the_14_blocks(void)
{
    begin();
    detector.single.count = 2000U;
    detector.single.phi = UINT32_C(27) << 21U;
    for (uint32_t i = 0U; i < 640U; i++) {
        take(1000000U);
    }
    TEST_ASSERT_EQUAL_UINT32(640U, blocks_now());
    TEST_ASSERT_TRUE(davar_steady_is_known(&sums, &detector));
    detector.single.phi += UINT32_C(1) << 14U; /* f is a little larger */
    TEST_ASSERT_FALSE(davar_steady_is_known(&sums, &detector));
    for (uint32_t i = 0U; i < 192U; i++) {
        take(1000000U);
    }
    TEST_ASSERT_TRUE(blocks_now() < 64U);
    detector.single.phi = UINT32_C(1) << 24U;
    while (!davar_steady_is_known(&sums, &detector) && (blocks_now() < 100000U)) {
        take(1000000U);
    }
    TEST_ASSERT_EQUAL_UINT32(16384U, blocks_now());
    for (uint32_t i = 0U; i < 640U; i++) {
        take(1000000U);
        TEST_ASSERT_TRUE(davar_steady_is_known(&sums, &detector));
    }
}

static void test_f_is_known_after_512_f_squared_blocks(void)
{
    static const double phis[] = {0.5, 1.0, 1.25, 1.6, 2.0, 3.3};
    begin();
    for (size_t i = 0U; i < sizeof phis / sizeof phis[0]; i++) {
        detector.single.phi = (uint32_t)(phis[i] * 16777216.0);
        const double f = davar_glr_dispersion(&detector, 3U) / 4096.0;
        const uint32_t blocks = (uint32_t)fmin(1536.0, floor(512.0 * f * f));
        detector.single.count = blocks - 1U;
        TEST_ASSERT_FALSE(davar_steady_is_known(&sums, &detector));
        detector.single.count = blocks;
        TEST_ASSERT_TRUE(davar_steady_is_known(&sums, &detector));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_the_interval_is_that_of_the_gamma_mixture);
    RUN_TEST(test_shocks_raise_the_upper_limit_alone);
    RUN_TEST(test_few_blocks_and_noise_near_the_rounding_have_no_interval);
    RUN_TEST(test_it_restarts_where_its_halves_differ);
    RUN_TEST(test_it_restarts_before_its_counts_wrap);
    RUN_TEST(test_it_restarts_before_the_sum_of_shocks_wraps);
    RUN_TEST(test_heavy_tails_withhold_the_interval_for_2_to_the_14_blocks);
    RUN_TEST(test_f_is_known_after_512_f_squared_blocks);
    return UNITY_END();
}
