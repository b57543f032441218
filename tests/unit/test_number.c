/* davar tests - numbers: wide integers, roots, quotients and conversions in integers, numbers of a
 * mantissa and a power of two, and pieces of memory, compared with another method or with the
 * compiler and its library, on every target. */
#include "compact.h"
#include "core/arena.h"
#include "davar/fit.h"
#include "number/q31.inc"

#include "number/q31_moments.inc"
#include "number/real.h"
#include "number/scaled.h"

#include "davar/davar.h"
#include "random.h"
#include "unity.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

void setUp(void) {}
void tearDown(void) {}

static uint64_t any(random_t *random)
{
    static const uint64_t edges[6] = {
        0U, 1U, UINT64_MAX, UINT64_C(1) << 63U, UINT32_MAX, UINT64_C(1) << 32U};
    const uint64_t bits = random_next(random);
    return ((bits % 4U) == 0U) ? edges[(bits >> 8U) % 6U] : random_next(random);
}

/* Schoolbook in 8-bit digits: slow and obvious. */
static davar_u128_t multiply_by_bytes(uint64_t a, uint64_t b)
{
    uint32_t digit[17] = {0};
    for (unsigned i = 0U; i < 8U; i++) {
        for (unsigned j = 0U; j < 8U; j++) {
            digit[i + j] +=
                (uint32_t)((a >> (8U * i)) & 0xFFU) * (uint32_t)((b >> (8U * j)) & 0xFFU);
        }
    }
    davar_u128_t product = {0U, 0U};
    uint32_t carry = 0U;
    for (unsigned i = 0U; i < 16U; i++) {
        const uint32_t sum = digit[i] + carry;
        uint64_t *const half = (i < 8U) ? &product.low : &product.high;
        *half |= (uint64_t)(sum & 0xFFU) << (8U * (i % 8U));
        carry = sum >> 8U;
    }
    return product;
}

static void test_products_of_64_bits_agree_however_they_are_made(void)
{
    random_t random = random_seeded(1U);
    for (unsigned i = 0U; i < 20000U; i++) {
        const uint64_t a = any(&random);
        const uint64_t b = any(&random);
        const davar_u128_t expected = multiply_by_bytes(a, b);
        const davar_u128_t made[] = {davar_multiply_u64_by_parts(a, b), davar_multiply_u64(a, b)};
        for (unsigned k = 0U; k < 2U; k++) {
            TEST_ASSERT_EQUAL_UINT64(expected.low, made[k].low);
            TEST_ASSERT_EQUAL_UINT64(expected.high, made[k].high);
        }
    }
}

/* The compiler's own 64-bit product is the reference. */
static void check_products_of_32_bits(uint32_t a, uint32_t b)
{
    const int32_t signed_a = (int32_t)a;
    const int16_t narrow = (int16_t)(uint16_t)b;
    const int32_t positive = (int32_t)(a & 0x7FFFFFFFU);
    const uint64_t product = (uint64_t)a * b;
    const uint64_t signed_product = (uint64_t)((int64_t)signed_a * (int32_t)b);
    const uint64_t square = (uint64_t)((int64_t)signed_a * signed_a);
    const uint64_t by_narrow = (uint64_t)((int64_t)positive * narrow);
    TEST_ASSERT_EQUAL_UINT64(product, davar_multiply_u32_by_parts(a, b));
    TEST_ASSERT_EQUAL_UINT64(product, davar_multiply_u32(a, b));
    TEST_ASSERT_EQUAL_UINT64(product, davar_multiply_by_small_by_parts(a, b));
    TEST_ASSERT_EQUAL_UINT64(product, davar_multiply_by_small(a, b));
    TEST_ASSERT_EQUAL_UINT64(signed_product, davar_multiply_i32_by_parts(signed_a, (int32_t)b));
    TEST_ASSERT_EQUAL_UINT64(signed_product, davar_multiply_i32(signed_a, (int32_t)b));
    TEST_ASSERT_EQUAL_UINT64(square, davar_square_i32_by_parts(signed_a));
    TEST_ASSERT_EQUAL_UINT64(square, davar_square_i32(signed_a));
    TEST_ASSERT_EQUAL_UINT64(by_narrow, davar_multiply_by_i16_by_parts(positive, narrow));
    TEST_ASSERT_EQUAL_UINT64(by_narrow, davar_multiply_by_i16(positive, narrow));
}

static void test_products_of_32_bits_agree_however_they_are_made(void)
{
    random_t random = random_seeded(4U);
    for (unsigned i = 0U; i < 20000U; i++) {
        check_products_of_32_bits((uint32_t)(any(&random) >> (8U * (i % 4U))),
                                  (uint32_t)any(&random) >> (i % 32U));
    }
    check_products_of_32_bits((uint32_t)INT32_MIN, (uint32_t)INT32_MIN);
    check_products_of_32_bits(UINT32_MAX, UINT32_MAX);
    check_products_of_32_bits(UINT32_MAX, UINT16_MAX);
    check_products_of_32_bits(UINT32_MAX, 0x10000U);
    check_products_of_32_bits(INT32_MAX, 0x8000U);
    for (uint32_t a = 65530U; a < 65545U; a++) { /* one multiplication is no longer enough */
        check_products_of_32_bits(a, 0U - a);
        check_products_of_32_bits(0U - a, a);
    }
}

static void test_leading_zeros_agree(void)
{
    for (uint32_t shift = 0U; shift < 64U; shift++) {
        const uint64_t value = (UINT64_C(1) << shift) | (shift > 3U ? 5U : 0U);
        TEST_ASSERT_EQUAL_UINT32(63U - shift, davar_leading_zeros(value));
        if (shift < 32U) {
            TEST_ASSERT_EQUAL_UINT32(31U - shift, davar_leading_zeros_32((uint32_t)value));
            TEST_ASSERT_EQUAL_UINT32(31U - shift,
                                     davar_leading_zeros_32_by_halving((uint32_t)value));
        }
    }
}

static wide_t any_wide(random_t *random)
{
    wide_t wide;
    for (unsigned i = 0U; i < WIDE_LIMBS; i++) {
        wide.limb[i] = any(random);
    }
    return wide;
}

static void same_wide(wide_t expected, wide_t actual)
{
    TEST_ASSERT_EQUAL_UINT64_ARRAY(expected.limb, actual.limb, WIDE_LIMBS);
}

static wide_t from_u128(davar_u128_t value)
{
    wide_t wide;
    wide_from_u128(&wide, &value);
    return wide;
}

static void same_u128(const wide_t *expected, davar_u128_t actual)
{
    TEST_ASSERT_EQUAL_UINT64(expected->limb[0], actual.low);
    TEST_ASSERT_EQUAL_UINT64(expected->limb[1], actual.high);
}

/* Compared with the 256-bit integers, whose limbs carry in a loop. */
static void test_sums_of_128_bits_are_those_of_256(void)
{
    random_t random = random_seeded(3U);
    for (unsigned i = 0U; i < 20000U; i++) {
        const davar_u128_t a = {any(&random), any(&random)};
        const davar_u128_t b = {any(&random), any(&random)};
        const uint32_t factor = (uint32_t)any(&random);
        const wide_t wide_b = from_u128(b);
        wide_t sum = from_u128(a);
        wide_t difference = from_u128(a);
        wide_t product = from_u128(a);
        wide_add(&sum, &wide_b);
        wide_subtract(&difference, &wide_b);
        wide_scale(&product, factor);
        same_u128(&sum, davar_u128_add(a, b));
        same_u128(&difference, davar_u128_subtract(a, b));
        same_u128(&product, davar_u128_scale(a, factor));
    }
}

static wide_t plus(wide_t a, wide_t b)
{
    wide_add(&a, &b);
    return a;
}

static wide_t minus(wide_t a, wide_t b)
{
    wide_subtract(&a, &b);
    return a;
}

static wide_t times(wide_t a, wide_t b)
{
    wide_multiply(&a, &a, &b);
    return a;
}

static wide_t scaled(wide_t a, uint64_t factor)
{
    wide_scale(&a, factor);
    return a;
}

static wide_t from_i64(int64_t value)
{
    wide_t wide;
    wide_from_i64(&wide, value);
    return wide;
}

/* Ring laws are valid modulo 2^256 for every operand: each compares two ways of computing. */
static void test_wide_integers_obey_the_laws_of_a_ring(void)
{
    random_t random = random_seeded(2U);
    for (unsigned i = 0U; i < 5000U; i++) {
        const wide_t a = any_wide(&random);
        const wide_t b = any_wide(&random);
        const wide_t c = any_wide(&random);
        const uint64_t factor = any(&random);
        const davar_u128_t whole_factor = {factor, 0U};
        same_wide(a, minus(plus(a, b), b));
        same_wide(times(a, b), times(b, a));
        same_wide(plus(times(a, b), times(a, c)), times(a, plus(b, c)));
        same_wide(times(a, from_u128(whole_factor)), scaled(a, factor));
        same_wide(minus(from_i64(0), a), times(a, from_i64(-1)));
    }
}

static void test_signed_values_widen_and_multiply(void)
{
    const davar_u128_t minus_three = davar_multiply_i64(-1, 3);
    wide_t wide;
    wide_from_i128(&wide, &minus_three);
    same_wide(from_i64(-3), wide);
    same_wide(from_i64(12), times(from_i64(-4), wide));
    const davar_u128_t three = davar_multiply_i64(1, 3);
    wide_from_i128(&wide, &three);
    same_wide(from_i64(3), wide);
    const davar_u128_t huge = davar_multiply_i64(INT64_MIN, INT64_MIN);
    TEST_ASSERT_EQUAL_UINT64(UINT64_C(1) << 62U, huge.high);
    TEST_ASSERT_EQUAL_UINT64(0U, huge.low);
    const davar_u128_t negative = davar_multiply_i64(INT64_MIN, 1);
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, negative.high);
    TEST_ASSERT_EQUAL_UINT64(UINT64_C(1) << 63U, negative.low);
}

/* The 64 leading bits, wherever they begin. */
static void test_a_wide_integer_is_cut_to_its_leading_bits(void)
{
    for (uint32_t top = 0U; top < 256U; top++) {
        wide_t wide = {{0}};
        wide.limb[top / 64U] |= UINT64_C(1) << (top % 64U);
        if (top >= 63U) {
            const uint32_t last = top - 63U; /* the lowest bit that is kept */
            wide.limb[last / 64U] |= UINT64_C(1) << (last % 64U);
        }
        davar_magnitude_t magnitude;
        wide_magnitude(&wide, &magnitude);
        TEST_ASSERT_EQUAL_INT32((int32_t)top - 63, magnitude.exponent);
        TEST_ASSERT_EQUAL_HEX64((UINT64_C(1) << 63U) | ((top > 63U) ? 1U : 0U) |
                                    ((top == 63U) ? 1U : 0U),
                                magnitude.mantissa);
    }
}

#define TRIALS 30000U

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

static const double edges[] = {
    0.0,
    1.0,
    2.0,
    4.0,
    0.5,
    3.0,
    DBL_MIN,
    DBL_MAX,
    4.94e-324,
    DBL_MIN / 3.0,
    1.0 / 0.9,
    1.0 - DBL_EPSILON,
    1.0 + DBL_EPSILON,
    (double)INFINITY,
    (double)NAN,
};
#define EDGES (sizeof edges / sizeof edges[0])

static void check_root(double value)
{
    same_double(sqrt(value), davar_root_by_integers(value), value, 0.0);
}

/* The hardest to round are the neighbours of squares. */
static void test_roots_of_doubles(void)
{
    random_t random = random_seeded(1U);
    for (unsigned i = 0U; i < EDGES; i++) {
        check_root(edges[i]);
        check_root(-edges[i]);
    }
    for (unsigned i = 0U; i < TRIALS; i++) {
        const double root = (double)(random_next(&random) >> 11U);
        check_root(any_double(&random));
        check_root(davar_double_of_bits(davar_bits_of_double(root * root) +
                                        (random_next(&random) % 5U) - 2U));
    }
}

static void check_quotient_and_product(double a, double b)
{
    same_double(a / b, davar_divide_by_integers(a, b), a, b);
    if (isnormal(a) && isnormal(b) && isnormal(a * b)) {
        same_double(a * b, davar_scale_by_integers(a, b), a, b);
        same_double(a * b, davar_scale(a, b), a, b);
    }
}

/* Also every exponent, beyond both limits of a double. */
static void test_quotients_and_products_of_doubles(void)
{
    random_t random = random_seeded(3U);
    for (unsigned i = 0U; i < EDGES; i++) {
        for (unsigned j = 0U; j < EDGES; j++) {
            check_quotient_and_product(edges[i], edges[j]);
        }
    }
    for (unsigned i = 0U; i < TRIALS; i++) {
        const double a = any_double(&random);
        const double near_a = davar_double_of_bits(davar_bits_of_double(a) + (i % 7U));
        check_quotient_and_product(a, ((i % 3U) == 0U) ? near_a : any_double(&random));
        same_double(0.0, davar_scale_by_integers(0.0, a), 0.0, a);
    }
    for (int i = -1074; i < 1024; i += 11) {
        for (int j = -1074; j < 1024; j += 13) {
            check_quotient_and_product(ldexp(1.25, i), ldexp(-1.75, j));
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

static double any_positive(random_t *random)
{
    const double mantissa = 1.0 + (double)(random_next(random) >> 12U) / 4503599627370496.0;
    return ldexp(mantissa, (int)(random_next(random) % 400U) - 200);
}

static void near(double expected, double actual, double relative)
{
    TEST_ASSERT_DOUBLE_WITHIN(relative * expected, expected, actual);
}

static void test_numbers_of_32_bits(void)
{
    random_t random = random_seeded(1U);
    for (unsigned i = 0U; i < TRIALS; i++) {
        const double a = any_positive(&random);
        const double b = ((i % 2U) == 0U) ? any_positive(&random)
                                          : ldexp(a, (int)(random_next(&random) % 80U) - 40);
        const uint32_t whole = (uint32_t)(random_next(&random) >> (32U + (i % 32U))) | 1U;
        const float single =
            (float)ldexp(1.0 + (double)(whole % 8388608U) / 8388608.0, (int)(i % 200U) - 100);
        const scaled_t x = scaled_of_double(a);
        const scaled_t y = scaled_of_double(b);
        near(a, davar_scaled_to_double(x), ldexp(1.0, -31));
        near((double)single, davar_scaled_to_double(scaled_of_float(single)), 0.0);
        near(ldexp((double)whole, (int)i % 99),
             davar_scaled_to_double(scaled_of_u32(whole, (int32_t)i % 99)), 0.0);
        near(a * b, davar_scaled_to_double(scaled_times(x, y)), ldexp(1.0, -29));
        near(1.0 / a, davar_scaled_to_double(scaled_inverse(x)), ldexp(1.0, -29));
        near(a + b, davar_scaled_to_double(davar_scaled_plus(x, y)), ldexp(1.0, -30));
        near(a, davar_scaled_to_double(davar_scaled_plus(scaled_of_double(0.0), x)),
             ldexp(1.0, -31));
        near(sqrt(a), davar_scaled_to_double(davar_scaled_root(x)), ldexp(1.0, -23));
        TEST_ASSERT_TRUE((davar_scaled_root(x).mantissa & SCALED_TOP) != 0U);
        if ((a > 1e-30) && (a < 1e30)) {
            near(a, (double)scaled_to_float(x), ldexp(1.0, -23));
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

#define COMPACT_TRIALS 200000U

static double value_of(compact_t compact)
{
    return davar_scaled_to_double(scaled_of_compact(compact));
}

/* Of any size that the cascade has, and 0. */
static compact_t any_compact(random_t *random)
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

static void test_compact_numbers_are_truncated(void)
{
    random_t random = random_seeded(1U);
    TEST_ASSERT_EQUAL_UINT32(0U, compact_of_scaled((scaled_t){0U, SCALED_ZERO}));
    TEST_ASSERT_EQUAL_DOUBLE(0.0, value_of(0U));
    for (uint32_t i = 0U; i < COMPACT_TRIALS; i++) {
        const scaled_t exact = scaled_of_u64(random_next(&random) | 1U, (int32_t)(i % 200U) - 150);
        const compact_t a = any_compact(&random);
        const compact_t b = any_compact(&random);
        assert_truncated(davar_scaled_to_double(exact), value_of(compact_of_scaled(exact)));
        assert_truncated(value_of(a) + value_of(b), value_of(compact_plus(a, b)));
        TEST_ASSERT_EQUAL_UINT32(compact_plus(a, b), compact_plus(b, a));
        assert_truncated(value_of(a) * value_of(a), value_of(compact_square(a)));
    }
}

static void test_pieces_follow_one_another_at_multiples_of_eight(void)
{
    uint64_t memory[8];
    davar_arena_t arena = {(unsigned char *)memory, 0U};
    TEST_ASSERT_EQUAL_PTR(&memory[0], davar_arena_take(&arena, 3U, 3U));
    TEST_ASSERT_EQUAL_PTR(&memory[2], davar_arena_take(&arena, 1U, 1U));
    TEST_ASSERT_NULL(davar_arena_take(&arena, 0U, 4U));
    TEST_ASSERT_EQUAL_size_t(24U, arena.used);
}

static void test_sizes_that_do_not_fit_stay_too_large(void)
{
    davar_arena_t arena = {NULL, 0U};
    TEST_ASSERT_NULL(davar_arena_take(&arena, (SIZE_MAX / 3U) + 1U, 3U));
    TEST_ASSERT_EQUAL_size_t(SIZE_MAX - 7U, arena.used);
    TEST_ASSERT_NULL(davar_arena_take(&arena, 100U, 8U));
    TEST_ASSERT_EQUAL_size_t(SIZE_MAX - 7U, arena.used);
    arena.used = 0U;
    (void)davar_arena_take(&arena, 1U, SIZE_MAX / 2U);
    (void)davar_arena_take(&arena, 1U, SIZE_MAX / 2U);
    TEST_ASSERT_EQUAL_size_t(SIZE_MAX - 7U, arena.used);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_products_of_64_bits_agree_however_they_are_made);
    RUN_TEST(test_products_of_32_bits_agree_however_they_are_made);
    RUN_TEST(test_leading_zeros_agree);
    RUN_TEST(test_sums_of_128_bits_are_those_of_256);
    RUN_TEST(test_wide_integers_obey_the_laws_of_a_ring);
    RUN_TEST(test_signed_values_widen_and_multiply);
    RUN_TEST(test_a_wide_integer_is_cut_to_its_leading_bits);
    RUN_TEST(test_roots_of_doubles);
    RUN_TEST(test_quotients_and_products_of_doubles);
    RUN_TEST(test_roots_of_mantissas);
    RUN_TEST(test_roots_of_quotients);
    RUN_TEST(test_integers_become_the_nearest_double);
    RUN_TEST(test_numbers_of_32_bits);
    RUN_TEST(test_fixed_point);
    RUN_TEST(test_values_outside_a_double);
    RUN_TEST(test_compact_numbers_are_truncated);
    RUN_TEST(test_pieces_follow_one_another_at_multiples_of_eight);
    RUN_TEST(test_sizes_that_do_not_fit_stay_too_large);
    return UNITY_END();
}
