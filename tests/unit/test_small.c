/* davar tests - the small pipeline beside an instance of the complete library that gets the same
 * samples and gaps: same results, same counters. Its deviations against those of the machine. */
#include "davar/davar.h"
#include "davar/fit.h"
#include "davar/small.h"

#include "deviation.h"
#include "number/real.h"
#include "random.h"

#include "unity.h"

#include <math.h>
#include <string.h>

#define WINDOW 160U
#define STRIDE 20U
#define RATE 100.0
#define UNIT 0.05
#define SAMPLES (40U * WINDOW)
#define BLOCK_MOST 40U

#include "small_streams.h"

static const uint32_t taus[] = {1U, 2U, 4U, 8U, 16U};
#define TAUS ((uint8_t)(sizeof taus / sizeof taus[0]))

static const davar_config_t config = {.rate_hz = RATE,
                                      .unit_per_count = UNIT,
                                      .stride = STRIDE,
                                      .window = {.longest = WINDOW, .shortest = WINDOW},
                                      .taus = taus,
                                      .tau_count = TAUS};
static davar_plan_t plan;
static davar_small_plan_t constant;
static uint64_t memory[256];
static davar_t davar;
static davar_result_t expected;
static int16_t ring[WINDOW + 1U];
static davar_small_t small;
static davar_result_t found;
static uint32_t seen[DAVAR_NOISE_FILTERED + 1];
static uint32_t unstable;

void setUp(void)
{
    (void)memset(seen, 0, sizeof seen);
    unstable = 0U;
    stream_state = 1U;
}

void tearDown(void) {}

/* The constant plan, as davar-plan makes it: that of a window after its fit. */
static void make_plan(const davar_filter_t *filter)
{
    static davar_result_t window;
    davar_plan_init_filtered(&plan, taus, TAUS, filter);
    window.tau_count = TAUS;
    window.window_samples = WINDOW;
    for (uint8_t t = 0U; t < TAUS; t++) {
        window.tau[t].m = taus[t];
        window.tau[t].differences = WINDOW + 1U - (2U * taus[t]);
        window.tau[t].adev = 1.0;
    }
    (void)davar_fit_white(&plan, RATE, &window);
    constant.fit = plan.white;
    constant.unit_per_count = UNIT;
    constant.stride = STRIDE;
}

static void start(void)
{
    davar_small_start(&small, &constant, ring);
    davar_small_restart(&small);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
}

static void assert_bits(double one, double other)
{
    TEST_ASSERT_EQUAL_HEX64(davar_bits_of_double(one), davar_bits_of_double(other));
}

static void assert_walk(const davar_coefficient_t *one, const davar_coefficient_t *other)
{
    TEST_ASSERT_EQUAL(one->present, other->present);
    assert_bits(one->value, other->value);
    assert_bits(one->low, other->low);
    assert_bits(one->high, other->high);
}

static void assert_same_result(void)
{
    TEST_ASSERT_EQUAL_UINT64(expected.epoch, found.epoch);
    TEST_ASSERT_EQUAL_UINT32(expected.window_samples, found.window_samples);
    TEST_ASSERT_EQUAL_UINT32(expected.gaps_in_window, found.gaps_in_window);
    TEST_ASSERT_EQUAL_UINT32(expected.equal_samples, found.equal_samples);
    TEST_ASSERT_EQUAL(expected.unstable, found.unstable);
    TEST_ASSERT_EQUAL(expected.noise, found.noise);
    TEST_ASSERT_EQUAL_UINT8(expected.tau_count, found.tau_count);
    for (uint8_t t = 0U; t < TAUS; t++) {
        TEST_ASSERT_EQUAL_UINT32(expected.tau[t].m, found.tau[t].m);
        TEST_ASSERT_EQUAL_UINT32(expected.tau[t].differences, found.tau[t].differences);
        assert_bits(expected.tau[t].adev, found.tau[t].adev);
        TEST_ASSERT_TRUE(isnan(found.tau[t].low) && isnan(found.tau[t].high));
    }
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        if (k == (int)DAVAR_ANGLE_RANDOM_WALK) {
            assert_walk(&expected.coefficient[k], &found.coefficient[k]);
        } else {
            TEST_ASSERT_FALSE(found.coefficient[k].present);
            TEST_ASSERT_TRUE(isinf(found.coefficient[k].high));
        }
    }
}

static void assert_same_health(void)
{
    const davar_health_t one = davar_health(&davar);
    const davar_health_t other = davar_small_health(&small);
    TEST_ASSERT_EQUAL_MEMORY(&one, &other, sizeof one);
}

/* Takes a result from both. */
static void take(void)
{
    const bool waits = davar_take(&davar, &expected);
    TEST_ASSERT_EQUAL(waits, davar_small_take(&small, &found));
    if (waits) {
        (void)davar_fit_white(&plan, RATE, &expected);
        assert_same_result();
        seen[found.noise]++;
        unstable += found.unstable ? 1U : 0U;
    }
}

/* Blocks of any size; one result in four is not taken; in every second stream gaps, some of them
 * while samples are skipped. */
static void run(int stream)
{
    int16_t samples[BLOCK_MOST];
    for (uint32_t i = 0U; i < SAMPLES;) {
        const uint32_t count = random_below(BLOCK_MOST + 1U);
        for (uint32_t k = 0U; k < count; k++) {
            samples[k] = clipped(sample_of(stream, i + k));
        }
        i += count;
        davar_push_q15(&davar, samples, count);
        davar_small_push(&small, samples, count);
        for (uint32_t more = 2U; (stream % 2 == 1) && (more > 0U); more--) {
            if (random_below(8U * WINDOW) < count) {
                davar_gap(&davar, more);
                davar_small_gap(&small, more);
            }
        }
        if (random_below(4U) > 0U) {
            take();
        }
        assert_same_health();
    }
}

static void run_all(const davar_filter_t *filter)
{
    make_plan(filter);
    for (int stream = 0; stream < STREAMS; stream++) {
        start();
        run(stream);
    }
}

static void test_without_a_filter_all_results_are_those_of_the_library(void)
{
    const davar_filter_t none = {0};
    run_all(&none);
    for (int noise = DAVAR_NOISE_WHITE; noise <= (int)DAVAR_NOISE_FILTERED; noise++) {
        TEST_ASSERT_TRUE(seen[noise] > 50U);
    }
    TEST_ASSERT_TRUE(unstable > 50U);
}

static void test_after_a_filter_too(void)
{
    davar_filter_t pole = {0};
    davar_filter_low_pass(&pole, 0.2, 1U, 0.1);
    run_all(&pole);
    TEST_ASSERT_TRUE(seen[DAVAR_NOISE_WHITE] > 50U);
}

static void test_a_gap_before_the_first_sample_restarts_nothing(void)
{
    const davar_filter_t none = {0};
    const int16_t sample = INT16_MIN;
    make_plan(&none);
    start();
    davar_gap(&davar, 3U);
    davar_small_gap(&small, 3U);
    assert_same_health();
    davar_push_q15(&davar, &sample, 1U);
    davar_small_push(&small, &sample, 1U);
    assert_same_health();
    take();
}

static void test_the_count_of_equal_samples_does_not_overflow(void)
{
    const davar_filter_t none = {0};
    static const int16_t sample[4U * WINDOW];
    make_plan(&none);
    start();
    davar_small_push(&small, sample, 1U); /* the first one equals none */
    small.equal = UINT32_MAX - 2U * WINDOW;
    davar_small_push(&small, sample, 4U * WINDOW);
    TEST_ASSERT_TRUE(small.equal > (UINT32_MAX / 2U));
    TEST_ASSERT_TRUE(small.equal <= ((UINT32_MAX / 2U) + STRIDE));
    TEST_ASSERT_TRUE(davar_small_take(&small, &found));
    TEST_ASSERT_EQUAL(DAVAR_NOISE_CONSTANT, found.noise);
}

static void test_deviations_digit_by_digit_are_correctly_rounded(void)
{
    random_t rng = random_seeded(7U);
    for (int i = 0; i < 200000; i++) {
        const uint64_t divisor = (random_next(&rng) >> (11U + (random_next(&rng) % 53U))) | 1U;
        const uint64_t sum = random_next(&rng) >> (random_next(&rng) % 64U);
        const double unit = ldexp(1.0 + random_uniform(&rng), (int)(random_next(&rng) % 60U) - 60);
        const double expected_value = sqrt((double)sum / (double)divisor) * unit;
        assert_bits(expected_value, davar_deviation_by_digits(sum, divisor, unit));
    }
    assert_bits(0.0, davar_deviation_by_digits(0U, 3U, 0.5));
    assert_bits(1.5, davar_deviation_by_digits(36U, 4U, 0.5));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_without_a_filter_all_results_are_those_of_the_library);
    RUN_TEST(test_after_a_filter_too);
    RUN_TEST(test_a_gap_before_the_first_sample_restarts_nothing);
    RUN_TEST(test_the_count_of_equal_samples_does_not_overflow);
    RUN_TEST(test_deviations_digit_by_digit_are_correctly_rounded);
    return UNITY_END();
}
