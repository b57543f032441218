/* davar tests - law glr from outside: a change is reported and the window begins after it; shocks,
 * gaps, restarts and settings. tests/tracking/test_forever.c compares the sums with brute
 * force. */
#include "davar/davar.h"

#include "random.h"
#include "reported.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define SAMPLES 9000U
#define STEP 5000U
#define TAUS 5U

typedef enum { Q15, Q31, F32 } type_t;

static const uint32_t taus[TAUS] = {1U, 2U, 4U, 8U, 16U};
static davar_config_t config;
static uint64_t memory[4096];
static davar_t davar;
static davar_result_t result;
static davar_glr_report_t report;
static int16_t stream[SAMPLES];

static double uniform(random_t *random)
{
    return ((double)(random_next(random) >> 11U) / 9007199254740992.0) - 0.5;
}

/* Sigma 20 counts, from `step` onward `ratio` times as much. */
static void make_stream(uint64_t seed, uint32_t step, double ratio)
{
    random_t random = random_seeded(seed);
    for (uint32_t i = 0U; i < SAMPLES; i++) {
        double sum = 0.0;
        for (unsigned k = 0U; k < 12U; k++) {
            sum += uniform(&random);
        }
        stream[i] = (int16_t)lround(sum * ((i < step) ? 20.0 : (20.0 * ratio)));
    }
}

void setUp(void)
{
    config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 0.25;
    config.full_scale = 4096.0;
    config.law = &davar_law_glr_q15;
    config.window.longest = 1200U;
    config.window.shortest = 20U;
    config.moments.segment = 0U;
    config.window.shrink = 16U;
    config.window.grow = 1U;
    config.window.gaps_max = 8U;
    config.glr.false_alarms_per_hour = 0.01;
    config.taus = taus;
    config.tau_count = TAUS;
    make_stream(3U, STEP, 1.8);
}

void tearDown(void) {}

static void init(type_t type)
{
    davar_status_t status = DAVAR_OK;
    if (config.law != NULL) {
        config.law = (type == Q15) ? &davar_law_glr_q15 : &davar_law_glr_q31;
    }
    memset(memory, 0xA5, sizeof memory);
    if (type == Q15) {
        TEST_ASSERT_LESS_OR_EQUAL_size_t(sizeof memory, davar_memory_size_q15(&config));
        status = davar_init_q15(&davar, &config, memory, sizeof memory);
    } else if (type == Q31) {
        status = davar_init_q31(&davar, &config, memory, sizeof memory);
    } else {
        status = davar_init_f32(&davar, &config, memory, sizeof memory);
    }
    TEST_ASSERT_EQUAL(DAVAR_OK, status);
}

/* Up to `count` samples from index n on; returns how many. */
static size_t push(type_t type, uint32_t n, size_t count)
{
    int32_t wide[64];
    float rate[64];
    const size_t most = (count < 64U) ? count : 64U;
    for (size_t i = 0U; i < most; i++) {
        wide[i] = stream[n + i];
        rate[i] = 0.25F * (float)stream[n + i];
    }
    if (type == Q15) {
        return davar_push_until_result_q15(&davar, &stream[n], most);
    }
    return (type == Q31) ? davar_push_until_result_q31(&davar, wide, most)
                         : davar_push_until_result_f32(&davar, rate, most);
}

/* --- tests --- */

/* A step of 1.8 is detected within two seconds, and soon the window has no older samples. */
static void check_step(type_t type, uint32_t stride, uint32_t block)
{
    uint32_t shortest = UINT32_MAX; /* window after the alarm */
    uint32_t alarms = 0U;
    config.stride = stride;
    init(type);
    for (uint32_t n = 0U; n < SAMPLES;) {
        n += (uint32_t)push(type, n, ((SAMPLES - n) < block) ? (SAMPLES - n) : block);
        if (!take_reported(&davar, &result, &report)) {
            continue;
        }
        TEST_ASSERT_TRUE(result.dispersion >= 1.0);
        if (report.alarm) {
            alarms++;
            TEST_ASSERT_UINT32_WITHIN(100U, STEP + 101U, (uint32_t)result.epoch);
            TEST_ASSERT_UINT32_WITHIN(60U, STEP, (uint32_t)result.epoch - report.cut_age_samples);
        }
        if ((alarms > 0U) && (result.window_samples < shortest)) {
            shortest = result.window_samples;
        }
    }
    TEST_ASSERT_EQUAL_UINT32(1U, alarms);
    TEST_ASSERT_EQUAL_UINT32(1U, davar_health(&davar).alarms);
    TEST_ASSERT_LESS_THAN_UINT32(450U, shortest);
    TEST_ASSERT_EQUAL_UINT32(0U, davar_health(&davar).missed);
}

static void test_a_step_is_reported_and_the_window_begins_after_it(void)
{
    check_step(Q15, 1U, 64U);
    check_step(Q15, 60U, 64U);
    check_step(Q31, 10U, 64U);
    check_step(F32, 1U, 1U);
    config.window.shrink = 5000U;
    check_step(Q15, 1U, 1U);
}

/* All waiting blocks may follow the change: it is reported before the window has reached it. */
static void test_a_change_reported_before_the_window_reaches_it_is_not_old(void)
{
    static int16_t quiet[SAMPLES];
    uint32_t ahead = 0U;
    make_stream(5U, SAMPLES, 1.0);
    memcpy(quiet, stream, sizeof quiet);
    config.glr.block = 25U;
    for (uint32_t turn = 0U; turn < 300U; turn++) {
        for (uint32_t n = 0U; n < 1400U; n++) {
            const int16_t sample = quiet[(n + (29U * turn)) % SAMPLES];
            stream[n] = (int16_t)((n < (1000U + (turn % 50U))) ? sample : (6 * sample));
        }
        init(Q15);
        for (uint32_t n = 0U; n < 1400U; n++) {
            (void)push(Q15, n, 1U);
            if (take_reported(&davar, &result, &report)) {
                TEST_ASSERT_LESS_OR_EQUAL_UINT32(n + 1U, report.cut_age_samples);
                ahead += (report.cut_age_samples == 0U) ? 1U : 0U;
            }
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT32(0U, ahead);
}

/* Pushes the first `count` samples, `block` at a time; returns the number of results. */
static uint32_t run(type_t type, uint32_t count, uint32_t block)
{
    uint32_t results = 0U;
    init(type);
    for (uint32_t n = 0U; n < count;) {
        n += (uint32_t)push(type, n, ((count - n) < block) ? (count - n) : block);
        results += take_reported(&davar, &result, &report) ? 1U : 0U;
    }
    return results;
}

/* A record that ends within a block; one shorter than the shortest window; a result at every
 * sample. */
static void test_a_flush_passes_the_samples_in_the_queue(void)
{
    static const struct {
        uint32_t stride;
        uint32_t count;
        uint64_t last;
    } cases[] = {{5U, 4009U, 4004U}, {5U, 9U, 0U}, {1U, 1004U, 1003U}};
    for (size_t i = 0U; i < sizeof cases / sizeof cases[0]; i++) {
        uint32_t flushed = 0U;
        config.stride = cases[i].stride;
        TEST_ASSERT_LESS_THAN_UINT32(1004U, run(Q15, cases[i].count, 64U));
        for (; davar_flush(&davar); flushed++) {
            TEST_ASSERT_TRUE(take_reported(&davar, &result, &report));
        }
        TEST_ASSERT_EQUAL(cases[i].last > 0U, flushed > 0U);
        if (flushed > 0U) {
            TEST_ASSERT_EQUAL_UINT64(cases[i].last, result.epoch);
        }
    }
}

/* An alarm that was not taken is in the next result that is taken. */
static void test_an_alarm_waits_to_be_taken(void)
{
    init(Q15);
    uint32_t n = 0U;
    for (; davar_health(&davar).alarms == 0U; n++) {
        TEST_ASSERT_LESS_THAN_UINT32(SAMPLES, n);
        (void)push(Q15, n, 1U);
    }
    for (uint32_t end = n + 100U; n < end; n++) {
        (void)push(Q15, n, 1U);
    }
    TEST_ASSERT_TRUE(take_reported(&davar, &result, &report));
    TEST_ASSERT_TRUE(report.alarm);
    (void)push(Q15, n, 1U);
    TEST_ASSERT_TRUE(take_reported(&davar, &result, &report));
    TEST_ASSERT_FALSE(report.alarm);
}

/* Each is counted once, for any block length. */
static void test_saturated_samples_are_counted_once(void)
{
    static const type_t types[2] = {Q15, F32};
    for (uint32_t i = 0U; i < 300U; i++) {
        stream[1000U + i] = INT16_MAX;
    }
    config.full_scale = 0.25 * 30000.0;
    config.stride = 10U;
    for (unsigned t = 0U; t < 2U; t++) {
        for (uint32_t block = 1U; block <= 64U; block += 21U) {
            (void)run(types[t], 4000U, block);
            TEST_ASSERT_EQUAL_UINT32(300U, davar_health(&davar).saturated);
        }
    }
}

/* ... and at least one result reports it, with or without moments. */
static void test_a_cut_is_unstable(void)
{
    for (uint32_t segment = 0U; segment <= 10U; segment += 10U) {
        uint32_t unstable = 0U;
        config.moments.segment = segment;
        init(Q15);
        for (uint32_t n = 0U; n < SAMPLES; n++) {
            (void)push(Q15, n, 1U);
            unstable += (take_reported(&davar, &result, &report) && result.unstable) ? 1U : 0U;
            TEST_ASSERT_LESS_OR_EQUAL_UINT32(SAMPLES, report.cut_age_samples);
        }
        TEST_ASSERT_EQUAL_UINT32(davar_health(&davar).cuts, unstable);
        TEST_ASSERT_EQUAL(segment == 0U, isnan(result.kurtosis));
    }
}

/* 79 samples are less than eight blocks, and 7690 more than 768. With the two shortest windows that
 * are refused, windows begin between two blocks. */
static void test_each_setting_outside_its_range_is_refused(void)
{
    static const struct {
        uint32_t block;
        uint32_t shock_blocks;
        uint32_t longest;
        uint32_t shortest;
        uint32_t stride;
        double alarms;
        double cuts;
        davar_status_t status;
    } cases[] = {
        {4U, 2U, 1200U, 20U, 1U, 1.0, 1.0, DAVAR_ERR_TRACKING},
        {65U, 2U, 1200U, 20U, 1U, 1.0, 1.0, DAVAR_ERR_TRACKING},
        {10U, 3U, 1200U, 20U, 1U, 1.0, 1.0, DAVAR_ERR_TRACKING},
        {10U, 2U, 79U, 20U, 1U, 1.0, 1.0, DAVAR_ERR_TRACKING},
        {10U, 2U, 7690U, 20U, 1U, 1.0, 1.0, DAVAR_ERR_TRACKING},
        {10U, 2U, 7680U, 20U, 1U, 1.0, 1.0, DAVAR_OK},
        {10U, 2U, 1200U, 20U, 1201U, 1.0, 1.0, DAVAR_ERR_STRIDE_LONG},
        {10U, 2U, 1200U, 1192U, 7U, 1.0, 1.0, DAVAR_ERR_TRACKING},
        {10U, 2U, 1200U, 1191U, 7U, 1.0, 1.0, DAVAR_OK},
        {10U, 2U, 1205U, 1201U, 20U, 1.0, 1.0, DAVAR_ERR_TRACKING},
        {10U, 2U, 1205U, 1200U, 20U, 1.0, 1.0, DAVAR_OK},
        {10U, 2U, 1200U, 20U, 1U, 1e-9, 1e9, DAVAR_OK},
        {10U, 2U, 1200U, 20U, 1U, 1e9, 1e-9, DAVAR_OK},
        {10U, 2U, 1200U, 20U, 1U, 0.0, 1.0, DAVAR_ERR_TRACKING},
        {10U, 2U, 1200U, 20U, 1U, 1.0, -1.0, DAVAR_ERR_TRACKING},
        {10U, 2U, 1200U, 20U, 1U, 0.9999999e-9, 1.0, DAVAR_ERR_TRACKING},
        {10U, 2U, 1200U, 20U, 1U, 1.0000001e9, 1.0, DAVAR_ERR_TRACKING},
        {10U, 2U, 1200U, 20U, 1U, 1.0, 0.9999999e-9, DAVAR_ERR_TRACKING},
        {10U, 2U, 1200U, 20U, 1U, 1.0, 1.0000001e9, DAVAR_ERR_TRACKING},
    };
    for (size_t i = 0U; i < sizeof cases / sizeof cases[0]; i++) {
        config.glr.block = cases[i].block;
        config.glr.shock_blocks = cases[i].shock_blocks;
        config.window.longest = cases[i].longest;
        config.window.shortest = cases[i].shortest;
        config.stride = cases[i].stride;
        config.glr.false_alarms_per_hour = cases[i].alarms;
        config.glr.cut_interval_s = cases[i].cuts;
        TEST_ASSERT_EQUAL(cases[i].status, davar_init_q15(&davar, &config, memory, sizeof memory));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_step_is_reported_and_the_window_begins_after_it);
    RUN_TEST(test_a_change_reported_before_the_window_reaches_it_is_not_old);
    RUN_TEST(test_a_flush_passes_the_samples_in_the_queue);
    RUN_TEST(test_an_alarm_waits_to_be_taken);
    RUN_TEST(test_saturated_samples_are_counted_once);
    RUN_TEST(test_a_cut_is_unstable);
    RUN_TEST(test_each_setting_outside_its_range_is_refused);
    return UNITY_END();
}
