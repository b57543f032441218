/* davar tests - the median time step of the simulator compared with sorting. */
#include "random.h"
#include "recording/median.h"
#include "unity.h"

#include <math.h>
#include <stdlib.h>

#define STAMPS_MAX 20000U

static sim_error_t error;
static spool_t times;
static double steps[STAMPS_MAX];

void setUp(void)
{
    error = (sim_error_t){{0}};
    TEST_ASSERT_TRUE(spool_open(&times, 1U, &error));
}

void tearDown(void)
{
    spool_close(&times);
}

static int by_size(const void *a, const void *b)
{
    const double *left = a;
    const double *right = b;
    return (*left > *right) - (*left < *right);
}

/* Spools the stamps and stores their steps for the reference. */
static double median_of(const double *stamps, size_t count)
{
    double median_s = -1.0;
    for (size_t i = 0; i < count; i++) {
        TEST_ASSERT_TRUE(spool_put(&times, &stamps[i], &error));
        if (i > 0U) {
            steps[i - 1U] = stamps[i] - stamps[i - 1U];
        }
    }
    TEST_ASSERT_TRUE(spool_flush(&times, &error));
    TEST_ASSERT_TRUE(median_step(&times, &median_s, &error));
    return median_s;
}

static double median_by_sorting(size_t count)
{
    qsort(steps, count, sizeof steps[0], by_size);
    const double lower = steps[(count - 1U) / 2U];
    return lower + 0.5 * (steps[count / 2U] - lower);
}

static void assert_exact(const double *stamps, size_t count)
{
    const double median_s = median_of(stamps, count);
    TEST_ASSERT_EQUAL_DOUBLE(median_by_sorting(count - 1U), median_s);
    TEST_ASSERT_TRUE(fabs(median_by_sorting(count - 1U) - median_s) <= 0.0);
}

static void test_one_step(void)
{
    const double stamps[] = {3.0, 3.25};
    assert_exact(stamps, 2U);
}

static void test_two_steps_give_their_mean(void)
{
    const double stamps[] = {0.0, 1.0, 4.0};
    TEST_ASSERT_EQUAL_DOUBLE(2.0, median_of(stamps, 3U));
}

static void test_equal_steps_and_zero_steps(void)
{
    const double stamps[] = {0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0};
    assert_exact(stamps, 7U);
}

/* Chunks of the spool overlap: at lengths near theirs a step could be lost. */
static void test_random_stamps_of_awkward_lengths(void)
{
    static const size_t COUNTS[] = {2U, 3U, 4095U, 4096U, 4097U, 8191U, 8192U, 19999U, 20000U};
    static double stamps[STAMPS_MAX];
    random_t random = random_seeded(3U);
    for (size_t c = 0; c < sizeof COUNTS / sizeof COUNTS[0]; c++) {
        for (size_t i = 1; i < COUNTS[c]; i++) {
            const double jitter = random_uniform(&random);
            stamps[i] = stamps[i - 1U] + 0.01 * ((jitter < 0.2) ? 0.0 : jitter);
        }
        tearDown();
        setUp();
        assert_exact(stamps, COUNTS[c]);
    }
}

static void test_steps_that_differ_in_the_last_bit_only(void)
{
    static double stamps[STAMPS_MAX];
    for (size_t i = 0; i < STAMPS_MAX; i++) {
        stamps[i] = 0.001 * (double)i;
    }
    assert_exact(stamps, STAMPS_MAX);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_one_step);
    RUN_TEST(test_two_steps_give_their_mean);
    RUN_TEST(test_equal_steps_and_zero_steps);
    RUN_TEST(test_random_stamps_of_awkward_lengths);
    RUN_TEST(test_steps_that_differ_in_the_last_bit_only);
    return UNITY_END();
}
