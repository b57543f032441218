/* davar tests - policy glr: the stride only sets how often results come. Streams with steps, shocks
 * and gaps: each result equals that of the same stream with a stride of one block, in window, age
 * of the cut, `young` and every bit of the deviations. The 95 % interval contains the true value
 * from one second after a change onward, at every stride. */
#include "davar/davar.h"
#include "davar/fit.h"

#include "random.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define SAMPLES 60000U
#define TAUS 6U
#define SIGMA 20.0

static const uint32_t taus[TAUS] = {1U, 2U, 4U, 8U, 16U, 32U};
static davar_config_t config;
static davar_t davar;
static davar_result_t result;
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
    config.window.mode = DAVAR_MODE_CENTRED;
    config.rate_hz = 1000.0;
    config.unit_per_count = 1.0;
    config.window.mode = DAVAR_MODE_TRAILING;
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

static void keep(row_t *row)
{
    row->window = result.window_samples;
    row->gaps = result.gaps_in_window;
    row->age = result.cut_age_samples;
    row->young = result.young;
    row->is_there = true;
    for (uint32_t t = 0U; t < TAUS; t++) {
        row->differences[t] = result.tau[t].differences;
        row->adev[t] = result.tau[t].adev;
    }
}

static void compare(const row_t *row)
{
    TEST_ASSERT_TRUE(row->is_there);
    TEST_ASSERT_EQUAL_UINT32(row->window, result.window_samples);
    TEST_ASSERT_EQUAL_UINT32(row->gaps, result.gaps_in_window);
    TEST_ASSERT_EQUAL_UINT32(row->age, result.cut_age_samples);
    TEST_ASSERT_EQUAL(row->young, result.young);
    for (uint32_t t = 0U; t < TAUS; t++) {
        TEST_ASSERT_EQUAL_UINT32(row->differences[t], result.tau[t].differences);
        TEST_ASSERT_EQUAL_MEMORY(&row->adev[t], &result.tau[t].adev, sizeof row->adev[t]);
    }
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
        if ((waits > late) && davar_take(&davar, &result)) {
            TEST_ASSERT_LESS_THAN_UINT64(SAMPLES, result.epoch);
            if (is_reference) {
                keep(&expected[result.epoch]);
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
static void check_strides(uint32_t block, double rate_hz, davar_mode_t mode)
{
    static const uint32_t factors[] = {2U, 3U, 10U, 25U, 50U, 100U};
    config.glr.block = block;
    config.rate_hz = rate_hz;
    config.window.mode = mode;
    config.window.longest = 120U * block;
    config.window.shortest = 2U * block;
    make_stream((UINT64_C(10) * block) + (uint64_t)mode, true);
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
    check_strides(5U, 100.0, DAVAR_MODE_TRAILING);
    check_strides(10U, 1000.0, DAVAR_MODE_TRAILING);
    check_strides(25U, 50.0, DAVAR_MODE_TRAILING);
    check_strides(64U, 8000.0, DAVAR_MODE_TRAILING);
}

static void test_a_stride_changes_no_result_of_centred_windows(void)
{
    check_strides(5U, 100.0, DAVAR_MODE_CENTRED);
    check_strides(10U, 1000.0, DAVAR_MODE_CENTRED);
    check_strides(25U, 50.0, DAVAR_MODE_CENTRED);
    check_strides(64U, 8000.0, DAVAR_MODE_CENTRED);
}

/* --- by time since a change --- */

#define STRETCH 6007U /* samples from step to step, 1 kHz; no multiple of a stride */
#define STRETCHES 200U
#define LATE (STRETCH - 1007U)

static const uint32_t strides[] = {7U, 10U, 33U, 100U, 250U, 500U, 1000U};

static double sigma_at(uint64_t i)
{
    return (((i / STRETCH) % 2U) == 0U) ? SIGMA : (2.0 * SIGMA);
}

#define BINS 3U
static const uint32_t bins[BINS + 1U] = {1000U, 2000U, 3000U, 5000U}; /* samples after a change */

typedef struct {
    uint32_t all[BINS];
    uint32_t held[BINS]; /* the interval contains the true value */
    uint32_t late;       /* from 5 s */
    uint32_t young;
} coverage_t;

/* No cut for nine blocks: not young. */
static void check_young(uint64_t cut_at)
{
    if ((result.epoch > cut_at) && ((result.epoch - cut_at) > (UINT64_C(9) * config.glr.block))) {
        TEST_ASSERT_FALSE(result.young);
    }
    if (result.cut_age_samples >= config.window.shortest) {
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(result.cut_age_samples,
                                         result.window_samples); /* nothing older */
    }
}

static void judge(davar_plan_t *plan, coverage_t *coverage)
{
    const double truth =
        60.0 * sigma_at(result.epoch) / sqrt(config.rate_hz); /* without the variance of rounding */
    davar_fit_white(plan, config.rate_hz, &result);
    const davar_coefficient_t *const arw = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
    const uint32_t since = (uint32_t)(result.epoch % STRETCH);
    for (uint32_t b = 0U; b < BINS; b++) {
        if ((since >= bins[b]) && (since < bins[b + 1U])) {
            coverage->all[b]++;
            coverage->held[b] +=
                (arw->present && (arw->low <= truth) && (truth <= arw->high)) ? 1U : 0U;
        }
    }
    if (since >= LATE) {
        coverage->late++;
        coverage->young += result.young ? 1U : 0U;
    }
}

static void check_coverage(uint32_t stride)
{
    static davar_plan_t plan;
    coverage_t coverage = {{0U}, {0U}, 0U, 0U};
    random_t random = random_seeded(23U);
    uint32_t cuts = 0U;
    uint64_t cut_at = 0U;
    davar_plan_init(&plan, taus, TAUS);
    init(stride);
    for (uint64_t i = 0U; i < ((uint64_t)STRETCHES * STRETCH); i++) {
        const int16_t sample = (int16_t)lround(sigma_at(i) * random_gauss(&random));
        davar_push_q15(&davar, &sample, 1U);
        cut_at = (davar_health(&davar).cuts == cuts) ? cut_at : i;
        cuts = davar_health(&davar).cuts;
        if (davar_take(&davar, &result) && (result.epoch >= STRETCH)) {
            check_young(cut_at);
            judge(&plan, &coverage);
        }
    }
    printf("stride %u: %u of %u young from 5 s\n", (unsigned)stride, (unsigned)coverage.young,
           (unsigned)coverage.late);
    for (uint32_t b = 0U; b < BINS; b++) {
        printf("  %u of %u held from %u s\n", (unsigned)coverage.held[b], (unsigned)coverage.all[b],
               (unsigned)(bins[b] / 1000U));
        TEST_ASSERT_GREATER_OR_EQUAL_UINT32(STRETCHES - 1U, coverage.all[b]);
        TEST_ASSERT_TRUE(coverage.held[b] >= (0.9 * coverage.all[b]));
    }
    TEST_ASSERT_TRUE(coverage.young <= (0.02 * coverage.late));
}

static void test_intervals_are_correct_soon_after_a_change_at_every_stride(void)
{
    config.window.longest = 6000U;
    config.window.shortest = 20U;
    for (uint32_t i = 0U; i < sizeof strides / sizeof strides[0]; i++) {
        check_coverage(strides[i]);
    }
}

/* window_min: a window is not shorter, and where the noise has changed since, it is longer by less
 * than a block. */
static void check_shortest(uint32_t stride, uint32_t window_min)
{
    uint32_t shortest = UINT32_MAX;
    config.window.shortest = window_min;
    init(stride);
    for (uint32_t i = 0U; i < SAMPLES; i++) {
        davar_push_q15(&davar, &stream[i], 1U);
        if (davar_take(&davar, &result)) {
            TEST_ASSERT_GREATER_OR_EQUAL_UINT32(window_min, result.window_samples);
            if ((config.window.mode == DAVAR_MODE_TRAILING) &&
                (result.cut_age_samples < window_min)) {
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
        config.window.mode = DAVAR_MODE_CENTRED;
        check_shortest(strides[i], 400U);
        config.window.mode = DAVAR_MODE_TRAILING;
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_stride_changes_no_result);
    RUN_TEST(test_a_stride_changes_no_result_of_centred_windows);
    RUN_TEST(test_intervals_are_correct_soon_after_a_change_at_every_stride);
    RUN_TEST(test_the_shortest_window_has_its_effect_at_every_stride);
    return UNITY_END();
}
