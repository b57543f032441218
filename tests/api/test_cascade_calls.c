/* davar tests - the cascade through its public header: settings that init rejects, results, gaps,
 * float input, reset, takes that a push interrupts, and how strong the noise was that each size
 * remembers (11.9), by brute force from the differences of the shortest size. */

#define _POSIX_C_SOURCE 200809L

#include "davar/cascade.h"
#include "davar/davar.h"
#include "random.h"
#include "unity.h"

#include <math.h>
#include <signal.h>
#include <string.h>
#include <sys/time.h>

#define TAUS 9U

static davar_cascade_config_t config;
static davar_cascade_t cascade;
static davar_result_t result;
static uint64_t memory[DAVAR_CASCADE_MEMORY(Q31, DAVAR_CASCADE_TAUS_MAX) / 8U];

void setUp(void)
{
    config = (davar_cascade_config_t){.rate_hz = 100.0,
                                      .unit_per_count = 0.5,
                                      .full_scale = 300.0,
                                      .shortest = 64U,
                                      .tau_count = TAUS,
                                      .clusters = 32U};
}

void tearDown(void) {}

static void init(void)
{
    TEST_ASSERT_EQUAL(DAVAR_CASCADE_OK,
                      davar_cascade_init_q15(&cascade, &config, memory, sizeof memory));
}

/* --- init ------------------------------------------------------------------------------------- */

static const struct {
    double rate_hz;
    double unit_per_count;
    double full_scale;
    uint32_t shortest;
    uint16_t clusters;
    uint8_t tau_count;
    davar_cascade_status_t q15;
    davar_cascade_status_t q31;
    davar_cascade_status_t f32;
} settings[] = {
#define ALL(status) DAVAR_CASCADE_##status, DAVAR_CASCADE_##status, DAVAR_CASCADE_##status
    {0.0, 0.5, 300.0, 64U, 32U, 9U, ALL(ERR_RATE)},
    {-1.0, 0.5, 300.0, 64U, 32U, 9U, ALL(ERR_RATE)},
    {NAN, 0.5, 300.0, 64U, 32U, 9U, ALL(ERR_RATE)},
    {1.0, 0.0, 300.0, 64U, 32U, 9U, DAVAR_CASCADE_ERR_SCALE, DAVAR_CASCADE_ERR_SCALE,
     DAVAR_CASCADE_OK},
    {1.0, 1.0, INFINITY, 64U, 32U, 9U, DAVAR_CASCADE_OK, DAVAR_CASCADE_OK, DAVAR_CASCADE_ERR_SCALE},
    {1.0, 0.5, 300.0, 0U, 32U, 1U, ALL(ERR_SHORTEST)},
    {1.0, 0.5, 300.0, 60U, 32U, 1U, ALL(ERR_SHORTEST)},
    {1.0, 0.5, 300.0, 63U, 32U, 1U, ALL(ERR_SHORTEST)},
    {1.0, 0.5, 300.0, 64U, 32U, 1U, ALL(OK)},
    {1.0, 0.5, 300.0, 66U, 32U, 1U, ALL(ERR_SHORTEST)},
    {1.0, 0.5, 300.0, 68U, 32U, 1U, ALL(OK)},
    {1.0, 0.5, 300.0, 262140U, 32U, 1U, ALL(OK)},
    {1.0, 0.5, 300.0, 262144U, 32U, 1U, ALL(ERR_SHORTEST)},
    {1.0, 0.5, 300.0, UINT32_MAX - 3U, 32U, 1U, ALL(ERR_SHORTEST)},
    {1.0, 0.5, 300.0, 64U, 0U, 9U, ALL(ERR_CLUSTERS)},
    {1.0, 0.5, 300.0, 64U, 2U, 9U, ALL(ERR_CLUSTERS)},
    {1.0, 0.5, 300.0, 64U, 3U, 9U, ALL(ERR_CLUSTERS)},
    {1.0, 0.5, 300.0, 64U, 4U, 9U, ALL(OK)},
    {1.0, 0.5, 300.0, 64U, 33U, 9U, ALL(ERR_CLUSTERS)},
    {1.0, 0.5, 300.0, 64U, 2048U, 9U, ALL(OK)},
    {1.0, 0.5, 300.0, 64U, 4096U, 9U, ALL(ERR_CLUSTERS)},
    {1.0, 0.5, 300.0, 64U, 32U, 0U, ALL(ERR_TAUS)},
    {1.0, 0.5, 300.0, 64U, 32U, DAVAR_CASCADE_TAUS_MAX + 1U, ALL(ERR_TAUS)},
    /* (11.4): 16 m^2 is 2^60 at m = 2^28, 2^62 at m = 2^29; 2^31 is the largest m. */
    {1.0, 0.5, 300.0, 64U, 16U, 23U, ALL(OK)},
    {1.0, 0.5, 300.0, 64U, 16U, 24U, DAVAR_CASCADE_OK, DAVAR_CASCADE_ERR_TAUS, DAVAR_CASCADE_OK},
    {1.0, 0.5, 300.0, 64U, 32U, 23U, DAVAR_CASCADE_OK, DAVAR_CASCADE_ERR_TAUS, DAVAR_CASCADE_OK},
    {1.0, 0.5, 300.0, 64U, 32U, 24U, DAVAR_CASCADE_OK, DAVAR_CASCADE_ERR_TAUS,
     DAVAR_CASCADE_ERR_TAUS},
    {1.0, 0.5, 300.0, 64U, 4U, 24U, ALL(OK)},
    {1.0, 0.5, 300.0, 256U, 4U, 24U, DAVAR_CASCADE_OK, DAVAR_CASCADE_ERR_TAUS,
     DAVAR_CASCADE_ERR_TAUS},
    {1.0, 0.5, 300.0, 260U, 4U, 24U, ALL(ERR_TAUS)},
};

/* An error writes nothing. */
static void test_settings(void)
{
    static davar_cascade_status_t (*const start[])(
        davar_cascade_t *, const davar_cascade_config_t *, void *,
        size_t) = {davar_cascade_init_q15, davar_cascade_init_q31, davar_cascade_init_f32};
    davar_cascade_t before;
    memset(&before, 0x5A, sizeof before);
    for (size_t i = 0U; i < sizeof settings / sizeof settings[0]; i++) {
        const davar_cascade_status_t expected[] = {settings[i].q15, settings[i].q31,
                                                   settings[i].f32};
        config.rate_hz = settings[i].rate_hz;
        config.unit_per_count = settings[i].unit_per_count;
        config.full_scale = settings[i].full_scale;
        config.shortest = settings[i].shortest;
        config.clusters = settings[i].clusters;
        config.tau_count = settings[i].tau_count;
        for (uint32_t type = 0U; type < 3U; type++) {
            memset(&cascade, 0x5A, sizeof cascade);
            memset(memory, 0x5A, sizeof memory);
            TEST_ASSERT_EQUAL(expected[type],
                              start[type](&cascade, &config, memory, sizeof memory));
            TEST_ASSERT_EQUAL(DAVAR_CASCADE_ERR_NULL,
                              start[type](&cascade, &config, NULL, sizeof memory));
            TEST_ASSERT_EQUAL(DAVAR_CASCADE_ERR_NULL,
                              start[type](&cascade, NULL, memory, sizeof memory));
            TEST_ASSERT_EQUAL(DAVAR_CASCADE_ERR_NULL,
                              start[type](NULL, &config, memory, sizeof memory));
            if (expected[type] != DAVAR_CASCADE_OK) {
                TEST_ASSERT_EQUAL_MEMORY(&before, &cascade, sizeof cascade);
                TEST_ASSERT_EACH_EQUAL_HEX8(0x5A, memory, sizeof memory);
            }
        }
    }
}

static void test_memory(void)
{
    for (config.tau_count = 1U; config.tau_count <= 20U; config.tau_count++) {
        const size_t narrow = DAVAR_CASCADE_MEMORY(Q15, config.tau_count);
        const size_t wide = DAVAR_CASCADE_MEMORY(Q31, config.tau_count);
        TEST_ASSERT_EQUAL(DAVAR_CASCADE_OK,
                          davar_cascade_init_q15(&cascade, &config, memory, narrow));
        TEST_ASSERT_EQUAL(DAVAR_CASCADE_OK,
                          davar_cascade_init_q31(&cascade, &config, memory, wide));
        TEST_ASSERT_EQUAL(DAVAR_CASCADE_ERR_MEMORY_SIZE,
                          davar_cascade_init_q15(&cascade, &config, memory, narrow - 1U));
        TEST_ASSERT_EQUAL(DAVAR_CASCADE_ERR_MEMORY_SIZE,
                          davar_cascade_init_f32(&cascade, &config, memory, wide - 1U));
    }
    TEST_ASSERT_EQUAL(
        DAVAR_CASCADE_ERR_MEMORY_ALIGN,
        davar_cascade_init_q15(&cascade, &config, (char *)memory + 4, sizeof memory - 4U));
}

/* Samples that fill exactly the memory of the macro touch nothing after it. */
static void test_a_push_stays_inside_its_memory(void)
{
    const size_t bytes = DAVAR_CASCADE_MEMORY(Q15, TAUS);
    memset(memory, 0x5A, sizeof memory);
    TEST_ASSERT_EQUAL(DAVAR_CASCADE_OK, davar_cascade_init_q15(&cascade, &config, memory, bytes));
    for (uint32_t i = 0U; i < 100000U; i++) {
        const int16_t sample = (int16_t)(i * 40503U);
        davar_cascade_push_q15(&cascade, &sample, 1U);
    }
    TEST_ASSERT_EACH_EQUAL_HEX8(0x5A, (char *)memory + bytes, sizeof memory - bytes);
}

/* --- results ---------------------------------------------------------------------------------- */

static void push_many(int16_t sample, uint32_t count)
{
    for (uint32_t i = 0U; i < count; i++) {
        davar_cascade_push_q15(&cascade, &sample, 1U);
    }
}

static bool take(void)
{
    result.tau_count = 0U;
    return davar_cascade_append(&cascade, &result);
}

/* --- gaps, refused input, reset --------------------------------------------------------------- */

static void test_floats_at_full_scale_are_counted_and_clamped(void)
{
    TEST_ASSERT_EQUAL(DAVAR_CASCADE_OK,
                      davar_cascade_init_f32(&cascade, &config, memory, sizeof memory));
    for (uint32_t i = 0U; i < 128U; i++) {
        const float rate = (i < 64U) ? -1e30F : 300.0F;
        davar_cascade_push_f32(&cascade, &rate, 1U);
    }
    davar_cascade_flush(&cascade);
    TEST_ASSERT_EQUAL_UINT32(128U, davar_cascade_health(&cascade).saturated);
    TEST_ASSERT_TRUE(take());
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 600.0 / sqrt(2.0), result.tau[0].adev);
}

static void test_reset_returns_to_the_start(void)
{
    davar_cascade_t fresh;
    for (int type = 0; type < 2; type++) {
        davar_cascade_status_t (*const start)(davar_cascade_t *, const davar_cascade_config_t *,
                                              void *, size_t) =
            (type == 0) ? davar_cascade_init_q15 : davar_cascade_init_f32;
        const float rate = 2.0F;
        const int16_t count = 3;
        TEST_ASSERT_EQUAL(DAVAR_CASCADE_OK, start(&cascade, &config, memory, sizeof memory));
        memcpy(&fresh, &cascade, sizeof fresh);
        davar_cascade_gap(&cascade, 1U);
        for (uint32_t i = 0U; i < 1000U; i++) {
            if (type == 0) {
                davar_cascade_push_q15(&cascade, &count, 1U);
            } else {
                davar_cascade_push_f32(&cascade, &rate, 1U);
            }
        }
        davar_cascade_reset(&cascade);
        TEST_ASSERT_EQUAL_MEMORY(&fresh, &cascade, sizeof fresh);
        TEST_ASSERT_FALSE(take());
    }
}

/* --- interrupts ------------------------------------------------------------------------------- */

static volatile uint32_t pushed;

/* A square wave with half a period of 64 samples. */
static void interrupt(int signal_number)
{
    (void)signal_number;
    for (uint32_t i = 0U; i < 31U; i++) {
        const int16_t sample = ((pushed / 64U) % 2U) != 0U ? 10 : -10;
        davar_cascade_push_q15(&cascade, &sample, 1U);
        pushed = pushed + 1U;
    }
}

/* |D| is 64 * 20 at every fourth hop and 32 * 20, 0, 32 * 20 between: over any n the sum has one
 * of four values. A torn result would have another. */
static bool is_consistent(const davar_adev_t *tau)
{
    static const double part[4] = {1.0, 0.25, 0.0, 0.25};
    const double full = 2.0 * 64.0 * 64.0 * (double)tau->differences;
    const double sum = tau->adev * tau->adev * full / (0.5 * 0.5 * 1280.0 * 1280.0);
    for (uint32_t first = 0U; first < 4U; first++) {
        double expected = 0.0;
        for (uint32_t i = 0U; i < tau->differences; i++) {
            expected += part[(first + i) % 4U];
        }
        if (fabs(sum - expected) < 1e-6) {
            return true;
        }
    }
    return false;
}

static void test_results_taken_while_an_interrupt_pushes_are_consistent(void)
{
    const struct itimerval on = {{0, 50}, {0, 50}};
    const struct itimerval off = {{0, 0}, {0, 0}};
    struct sigaction action;
    uint32_t results = 0U;
    config.clusters = 4U;
    config.tau_count = 1U; /* so that most of the time is spent reading its sum */
    init();
    pushed = 0U;
    memset(&action, 0, sizeof action);
    action.sa_handler = interrupt;
    TEST_ASSERT_EQUAL(0, sigaction(SIGALRM, &action, NULL));
    TEST_ASSERT_EQUAL(0, setitimer(ITIMER_REAL, &on, NULL));
    while (results < 2000000U) {
        if (take()) {
            results++;
            TEST_ASSERT_TRUE(is_consistent(&result.tau[0]));
        }
    }
    TEST_ASSERT_EQUAL(0, setitimer(ITIMER_REAL, &off, NULL));
}

#define POWER_SAMPLES 100000U
#define POWER_CLUSTERS 4U
#define CLUSTER_HOPS 8U /* whose power is summed */

static double square_at[POWER_SAMPLES / 16U]; /* D^2 of the shortest size at each hop; -1: none */

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

/* One burst among 2000 clusters: as uneven as the field can say. */
static void test_the_largest_unevenness(void)
{
    random_t random = random_seeded(13U);
    config.clusters = 2048U;
    init();
    for (uint32_t i = 0U; i < 140000U; i++) {
        const bool loud = (i >= 70000U) && (i < 70100U);
        push_many((int16_t)lround((loud ? 5000.0 : 1.0) * random_gauss(&random)), 1U);
    }
    davar_cascade_flush(&cascade);
    TEST_ASSERT_TRUE(take());
    TEST_ASSERT_EQUAL_UINT16(UINT16_MAX, result.tau[0].uneven);
    TEST_ASSERT_TRUE(result.tau[6].uneven < (32U * DAVAR_EVEN)); /* 34 clusters */
    TEST_ASSERT_TRUE(result.tau[6].uneven > (10U * DAVAR_EVEN));
}

static void test_the_sizes_of_a_window_have_power_1(void)
{
    init();
    push_many(1, 1U);
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
    RUN_TEST(test_settings);
    RUN_TEST(test_memory);
    RUN_TEST(test_a_push_stays_inside_its_memory);
    RUN_TEST(test_floats_at_full_scale_are_counted_and_clamped);
    RUN_TEST(test_reset_returns_to_the_start);
    RUN_TEST(test_results_taken_while_an_interrupt_pushes_are_consistent);
    RUN_TEST(test_the_power_is_that_of_what_a_size_remembers);
    RUN_TEST(test_the_largest_unevenness);
    RUN_TEST(test_the_sizes_of_a_window_have_power_1);
    return UNITY_END();
}
