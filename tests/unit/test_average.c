/* davar tests - sums of blocks of a fast stream, compared with brute force. */
#include "davar/average.h"
#include "random.h"
#include "unity.h"

#define COUNT 5000

static davar_average_t average;

static void test_each_sum_is_that_of_its_block(void)
{
    static const uint16_t lengths[] = {1U, 2U, 8U, 10U, 4096U};
    static int32_t samples[COUNT];
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
                int64_t expected = 0;
                for (int k = i + 1 - length; k <= i; k++) {
                    expected += samples[k];
                }
                TEST_ASSERT_EQUAL_INT64(expected, sum);
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

void setUp(void) {}

void tearDown(void) {}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_each_sum_is_that_of_its_block);
    RUN_TEST(test_a_sum_is_limited);
    RUN_TEST(test_a_gap_drops_the_block_that_it_interrupts);
    return UNITY_END();
}
