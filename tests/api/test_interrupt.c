/* davar tests - push from a real asynchronous interrupt (a POSIX timer signal), take from the main
 * loop: every result is consistent. */
#define _POSIX_C_SOURCE 200809L

#include "davar/davar.h"
#include "davar/glr.h"
#include "davar/small.h"
#include "fitted.h"
#include "unity.h"

#include <math.h>
#include <signal.h>
#include <string.h>
#include <sys/time.h>

#define WINDOW 64U
#define RESULTS 3000U

static const uint32_t taus[3] = {1U, 2U, 8U};
static uint64_t memory[1024];
static davar_config_t config; /* the instance keeps it for the next test */
static davar_t davar;
static volatile uint32_t pushed;

void setUp(void)
{
    config = davar_default_config;
    config.rate_hz = 1000.0;
    config.unit_per_count = 1.0;
    config.window.longest = WINDOW;
    config.window.shortest = WINDOW / 2U;
    config.moments.segment = 8U;
    config.taus = taus;
    config.tau_count = 3U;
    pushed = 0U;
}

void tearDown(void) {}

/* A staircase: in a window on a line x = n, D is m^2 for every span, so adev(m) = m / sqrt 2
 * exactly. The slope changes with time, so that sums mixed from two samples would show. */
static int16_t sample_at(uint32_t n)
{
    return (int16_t)((n / 1000U % 2U != 0U) ? (int16_t)(n % 1000U) : (int16_t)(3U * (n % 1000U)));
}

static void interrupt(int signal_number)
{
    (void)signal_number;
    for (uint32_t i = 0U; i < 7U; i++) {
        const int16_t sample = sample_at(pushed);
        davar_push_q15(&davar, &sample, 1U);
        pushed = pushed + 1U;
    }
}

static double expected_adev(uint64_t newest, uint32_t m)
{
    double sum = 0.0;
    for (uint32_t start = 0U; (start + (2U * m)) <= WINDOW; start++) {
        double difference = 0.0;
        for (uint32_t k = 0U; k < m; k++) {
            const uint32_t first = (uint32_t)newest + 1U - WINDOW + start + k;
            difference += (double)sample_at(first + m) - (double)sample_at(first);
        }
        sum += difference * difference;
    }
    return sqrt(sum / (2.0 * (double)m * (double)m * (double)(WINDOW - (2U * m) + 1U)));
}

static void start_timer(long microseconds)
{
    const struct itimerval timer = {{0, microseconds}, {0, microseconds}};
    TEST_ASSERT_EQUAL(0, setitimer(ITIMER_REAL, &timer, NULL));
}

/* Pushes from `handler`, every 50 us, into an instance with these settings. */
static void start(void (*handler)(int))
{
    struct sigaction action;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
    memset(&action, 0, sizeof action);
    action.sa_handler = handler;
    TEST_ASSERT_EQUAL(0, sigaction(SIGALRM, &action, NULL));
    start_timer(50);
}

static void test_results_taken_while_an_interrupt_pushes_are_consistent(void)
{
    uint64_t last = 0U;
    config.law = NULL;
    config.window.shortest = WINDOW;
    start(interrupt);
    for (uint32_t results = 0U; results < RESULTS;) {
        davar_result_t result;
        if (!take_fitted(&davar, &result)) {
            continue;
        }
        results++;
        TEST_ASSERT_TRUE(result.epoch > last);
        last = result.epoch;
        for (uint32_t t = 0U; t < 3U; t++) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, expected_adev(result.epoch, taus[t]),
                                      result.tau[t].adev);
        }
    }
    start_timer(0);
    const uint32_t whole_windows = pushed - WINDOW + 1U;
    TEST_ASSERT_UINT32_WITHIN(1U, whole_windows, RESULTS + davar_health(&davar).missed);
}

/* Gaps appear, leave, and restart the window: the list that take reads gets shorter during the
 * read. */
static void interrupt_with_gaps(int signal_number)
{
    (void)signal_number;
    if (((pushed / 7U) % 3U) == 0U) {
        davar_gap(&davar, 1U);
    }
    interrupt(0);
}

static void test_gaps_in_an_interrupt_tear_no_result(void)
{
    static const uint32_t strides[3] = {1U, 5U, 5U};
    config.window.gaps_max = 40U;
    for (unsigned i = 0U; i < 3U; i++) {
        config.stride = strides[i];
        config.engine = (i == 2U) ? NULL : &davar_engine_grid_q15;
        start(interrupt_with_gaps);
        for (uint32_t results = 0U; results < RESULTS;) {
            davar_result_t result;
            if (take_fitted(&davar, &result)) {
                results++;
                for (uint32_t t = 0U; t < 3U; t++) {
                    TEST_ASSERT_LESS_OR_EQUAL_UINT32(result.window_samples - (2U * taus[t]) + 1U,
                                                     result.tau[t].differences);
                }
                TEST_ASSERT_LESS_OR_EQUAL_UINT32(config.window.gaps_max, result.gaps_in_window);
            }
        }
        start_timer(0);
    }
}

static void finish_push(int signal_number)
{
    (void)signal_number;
    davar.sequence = davar.sequence + 1U;
}

/* A push in progress on another core leaves `sequence` odd. take, report and health re-read until
 * it is done. */
static void test_all_readers_wait_for_a_push_at_work_elsewhere(void)
{
    const struct itimerval once = {{0, 0}, {0, 2000}};
    davar_result_t result;
    davar_glr_report_t report;
    config.law = &davar_law_glr_q15;
    config.window.longest = 400U;
    config.moments.segment = 0U;
    start(finish_push);
    start_timer(0);
    for (int i = 0; i < 3; i++) {
        davar.sequence += (davar.sequence % 2U == 0U) ? 1U : 2U;
        TEST_ASSERT_EQUAL(0, setitimer(ITIMER_REAL, &once, NULL));
        if (i == 0) {
            (void)take_fitted(&davar, &result);
        } else if (i == 1) {
            davar_glr_report(&davar, &report);
        } else {
            (void)davar_health(&davar);
        }
        TEST_ASSERT_EQUAL_UINT32(0U, davar.sequence % 2U);
    }
}

static davar_small_t small;

static void finish_small_push(int signal_number)
{
    (void)signal_number;
    small.sequence = small.sequence + 1U;
}

static void test_the_readers_of_the_small_pipeline_wait_too(void)
{
    const struct itimerval once = {{0, 0}, {0, 2000}};
    static const davar_small_plan_t plan = {.unit_per_count = 1.0, .stride = WINDOW};
    static int16_t ring[WINDOW + 1U];
    davar_result_t result;
    davar_small_start(&small, &plan, ring);
    start(finish_small_push);
    start_timer(0);
    for (int i = 0; i < 2; i++) {
        small.sequence += (small.sequence % 2U == 0U) ? 1U : 2U;
        TEST_ASSERT_EQUAL(0, setitimer(ITIMER_REAL, &once, NULL));
        if (i == 0) {
            TEST_ASSERT_FALSE(davar_small_take(&small, &result));
        } else {
            (void)davar_small_health(&small);
        }
        TEST_ASSERT_EQUAL_UINT32(0U, small.sequence % 2U);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_results_taken_while_an_interrupt_pushes_are_consistent);
    RUN_TEST(test_gaps_in_an_interrupt_tear_no_result);
    RUN_TEST(test_all_readers_wait_for_a_push_at_work_elsewhere);
    RUN_TEST(test_the_readers_of_the_small_pipeline_wait_too);
    return UNITY_END();
}
