/* davar tests - how often the 95 % interval of the angle random walk contains the value at the
 * epoch, while policy glr cuts the window: steps of the noise, a result every ten samples, by the
 * time since the step, in windows cut since. Prints the tables of DESIGN (10.14), and (10.15) for
 * centred windows by the time to the nearest step. */
#include "davar/davar.h"
#include "davar/fit.h"

#include "random.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>

#define RATE_HZ 100.0
#define SIGMA 20.0
#define TAUS 9U
#define STRETCH UINT64_C(6000) /* samples between two steps */
#define BINS 6U

static const uint32_t taus[TAUS] = {1U, 2U, 4U, 8U, 16U, 32U, 64U, 128U, 256U};
static const uint32_t until[BINS] = {50U,  100U,  200U,
                                     500U, 1500U, 6000U}; /* samples since the step */

/* Results at this time since the step whose window was cut after it (within three blocks); for
 * steps of x1, all. */
typedef struct {
    uint32_t all; /* results at this time, cut or not */
    uint32_t cut;
    uint32_t offered; /* of them with an interval */
    uint32_t held;
} bin_t;

static davar_config_t config;
static davar_t davar;
static davar_plan_t plan;
static davar_result_t result;
static uint64_t memory[32768];

void setUp(void)
{
    config = davar_default_config;
    config.window.mode = DAVAR_MODE_CENTRED;
    config.rate_hz = RATE_HZ;
    config.unit_per_count = 1.0;
    config.window.mode = DAVAR_MODE_TRAILING;
    config.law = &davar_law_glr_q15;
    config.window.longest = 6000U;
    config.window.shortest = 20U;
    config.moments.segment = 0U;
    config.window.grow = 1U;
    config.stride = 10U;
    config.window.gaps_max = 64U;
    config.taus = taus;
    config.tau_count = TAUS;
    davar_plan_init_white(&plan, taus, TAUS);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
}

void tearDown(void) {}

static double sigma_at(uint64_t i, double ratio)
{
    return (((i / STRETCH) % 2U) == 0U) ? SIGMA : (SIGMA * ratio);
}

static void judge(bin_t bins[BINS], double ratio)
{
    const uint32_t since = (uint32_t)(result.epoch % STRETCH);
    const double truth =
        60.0 * sqrt((pow(sigma_at(result.epoch, ratio), 2.0) + (1.0 / 12.0)) / RATE_HZ);
    uint32_t b = 0U;
    while (since >= until[b]) {
        b++;
    }
    (void)davar_fit_white(&plan, RATE_HZ, &result);
    const davar_coefficient_t *const arw = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
    bins[b].all++;
    if ((ratio > 1.0) && (result.cut_age_samples > (since + 30U))) {
        return;
    }
    bins[b].cut++;
    bins[b].offered += arw->present ? 1U : 0U;
    bins[b].held += (arw->present && (arw->low <= truth) && (truth <= arw->high)) ? 1U : 0U;
}

static double percent(uint32_t part, uint32_t all)
{
    return (100.0 * part) / all;
}

static void run(double ratio, uint32_t steps, bin_t bins[BINS])
{
    random_t random = random_seeded(11U);
    for (uint64_t i = 0U; i < (steps * STRETCH); i++) {
        const int16_t sample = (int16_t)lround(sigma_at(i, ratio) * random_gauss(&random));
        davar_push_q15(&davar, &sample, 1U);
        if (davar_take(&davar, &result) && (result.epoch >= STRETCH)) {
            judge(bins, ratio);
        }
    }
    printf("| x%g |", ratio);
    for (uint32_t b = 0U; b < BINS; b++) {
        printf(" %.1f (%.0f) |", percent(bins[b].held, bins[b].offered),
               percent(bins[b].cut, bins[b].all));
    }
    printf("\n");
}

/* 600 sections. A bin of half a second has 50 results of each, which are strongly correlated, so
 * its standard error is about 0.7 %. */
static void check(double ratio, double least_cut)
{
    bin_t bins[BINS] = {{0U, 0U, 0U, 0U}};
    run(ratio, 600U, bins);
    for (uint32_t b = 0U; b < BINS; b++) {
        if (percent(bins[b].cut, bins[b].all) >= 50.0) {
            TEST_ASSERT_TRUE(percent(bins[b].held, bins[b].offered) >= 93.0);
            TEST_ASSERT_TRUE(percent(bins[b].held, bins[b].offered) <=
                             ((until[b] > 100U) ? 97.5 : 100.0)); /* young: wider */
        }
    }
    TEST_ASSERT_TRUE(percent(bins[3].offered, bins[3].cut) >=
                     95.0); /* white noise explains the window */
    TEST_ASSERT_TRUE(percent(bins[3].cut, bins[3].all) >= least_cut); /* 2 s to 5 s */
}

static void test_noise_that_does_not_change(void)
{
    check(1.0, 100.0);
}

static void test_steps(void)
{
    check(1.5, 95.0);
    setUp();
    check(2.0, 99.0);
    setUp();
    check(3.0, 99.0);
}

static void test_a_small_step(void)
{
    check(1.25, 50.0);
}

/* --- centred --- */

#define FARTHEST 5U

static const uint32_t within[FARTHEST] = {50U, 200U, 300U, 500U,
                                          3001U}; /* samples to the nearest step */

/* Farther from a step than half a window the interval is correct. Nearer, it is correct, or most
 * results are marked young. */
static void check_centred(double ratio)
{
    bin_t bins[FARTHEST] = {{0U, 0U, 0U, 0U}};
    random_t random = random_seeded(12U);
    config.window.mode = DAVAR_MODE_CENTRED;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
    for (uint64_t i = 0U; i < (300U * STRETCH); i++) {
        const int16_t sample = (int16_t)lround(sigma_at(i, ratio) * random_gauss(&random));
        davar_push_q15(&davar, &sample, 1U);
        if (!davar_take(&davar, &result) || (result.epoch < STRETCH)) {
            continue;
        }
        const uint32_t since = (uint32_t)(result.epoch % STRETCH);
        const uint32_t away = (since < (STRETCH / 2U)) ? since : ((uint32_t)STRETCH - since);
        const double truth =
            60.0 * sqrt((pow(sigma_at(result.epoch, ratio), 2.0) + (1.0 / 12.0)) / RATE_HZ);
        uint32_t b = 0U;
        while (away >= within[b]) {
            b++;
        }
        (void)davar_fit_white(&plan, RATE_HZ, &result);
        const davar_coefficient_t *const arw = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
        bins[b].all++;
        bins[b].cut += result.young ? 1U : 0U;
        bins[b].offered += arw->present ? 1U : 0U;
        bins[b].held += (arw->present && (arw->low <= truth) && (truth <= arw->high)) ? 1U : 0U;
    }
    printf("| x%g |", ratio);
    for (uint32_t b = 0U; b < FARTHEST; b++) {
        const double held = percent(bins[b].held, bins[b].offered);
        const double young = percent(bins[b].cut, bins[b].all);
        printf(" %.1f (%.0f) |", held, young);
        TEST_ASSERT_TRUE((held >= 93.0) || ((b < 3U) && (young >= 50.0)));
        TEST_ASSERT_TRUE(held <= 98.0);
    }
    printf("\n");
}

static void test_centred_windows(void)
{
    static const double ratios[] = {1.0, 1.25, 1.5, 2.0, 3.0};
    for (uint32_t i = 0U; i < 5U; i++) {
        check_centred(ratios[i]);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_noise_that_does_not_change);
    RUN_TEST(test_a_small_step);
    RUN_TEST(test_steps);
    RUN_TEST(test_centred_windows);
    return UNITY_END();
}
