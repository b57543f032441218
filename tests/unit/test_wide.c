/* davar tests - the moments of the widest counts in the longest window: nothing overflows, for any
 * mean. */
#include "number/q31.inc"

#include "number/q31_moments.inc"

#include "unity.h"

#include <math.h>

void setUp(void) {}

void tearDown(void) {}

/* Two values, a share p of n samples the upper one: K = 1 / (p (1 - p)) - 3. */
static double kurtosis_of_two(int32_t lower, int32_t upper, uint32_t n, uint32_t one_in)
{
    powers_t sums = {0};
    davar_central_t central;
    for (uint32_t i = 0U; i < n; i++) {
        powers_add(&sums, ((i % one_in) == 0U) ? upper : lower);
    }
    powers_central(&sums, n, &central);
    return davar_kurtosis(&central);
}

static void test_rails_of_32_bits_in_a_window_of_2_to_the_24(void)
{
    static const uint32_t shares[2] = {2U, 64U};
    for (unsigned i = 0U; i < 2U; i++) {
        const double p = 1.0 / (double)shares[i];
        const double expected = (1.0 / (p * (1.0 - p))) - 3.0;
        TEST_ASSERT_DOUBLE_WITHIN(
            4e-15 * expected, expected,
            kurtosis_of_two(INT32_MIN, INT32_MAX, NUMBER_WINDOW_MAX, shares[i]));
        TEST_ASSERT_DOUBLE_WITHIN(
            4e-15 * expected, expected,
            kurtosis_of_two(INT32_MAX - 1, INT32_MAX, NUMBER_WINDOW_MAX, shares[i]));
    }
}

/* Sums continue modulo their widths: the difference of two is the sum of the samples between
 * them. */
static void test_sums_between_two_cursors_wrap_unnoticed(void)
{
    powers_t before = {0};
    before.first = UINT64_MAX - 5U;
    before.second.low = UINT64_MAX;
    before.second.high = UINT64_MAX;
    before.third = before.second;
    before.fourth_low = before.second;
    before.fourth_high = UINT32_MAX;
    powers_t after;
    powers_copy(&after, &before);
    powers_t plain = {0};
    for (int32_t i = -500; i < 700; i++) {
        powers_add(&after, i * 3000000);
        powers_add(&plain, i * 3000000);
    }
    powers_t between;
    davar_central_t central[2];
    powers_between(&between, &after, &before);
    powers_central(&between, 1200U, &central[0]);
    powers_central(&plain, 1200U, &central[1]);
    TEST_ASSERT_EQUAL_DOUBLE(davar_kurtosis(&central[1]), davar_kurtosis(&central[0]));
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 1.8, davar_kurtosis(&central[0])); /* uniform */
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_rails_of_32_bits_in_a_window_of_2_to_the_24);
    RUN_TEST(test_sums_between_two_cursors_wrap_unnoticed);
    return UNITY_END();
}
