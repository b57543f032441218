/* davar tests - policy glr over 10^7 samples with steps, shocks, gaps, stuck stretches and rails, saved and restored all the while: every
 * epoch against sums made anew from the record, bit for bit. Which samples belong to no sum is told by a detector of the test's own, which
 * hears the raw samples (unit/test_glr.c holds it to the law). */
#include "davar/davar.h"
#include "davar/state.h"
#include "random.h"
#include "track/glr.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#ifndef SAMPLES
#define SAMPLES 10000000U
#endif
#define TAUS 5U
#define RING 1024U /* of the record of accepted samples; a power of two above the window and what waits */
#define BLOCK 5U
#define WAITING_MAX (BLOCK * 4U)
#define SLOT ((size_t)65536)

static const uint32_t taus[TAUS] = {1U, 2U, 4U, 8U, 16U};
static uint64_t memory[2][2048];
static davar_t instances[2];
static unsigned char cells[2U * SLOT];
static davar_config_t config;

/* The record: accepted samples, one after the other. */
static struct {
    int64_t phase[RING];   /* cumulative sums up to sample n */
    uint32_t run[RING];    /* samples without a boundary up to sample n */
    uint64_t moment[RING]; /* when it came */
    uint64_t count;
    bool is_behind_boundary; /* the next one */
} record;

/* What has come and is not accepted yet. */
static struct {
    davar_glr_config_t config;
    davar_glr_t detector;
    int16_t sample[WAITING_MAX];
    uint32_t count;
    uint64_t now;
    uint32_t cuts;
    uint32_t alarms;
    uint32_t shocks;
} heard;

static bool read_cells(void *context, size_t offset, void *data, size_t bytes)
{
    (void)context;
    memcpy(data, &cells[offset], bytes);
    return true;
}

static bool write_cells(void *context, size_t offset, const void *data, size_t bytes)
{
    (void)context;
    memcpy(&cells[offset], data, bytes);
    return true;
}

static const davar_storage_t storage = {read_cells, write_cells, NULL, SLOT};

void setUp(void)
{
    config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 1.0;
    config.mode = DAVAR_MODE_TRAILING;
    config.policy = DAVAR_POLICY_GLR;
    config.window_max = 200U;
    config.window_min = 40U;
    config.shrink = 16U;
    config.grow = 1U;
    config.segment = 0U;
    config.gaps_max = 200U;
    config.block = BLOCK;
    config.shock_blocks = 2U;
    config.false_alarms_per_hour = 1.0;
    config.cut_interval_s = 30.0;
    config.taus = taus;
    config.tau_count = TAUS;
    memset(&record, 0, sizeof record);
    memset(&heard, 0, sizeof heard);
    record.is_behind_boundary = true;
    const davar_glr_wish_t wish = {.rate_hz = 100.0,
                                   .false_alarms_per_hour = 1.0,
                                   .cut_interval_s = 30.0,
                                   .longest = 200U,
                                   .block = BLOCK,
                                   .shock = 2U};
    davar_glr_start(&heard.config, &wish);
    davar_glr_reset(&heard.detector);
}

void tearDown(void) {}

/* --- the samples ------------------------------------------------------------------------------------------------------ */

/* Nearly Gaussian; another level every 2000 samples, a knock of 2 to 8 samples every 900 on the average. */
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

/* --- what belongs to the record ------------------------------------------------------------------------------------- */

static void accept(int16_t sample, uint64_t moment)
{
    const uint64_t n = record.count;
    record.phase[n % RING] = ((n > 0U) ? record.phase[(n - 1U) % RING] : 0) + sample;
    record.run[n % RING] = record.is_behind_boundary ? 1U : (record.run[(n - 1U) % RING] + 1U);
    record.moment[n % RING] = moment;
    record.is_behind_boundary = false;
    record.count++;
}

static void hear_block(void)
{
    davar_glr_event_t event;
    int32_t sum = 0;
    uint64_t squares = 0U;
    for (uint32_t i = heard.count - BLOCK; i < heard.count; i++) {
        sum += heard.sample[i];
        squares += (uint64_t)((int64_t)heard.sample[i] * heard.sample[i]);
    }
    davar_glr_push_q15(&heard.detector, &heard.config, sum, squares, &event);
    heard.cuts += event.is_cut ? 1U : 0U;
    heard.alarms += event.is_alarm ? 1U : 0U;
    heard.shocks += (event.dropped > 0U) ? 1U : 0U;
    record.is_behind_boundary = record.is_behind_boundary || (event.dropped > 0U);
    if (event.resolved > 0U) {
        TEST_ASSERT_EQUAL_UINT32(heard.count, event.resolved * BLOCK);
        for (uint32_t i = event.dropped * BLOCK; i < heard.count; i++) {
            accept(heard.sample[i], heard.now - heard.count + i);
        }
        heard.count = 0U;
    }
}

static void hear(int16_t sample)
{
    heard.sample[heard.count] = sample;
    heard.count++;
    heard.now++;
    if ((heard.count % BLOCK) == 0U) {
        hear_block();
    }
}

/* What waits is left out with the gap. An epoch counts samples that came. */
static void hear_gap(void)
{
    davar_glr_event_t event;
    davar_glr_skip(&heard.detector, &heard.config, &event);
    heard.count = 0U;
    record.is_behind_boundary = true;
}

/* --- the check -------------------------------------------------------------------------------------------------------- */

/* Sum of D^2 over [tail, head) and its count, from cumulative sums: D = P[i] - 2 P[i - m] + P[i - 2 m]. */
static uint64_t window_sum(uint64_t tail, uint64_t head, uint32_t m, uint32_t *differences)
{
    uint64_t sum = 0U;
    *differences = 0U;
    for (uint64_t last = tail + (UINT64_C(2) * m) - 1U; last < head; last++) {
        if (record.run[last % RING] >= (2U * m)) {
            const int64_t before = (last >= (UINT64_C(2) * m)) ? record.phase[(last - (UINT64_C(2) * m)) % RING] : 0;
            const int64_t d = record.phase[last % RING] - (2 * record.phase[(last - m) % RING]) + before;
            sum += (uint64_t)(d * d);
            (*differences)++;
        }
    }
    return sum;
}

static void check(const davar_result_t *result)
{
    uint64_t head = record.count;
    while (record.moment[(head - 1U) % RING] > result->epoch) {
        head--;
    }
    TEST_ASSERT_EQUAL_UINT64(result->epoch, record.moment[(head - 1U) % RING]);
    const uint64_t tail = head - result->window_samples;
    for (uint32_t t = 0U; t < TAUS; t++) {
        uint32_t differences = 0U;
        const double m = (double)taus[t];
        const uint64_t sum = window_sum(tail, head, taus[t], &differences);
        if (differences != result->tau[t].differences) {
            TEST_ASSERT_EQUAL_UINT32(differences, result->tau[t].differences);
        }
        if (differences > 0U) {
            const double expected = sqrt((double)sum / (2.0 * m * m * (double)differences));
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
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&instances[other], &config, memory[other], sizeof memory[other]));
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_restore(&instances[other], &storage));
    return &instances[other];
}

static void run_forever(uint32_t stride, uint32_t samples)
{
    davar_t *davar = &instances[0];
    davar_result_t result;
    random_t random = random_seeded(5U);
    config.stride = stride;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(davar, &config, memory[0], sizeof memory[0]));
    uint64_t checked = 0U;
    uint32_t gaps = 0U;
    for (uint32_t n = 0U; n < samples; n++) {
        const int16_t sample = next_sample(&random, n);
        if ((n > 0U) && (((n / 3000U) % 3U) == 1U) && ((random_next(&random) % 200U) == 0U)) {
            davar_gap(davar, 1U + (n % 3U));
            hear_gap();
            gaps++;
        }
        hear(sample);
        (void)davar_push_q15(davar, &sample, 1U);
        const bool is_late = (stride > 1U) && ((n % 4U) != 3U); /* up to three samples behind the epoch */
        if (!is_late && davar_take(davar, &result)) {
            check(&result);
            checked++;
        }
        if ((n % 7919U) == 7918U) {
            davar = change_over(davar);
        }
    }
    const davar_health_t health = davar_health(davar);
    TEST_ASSERT_EQUAL_UINT32(heard.cuts, health.cuts);
    TEST_ASSERT_EQUAL_UINT32(heard.alarms, health.alarms);
    TEST_ASSERT_EQUAL_UINT32(heard.shocks, health.shocks);
    TEST_ASSERT_EQUAL_UINT32(gaps, health.gaps);
    TEST_ASSERT_GREATER_THAN_UINT32(samples / 4000U, heard.alarms);
    TEST_ASSERT_GREATER_THAN_UINT32(samples / 4000U, heard.shocks);
    TEST_ASSERT_GREATER_THAN_UINT64((8U * (uint64_t)samples) / (10U * stride), checked);
}

static void test_every_epoch_of_ten_million_samples_is_exact(void)
{
    run_forever(1U, SAMPLES);
}

static void test_every_epoch_of_ten_million_samples_on_a_grid_is_exact(void)
{
    run_forever(10U, SAMPLES);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_every_epoch_of_ten_million_samples_is_exact);
    RUN_TEST(test_every_epoch_of_ten_million_samples_on_a_grid_is_exact);
    return UNITY_END();
}
