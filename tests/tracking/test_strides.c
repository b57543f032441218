/* davar tests - law glr: the stride only sets how often results come. Streams with steps, shocks
 * and gaps: each result equals that of the same stream with a stride of one block, in window, age
 * of the cut, `young` and every bit of the deviations. */
#include "davar/davar.h"

#include "random.h"
#include "reported.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define SAMPLES 60000U
#define TAUS 6U
#define SIGMA 20.0

static const uint32_t taus[TAUS] = {1U, 2U, 4U, 8U, 16U, 32U};
static davar_config_t config;
static davar_t davar;
static davar_result_t result;
static davar_glr_report_t report;
static uint64_t memory[32768];
static int16_t stream[SAMPLES];
static bool is_gap[SAMPLES]; /* before this sample */

/* Values that must not depend on the stride, by epoch. */
typedef struct {
    double adev[TAUS];
    uint32_t window;
    uint32_t gaps;
    uint32_t age;
    uint32_t differences[TAUS];
    bool young;
    bool is_there;
} row_t;

static row_t expected[SAMPLES];

void setUp(void)
{
    config = davar_default_config;
    config.rate_hz = 1000.0;
    config.unit_per_count = 1.0;
    config.law = &davar_law_glr_q15;
    config.moments.segment = 0U;
    config.window.grow = 1U;
    config.window.shrink = 64U;
    config.window.gaps_max = 400U;
    config.taus = taus;
    config.tau_count = TAUS;
}

void tearDown(void) {}

/* Steps of x1 to x3 every few thousand samples, shocks of up to three blocks, gaps, sometimes three
 * in a row. */
static void make_stream(uint64_t seed, bool has_gaps)
{
    random_t random = random_seeded(seed);
    double level = 1.0;
    uint32_t knock = 0U;
    memset(is_gap, 0, sizeof is_gap);
    for (uint32_t i = 0U; i < SAMPLES; i++) {
        if ((random_next(&random) % 4000U) == 0U) {
            level = 1.0 + (2.0 * random_uniform(&random));
        }
        if ((random_next(&random) % 1500U) == 0U) {
            knock = 1U + (uint32_t)(random_next(&random) % (UINT64_C(3) * config.glr.block));
        }
        is_gap[i] = has_gaps && (i > 0U) &&
                    ((random_next(&random) % ((((i / 5000U) % 2U) == 0U) ? 900U : 60U)) == 0U);
        const double kick = (knock > 0U) ? (400.0 * (((knock % 2U) == 0U) ? 1.0 : -1.0)) : 0.0;
        knock -= (knock > 0U) ? 1U : 0U;
        stream[i] = (int16_t)lround((SIGMA * level * random_gauss(&random)) + kick);
    }
}

static void init(uint32_t stride)
{
    config.stride = stride;
    TEST_ASSERT_LESS_OR_EQUAL_size_t(sizeof memory, davar_memory_size_q15(&config));
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
}

static row_t row_of_result(void)
{
    row_t row = {.is_there = true};
    row.window = result.window_samples;
    row.gaps = result.gaps_in_window;
    row.age = report.cut_age_samples;
    row.young = report.young;
    for (uint32_t t = 0U; t < TAUS; t++) {
        row.differences[t] = result.tau[t].differences;
        row.adev[t] = result.tau[t].adev;
    }
    return row;
}

static void compare(const row_t *expected_row)
{
    const row_t row = row_of_result();
    TEST_ASSERT_TRUE(expected_row->is_there);
    TEST_ASSERT_EQUAL_UINT32(expected_row->window, row.window);
    TEST_ASSERT_EQUAL_UINT32(expected_row->gaps, row.gaps);
    TEST_ASSERT_EQUAL_UINT32(expected_row->age, row.age);
    TEST_ASSERT_EQUAL(expected_row->young, row.young);
    TEST_ASSERT_EQUAL_MEMORY(expected_row->differences, row.differences, sizeof row.differences);
    TEST_ASSERT_EQUAL_MEMORY(expected_row->adev, row.adev, sizeof row.adev);
}

/* Stores or compares every result of the stream; returns their number. Each is taken as late as
 * possible: a result may come up to three blocks after its samples. */
static uint32_t run(uint32_t stride, bool is_reference)
{
    const uint32_t late =
        (stride > (4U * config.glr.block)) ? (stride - (4U * config.glr.block)) : 0U;
    uint32_t results = 0U;
    uint32_t waits = 0U;
    init(stride);
    for (uint32_t i = 0U; i < SAMPLES; i++) {
        if (is_gap[i]) {
            const uint32_t produced = davar.produced;
            davar_gap(&davar, 1U);
            TEST_ASSERT_EQUAL_UINT32(produced, davar.produced); /* a gap completes none */
        }
        davar_push_q15(&davar, &stream[i], 1U);
        waits = (davar.produced == davar.seen) ? 0U : (waits + 1U);
        if ((waits > late) && take_reported(&davar, &result, &report)) {
            TEST_ASSERT_LESS_THAN_UINT64(SAMPLES, result.epoch);
            if (is_reference) {
                expected[result.epoch] = row_of_result();
            } else {
                compare(&expected[result.epoch]);
            }
            results++;
        }
    }
    TEST_ASSERT_EQUAL_UINT32(0U, davar_health(&davar).missed);
    TEST_ASSERT_EQUAL_UINT32(0U, davar_health(&davar).restarts);
    return results;
}

/* Strides of whole blocks; where shocks and gaps shift epochs, the count may differ by 2. */
static void check_strides(uint32_t block, double rate_hz)
{
    static const uint32_t factors[] = {2U, 3U, 10U, 25U, 50U, 100U};
    config.glr.block = block;
    config.rate_hz = rate_hz;
    config.window.longest = 120U * block;
    config.window.shortest = 2U * block;
    make_stream(UINT64_C(10) * block, true);
    memset(expected, 0, sizeof expected);
    const uint32_t all = run(block, true);
    for (uint32_t i = 0U; i < sizeof factors / sizeof factors[0]; i++) {
        const uint32_t results = run(factors[i] * block, false);
        TEST_ASSERT_UINT32_WITHIN(2U, all / factors[i], results);
    }
    TEST_ASSERT_GREATER_THAN_UINT32(3U, davar_health(&davar).shocks);
    TEST_ASSERT_GREATER_THAN_UINT32(3U, davar_health(&davar).cuts);
}

static void test_a_stride_changes_no_result(void)
{
    check_strides(5U, 100.0);
    check_strides(10U, 1000.0);
    check_strides(25U, 50.0);
    check_strides(64U, 8000.0);
}

static const uint32_t strides[] = {7U, 10U, 33U, 100U, 250U, 500U, 1000U};

/* window_min: a window is not shorter, and where the noise has changed since, it is longer by less
 * than a block. */
static void check_shortest(uint32_t stride, uint32_t window_min)
{
    uint32_t shortest = UINT32_MAX;
    config.window.shortest = window_min;
    init(stride);
    for (uint32_t i = 0U; i < SAMPLES; i++) {
        davar_push_q15(&davar, &stream[i], 1U);
        if (take_reported(&davar, &result, &report)) {
            TEST_ASSERT_GREATER_OR_EQUAL_UINT32(window_min, result.window_samples);
            if (report.cut_age_samples < window_min) {
                TEST_ASSERT_LESS_THAN_UINT32(window_min + config.glr.block, result.window_samples);
            }
            shortest = (result.window_samples < shortest) ? result.window_samples : shortest;
        }
    }
    TEST_ASSERT_LESS_THAN_UINT32(window_min + config.glr.block, shortest);
}

static void test_the_shortest_window_has_its_effect_at_every_stride(void)
{
    config.window.longest = 1200U;
    make_stream(7U, false);
    for (uint32_t i = 0U; i < sizeof strides / sizeof strides[0]; i++) {
        check_shortest(strides[i], 400U);
        check_shortest(strides[i], 405U);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_stride_changes_no_result);
    RUN_TEST(test_the_shortest_window_has_its_effect_at_every_stride);
    return UNITY_END();
}
