/* davar tests - how strong the noise was that each size of a cascade remembers (11.9), by brute
 * force from the differences of the shortest size. */
#include "davar/cascade.h"
#include "random.h"
#include "unity.h"

#include <math.h>

#define TAUS 9U
#define POWER_SAMPLES 100000U
#define POWER_CLUSTERS 4U
#define CLUSTER_HOPS 8U /* whose power is summed */

static davar_cascade_config_t config;
static davar_cascade_t cascade;
static davar_result_t result;
static uint64_t memory[DAVAR_CASCADE_MEMORY(Q15, TAUS) / 8U];
static double square_at[POWER_SAMPLES / 16U]; /* D^2 of the shortest size at each hop; -1: none */

void setUp(void)
{
    config = (davar_cascade_config_t){.rate_hz = 100.0,
                                      .unit_per_count = 0.5,
                                      .shortest = 64U,
                                      .tau_count = TAUS,
                                      .clusters = 32U};
}

void tearDown(void) {}

static void init(void)
{
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_cascade_init_q15(&cascade, &config, memory, sizeof memory));
}

static void push(int16_t sample)
{
    davar_cascade_push_q15(&cascade, &sample, 1U);
}

static bool take(void)
{
    result.tau_count = 0U;
    return davar_cascade_append(&cascade, &result);
}

typedef struct {
    double time; /* in clusters of the first stage */
    double sum;
} share_t;

/* Of the hops from + 1 to `to` of the shortest size. Only the newest cluster may be a part. One
 * without differences repeats the one before. */
static share_t share_of(uint32_t from, uint32_t to, uint32_t hops)
{
    share_t share = {0.0, 0.0};
    double last = 0.0;
    for (uint32_t start = 0U; start < to; start += CLUSTER_HOPS) {
        const uint32_t end = (start + CLUSTER_HOPS < to) ? start + CLUSTER_HOPS : to;
        double sum = 0.0;
        uint32_t count = 0U;
        for (uint32_t h = start + 1U; h <= end; h++) {
            sum += (square_at[h] >= 0.0) ? square_at[h] : 0.0;
            count += (square_at[h] >= 0.0) ? 1U : 0U;
        }
        last = (count > 0U) ? sum / (double)count : last;
        if (start < from) {
            continue;
        }
        const bool whole = end < hops; /* the cluster of the newest hop has not ended */
        const double part = whole ? 1.0 : ((double)count / CLUSTER_HOPS);
        share.time += part;
        share.sum += part * last;
    }
    return share;
}

/* First hop, of the shortest size, of what a size remembers after so many hops. */
static uint32_t remembered_from(uint32_t t, uint32_t hops)
{
    const uint32_t ratio = 1U << (2U * (t / 2U)); /* of the hops of its stage to those */
    const uint32_t generation = (4U << (t % 2U)) * POWER_CLUSTERS;
    const uint32_t now = ((hops / ratio) - 1U) / generation;
    return ((now > 0U) ? (now - 1U) : 0U) * generation * ratio;
}

static double power_of(uint32_t t, uint32_t hops)
{
    const share_t all = share_of(remembered_from(t, hops), hops, hops);
    return all.sum / all.time;
}

/* The mean square of the clusters' powers, over that of white noise of the same power. */
static double unevenness(uint32_t t, uint32_t hops)
{
    const uint32_t ratio = 1U << (2U * (t / 2U));
    const uint32_t present = ((hops / ratio) - 1U) / CLUSTER_HOPS * CLUSTER_HOPS * ratio;
    const share_t all = share_of(remembered_from(t, hops), hops, hops);
    const double edf = 0.9 + 2.78 * (double)ratio;
    double squares = 0.0;
    for (uint32_t h = remembered_from(t, hops); h <= present; h += CLUSTER_HOPS * ratio) {
        const share_t one = share_of(h, (h < present) ? h + (CLUSTER_HOPS * ratio) : hops, hops);
        squares += one.sum * one.sum;
    }
    return squares * all.time / (all.sum * all.sum) / (double)ratio / (1.0 + 2.0 / edf);
}

static void assert_power(uint32_t hops)
{
    uint32_t longest = 0U;
    for (uint32_t t = 0U; t < TAUS; t++) {
        longest = (result.tau[t].differences > 0U) ? t : longest;
    }
    for (uint32_t t = 0U; t <= longest; t++) {
        if (result.tau[t].differences == 0U) {
            continue;
        }
        const double power = power_of(t, hops) / power_of(longest, hops);
        const double uneven = DAVAR_EVEN * unevenness(t, hops);
        TEST_ASSERT_DOUBLE_WITHIN(1e-5 * power, power, (double)result.tau[t].power);
        TEST_ASSERT_DOUBLE_WITHIN(1.0 + 1e-5 * uneven, (uneven < DAVAR_EVEN) ? DAVAR_EVEN : uneven,
                                  (double)result.tau[t].uneven);
    }
}

/* Bursts, steps and gaps; by brute force from the differences of the shortest size. */
static void check_power(uint32_t gap_every, uint64_t seed)
{
    static int64_t phase[POWER_SAMPLES];
    random_t random = random_seeded(seed);
    uint32_t gap = 0U; /* samples before it */
    config.clusters = POWER_CLUSTERS;
    init();
    for (uint32_t i = 1U; i < POWER_SAMPLES; i++) {
        const double sigma = ((i % 20000U) < 700U) ? 400.0 : ((i > 60000U) ? 20.0 : 60.0);
        const int16_t sample = (int16_t)lround(sigma * random_gauss(&random));
        if ((gap_every > 0U) && ((random_next(&random) % gap_every) == 0U)) {
            davar_cascade_gap(&cascade, 1U);
            gap = i - 1U;
        }
        phase[i] = phase[i - 1U] + sample;
        davar_cascade_push_q15(&cascade, &sample, 1U);
        if ((i % 16U) != 0U) {
            continue;
        }
        const bool is_full = (i >= (128U + gap));
        const double d =
            is_full ? (double)(phase[i] - (2 * phase[i - 64U]) + phase[i - 128U]) : 0.0;
        square_at[i / 16U] = is_full ? d * d : -1.0;
        if ((i > 2000U) && ((random_next(&random) % 37U) == 0U)) {
            davar_cascade_flush(&cascade);
            if (take()) {
                assert_power(i / 16U);
            }
        }
    }
}

static void test_the_power_is_that_of_what_a_size_remembers(void)
{
    check_power(0U, 9U);
    check_power(900U, 10U);
    check_power(200U, 11U);
}

/* A ramp: all differences of a size are equal, and so is the power at every sample, whatever turn
 * the take falls between. */
static void test_the_power_at_every_sample(void)
{
    config.clusters = 4U;
    init();
    for (uint32_t i = 0U; i < 32767U; i++) {
        push((int16_t)i);
        (void)take();
        for (uint32_t t = 0U; t < TAUS; t++) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-5, 1.0, (double)result.tau[t].power);
            TEST_ASSERT_TRUE(result.tau[t].uneven >= DAVAR_EVEN);
            TEST_ASSERT_TRUE(result.tau[t].uneven < (DAVAR_EVEN + (DAVAR_EVEN / 8U)));
        }
    }
}

/* One burst among 2000 clusters: as uneven as the field can say. */
static void test_the_largest_unevenness(void)
{
    random_t random = random_seeded(13U);
    config.clusters = 2048U;
    init();
    for (uint32_t i = 0U; i < 140000U; i++) {
        const bool loud = (i >= 70000U) && (i < 70100U);
        push((int16_t)lround((loud ? 5000.0 : 1.0) * random_gauss(&random)));
    }
    davar_cascade_flush(&cascade);
    TEST_ASSERT_TRUE(take());
    TEST_ASSERT_EQUAL_UINT16(UINT16_MAX, result.tau[0].uneven);
    TEST_ASSERT_TRUE(result.tau[6].uneven < (32U * DAVAR_EVEN)); /* 34 clusters */
    TEST_ASSERT_TRUE(result.tau[6].uneven > (10U * DAVAR_EVEN));
}

/* Nothing but zeros: no power to compare. */
static void test_the_power_of_a_constant_rate(void)
{
    init();
    for (uint32_t i = 0U; i < 5000U; i++) {
        push(-7);
    }
    davar_cascade_flush(&cascade);
    TEST_ASSERT_TRUE(take());
    for (uint32_t t = 0U; t < TAUS; t++) {
        TEST_ASSERT_EQUAL_DOUBLE(1.0, (double)result.tau[t].power);
        TEST_ASSERT_EQUAL_UINT16(DAVAR_EVEN, result.tau[t].uneven);
    }
}

static void test_the_sizes_of_a_window_have_power_1(void)
{
    init();
    push(1);
    result.tau[0] = (davar_adev_t){.m = 1U, .differences = 1U, .adev = 0.5};
    result.tau_count = 1U;
    TEST_ASSERT_FALSE(davar_cascade_append(&cascade, &result));
    TEST_ASSERT_EQUAL_DOUBLE(1.0, (double)result.tau[0].power);
    TEST_ASSERT_EQUAL_UINT16(DAVAR_EVEN, result.tau[0].uneven);
    TEST_ASSERT_EQUAL_DOUBLE(0.5, result.tau[0].adev);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_the_power_is_that_of_what_a_size_remembers);
    RUN_TEST(test_the_power_at_every_sample);
    RUN_TEST(test_the_largest_unevenness);
    RUN_TEST(test_the_power_of_a_constant_rate);
    RUN_TEST(test_the_sizes_of_a_window_have_power_1);
    return UNITY_END();
}
