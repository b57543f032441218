/* davar tests - the cascade through its public header: settings that init rejects, results, gaps,
 * float input, reset, and takes that a push interrupts. */
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
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_cascade_init_q15(&cascade, &config, memory, sizeof memory));
}

/* --- init ------------------------------------------------------------------------------------- */

static void assert_status(davar_status_t q15, davar_status_t q31, davar_status_t f32)
{
    TEST_ASSERT_EQUAL(q15, davar_cascade_init_q15(&cascade, &config, memory, sizeof memory));
    TEST_ASSERT_EQUAL(q31, davar_cascade_init_q31(&cascade, &config, memory, sizeof memory));
    TEST_ASSERT_EQUAL(f32, davar_cascade_init_f32(&cascade, &config, memory, sizeof memory));
}

static void assert_all(davar_status_t status)
{
    assert_status(status, status, status);
}

static void test_null_pointers(void)
{
    TEST_ASSERT_EQUAL(DAVAR_ERR_NULL, davar_cascade_init_q15(NULL, &config, memory, sizeof memory));
    TEST_ASSERT_EQUAL(DAVAR_ERR_NULL,
                      davar_cascade_init_q31(&cascade, NULL, memory, sizeof memory));
    TEST_ASSERT_EQUAL(DAVAR_ERR_NULL,
                      davar_cascade_init_f32(&cascade, &config, NULL, sizeof memory));
}

static void test_rate_and_scale(void)
{
    config.rate_hz = 0.0;
    assert_all(DAVAR_ERR_RATE);
    config.rate_hz = -1.0;
    assert_all(DAVAR_ERR_RATE);
    config.rate_hz = (double)NAN;
    assert_all(DAVAR_ERR_RATE);
    config.rate_hz = 1.0;
    config.unit_per_count = 0.0;
    assert_status(DAVAR_ERR_SCALE, DAVAR_ERR_SCALE, DAVAR_OK);
    config.unit_per_count = 1.0;
    config.full_scale = (double)INFINITY;
    assert_status(DAVAR_OK, DAVAR_OK, DAVAR_ERR_SCALE);
}

static void test_the_shortest_cluster_size(void)
{
    static const uint32_t wrong[] = {0U, 4U, 60U, 63U, 65U, 66U, 262144U, UINT32_MAX - 3U};
    static const uint32_t right[] = {64U, 68U, 262140U};
    config.tau_count = 1U;
    for (size_t i = 0U; i < (sizeof wrong / sizeof wrong[0]); i++) {
        config.shortest = wrong[i];
        assert_all(DAVAR_ERR_CASCADE_SHORTEST);
    }
    for (size_t i = 0U; i < (sizeof right / sizeof right[0]); i++) {
        config.shortest = right[i];
        assert_all(DAVAR_OK);
    }
}

static void test_the_clusters_that_are_remembered(void)
{
    static const uint16_t wrong[] = {0U, 1U, 2U, 3U, 5U, 33U, 2047U, 4096U, 65535U};
    for (size_t i = 0U; i < (sizeof wrong / sizeof wrong[0]); i++) {
        config.clusters = wrong[i];
        assert_all(DAVAR_ERR_CASCADE_CLUSTERS);
    }
    for (config.clusters = 4U; config.clusters <= 2048U; config.clusters *= 2U) {
        assert_all(DAVAR_OK);
    }
}

static void test_the_number_of_cluster_sizes(void)
{
    config.tau_count = 0U;
    assert_all(DAVAR_ERR_CASCADE_TAUS);
    config.tau_count = DAVAR_CASCADE_TAUS_MAX + 1U;
    assert_all(DAVAR_ERR_CASCADE_TAUS);
    config.tau_count = 1U;
    assert_all(DAVAR_OK);
}

/* (11.4): 16 m^2 is 2^60 at m = 2^28, 2^62 at m = 2^29; 2^31 is the largest m. */
static void test_the_longest_cluster_size(void)
{
    config.clusters = 16U;
    config.tau_count = 23U; /* 2^28 */
    assert_all(DAVAR_OK);
    config.tau_count = 24U;
    assert_status(DAVAR_OK, DAVAR_ERR_CASCADE_TAUS, DAVAR_OK);
    config.clusters = 32U;
    config.tau_count = 23U;
    assert_status(DAVAR_OK, DAVAR_ERR_CASCADE_TAUS, DAVAR_OK);
    config.tau_count = 24U;
    assert_status(DAVAR_OK, DAVAR_ERR_CASCADE_TAUS, DAVAR_ERR_CASCADE_TAUS);
    config.clusters = 4U;
    config.tau_count = 24U;
    assert_status(DAVAR_OK, DAVAR_OK, DAVAR_OK);
    config.shortest = 256U; /* 2^31 */
    assert_status(DAVAR_OK, DAVAR_ERR_CASCADE_TAUS, DAVAR_ERR_CASCADE_TAUS);
    config.shortest = 260U;
    assert_status(DAVAR_ERR_CASCADE_TAUS, DAVAR_ERR_CASCADE_TAUS, DAVAR_ERR_CASCADE_TAUS);
}

static void test_memory(void)
{
    for (config.tau_count = 1U; config.tau_count <= 20U; config.tau_count++) {
        const size_t narrow = DAVAR_CASCADE_MEMORY(Q15, config.tau_count);
        const size_t wide = DAVAR_CASCADE_MEMORY(Q31, config.tau_count);
        TEST_ASSERT_EQUAL(DAVAR_OK, davar_cascade_init_q15(&cascade, &config, memory, narrow));
        TEST_ASSERT_EQUAL(DAVAR_OK, davar_cascade_init_q31(&cascade, &config, memory, wide));
        TEST_ASSERT_EQUAL(DAVAR_ERR_MEMORY_SIZE,
                          davar_cascade_init_q15(&cascade, &config, memory, narrow - 1U));
        TEST_ASSERT_EQUAL(DAVAR_ERR_MEMORY_SIZE,
                          davar_cascade_init_f32(&cascade, &config, memory, wide - 1U));
    }
    TEST_ASSERT_EQUAL(
        DAVAR_ERR_MEMORY_ALIGN,
        davar_cascade_init_q15(&cascade, &config, (char *)memory + 4, sizeof memory - 4U));
}

static void test_an_error_writes_nothing(void)
{
    davar_cascade_t before;
    memset(memory, 0x5A, sizeof memory);
    memset(&cascade, 0x5A, sizeof cascade);
    memset(&before, 0x5A, sizeof before);
    config.clusters = 3U;
    assert_all(DAVAR_ERR_CASCADE_CLUSTERS);
    TEST_ASSERT_EQUAL_MEMORY(&before, &cascade, sizeof cascade);
    TEST_ASSERT_EACH_EQUAL_HEX8(0x5A, memory, sizeof memory);
}

/* Samples that fill exactly the memory of the macro touch nothing after it. */
static void test_a_push_stays_inside_its_memory(void)
{
    const size_t bytes = DAVAR_CASCADE_MEMORY(Q15, TAUS);
    memset(memory, 0x5A, sizeof memory);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_cascade_init_q15(&cascade, &config, memory, bytes));
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

/* Whole clusters that the differences span. */
static uint32_t clusters_of(const davar_adev_t *tau)
{
    return (tau->differences > 0U) ? (2U + ((tau->differences - 1U) / tau->hops)) : 0U;
}

static void assert_absent(const davar_adev_t *tau)
{
    TEST_ASSERT_EQUAL_UINT32(0U, tau->differences);
    TEST_ASSERT_TRUE(isnan(tau->adev) && isnan(tau->low) && isnan(tau->high) && isnan(tau->edf));
}

static void test_a_result_before_the_first_difference(void)
{
    init();
    push_many(1, 127U);
    davar_cascade_flush(&cascade);
    TEST_ASSERT_FALSE(take());
    TEST_ASSERT_EQUAL_UINT8(TAUS, result.tau_count);
    for (uint32_t t = 0U; t < TAUS; t++) {
        assert_absent(&result.tau[t]);
        TEST_ASSERT_EQUAL_UINT32(64U << t, result.tau[t].m);
        TEST_ASSERT_EQUAL_UINT32(16U << (2U * (t / 2U)), result.tau[t].m / result.tau[t].hops);
    }
}

/* One step in the middle: D is 64 counts times the height. */
static void test_the_first_difference(void)
{
    init();
    push_many(0, 64U);
    push_many(10, 64U);
    davar_cascade_flush(&cascade);
    TEST_ASSERT_TRUE(take());
    TEST_ASSERT_EQUAL_UINT32(1U, result.tau[0].differences);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 0.5 * 10.0 / sqrt(2.0), result.tau[0].adev);
    TEST_ASSERT_TRUE(isnan(result.tau[0].low) && isnan(result.tau[0].edf)); /* until a fit */
    assert_absent(&result.tau[1]);
}

static void test_a_constant_rate(void)
{
    init();
    push_many(-7, 5000U);
    davar_cascade_flush(&cascade);
    TEST_ASSERT_TRUE(take());
    for (uint32_t t = 0U; t < 5U; t++) {
        TEST_ASSERT_EQUAL_DOUBLE(0.0, result.tau[t].adev);
    }
}

/* A rate that becomes constant again: some sizes are 0, their neighbours are not. */
static void test_a_constant_rate_after_noise(void)
{
    config.clusters = 4U;
    init();
    for (uint32_t i = 0U; i < 8192U; i++) {
        push_many(((i / 512U) % 2U) != 0U ? 100 : -100, 1U);
    }
    push_many(0, 1500U);
    davar_cascade_flush(&cascade);
    TEST_ASSERT_TRUE(take());
    TEST_ASSERT_EQUAL_DOUBLE(0.0, result.tau[0].adev);
    TEST_ASSERT_TRUE(result.tau[4].adev > 0.0);
}

/* The same samples in the core and the cascade: the same deviation if the core's differences are
 * those at the hops, as in a square wave of constant samples. */
static void test_the_deviation_agrees_with_the_core(void)
{
    static const uint32_t taus[3] = {64U, 128U, 256U};
    static uint64_t core_memory[4096];
    static davar_t davar;
    static davar_result_t curve;
    static davar_config_t core;
    random_t random = random_seeded(4U);
    core = davar_default_config;
    core.rate_hz = 100.0;
    core.unit_per_count = 0.5;
    core.law = NULL;
    core.window.longest = 4096U;
    core.window.shortest = 4096U;
    core.moments.segment = 0U;
    core.taus = taus;
    core.tau_count = 3U;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &core, core_memory, sizeof core_memory));
    config.clusters = 128U;
    init();
    for (uint32_t i = 0U; i < 4096U; i++) {
        const int16_t sample = (int16_t)lround(40.0 * random_gauss(&random));
        davar_push_q15(&davar, &sample, 1U);
        davar_cascade_push_q15(&cascade, &sample, 1U);
    }
    davar_cascade_flush(&cascade);
    TEST_ASSERT_TRUE(davar_take(&davar, &curve));
    TEST_ASSERT_EQUAL_UINT32(0U, curve.tau[0].hops);
    TEST_ASSERT_TRUE(take());
    for (uint32_t t = 0U; t < 3U; t++) {
        TEST_ASSERT_DOUBLE_WITHIN(0.1 * curve.tau[t].adev, curve.tau[t].adev, result.tau[t].adev);
    }
}

/* --- forgetting (11.5) ------------------------------------------------------------------------ */

static void test_each_size_remembers_between_one_and_two_generations(void)
{
    config.clusters = 8U;
    init();
    for (uint32_t i = 0U; i < 200000U; i++) {
        push_many((int16_t)(i % 3U), 1U);
        if ((i % 97U) != 0U) {
            continue;
        }
        (void)take();
        for (uint32_t t = 0U; t < TAUS; t++) {
            const uint32_t generation = 8U * result.tau[t].hops;
            TEST_ASSERT_TRUE(result.tau[t].differences <= (2U * generation));
            TEST_ASSERT_TRUE(clusters_of(&result.tau[t]) < 18U);
            if (i > (17U * result.tau[t].m)) {
                TEST_ASSERT_TRUE(result.tau[t].differences >= generation);
                TEST_ASSERT_TRUE(clusters_of(&result.tau[t]) >= 9U);
            }
        }
    }
}

/* --- gaps, refused input, reset --------------------------------------------------------------- */

static void test_counters(void)
{
    init();
    davar_cascade_gap(&cascade, 3U);
    davar_cascade_gap(&cascade, UINT32_MAX);
    const davar_cascade_health_t health = davar_cascade_health(&cascade);
    TEST_ASSERT_EQUAL_UINT32(2U, health.gaps);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, health.missing);
}

static void test_runs_of_nan_and_inf_are_gaps(void)
{
    const float in[] = {1.0F, (float)NAN, (float)INFINITY, 2.0F, -(float)INFINITY, 3.0F};
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_cascade_init_f32(&cascade, &config, memory, sizeof memory));
    davar_cascade_push_f32(&cascade, in, sizeof in / sizeof in[0]);
    const davar_cascade_health_t health = davar_cascade_health(&cascade);
    TEST_ASSERT_EQUAL_UINT32(2U, health.gaps);
    TEST_ASSERT_EQUAL_UINT32(3U, health.missing);
    TEST_ASSERT_EQUAL_UINT32(3U, health.not_finite);
    TEST_ASSERT_EQUAL_UINT32(0U, health.saturated);
}

static void test_floats_at_full_scale_are_counted_and_clamped(void)
{
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_cascade_init_f32(&cascade, &config, memory, sizeof memory));
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
        davar_status_t (*const start)(davar_cascade_t *, const davar_cascade_config_t *, void *,
                                      size_t) =
            (type == 0) ? davar_cascade_init_q15 : davar_cascade_init_f32;
        const float rate = 2.0F;
        const int16_t count = 3;
        TEST_ASSERT_EQUAL(DAVAR_OK, start(&cascade, &config, memory, sizeof memory));
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

static void test_an_empty_block_changes_nothing(void)
{
    davar_cascade_t before;
    init();
    push_many(5, 77U);
    memcpy(&before, &cascade, sizeof before);
    davar_cascade_push_q15(&cascade, NULL, 0U);
    davar_cascade_flush(&cascade);
    TEST_ASSERT_EQUAL_MEMORY(&before, &cascade, sizeof before);
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

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_null_pointers);
    RUN_TEST(test_rate_and_scale);
    RUN_TEST(test_the_shortest_cluster_size);
    RUN_TEST(test_the_clusters_that_are_remembered);
    RUN_TEST(test_the_number_of_cluster_sizes);
    RUN_TEST(test_the_longest_cluster_size);
    RUN_TEST(test_memory);
    RUN_TEST(test_an_error_writes_nothing);
    RUN_TEST(test_a_push_stays_inside_its_memory);
    RUN_TEST(test_a_result_before_the_first_difference);
    RUN_TEST(test_the_first_difference);
    RUN_TEST(test_a_constant_rate);
    RUN_TEST(test_a_constant_rate_after_noise);
    RUN_TEST(test_the_deviation_agrees_with_the_core);
    RUN_TEST(test_each_size_remembers_between_one_and_two_generations);
    RUN_TEST(test_counters);
    RUN_TEST(test_runs_of_nan_and_inf_are_gaps);
    RUN_TEST(test_floats_at_full_scale_are_counted_and_clamped);
    RUN_TEST(test_reset_returns_to_the_start);
    RUN_TEST(test_an_empty_block_changes_nothing);
    RUN_TEST(test_results_taken_while_an_interrupt_pushes_are_consistent);
    return UNITY_END();
}
