/* davar tests - numbers of a mantissa and a power of two compared with doubles, and white noise at
 * the limits of a double. */
#include "davar/fit.h"
#include "number/scaled.h"
#include "random.h"
#include "unity.h"

#include <float.h>
#include <string.h>

#define TRIALS 20000U

void setUp(void) {}
void tearDown(void) {}

static double any_positive(random_t *random)
{
    const double mantissa = 1.0 + (double)(random_next(random) >> 12U) / 4503599627370496.0;
    return ldexp(mantissa, (int)(random_next(random) % 400U) - 200);
}

static void near(double expected, double actual, double relative)
{
    TEST_ASSERT_DOUBLE_WITHIN(relative * expected, expected, actual);
}

static void test_numbers_keep_32_bits(void)
{
    random_t random = random_seeded(1U);
    for (unsigned i = 0U; i < TRIALS; i++) {
        const double value = any_positive(&random);
        const uint32_t whole = (uint32_t)(random_next(&random) >> (32U + (i % 32U))) | 1U;
        const float single =
            (float)ldexp(1.0 + (double)(whole % 8388608U) / 8388608.0, (int)(i % 200U) - 100);
        near(value, davar_scaled_to_double(scaled_of_double(value)), ldexp(1.0, -31));
        near((double)single, davar_scaled_to_double(scaled_of_float(single)), 0.0);
        near(ldexp((double)whole, (int)i % 99),
             davar_scaled_to_double(scaled_of_u32(whole, (int32_t)i % 99)), 0.0);
    }
}

static void test_products_and_roots(void)
{
    random_t random = random_seeded(2U);
    for (unsigned i = 0U; i < TRIALS; i++) {
        const double a = any_positive(&random);
        const double b = any_positive(&random);
        const scaled_t scaled = scaled_of_double(a);
        near(a * b, davar_scaled_to_double(scaled_times(scaled, scaled_of_double(b))),
             ldexp(1.0, -29));
        near(sqrt(a), davar_scaled_to_double(davar_scaled_root(scaled)), ldexp(1.0, -23));
        TEST_ASSERT_TRUE((davar_scaled_root(scaled).mantissa & SCALED_TOP) != 0U);
    }
}

static void test_inverses_and_sums(void)
{
    random_t random = random_seeded(3U);
    for (unsigned i = 0U; i < TRIALS; i++) {
        const double a = any_positive(&random);
        const double b = ((i % 2U) == 0U) ? any_positive(&random)
                                          : ldexp(a, (int)(random_next(&random) % 80U) - 40);
        const scaled_t scaled = scaled_of_double(a);
        near(1.0 / a, davar_scaled_to_double(scaled_inverse(scaled)), ldexp(1.0, -29));
        near(a + b, davar_scaled_to_double(davar_scaled_plus(scaled, scaled_of_double(b))),
             ldexp(1.0, -30));
        near(a, davar_scaled_to_double(davar_scaled_plus(scaled_of_double(0.0), scaled)),
             ldexp(1.0, -31));
        if ((a > 1e-30) && (a < 1e30)) {
            near(a, (double)scaled_to_float(scaled), ldexp(1.0, -23));
        }
    }
}

/* To the nearest unit of 2^-bits. */
static void test_fixed_point(void)
{
    random_t random = random_seeded(4U);
    for (unsigned i = 0U; i < TRIALS; i++) {
        const int bits = (int)(random_next(&random) % 31U);
        const double value = ldexp(1.0 + (double)(random_next(&random) >> 42U) / 4194304.0,
                                   32 - bits - (int)(i % 40U));
        const double units = floor(ldexp(value, bits) + 0.5);
        const uint32_t fixed = davar_scaled_to_fixed(scaled_of_double(value), bits);
        TEST_ASSERT_EQUAL_HEX32((units < 4294967296.0) ? (uint32_t)units : UINT32_MAX, fixed);
        const uint64_t whole = random_next(&random) >> (i % 64U);
        near((double)whole, davar_scaled_to_double(scaled_of_u64(whole, 0)), ldexp(1.0, -31));
    }
    TEST_ASSERT_EQUAL_HEX32(0U, davar_scaled_to_fixed(scaled_of_u64(0U, 0), 30));
}

static void test_values_outside_a_double(void)
{
    const scaled_t large = scaled_of_double(DBL_MAX);
    const scaled_t small = scaled_of_double(DBL_MIN);
    TEST_ASSERT_TRUE(isinf(davar_scaled_to_double(scaled_times(large, scaled_of_double(1.5)))));
    TEST_ASSERT_EQUAL_DOUBLE(0.0,
                             davar_scaled_to_double(scaled_times(small, scaled_of_double(0.25))));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, davar_scaled_to_double(scaled_of_double(0.0)));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, davar_scaled_to_double(scaled_of_double(DBL_MIN / 4.0)));
    near(DBL_MIN, davar_scaled_to_double(small), 0.0);
    near(DBL_MAX, davar_scaled_to_double(large), ldexp(1.0, -31));
}

/* The limits of a deviation near the largest double are infinite, not wrapped. */
static void test_white_noise_near_the_largest_double(void)
{
    static const uint32_t m[] = {1U, 2U, 4U, 8U};
    davar_plan_t plan;
    davar_result_t result;
    memset(&result, 0, sizeof result);
    result.window_samples = 100U;
    result.tau_count = 4U;
    for (unsigned t = 0U; t < 4U; t++) {
        result.tau[t].m = m[t];
        result.tau[t].differences = 101U - (2U * m[t]);
        result.tau[t].adev = (0.999 * DBL_MAX) / sqrt((double)m[t]);
    }
    davar_plan_init_white(&plan, m, 4U);
    davar_fit(&plan, 1.0, &result);
    TEST_ASSERT_TRUE(isinf(result.tau[0].high));
    TEST_ASSERT_TRUE(isfinite(result.tau[0].low));
    TEST_ASSERT_TRUE(result.tau[3].high < DBL_MAX);
    TEST_ASSERT_TRUE(isinf(
        result.coefficient[DAVAR_ANGLE_RANDOM_WALK].value)); /* per root hour: 60 times as much */
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_numbers_keep_32_bits);
    RUN_TEST(test_products_and_roots);
    RUN_TEST(test_inverses_and_sums);
    RUN_TEST(test_fixed_point);
    RUN_TEST(test_values_outside_a_double);
    RUN_TEST(test_white_noise_near_the_largest_double);
    return UNITY_END();
}
