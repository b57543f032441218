/* davar tests - decisions in 32 bits compared with kurtosis and contribution in doubles: never
 * wrong, and certain unless a bound is extremely close. */
#include "core/song.h"
#include "pipeline/type_q15.inc"

#include "davar/davar.h"
#include "random.h"
#include "unity.h"

#include <math.h>

#define TRIALS 20000U
#define SAMPLES 40U

static davar_config_t config;
static random_t source;
static davar_central_t whole;
static davar_central_t first;

void setUp(void)
{
    config = davar_default_config;
    config.window.mode = DAVAR_MODE_CENTRED;
    source = random_seeded(31U);
}

void tearDown(void) {}

static uint32_t below(uint32_t bound)
{
    return (uint32_t)(random_next(&source) % bound);
}

/* Samples of any size about any mean, a few of them larger. */
static davar_central_t any_central(uint32_t size)
{
    powers_t sums = {0};
    const int32_t mean = (int32_t)below(20000U) - 10000;
    const uint32_t n = 8U + below(SAMPLES);
    for (uint32_t i = 0U; i < n; i++) {
        const uint32_t width = (below(16U) == 0U) ? (4U * size) : size;
        powers_add(&sums, (int16_t)(mean + (int32_t)below(2U * width + 1U) - (int32_t)width));
    }
    davar_central_t central;
    powers_central(&sums, n, &central);
    return central;
}

/* Two sets of samples with a variance; the second of similar size as the first, or of another. */
static void choose_centrals(void)
{
    do {
        const uint32_t size = 1U + (below(5000U) >> below(12U));
        whole = any_central(size);
        first = any_central((below(4U) == 0U) ? (1U + below(5000U)) : size);
    } while ((whole.second.mantissa == 0U) || (first.second.mantissa == 0U));
}

/* Extremely close to the value, or not. True: so far that the decision must be certain. */
static bool choose_bound(double value, double *bound)
{
    const uint32_t bits = 1U + below(36U);
    const double distance = ldexp(1.0 + value, -(int)bits);
    *bound = ((below(2U) == 0U) || (distance > value)) ? (value + distance) : (value - distance);
    return bits < 22U;
}

static void check(davar_rough_t rough, bool outside, bool must_know)
{
    if (must_know) {
        TEST_ASSERT_NOT_EQUAL(ROUGH_UNSURE, rough);
    }
    if (rough != ROUGH_UNSURE) {
        TEST_ASSERT_EQUAL(outside ? ROUGH_OUTSIDE : ROUGH_INSIDE, rough);
    }
}

static void test_kurtosis_against_one_bound_or_the_other(void)
{
    for (uint32_t i = 0U; i < TRIALS; i++) {
        choose_centrals();
        const double kurtosis = davar_song_kurtosis(&whole);
        const bool upper = (i % 2U) == 0U;
        double bound;
        const bool far = choose_bound(kurtosis, &bound);
        config.moments.kurtosis_low = upper ? 0.0 : bound;
        config.moments.kurtosis_high = upper ? bound : 1e300;
        check(davar_rough_kurtosis(&config, &whole),
              upper ? (kurtosis > bound) : (kurtosis < bound), far);
    }
}

/* Contributions above 1 may be left to the exact path: y is more than twice x there. */
static void test_contribution_against_one_bound_or_the_other(void)
{
    for (uint32_t i = 0U; i < TRIALS; i++) {
        choose_centrals();
        const double contribution = davar_song_contribution(&whole, &first);
        const bool upper = (i % 2U) == 0U;
        double bound;
        const bool far = choose_bound(contribution, &bound) && (contribution < 0.45) &&
                         (contribution > 1e-6) && (bound > 1e-6);
        config.moments.contribution_low = upper ? 0.0 : bound;
        config.moments.contribution_high = upper ? bound : 3.9;
        check(davar_rough_contribution(&config, &whole, &first),
              upper ? (contribution > bound) : (contribution < bound), far);
    }
}

/* With the paper's bounds the exact path is hardly ever needed. */
static void test_the_usual_bounds_are_nearly_always_decided(void)
{
    uint32_t unsure = 0U;
    for (uint32_t i = 0U; i < TRIALS; i++) {
        const uint32_t size = 20U + below(3000U);
        whole = any_central(size);
        first = any_central(size);
        unsure += (davar_rough_kurtosis(&config, &whole) == ROUGH_UNSURE) ? 1U : 0U;
    }
    TEST_ASSERT_LESS_THAN_UINT32(TRIALS / 1000U, unsure);
}

static void test_bounds_of_no_use_are_left_to_the_exact_way(void)
{
    choose_centrals();
    first = whole;
    config.moments.contribution_high = 100.0;
    TEST_ASSERT_EQUAL(ROUGH_UNSURE, davar_rough_contribution(&config, &whole, &first));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_kurtosis_against_one_bound_or_the_other);
    RUN_TEST(test_contribution_against_one_bound_or_the_other);
    RUN_TEST(test_bounds_of_no_use_are_left_to_the_exact_way);
    RUN_TEST(test_the_usual_bounds_are_nearly_always_decided);
    return UNITY_END();
}
