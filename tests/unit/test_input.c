/* davar tests - what comes before the window: torn register reads (DESIGN 12) and sums of blocks of a
 * fast stream, compared with brute force. */
#include "davar/average.h"
#include "davar/torn.h"
#include "random.h"
#include "unity.h"

#include <stdlib.h>

#define COUNT 20000
#define WHITE 2500000 /* per noise; 10^7 together */

static davar_torn_t torn;
static int32_t samples[COUNT];
static bool breaks[COUNT];   /* a gap is before this sample */
static bool expected[COUNT]; /* torn */

/* Do both neighbours differ by the same power of two, of at least 32 times the noise? */
static bool is_torn(int64_t before, int64_t here, int64_t after, int64_t noise)
{
    for (int64_t power = 1; power < (INT64_C(1) << 34); power *= 2) {
        for (int64_t sign = -1; sign <= 1; sign += 2) {
            if ((power >= 32 * noise) && (llabs(here - before - sign * power) <= 4 * noise) &&
                (llabs(here - after - sign * power) <= 4 * noise)) {
                return true;
            }
        }
    }
    return false;
}

/* Brute force: every run of samples between gaps, with all powers of two. */
static uint32_t judge_all(void)
{
    int64_t sum = 0;
    int learned = 0;
    uint32_t found = 0U;
    int64_t kept[COUNT]; /* of this run */
    int run = 0;
    bool calm = false;
    for (int i = 0; i < COUNT; i++) {
        expected[i] = false;
        if (breaks[i]) {
            run = 0;
            calm = false;
        }
        const bool judged = (run > 0) && (i + 1 < COUNT) && !breaks[i + 1];
        if (judged) {
            const int64_t noise = sum / 64 + 1;
            const int64_t step = llabs((int64_t)samples[i] - kept[run - 1]);
            expected[i] = (learned == 64) && calm &&
                          is_torn(kept[run - 1], samples[i], samples[i + 1], noise);
            if (!expected[i]) {
                calm = (step <= 4 * noise);
                const int64_t widest = (1 << 26) - 1;
                const int64_t limit = ((learned < 64) || (8 * noise > widest)) ? widest : 8 * noise;
                sum += ((step < limit) ? step : limit) - ((learned < 64) ? 0 : sum / 64);
                learned += (learned < 64) ? 1 : 0;
            }
        }
        found += expected[i] ? 1U : 0U;
        if (!expected[i]) {
            kept[run] = samples[i];
            run++;
        }
    }
    return found;
}

/* What the filter says about the sample before i. */
static void check_before(int i, davar_torn_step_t step, int32_t before)
{
    if ((i == 0) || breaks[i]) {
        TEST_ASSERT_EQUAL_INT(DAVAR_TORN_NOTHING, step);
        TEST_ASSERT_EQUAL_INT32(-7, before);
        return;
    }
    TEST_ASSERT_EQUAL_INT(expected[i - 1] ? DAVAR_TORN_READ : DAVAR_TORN_SAMPLE, step);
    TEST_ASSERT_EQUAL_INT32(samples[i - 1], before);
}

static void compare_with_brute_force(uint32_t least)
{
    const uint32_t found = judge_all();
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(least, found);
    davar_torn_init(&torn);
    for (int i = 0; i < COUNT; i++) {
        int32_t last = 0;
        if (breaks[i] && (i > 0)) {
            TEST_ASSERT_TRUE(davar_torn_gap(&torn, &last));
            TEST_ASSERT_EQUAL_INT32(samples[i - 1], last);
            TEST_ASSERT_FALSE(davar_torn_gap(&torn, &last));
        }
        int32_t before = -7;
        const davar_torn_step_t step = davar_torn_push(&torn, samples[i], &before);
        check_before(i, step, before);
    }
    TEST_ASSERT_EQUAL_UINT32(found, davar_torn_reads(&torn));
}

static int32_t white(random_t *rng, double sigma)
{
    return (int32_t)lround(sigma * random_gauss(rng));
}

static void no_gaps(void)
{
    for (int i = 0; i < COUNT; i++) {
        breaks[i] = false;
    }
}

/* Offsets by powers of two, by other sizes, in pairs, beside gaps and in noise of changing size. */
static void test_every_sample_is_judged_as_by_brute_force(void)
{
    static const double sigmas[] = {0.0, 0.2, 1.0, 3.0, 6.0, 40.0, 2000.0};
    random_t rng = random_seeded(12U);
    for (size_t s = 0U; s < sizeof sigmas / sizeof sigmas[0]; s++) {
        for (int i = 0; i < COUNT; i++) {
            const double loud = (((i / 3000) % 2) != 0) ? 10.0 : 1.0;
            const uint64_t dice = random_next(&rng);
            const int32_t power = (int32_t)(UINT32_C(1) << (dice % 27U));
            samples[i] = white(&rng, sigmas[s] * loud) - 240 + (i / 8);
            if (((dice >> 32U) % 20U) == 0U) {
                samples[i] += (((dice >> 40U) % 2U) != 0U) ? power : -power;
            } else if (((dice >> 32U) % 20U) == 1U) {
                samples[i] += (power / 3) * 2;
            }
            breaks[i] = (((dice >> 48U) % 200U) == 0U);
        }
        compare_with_brute_force(50U);
    }
}

static void test_the_ends_of_the_range_do_not_overflow(void)
{
    random_t rng = random_seeded(13U);
    no_gaps();
    for (int i = 0; i < COUNT; i++) {
        samples[i] = (int32_t)(uint32_t)(random_next(&rng) >> 32U);
    }
    compare_with_brute_force(0U);
    for (int i = 0; i < COUNT; i++) {
        samples[i] = INT32_MIN;
    }
    for (int i = 100; i < COUNT; i += 50) {
        samples[i] = (i % 100 == 0) ? 0 : INT32_MAX;
    }
    compare_with_brute_force(300U);
}

static void test_white_noise_has_no_torn_reads(void)
{
    static const double sigmas[] = {0.3, 3.0, 27.5, 1000.0};
    random_t rng = random_seeded(16U);
    for (size_t s = 0U; s < sizeof sigmas / sizeof sigmas[0]; s++) {
        davar_torn_init(&torn);
        for (int i = 0; i < WHITE; i++) {
            int32_t before = 0;
            (void)davar_torn_push(&torn, white(&rng, sigmas[s]), &before);
        }
        TEST_ASSERT_EQUAL_UINT32(0U, davar_torn_reads(&torn));
    }
}

static void test_the_counter_saturates(void)
{
    int32_t before = 0;
    davar_torn_init(&torn);
    torn.reads = UINT32_MAX - 1U;
    for (int i = 0; i < 200; i++) {
        (void)davar_torn_push(&torn, ((i == 100) || (i == 150)) ? 64 : 0, &before);
    }
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, davar_torn_reads(&torn));
    TEST_ASSERT_EQUAL_INT32(0, before);
}

static void test_nothing_waits_before_the_first_sample(void)
{
    int32_t last = -7;
    davar_torn_init(&torn);
    TEST_ASSERT_FALSE(davar_torn_gap(&torn, &last));
    TEST_ASSERT_EQUAL_INT32(-7, last);
    TEST_ASSERT_EQUAL_UINT32(0U, davar_torn_reads(&torn));
}

void setUp(void) {}

void tearDown(void) {}

static davar_average_t average;

static void test_each_sum_is_that_of_its_block(void)
{
    static const uint16_t lengths[] = {1U, 2U, 8U, 10U, 4096U};
    random_t rng = random_seeded(33U);
    for (int i = 0; i < COUNT; i++) {
        samples[i] = (int32_t)(random_next(&rng) >> 45U) - (1 << 18U);
    }
    for (size_t l = 0U; l < sizeof lengths / sizeof lengths[0]; l++) {
        const int length = (int)lengths[l];
        int sums = 0;
        davar_average_init(&average, lengths[l]);
        for (int i = 0; i < COUNT; i++) {
            int32_t sum = -1;
            if (davar_average_push(&average, samples[i], &sum)) {
                int64_t exact = 0;
                for (int k = i + 1 - length; k <= i; k++) {
                    exact += samples[k];
                }
                TEST_ASSERT_EQUAL_INT64(exact, sum);
                sums++;
            } else {
                TEST_ASSERT_EQUAL_INT32(-1, sum);
            }
        }
        TEST_ASSERT_EQUAL_INT(COUNT / length, sums);
    }
}

/* A sum of more than 32 bits is limited, as a sample would be. */
static void test_a_sum_is_limited(void)
{
    int32_t sum = 0;
    davar_average_init(&average, 2U);
    TEST_ASSERT_FALSE(davar_average_push(&average, INT32_MAX, &sum));
    TEST_ASSERT_TRUE(davar_average_push(&average, 1, &sum));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, sum);
    TEST_ASSERT_FALSE(davar_average_push(&average, INT32_MIN, &sum));
    TEST_ASSERT_TRUE(davar_average_push(&average, -1, &sum));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, sum);
    TEST_ASSERT_FALSE(davar_average_push(&average, INT32_MAX, &sum));
    TEST_ASSERT_TRUE(davar_average_push(&average, 0, &sum));
    TEST_ASSERT_EQUAL_INT32(INT32_MAX, sum);
    TEST_ASSERT_FALSE(davar_average_push(&average, INT32_MIN, &sum));
    TEST_ASSERT_TRUE(davar_average_push(&average, 0, &sum));
    TEST_ASSERT_EQUAL_INT32(INT32_MIN, sum);
}

/* After a gap, a sum has samples of its own block only. */
static void test_a_gap_drops_the_block_that_it_interrupts(void)
{
    static const struct {
        uint32_t before;
        uint32_t missing;
        uint32_t sums;
    } gaps[] = {{0U, 1U, 1U},
                {3U, 1U, 1U},
                {3U, 8U, 1U},
                {3U, 9U, 2U},
                {0U, 11U, 1U},
                {0U, 12U, 2U},
                {7U, 800U, 101U},
                {4U, 0U, 1U},
                {0U, 0U, 1U},
                {7U, 12U, 2U},
                {7U, UINT32_MAX, 0x20000001U}};
    for (size_t g = 0U; g < sizeof gaps / sizeof gaps[0]; g++) {
        int32_t sum = 0;
        davar_average_init(&average, 8U);
        for (uint32_t i = 0U; i < gaps[g].before; i++) {
            TEST_ASSERT_FALSE(davar_average_push(&average, 1000, &sum));
        }
        TEST_ASSERT_EQUAL_UINT32(gaps[g].sums, davar_average_gap(&average, gaps[g].missing));
        for (int i = 0; i < 7; i++) {
            TEST_ASSERT_FALSE(davar_average_push(&average, 1, &sum));
        }
        TEST_ASSERT_TRUE(davar_average_push(&average, 1, &sum));
        TEST_ASSERT_EQUAL_INT32(8, sum);
    }
    davar_average_init(&average, 1U);
    TEST_ASSERT_EQUAL_UINT32(UINT32_MAX, davar_average_gap(&average, UINT32_MAX));
    TEST_ASSERT_EQUAL_UINT32(5U, davar_average_gap(&average, 5U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_every_sample_is_judged_as_by_brute_force);
    RUN_TEST(test_the_ends_of_the_range_do_not_overflow);
    RUN_TEST(test_white_noise_has_no_torn_reads);
    RUN_TEST(test_the_counter_saturates);
    RUN_TEST(test_nothing_waits_before_the_first_sample);
    RUN_TEST(test_each_sum_is_that_of_its_block);
    RUN_TEST(test_a_sum_is_limited);
    RUN_TEST(test_a_gap_drops_the_block_that_it_interrupts);
    return UNITY_END();
}
