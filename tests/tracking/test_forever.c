/* davar tests - millions of samples with steps, shocks, gaps, stuck values and rails through windows
 * that laws or and glr choose, saved and restored repeatedly: every epoch is compared with sums
 * recomputed from the record, bit for bit. */
#include "accepted.h"
#include "davar/state.h"
#include "random.h"
#include "reported.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#ifndef FOREVER_SAMPLES
#define FOREVER_SAMPLES 5000000U
#endif
#define TAUS 5U
#define SLOT ((size_t)65536)

#include "cells.h"

static const uint32_t taus[TAUS] = {1U, 2U, 4U, 8U, 16U};
static uint64_t memory[2][4096];
static davar_t instances[2];
static davar_config_t config;
static accepted_t accepted;

typedef struct {
    const davar_law_t *law;
    uint32_t longest;
    uint32_t stride;
    uint32_t samples;
} forever_t;

static const forever_t runs[] = {
    {&davar_law_or, 96U, 1U, FOREVER_SAMPLES},
    {&davar_law_glr_q15, 200U, 1U, FOREVER_SAMPLES},
    {&davar_law_glr_q15, 200U, 10U, FOREVER_SAMPLES},
    {&davar_law_glr_q15, 330U, 12U, FOREVER_SAMPLES},
};

static void configure(const forever_t *run)
{
    config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 1.0;
    config.law = run->law;
    config.window.longest = run->longest;
    config.window.shortest = 40U;
    config.window.gaps_max = 200U;
    config.moments.segment = 16U;
    config.stride = run->stride;
    config.taus = taus;
    config.tau_count = TAUS;
    if (run->law == &davar_law_glr_q15) {
        config.window.shrink = 16U;
        config.window.grow = 1U;
        config.moments.segment = 0U;
        config.glr.block = 5U;
        config.glr.shock_blocks = 2U;
        config.glr.false_alarms_per_hour = 1.0;
        config.glr.cut_interval_s = 30.0;
    }
}

void setUp(void) {}

void tearDown(void) {}

/* --- the samples --- */

/* Noise on a ramp, rails, one rail and full scale, each for 500 samples. */
static int16_t next_burst(random_t *random, uint32_t n)
{
    const uint64_t bits = random_next(random);
    switch ((n / 500U) % 7U) {
    case 2U:
        return ((bits & 1U) != 0U) ? INT16_MAX : INT16_MIN;
    case 4U:
        return INT16_MIN;
    case 6U:
        return (int16_t)(bits & 0xFFFFU);
    default:
        return (int16_t)((int32_t)(bits % 41U) - 20 + (int32_t)(n % 997U));
    }
}

/* Nearly Gaussian; another level every 2000 samples, a shock of 2 to 8 samples every 900 on
 * average. */
static int16_t next_sample(random_t *random, uint32_t n)
{
    static const int32_t levels[] = {4, 12, 5, 40, 6, 400, 30, 8};
    static uint32_t knock;
    int32_t sum = 0;
    for (unsigned k = 0U; k < 4U; k++) {
        sum += (int32_t)(random_next(random) % 256U) - 128;
    }
    const int32_t value = (sum * levels[(n / 2000U) % 8U]) / 64;
    if ((random_next(random) % 900U) == 0U) {
        knock = 2U + (uint32_t)(random_next(random) % 7U);
    }
    if (knock > 0U) {
        knock--;
        return (int16_t)(((knock % 2U) != 0U) ? INT16_MAX : INT16_MIN);
    }
    switch ((n / 50000U) % 16U) {
    case 9U:
        return (int16_t)levels[(n / 300U) % 8U]; /* stuck */
    case 13U:
        return ((random_next(random) & 1U) != 0U) ? INT16_MAX : INT16_MIN;
    default:
        return (int16_t)value;
    }
}

/* --- the check --- */

static bool is_glr(void)
{
    return config.law == &davar_law_glr_q15;
}

/* Up to eight blocks after a cut, and until the window does not reach it (10.14). */
static bool is_young(const davar_t *davar, const davar_result_t *result,
                     const davar_glr_report_t *report)
{
    return is_glr() && (davar->health.cuts > 0U) &&
           ((report->cut_age_samples <= (8U * config.glr.block)) ||
            (report->cut_age_samples < result->window_samples));
}

static void check(const davar_t *davar, const davar_result_t *result,
                  const davar_glr_report_t *report)
{
    const uint64_t head = accepted_head(&accepted, result->epoch);
    const uint64_t tail = head - result->window_samples;
    TEST_ASSERT_GREATER_OR_EQUAL_UINT64(result->window_samples, head);
    TEST_ASSERT_EQUAL(is_young(davar, result, report), report->young);
    TEST_ASSERT_EQUAL(report->young || ((report->cut_age_samples - (report->cut_age_samples / 2U)) >
                                        result->window_samples),
                      result->chosen);
    for (uint32_t t = 0U; t < TAUS; t++) {
        uint32_t differences = 0U;
        const double m = (double)taus[t];
        const double sum = accepted_sum(&accepted, tail, head, taus[t], &differences);
        if (differences != result->tau[t].differences) {
            TEST_ASSERT_EQUAL_UINT32(differences, result->tau[t].differences);
        }
        if (differences > 0U) {
            const double expected = sqrt(sum / (2.0 * m * m * (double)differences));
            if ((expected < result->tau[t].adev) || (expected > result->tau[t].adev)) {
                TEST_ASSERT_EQUAL_DOUBLE(expected, result->tau[t].adev);
            }
        }
    }
}

static davar_t *change_over(davar_t *davar)
{
    const unsigned other = (davar == &instances[0]) ? 1U : 0U;
    memset(memory[other], 0xA5, sizeof memory[other]);
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_state_save(davar, &storage));
    TEST_ASSERT_EQUAL(
        DAVAR_OK, davar_init_q15(&instances[other], &config, memory[other], sizeof memory[other]));
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_state_restore(&instances[other], &storage));
    return &instances[other];
}

/* At times, or soon after the level has changed: while blocks of a possible shock are accepted
 * together. */
static bool has_gap(random_t *random, uint32_t n)
{
    const bool soon = ((n % 2000U) > 8U) && ((n % 2000U) < 60U);
    const bool dense = soon && (((n / 2000U) % 3U) == 0U) && ((random_next(random) % 7U) == 0U);
    const bool rare = (((n / 3000U) % 3U) == 1U) && ((random_next(random) % 200U) == 0U);
    return (n > 0U) && (dense || rare);
}

static void run_forever(const forever_t *run)
{
    davar_t *davar = &instances[0];
    davar_result_t result;
    davar_glr_report_t report;
    random_t random = random_seeded(5U);
    configure(run);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(davar, &config, memory[0], sizeof memory[0]));
    accepted_start(&accepted, &config);
    uint64_t checked = 0U;
    uint32_t gaps = 0U;
    uint32_t shortest = config.window.longest;
    for (uint32_t n = 0U; n < run->samples; n++) {
        const int16_t sample = is_glr() ? next_sample(&random, n) : next_burst(&random, n);
        if (has_gap(&random, n)) {
            davar_gap(davar, 1U + (n % 3U));
            accepted_gap(&accepted);
            gaps++;
        }
        accepted_hear(&accepted, sample);
        davar_push_q15(davar, &sample, 1U);
        const bool is_late =
            (run->stride > 1U) && ((n % 4U) != 3U); /* up to three samples after the epoch */
        if (!is_late && take_reported(davar, &result, &report)) {
            check(davar, &result, &report);
            checked++;
            shortest = (result.window_samples < shortest) ? result.window_samples : shortest;
        }
        if ((n % 7919U) == 7918U) {
            davar = change_over(davar);
        }
    }
    const davar_health_t health = davar_health(davar);
    TEST_ASSERT_EQUAL_UINT32(accepted.cuts, health.cuts);
    TEST_ASSERT_EQUAL_UINT32(accepted.alarms, health.alarms);
    TEST_ASSERT_EQUAL_UINT32(accepted.shocks, health.shocks);
    TEST_ASSERT_EQUAL_UINT32(gaps, health.gaps);
    TEST_ASSERT_EQUAL_UINT32(config.window.shortest, shortest);
    TEST_ASSERT_GREATER_THAN_UINT64((uint64_t)run->samples / run->stride / 5U * 4U, checked);
    if (is_glr()) {
        TEST_ASSERT_GREATER_THAN_UINT32(run->samples / 4000U, accepted.alarms);
        TEST_ASSERT_GREATER_THAN_UINT32(run->samples / 4000U, accepted.shocks);
    }
}

static void test_every_epoch_of_millions_of_samples_is_exact(void)
{
    for (size_t i = 0U; i < (sizeof runs / sizeof runs[0]); i++) {
        run_forever(&runs[i]);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_every_epoch_of_millions_of_samples_is_exact);
    return UNITY_END();
}
