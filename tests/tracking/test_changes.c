/* davar tests - how law glr reports a change: the levels before and after it. Waiting samples at
 * the end of a record are processed. */
#include "davar/davar.h"
#include "davar/fit.h"
#include "davar/state.h"

#include "random.h"
#include "reported.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define SAMPLES 40000U
#define STEP 20000U
#define SIGMA 20.0
#define SLOT 16384U

#include "cells.h"
#define UNIT 0.25

static const uint32_t taus[4] = {1U, 2U, 4U, 8U};
static davar_config_t config;
static uint64_t memory[4096];
static davar_t davar;
static davar_result_t result;
static davar_glr_report_t report;
static int16_t stream[SAMPLES];

void setUp(void)
{
    config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = UNIT;
    config.law = &davar_law_glr_q15;
    config.window.longest = 1200U;
    config.window.shortest = 20U;
    config.moments.segment = 0U;
    config.window.shrink = 64U;
    config.window.grow = 1U;
    config.stride = 10U;
    config.taus = taus;
    config.tau_count = 4U;
}

void tearDown(void) {}

/* White noise; from STEP onward `ratio` times as loud. */
static void make_stream(uint64_t seed, double ratio)
{
    random_t random = random_seeded(seed);
    for (uint32_t i = 0U; i < SAMPLES; i++) {
        stream[i] = (int16_t)lround(random_gauss(&random) * SIGMA * ((i < STEP) ? 1.0 : ratio));
    }
}

static void init_q15(void)
{
    TEST_ASSERT_LESS_OR_EQUAL_size_t(sizeof memory, davar_memory_size_q15(&config));
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
}

/* Alarms of [from, to); `first`: epoch of the first of them, result: the newest. */
static uint32_t run(uint32_t from, uint32_t to, uint32_t *first)
{
    uint32_t alarms = 0U;
    for (uint32_t n = from; n < to; n++) {
        davar_push_q15(&davar, &stream[n], 1U);
        if (take_reported(&davar, &result, &report) && report.alarm) {
            *first = (alarms == 0U) ? (uint32_t)result.epoch : *first;
            alarms++;
        }
    }
    return alarms;
}

/* Standard deviation about the means of blocks of ten, by its definition. */
static double level_of(uint32_t from, uint32_t to)
{
    double squares = 0.0;
    for (uint32_t n = from; n < to; n += 10U) {
        double mean = 0.0;
        for (uint32_t i = 0U; i < 10U; i++) {
            mean += stream[n + i] / 10.0;
        }
        for (uint32_t i = 0U; i < 10U; i++) {
            squares += (stream[n + i] - mean) * (stream[n + i] - mean);
        }
    }
    return UNIT * sqrt(squares / ((to - from) * 0.9));
}

static void test_a_step_reports_both_levels(void)
{
    uint32_t first = 0U;
    make_stream(1U, 2.0);
    init_q15();
    TEST_ASSERT_EQUAL_UINT32(0U, run(0U, STEP, &first));
    TEST_ASSERT_EQUAL_UINT32(0U, report.change.m);
    TEST_ASSERT_TRUE(isnan(report.change.older) && isnan(report.change.newer) &&
                     isnan(report.change.gain));
    /* 600 samples, and the one that brings the result of the last of them */
    TEST_ASSERT_EQUAL_UINT32(1U, run(STEP, STEP + 601U, &first));
    TEST_ASSERT_EQUAL_UINT32(1U, report.change.m);
    TEST_ASSERT_DOUBLE_WITHIN(0.03 * UNIT * SIGMA, UNIT * SIGMA, report.change.older);
    TEST_ASSERT_TRUE(report.change.gain > 14.0);
    /* the cut is at the alarm: there was no other */
    const uint32_t begin = (uint32_t)result.epoch + 1U - report.cut_age_samples;
    TEST_ASSERT_UINT32_WITHIN(20U, STEP, begin);
    const double expected = level_of(begin, STEP + 600U);
    TEST_ASSERT_DOUBLE_WITHIN(1e-8 * expected, expected, report.change.newer);
}

static void test_other_laws_report_no_change(void)
{
    static const davar_law_t *const laws[] = {NULL, &davar_law_or};
    uint32_t first = 0U;
    make_stream(1U, 2.0);
    config.moments.segment = 5U;
    for (size_t i = 0U; i < sizeof laws / sizeof laws[0]; i++) {
        memset(&report, 0xA5, sizeof report);
        config.law = laws[i];
        init_q15();
        TEST_ASSERT_EQUAL_UINT32(0U, run(STEP, STEP + 2000U, &first));
        TEST_ASSERT_EQUAL_UINT32(0U, report.cut_age_samples);
        TEST_ASSERT_FALSE(report.young || report.alarm || result.chosen);
        TEST_ASSERT_EQUAL_UINT32(0U, report.change.m);
        TEST_ASSERT_TRUE(isnan(report.change.older) && isnan(report.change.newer) &&
                         isnan(report.change.gain));
        TEST_ASSERT_EQUAL_UINT64(0U, report.steady.samples);
        TEST_ASSERT_TRUE(isnan(report.steady.level) && isnan(report.steady.low) &&
                         isnan(report.steady.high) && isnan(result.dispersion));
    }
}

/* The report is the same until the next push, except for the alarm, which is new only once. A reset
 * forgets it. */
static void test_a_report_returns_an_alarm_once(void)
{
    davar_glr_report_t again;
    make_stream(1U, 2.0);
    init_q15();
    for (uint32_t n = 0U; davar_health(&davar).alarms == 0U; n++) {
        davar_push_q15(&davar, &stream[STEP - 5000U + n], 1U);
    }
    davar_glr_report(&davar, &report); /* no result was taken */
    davar_glr_report(&davar, &again);
    TEST_ASSERT_TRUE(report.alarm);
    TEST_ASSERT_FALSE(again.alarm);
    again.alarm = true;
    TEST_ASSERT_EQUAL_MEMORY(&report.change, &again.change, sizeof report.change);
    TEST_ASSERT_EQUAL_UINT32(report.cut_age_samples, again.cut_age_samples);
    TEST_ASSERT_TRUE(davar_take(&davar, &result));
    davar_reset(&davar);
    davar_glr_report(&davar, &again);
    TEST_ASSERT_FALSE(again.alarm || again.young);
    TEST_ASSERT_EQUAL_UINT32(0U, again.change.m);
}

/* Only rounding remains: level 0. If gaps have removed all samples, there is no level. */
static void test_a_sensor_that_is_stuck_has_level_0(void)
{
    uint32_t first = 0U;
    make_stream(2U, 0.0);
    init_q15();
    TEST_ASSERT_EQUAL_UINT32(1U, run(STEP - 5000U, STEP + 500U, &first));
    TEST_ASSERT_TRUE(report.change.newer <= 0.0);
    TEST_ASSERT_TRUE(report.change.older > 0.9 * UNIT * SIGMA);
    config.window.gaps_max = 400U;
    config.stride = 1U;
    make_stream(1U, 2.0);
    init_q15();
    (void)run(STEP - 5000U, STEP + 500U, &first);
    for (uint32_t n = 0U; n < 300U; n++) {
        (void)run(STEP + 500U + n, STEP + 501U + n, &first);
        davar_gap(&davar, 1U);
    }
    (void)run(STEP + 1000U, STEP + 1009U, &first);
    while (davar_flush(&davar)) {
        TEST_ASSERT_TRUE(take_reported(&davar, &result, &report));
    }
    TEST_ASSERT_TRUE(isnan(report.change.newer));
    TEST_ASSERT_TRUE(report.change.older > 0.9 * UNIT * SIGMA);
}

static void test_a_restored_stream_reports_the_same(void)
{
    uint32_t first = 0U;
    make_stream(3U, 2.0);
    init_q15();
    (void)run(0U, STEP + 7U, &first);
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_state_save(&davar, &storage));
    TEST_ASSERT_EQUAL_UINT32(1U, run(STEP + 7U, STEP + 3000U, &first));
    const uint32_t before = first;
    const davar_change_t expected = report.change;
    init_q15();
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_state_restore(&davar, &storage));
    TEST_ASSERT_EQUAL_UINT32(1U, run(STEP + 7U, STEP + 3000U, &first));
    TEST_ASSERT_EQUAL_UINT32(before, first);
    TEST_ASSERT_EQUAL_DOUBLE(expected.older, report.change.older);
    TEST_ASSERT_EQUAL_DOUBLE(expected.newer, report.change.newer);
    config.glr.shock_blocks = 1U; /* another configuration */
    init_q15();
    TEST_ASSERT_EQUAL(DAVAR_STATE_ERR_FOREIGN, davar_state_restore(&davar, &storage));
}

/* A window that was just cut, or that excluded most samples since the cut, depends on its content
 * (10.14). */
static void test_intervals_of_a_chosen_window_are_wider(void)
{
    static davar_plan_t plan;
    uint32_t first = 0U;
    make_stream(1U, 1.0);
    init_q15();
    (void)run(0U, 3000U, &first);
    davar_plan_init(&plan, taus, 4U);
    TEST_ASSERT_FALSE(result.chosen);
    davar_result_t chosen = result;
    chosen.chosen = true;
    (void)davar_fit_white(&plan, 100.0, &result);
    (void)davar_fit_white(&plan, 100.0, &chosen);
    TEST_ASSERT_TRUE((result.noise == DAVAR_NOISE_WHITE) && (chosen.noise == DAVAR_NOISE_WHITE));
    for (uint32_t t = 0U; t < 4U; t++) {
        TEST_ASSERT_DOUBLE_WITHIN(1e-3 * result.tau[t].edf, 0.4375 * result.tau[t].edf,
                                  chosen.tau[t].edf);
        TEST_ASSERT_TRUE(chosen.tau[t].high > result.tau[t].high);
    }
}

/* --- the end of a record --- */

/* Every sample finally has its result, as if more samples had followed. */
static void check_end(uint32_t stride, uint32_t count)
{
    uint32_t first = 0U;
    make_stream(6U, 1.0);
    config.stride = stride;
    init_q15();
    (void)run(0U, count, &first);
    while (davar_flush(&davar)) {
        TEST_ASSERT_TRUE(take_reported(&davar, &result, &report));
    }
    TEST_ASSERT_FALSE(davar_flush(&davar));
    TEST_ASSERT_EQUAL_UINT64(((count / stride) * stride) - 1U, result.epoch);
    TEST_ASSERT_EQUAL_UINT32(0U, davar_health(&davar).missed);
}

static void test_waiting_samples_continue_at_the_end(void)
{
    for (uint32_t count = 3000U; count < 3025U; count++) {
        check_end(1U, count);
        check_end(5U, count);
        check_end(10U, count);
        check_end(7U, count);
    }
}

/* ... except for a possible shock. A saved instance that has ended stays ended. */
static void test_a_shock_at_the_end_is_left(void)
{
    uint32_t first = 0U;
    make_stream(6U, 1.0);
    stream[2995] = 900;
    config.stride = 1U;
    init_q15();
    (void)run(0U, 3004U, &first);
    while (davar_flush(&davar)) {
        TEST_ASSERT_TRUE(take_reported(&davar, &result, &report));
    }
    TEST_ASSERT_EQUAL_UINT64(2989U, result.epoch);
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_state_save(&davar, &storage));
    init_q15();
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_state_restore(&davar, &storage));
    TEST_ASSERT_FALSE(davar_flush(&davar));
#ifdef NDEBUG
    TEST_ASSERT_EQUAL_size_t(1U, davar_push_until_result_q15(&davar, stream, 1U));
    TEST_ASSERT_EQUAL_UINT32(1U, davar_health(&davar).missing);
#endif
    davar_reset(&davar);
    TEST_ASSERT_EQUAL_size_t(1U, davar_push_until_result_q15(&davar, stream, 1U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_step_reports_both_levels);
    RUN_TEST(test_other_laws_report_no_change);
    RUN_TEST(test_a_report_returns_an_alarm_once);
    RUN_TEST(test_a_sensor_that_is_stuck_has_level_0);
    RUN_TEST(test_a_restored_stream_reports_the_same);
    RUN_TEST(test_intervals_of_a_chosen_window_are_wider);
    RUN_TEST(test_waiting_samples_continue_at_the_end);
    RUN_TEST(test_a_shock_at_the_end_is_left);
    return UNITY_END();
}
