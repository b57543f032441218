/* davar tests - float input: its error bound over any time, its counters, and the same decisions as
 * fixed point. */
#include "davar/davar.h"
#include "random.h"
#include "unity.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define TAUS 6U

static const uint32_t taus[TAUS] = {1U, 2U, 4U, 8U, 16U, 32U};
#ifndef SAMPLES /* an emulated board takes fewer */
#define SAMPLES 40000U
#endif

static uint64_t memory[2][4096];
static davar_config_t config;
static davar_result_t result;

void setUp(void)
{
    config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 1.0;
    config.full_scale = 2000.0;
    config.taus = taus;
    config.tau_count = TAUS;
}

void tearDown(void) {}

/* Overlapping Allan deviation of the newest `window` of n double samples. */
static double brute_force(const double *sample, uint32_t n, uint32_t window, uint32_t m)
{
    double sum = 0.0;
    for (uint32_t i = n - window; (i + (2U * m)) <= n; i++) {
        double difference = 0.0;
        for (uint32_t k = 0U; k < m; k++) {
            difference += sample[i + m + k] - sample[i + k];
        }
        sum += difference * difference;
    }
    return sqrt(sum / (2.0 * (double)m * (double)m * (double)(window - (2U * m) + 1U)));
}

/* DESIGN (2.3): |adev - exact| <= q / sqrt 2 with q <= full_scale / 2^29, whatever the stream held before. */
static void test_the_error_stays_in_its_bound_after_full_scale_bursts(void)
{
    static double sample[SAMPLES];
    davar_t davar;
    config.law = NULL;
    config.window.longest = 200U;
    config.window.shortest = 200U;
    const double bound = config.full_scale / 536870912.0 / sqrt(2.0);
    random_t random = random_seeded(7U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_f32(&davar, &config, memory[0], sizeof memory[0]));
    for (uint32_t n = 0U; n < SAMPLES; n++) {
        const bool burst = ((n / 1000U) % 3U) == 1U;
        const float rate =
            (float)((burst ? 1999.0 : 0.02) * (2.0 * random_uniform(&random) - 1.0) + 0.5);
        sample[n] = (double)rate;
        davar_push_f32(&davar, &rate, 1U);
        if (davar_take(&davar, &result) && ((n % 37U) == 0U)) {
            TEST_ASSERT_EQUAL_DOUBLE(0.0, result.unit_per_count); /* no rounding to remove */
            for (uint32_t t = 0U; t < TAUS; t++) {
                const double exact = brute_force(sample, n + 1U, 200U, taus[t]);
                TEST_ASSERT_DOUBLE_WITHIN(bound + (1e-14 * exact), exact, result.tau[t].adev);
            }
        }
    }
}

/* Noise of 20 quanta far below full scale keeps the kurtosis of the quanta: no bits are dropped. */
static void test_a_quiet_sensor_keeps_its_kurtosis(void)
{
    davar_t fixed;
    davar_t floating;
    davar_result_t other;
    random_t random = random_seeded(12U);
    config.full_scale = 2000.0;
    config.sample_bits = 32U;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q31(&fixed, &config, memory[0], sizeof memory[0]));
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_f32(&floating, &config, memory[1], sizeof memory[1]));
    for (uint32_t n = 0U; n < 2000U; n++) {
        const int32_t count = 524288 + (int32_t)lrint(20.0 * random_gauss(&random));
        const float rate = (float)((double)count / 524288.0);
        davar_push_q31(&fixed, &count, 1U);
        davar_push_f32(&floating, &rate, 1U);
        if (davar_take(&fixed, &result) && davar_take(&floating, &other)) {
            TEST_ASSERT_EQUAL_DOUBLE(result.kurtosis, other.kurtosis);
            TEST_ASSERT_EQUAL(result.unstable, other.unstable);
            TEST_ASSERT_DOUBLE_WITHIN(1.0, 3.0, other.kurtosis);
        }
    }
}

static void test_not_a_number_and_infinity_are_gaps(void)
{
    davar_t davar;
    config.law = NULL;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_f32(&davar, &config, memory[0], sizeof memory[0]));
    float block[700];
    for (uint32_t i = 0U; i < 700U; i++) {
        block[i] = (float)((i * 7919U) % 101U);
    }
    block[100] = (float)NAN;
    block[101] = (float)INFINITY;
    block[102] = -(float)INFINITY;
    block[300] = (float)NAN;
    uint32_t results = 0U;
    for (size_t i = 0U; i < 700U;) {
        i += davar_push_until_result_f32(&davar, &block[i], 700U - i);
        results += davar_take(&davar, &result) ? 1U : 0U;
    }
    const davar_health_t health = davar_health(&davar);
    TEST_ASSERT_EQUAL_UINT32(4U, health.not_finite);
    TEST_ASSERT_EQUAL_UINT32(2U, health.gaps);
    TEST_ASSERT_EQUAL_UINT32(4U, health.missing);
    TEST_ASSERT_EQUAL_UINT32(696U - 399U, results);
    TEST_ASSERT_EQUAL_UINT32(2U, result.gaps_in_window);
}

static void test_beyond_full_scale_saturates_and_counts(void)
{
    davar_t davar;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_f32(&davar, &config, memory[0], sizeof memory[0]));
    const float rates[5] = {2000.0F, -2000.0F, 2000.5F, -FLT_MAX, 1e-30F};
    davar_push_f32(&davar, rates, 5U);
    TEST_ASSERT_EQUAL_UINT32(4U, davar_health(&davar).saturated); /* at or above */
    davar.health.saturated = UINT32_MAX - 2U;
    for (uint32_t left = 2U; left > 0U; left--) {
        davar_push_f32(&davar, rates, 1U);
        TEST_ASSERT_EQUAL_UINT32(UINT32_MAX - left + 1U, davar_health(&davar).saturated);
    }
    davar_push_f32(&davar, rates, 1U);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, davar_health(&davar).saturated); /* and stays there */
}

/* At every full scale, the conversion to counts rounds halves away from zero. */
static void test_rounding_at_the_input(void)
{
    static const double scales[] = {1e-20,  1e-11,        0.3,          1.0, 4.0,
                                    2000.0, 1073741824.0, 1073741824.5, 1e20};
    static const double expected[] = {0.0, 1.0, 1.0, 2.0};
    static const double quanta[] = {0.4, 0.5, 1.4, 1.5};
    config.law = NULL;
    config.window.longest = 4U;
    config.window.shortest = 4U;
    config.moments.segment = 0U;
    config.tau_count = 1U;
    for (unsigned s = 0U; s < (sizeof scales / sizeof scales[0]); s++) {
        int exponent;
        const double fraction = frexp(scales[s], &exponent);
        const double quantum = ldexp(1.0, exponent - 30 - ((fraction > 0.5) ? 0 : 1));
        config.full_scale = scales[s];
        for (unsigned i = 0U; i < 8U; i++) {
            davar_t davar;
            const double sign = (i < 4U) ? 1.0 : -1.0;
            TEST_ASSERT_EQUAL(DAVAR_OK,
                              davar_init_f32(&davar, &config, memory[0], sizeof memory[0]));
            const float block[4] = {0.0F, 0.0F, 0.0F, (float)(sign * quanta[i % 4U] * quantum)};
            davar_push_f32(&davar, block, 4U);
            TEST_ASSERT_TRUE(davar_take(&davar, &result));
            /* three differences, the last one of `expected` quanta: adev = quantum * expected /
             * sqrt 6 */
            const double adev = quantum * expected[i % 4U] / sqrt(6.0);
            TEST_ASSERT_DOUBLE_WITHIN(1e-12 * quantum, adev, result.tau[0].adev);
        }
    }
}

/* Noise with bursts above full scale, and runs of values that are not numbers. */
static float rough_sample(random_t *random)
{
    const uint64_t weather = random_next(random) % 200U;
    const double rate = random_gauss(random) * ((weather < 4U) ? 2000.0 : 10.0);
    return (weather == 199U) ? NAN : (float)rate;
}

/* Pushes up to `most` samples. The result that they complete must equal that of the other
 * instance. */
static void push_like(davar_t *davar, davar_t *other, const float *rates, size_t most)
{
    davar_result_t expected;
    for (size_t done = 0U; done < most;) {
        const size_t consumed = davar_push_until_result_f32(davar, &rates[done], most - done);
        TEST_ASSERT_TRUE((consumed > 0U) && (consumed <= (most - done)));
        for (size_t i = done; i < (done + consumed); i++) {
            TEST_ASSERT_EQUAL_size_t(1U, davar_push_until_result_f32(other, &rates[i], 1U));
        }
        done += consumed;
        memset(&result, 0, sizeof result);
        memset(&expected, 0, sizeof expected);
        TEST_ASSERT_EQUAL_INT(davar_take(other, &expected), davar_take(davar, &result));
        TEST_ASSERT_EQUAL_MEMORY(&expected, &result, sizeof result);
        TEST_ASSERT_EQUAL_MEMORY(&other->health, &davar->health, sizeof davar->health);
    }
}

/* The number of samples per push changes nothing, with any input faults: on grids and without, with
 * restarts (two gaps at most). */
static void test_blocks_equal_samples_one_by_one(void)
{
    static const uint32_t strides[] = {1U, 20U, 100U, 400U};
    random_t random = random_seeded(11U);
    float rates[300];
    uint32_t saturated = 0U;
    uint32_t restarts = 0U;
    uint32_t results = 0U;
    for (unsigned trial = 0U; trial < 40U; trial++) {
        davar_t davar[2];
        config.stride = strides[trial % 4U];
        config.engine = (((trial / 4U) % 2U) == 0U) ? NULL : &davar_engine_grid_q31;
        config.window.longest = 400U;
        config.window.shortest = 200U;
        config.moments.segment = 100U;
        config.window.gaps_max = 2U;
        for (unsigned i = 0U; i < 2U; i++) {
            TEST_ASSERT_EQUAL_INT(DAVAR_OK,
                                  davar_init_f32(&davar[i], &config, memory[i], sizeof memory[i]));
        }
        for (unsigned block = 0U; block < 20U; block++) {
            const size_t count = 1U + (size_t)(random_next(&random) % 300U);
            for (size_t i = 0U; i < count; i++) {
                rates[i] = rough_sample(&random);
            }
            push_like(&davar[0], &davar[1], rates, count);
        }
        saturated += davar[0].health.saturated;
        restarts += davar[0].health.restarts;
        results += davar[0].produced;
    }
    TEST_ASSERT_TRUE((saturated > 500U) && (restarts > 100U) &&
                     (results > 1000U)); /* some results were compared */
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_the_error_stays_in_its_bound_after_full_scale_bursts);
    RUN_TEST(test_a_quiet_sensor_keeps_its_kurtosis);
    RUN_TEST(test_not_a_number_and_infinity_are_gaps);
    RUN_TEST(test_beyond_full_scale_saturates_and_counts);
    RUN_TEST(test_rounding_at_the_input);
    RUN_TEST(test_blocks_equal_samples_one_by_one);
    return UNITY_END();
}
