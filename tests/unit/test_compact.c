/* davar tests - sums and squares of compact numbers, compared with doubles. */
#include "cascade/compact.h"
#include "random.h"
#include "unity.h"

#include <math.h>

#define TRIALS 200000U

void setUp(void) {}
void tearDown(void) {}

static double value_of(compact_t compact)
{
    return davar_scaled_to_double(scaled_of_compact(compact));
}

/* Of any size that the cascade has, and 0. */
static compact_t draw(random_t *random)
{
    const uint64_t mantissa = random_next(random);
    const int32_t exponent = (int32_t)(random_next(random) % 160U) - 100;
    return ((random_next(random) % 16U) == 0U)
               ? 0U
               : compact_of_scaled(scaled_of_u64(mantissa, exponent));
}

static void assert_truncated(double exact, double value)
{
    TEST_ASSERT_TRUE(value <= exact);
    TEST_ASSERT_TRUE(value >= exact * (1.0 - 0x1p-21));
}

static void test_conversion(void)
{
    random_t random = random_seeded(1U);
    TEST_ASSERT_EQUAL_UINT32(0U, compact_of_scaled((scaled_t){0U, SCALED_ZERO}));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(0U));
    for (uint32_t i = 0U; i < TRIALS; i++) {
        const scaled_t exact = scaled_of_u64(random_next(&random) | 1U, (int32_t)(i % 200U) - 150);
        assert_truncated(davar_scaled_to_double(exact), value_of(compact_of_scaled(exact)));
    }
}

static void test_sums(void)
{
    random_t random = random_seeded(2U);
    for (uint32_t i = 0U; i < TRIALS; i++) {
        const compact_t a = draw(&random);
        const compact_t b = draw(&random);
        assert_truncated(value_of(a) + value_of(b), value_of(compact_plus(a, b)));
        TEST_ASSERT_EQUAL_UINT32(compact_plus(a, b), compact_plus(b, a));
    }
}

static void test_squares(void)
{
    random_t random = random_seeded(3U);
    for (uint32_t i = 0U; i < TRIALS; i++) {
        const compact_t a = draw(&random);
        assert_truncated(value_of(a) * value_of(a), value_of(compact_square(a)));
    }
}

/* As a size adds the clusters of a day: the truncations stay small. */
static void test_a_long_sum(void)
{
    random_t random = random_seeded(4U);
    compact_t sum = 0U;
    double exact = 0.0;
    for (uint32_t i = 0U; i < 4096U; i++) {
        const compact_t one =
            compact_of_scaled(scaled_of_u64((random_next(&random) >> 40U) + 1U, 0));
        sum = compact_plus(sum, one);
        exact += value_of(one);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * exact, exact, value_of(sum));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_conversion);
    RUN_TEST(test_sums);
    RUN_TEST(test_squares);
    RUN_TEST(test_a_long_sum);
    return UNITY_END();
}
