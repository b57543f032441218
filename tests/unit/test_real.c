/* davar tests - roots, quotients and conversions in integers compared with those of the compiler
 * and its library, which are correctly rounded: the same bits are expected, on every target. */
#include "number/real.h"

#include "random.h"
#include "unity.h"

#include <float.h>
#include <stdio.h>

#define TRIALS 30000U

void setUp(void) {}
void tearDown(void) {}

static void same_bits(uint64_t expected, uint64_t actual, double a, double b)
{
    char message[128];
    snprintf(message, sizeof message, "of %a and %a", a, b);
    TEST_ASSERT_EQUAL_HEX64_MESSAGE(expected, actual, message);
}

static void same_double(double expected, double actual, double a, double b)
{
    if (isnan(expected)) {
        TEST_ASSERT_TRUE(isnan(actual));
    } else {
        same_bits(davar_bits_of_double(expected), davar_bits_of_double(actual), a, b);
    }
}

/* Of either sign, subnormal and not finite too; half of them with few bits set, or near a power of
 * two. */
static double any_double(random_t *random)
{
    uint64_t bits = random_next(random);
    const uint64_t shape = random_next(random);
    bits &= ((shape & 3U) == 0U) ? (UINT64_MAX << (shape >> 59U)) << 20U : UINT64_MAX;
    bits |= ((shape & 3U) == 1U) ? (UINT64_C(1) << (shape >> 59U)) - 1U : 0U;
    bits &= ((shape & 60U) == 4U) ? (UINT64_C(1) << 52U) - 1U : UINT64_MAX; /* subnormal */
    bits |= ((shape & 252U) == 8U) ? (UINT64_C(0x7FF) << 52U) : 0U;         /* infinite or NaN */
    return davar_double_of_bits(bits);
}

static const double edges[] = {0.0,
                               1.0,
                               2.0,
                               4.0,
                               0.5,
                               3.0,
                               DBL_MIN,
                               DBL_MAX,
                               DBL_MIN / 3.0,
                               4.94e-324,
                               1.0 / 0.9,
                               1.0 - DBL_EPSILON,
                               1.0 + DBL_EPSILON,
                               (double)INFINITY,
                               (double)NAN};
#define EDGES (sizeof edges / sizeof edges[0])

static void test_roots_of_doubles(void)
{
    random_t random = random_seeded(1U);
    for (unsigned i = 0U; i < EDGES; i++) {
        same_double(sqrt(edges[i]), davar_root_by_integers(edges[i]), edges[i], 0.0);
        same_double(sqrt(-edges[i]), davar_root_by_integers(-edges[i]), -edges[i], 0.0);
    }
    for (unsigned i = 0U; i < TRIALS; i++) {
        const double value = any_double(&random);
        same_double(sqrt(value), davar_root_by_integers(value), value, 0.0);
    }
}

/* The hardest to round are the neighbours of squares. */
static void test_roots_of_doubles_next_to_squares(void)
{
    random_t random = random_seeded(2U);
    for (unsigned i = 0U; i < TRIALS; i++) {
        const double root = (double)(random_next(&random) >> 11U);
        const double value = davar_double_of_bits(davar_bits_of_double(root * root) +
                                                  (random_next(&random) % 5U) - 2U);
        same_double(sqrt(value), davar_root_by_integers(value), value, 0.0);
    }
}

static void test_quotients(void)
{
    random_t random = random_seeded(3U);
    for (unsigned i = 0U; i < EDGES; i++) {
        for (unsigned j = 0U; j < EDGES; j++) {
            same_double(edges[i] / edges[j], davar_divide_by_integers(edges[i], edges[j]), edges[i],
                        edges[j]);
        }
    }
    for (unsigned i = 0U; i < TRIALS; i++) {
        const double a = any_double(&random);
        const double b = ((i % 3U) == 0U) ? davar_double_of_bits(davar_bits_of_double(a) + (i % 7U))
                                          : any_double(&random);
        same_double(a / b, davar_divide_by_integers(a, b), a, b);
    }
}

/* All exponents of a quotient, beyond both limits of a double. */
static void test_quotients_of_every_size(void)
{
    for (int i = -1074; i < 1024; i += 11) {
        for (int j = -1074; j < 1024; j += 13) {
            const double a = ldexp(1.25, i);
            const double b = ldexp(-1.75, j);
            same_double(a / b, davar_divide_by_integers(a, b), a, b);
        }
    }
}

/* The step of 32 bits: of 24 significant bits, in [1, 2) and in [2, 4). */
static void test_roots_of_mantissas(void)
{
    random_t random = random_seeded(8U);
    for (unsigned i = 0U; i < TRIALS; i++) {
        const uint32_t bits = (UINT32_C(1) << 23U) | ((uint32_t)random_next(&random) >> 9U);
        const uint32_t m = bits << (7U + (i % 2U));
        const float root = (float)sqrt((double)m / 1073741824.0);
        TEST_ASSERT_EQUAL_UINT32((uint32_t)(root * 8388608.0F),
                                 davar_root_of_mantissa_by_integers(m));
        TEST_ASSERT_EQUAL_UINT32((uint32_t)(root * 8388608.0F), davar_root_of_mantissa(m));
    }
}

/* Known divisors: the ADEV's sums over 2 m^2 n, both integers. */
static void test_roots_of_quotients(void)
{
    random_t random = random_seeded(6U);
    for (unsigned i = 0U; i < TRIALS; i++) {
        const double a = (double)(random_next(&random) >> (random_next(&random) % 64U));
        const double b = (double)((random_next(&random) >> (random_next(&random) % 60U)) | 1U);
        same_double(sqrt(a / b), davar_root_of_quotient_by_integers(a, b), a, b);
        same_double(sqrt(b / b), davar_root_of_quotient_by_integers(b, b), b, b);
        same_double(sqrt(a / b), davar_root_of_quotient(a, b), a, b);
    }
    same_double(0.0, davar_root_of_quotient_by_integers(0.0, 3.0), 0.0, 3.0);
}

static void assert_product(double a, double b)
{
    if (isnormal(a) && isnormal(b) && isnormal(a * b)) {
        same_double(a * b, davar_scale_by_integers(a, b), a, b);
        same_double(a * b, davar_scale(a, b), a, b);
    }
}

static void test_products(void)
{
    random_t random = random_seeded(7U);
    for (unsigned i = 0U; i < EDGES; i++) {
        for (unsigned j = 0U; j < EDGES; j++) {
            assert_product(edges[i], edges[j]);
        }
    }
    for (unsigned i = 0U; i < TRIALS; i++) {
        const double a = any_double(&random);
        const double b = any_double(&random);
        assert_product(a, b);
        same_double(0.0, davar_scale_by_integers(0.0, b), a, b);
    }
    for (int i = -1022; i < 1024; i += 11) { /* all sizes, to both limits of normal numbers */
        for (int j = -1022; j < 1024; j += 13) {
            assert_product(ldexp(1.25, i), ldexp(-1.75, j));
        }
    }
}

static void test_integers_become_the_nearest_double(void)
{
    random_t random = random_seeded(4U);
    same_double(0.0, davar_double_of_u64_by_parts(0U), 0.0, 0.0);
    for (unsigned i = 0U; i < TRIALS; i++) {
        const uint64_t dense = random_next(&random) >> (random_next(&random) % 64U);
        const uint64_t tie = (dense & ~UINT64_C(0x7FF)) | 0x400U;
        same_double((double)dense, davar_double_of_u64_by_parts(dense), (double)dense, 0.0);
        same_double((double)tie, davar_double_of_u64_by_parts(tie), (double)tie, 0.0);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_roots_of_doubles);
    RUN_TEST(test_roots_of_doubles_next_to_squares);
    RUN_TEST(test_quotients);
    RUN_TEST(test_quotients_of_every_size);
    RUN_TEST(test_roots_of_mantissas);
    RUN_TEST(test_roots_of_quotients);
    RUN_TEST(test_products);
    RUN_TEST(test_integers_become_the_nearest_double);
    return UNITY_END();
}
