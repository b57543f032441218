/* davar tests - policy glr over 10^7 samples with steps, shocks, gaps, stuck values and rails,
 * saved and restored repeatedly: every epoch is compared with sums recomputed from the record, bit
 * for bit. */
#include "accepted.h"
#include "davar/state.h"
#include "random.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#ifndef FOREVER_SAMPLES
#define FOREVER_SAMPLES 10000000U
#endif
#define TAUS 5U
#define SLOT ((size_t)65536)

#include "cells.h"

static const uint32_t taus[TAUS] = {1U, 2U, 4U, 8U, 16U};
static uint64_t memory[2][4096];
static davar_t instances[2];
static davar_config_t config;
static accepted_t accepted;

void setUp(void)
{
    config = davar_default_config;
    config.window.mode = DAVAR_MODE_CENTRED;
    config.rate_hz = 100.0;
    config.unit_per_count = 1.0;
    config.window.mode = DAVAR_MODE_TRAILING;
    config.law = &davar_law_glr_q15;
    config.window.longest = 200U;
    config.window.shortest = 40U;
    config.window.shrink = 16U;
    config.window.grow = 1U;
    config.moments.segment = 0U;
    config.window.gaps_max = 200U;
    config.glr.block = 5U;
    config.glr.shock_blocks = 2U;
    config.glr.false_alarms_per_hour = 1.0;
    config.glr.cut_interval_s = 30.0;
    config.taus = taus;
    config.tau_count = TAUS;
}

void tearDown(void) {}

/* --- the samples --- */

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

/* One after the newest accepted sample of the window. Centred windows may end before the newest of
 * all. */
static uint64_t head_of(const davar_t *davar, const davar_result_t *result)
{
    return (config.window.mode == DAVAR_MODE_CENTRED) ? (davar->window.received - davar->window.lag)
                                                      : accepted_head(&accepted, result->epoch);
}

/* `is_cut`: there was a cut. Up to eight blocks after it, and until the window does not reach it
 * (10.14). */
static void check(const davar_t *davar, const davar_result_t *result)
{
    const bool is_cut = (davar->health.cuts > 0U);
    const bool young = is_cut && ((result->cut_age_samples <= (8U * config.glr.block)) ||
                                  (result->cut_age_samples < result->window_samples));
    TEST_ASSERT_EQUAL(young, result->young);
    const uint64_t head = head_of(davar, result);
    TEST_ASSERT_TRUE(head > 0U);
    const uint64_t tail = head - result->window_samples;
    if (config.window.mode == DAVAR_MODE_CENTRED) {
        TEST_ASSERT_TRUE(accepted_holds(&accepted, tail, head, result->epoch));
    }
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
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(davar, &storage));
    TEST_ASSERT_EQUAL(
        DAVAR_OK, davar_init_q15(&instances[other], &config, memory[other], sizeof memory[other]));
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_restore(&instances[other], &storage));
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

static void run_forever(uint32_t stride, uint32_t samples)
{
    davar_t *davar = &instances[0];
    davar_result_t result;
    random_t random = random_seeded(5U);
    config.stride = stride;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(davar, &config, memory[0], sizeof memory[0]));
    accepted_start(&accepted, &config);
    uint64_t checked = 0U;
    uint32_t gaps = 0U;
    for (uint32_t n = 0U; n < samples; n++) {
        const int16_t sample = next_sample(&random, n);
        if (has_gap(&random, n)) {
            davar_gap(davar, 1U + (n % 3U));
            accepted_gap(&accepted);
            gaps++;
        }
        accepted_hear(&accepted, sample);
        davar_push_q15(davar, &sample, 1U);
        const bool is_late =
            (stride > 1U) && ((n % 4U) != 3U); /* up to three samples after the epoch */
        if (!is_late && davar_take(davar, &result)) {
            check(davar, &result);
            checked++;
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
    TEST_ASSERT_GREATER_THAN_UINT32(samples / 4000U, accepted.alarms);
    TEST_ASSERT_GREATER_THAN_UINT32(samples / 4000U, accepted.shocks);
    TEST_ASSERT_GREATER_THAN_UINT64((uint64_t)samples / stride / 5U * 4U, checked);
}

static void test_every_epoch_of_ten_million_samples_is_exact(void)
{
    run_forever(1U, FOREVER_SAMPLES);
}

static void test_every_epoch_of_ten_million_samples_on_a_grid_is_exact(void)
{
    run_forever(10U, FOREVER_SAMPLES);
}

static void test_every_epoch_of_centred_windows_is_exact(void)
{
    config.window.mode = DAVAR_MODE_CENTRED;
    config.window.longest = 330U;
    run_forever(1U, FOREVER_SAMPLES / 10U);
    run_forever(12U, FOREVER_SAMPLES);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_every_epoch_of_ten_million_samples_is_exact);
    RUN_TEST(test_every_epoch_of_ten_million_samples_on_a_grid_is_exact);
    RUN_TEST(test_every_epoch_of_centred_windows_is_exact);
    return UNITY_END();
}
