/* davar tests - runs of int16 samples, processed as on large cores and as on small ones, compared
 * with one sample after the other. */
#include "number/q15.inc"

#include "number/q15_runs.inc"

#include "davar/davar.h"
#include "random.h"
#include "unity.h"

#define LONGEST 70U

void setUp(void) {}
void tearDown(void) {}

/* Small and large ones, including the limits of a small core's fast path. */
static sample_t any_sample(random_t *random, unsigned bits)
{
    static const sample_t edges[8] = {INT16_MIN, INT16_MAX, 8191,  8192,
                                      -8192,     -8193,     16383, -16384};
    const uint64_t next = random_next(random);
    if ((next % 16U) == 0U) {
        return edges[(next >> 8U) % 8U];
    }
    return (sample_t)((int32_t)((next >> 32U) % (1U << bits)) - (int32_t)(1U << (bits - 1U)));
}

static void fill(random_t *random, sample_t sample[LONGEST])
{
    const unsigned bits = 2U + (unsigned)(random_next(random) % 15U);
    const bool with_edges = (random_next(random) % 2U) == 0U;
    for (unsigned i = 0U; i < LONGEST; i++) {
        if (with_edges) {
            sample[i] = any_sample(random, bits);
        } else {
            sample[i] = (sample_t)(random_next(random) % (1U << (bits - 1U)));
        }
    }
}

static void same_powers(const powers_t *expected, const powers_t *powers)
{
    TEST_ASSERT_EQUAL_UINT32(expected->first, powers->first);
    TEST_ASSERT_EQUAL_UINT64(expected->second, powers->second);
    TEST_ASSERT_EQUAL_UINT64(expected->third, powers->third);
    TEST_ASSERT_EQUAL_UINT64(expected->fourth_low, powers->fourth_low);
    TEST_ASSERT_EQUAL_UINT32(expected->fourth_high, powers->fourth_high);
}

static void check_powers(const powers_t *start, const sample_t *sample, uint32_t count)
{
    powers_t expected = *start;
    powers_t at_once = *start;
    powers_t by_parts = *start;
    for (uint32_t i = 0U; i < count; i++) {
        powers_add(&expected, sample[i]);
    }
    powers_add_run_at_once(&at_once, sample, count);
    powers_add_run_by_parts(&by_parts, sample, count);
    same_powers(&expected, &at_once);
    same_powers(&expected, &by_parts);
}

static void test_powers_of_a_run_are_those_of_its_samples(void)
{
    random_t random = random_seeded(1U);
    sample_t sample[LONGEST];
    for (unsigned trial = 0U; trial < 5000U; trial++) {
        const powers_t start = {(uint32_t)random_next(&random), (uint32_t)random_next(&random),
                                random_next(&random), random_next(&random),
                                UINT64_MAX - (random_next(&random) % 1000U)};
        fill(&random, sample);
        check_powers(&start, sample, (uint32_t)(random_next(&random) % (LONGEST + 1U)));
    }
}

static void test_powers_of_a_run_of_the_lowest_sample_fit(void)
{
    const powers_t zero = {0};
    sample_t sample[LONGEST];
    for (unsigned i = 0U; i < LONGEST; i++) {
        sample[i] = INT16_MIN;
    }
    check_powers(&zero, sample, LONGEST);
}

/* Three unrelated runs for the taps. */
static void check_squares(random_t *random, difference_t head, uint32_t count)
{
    sample_t tap[3][LONGEST];
    for (unsigned k = 0U; k < 3U; k++) {
        fill(random, tap[k]);
    }
    const sum_t start = random_next(random);
    sum_t expected = start;
    int64_t difference = head;
    for (uint32_t i = 0U; i < count; i++) {
        difference += (int64_t)tap[0][i] - (2 * (int64_t)tap[1][i]) + tap[2][i];
        expected += (uint64_t)(difference * difference);
    }
    sum_t at_once = start;
    sum_t by_parts = start;
    TEST_ASSERT_EQUAL_INT32(difference,
                            sum_add_run_at_once(&at_once, head, tap[0], tap[1], tap[2], count));
    TEST_ASSERT_EQUAL_INT32(difference,
                            sum_add_run_by_parts(&by_parts, head, tap[0], tap[1], tap[2], count));
    TEST_ASSERT_EQUAL_UINT64(expected, at_once);
    TEST_ASSERT_EQUAL_UINT64(expected, by_parts);
}

static void test_squares_of_a_run_are_those_of_its_differences(void)
{
    random_t random = random_seeded(2U);
    for (unsigned trial = 0U; trial < 5000U; trial++) {
        const difference_t head =
            (difference_t)(uint32_t)random_next(&random) >> (4U + (trial % 28U));
        check_squares(&random, head, (uint32_t)(random_next(&random) % (LONGEST + 1U)));
    }
}

/* D with which the squares of a few just fit 32 bits, or no longer do. */
static void test_squares_at_the_limit_of_32_bits_fit(void)
{
    static const difference_t limits[] = {16383, 16384,  -16384, -16385,
                                          32767, -32768, 65535,  -65536};
    const sample_t still[LONGEST] = {0};
    for (unsigned k = 0U; k < (sizeof limits / sizeof limits[0]); k++) {
        sum_t sum = 0U;
        TEST_ASSERT_EQUAL_INT32(
            limits[k], sum_add_run_by_parts(&sum, limits[k], still, still, still, LONGEST));
        TEST_ASSERT_EQUAL_UINT64((uint64_t)((int64_t)limits[k] * limits[k]) * LONGEST, sum);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_powers_of_a_run_are_those_of_its_samples);
    RUN_TEST(test_powers_of_a_run_of_the_lowest_sample_fit);
    RUN_TEST(test_squares_of_a_run_are_those_of_its_differences);
    RUN_TEST(test_squares_at_the_limit_of_32_bits_fit);
    return UNITY_END();
}
