/* davar tests - the wide integers compared with another method, and both methods of
 * multiplication. */
#include "pipeline/type_q31.inc"

#include "davar/davar.h"
#include "random.h"
#include "unity.h"

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
        const davar_u128_t by_parts = davar_multiply_u64_by_parts(a, b);
        const davar_u128_t native = davar_multiply_u64(a, b);
        TEST_ASSERT_EQUAL_UINT64(expected.low, by_parts.low);
        TEST_ASSERT_EQUAL_UINT64(expected.high, by_parts.high);
        TEST_ASSERT_EQUAL_UINT64(expected.low, native.low);
        TEST_ASSERT_EQUAL_UINT64(expected.high, native.high);
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

/* The compiler's own 64-bit product is the reference. */
static void test_products_of_32_bits_agree_however_they_are_made(void)
{
    random_t random = random_seeded(4U);
    for (unsigned i = 0U; i < 20000U; i++) {
        const uint32_t a = (uint32_t)(any(&random) >> (8U * (i % 4U)));
        const uint32_t b = (uint32_t)any(&random);
        const int64_t signed_product = (int64_t)(int32_t)a * (int32_t)b;
        TEST_ASSERT_EQUAL_UINT64((uint64_t)a * b, davar_multiply_u32_by_parts(a, b));
        TEST_ASSERT_EQUAL_UINT64((uint64_t)a * b, davar_multiply_u32(a, b));
        TEST_ASSERT_EQUAL_UINT64((uint64_t)signed_product,
                                 davar_multiply_i32_by_parts((int32_t)a, (int32_t)b));
        TEST_ASSERT_EQUAL_UINT64((uint64_t)signed_product,
                                 davar_multiply_i32((int32_t)a, (int32_t)b));
    }
    TEST_ASSERT_EQUAL_UINT64(UINT64_C(1) << 62U, davar_multiply_i32_by_parts(INT32_MIN, INT32_MIN));
    TEST_ASSERT_EQUAL_UINT64(UINT64_C(0xFFFFFFFE00000001),
                             davar_multiply_u32_by_parts(UINT32_MAX, UINT32_MAX));
}

static void test_small_factors_and_squares_agree_however_they_are_made(void)
{
    random_t random = random_seeded(5U);
    for (unsigned i = 0U; i < 20000U; i++) {
        const int32_t a = (int32_t)((uint32_t)any(&random) >> (8U * (i % 4U)));
        const int32_t positive = (int32_t)((uint32_t)a & 0x7FFFFFFFU);
        const int16_t b = (int16_t)(uint16_t)(any(&random) >> (4U * (i % 4U)));
        const uint64_t square = (uint64_t)((int64_t)a * a);
        const uint64_t product = (uint64_t)((int64_t)positive * b);
        TEST_ASSERT_EQUAL_UINT64(square, davar_square_i32_by_parts(a));
        TEST_ASSERT_EQUAL_UINT64(square, davar_square_i32(a));
        TEST_ASSERT_EQUAL_UINT64(product, davar_multiply_by_i16_by_parts(positive, b));
        TEST_ASSERT_EQUAL_UINT64(product, davar_multiply_by_i16(positive, b));
        TEST_ASSERT_EQUAL_UINT64((uint64_t)((int64_t)b * (int16_t)a),
                                 davar_multiply_i32_by_parts(b, (int16_t)a));
        const uint32_t wide = (uint32_t)a;
        const uint32_t small = (uint32_t)positive >> (i % 32U);
        TEST_ASSERT_EQUAL_UINT64((uint64_t)wide * small,
                                 davar_multiply_by_small_by_parts(wide, small));
        TEST_ASSERT_EQUAL_UINT64((uint64_t)wide * small, davar_multiply_by_small(wide, small));
    }
    TEST_ASSERT_EQUAL_UINT64((uint64_t)UINT32_MAX * UINT16_MAX,
                             davar_multiply_by_small_by_parts(UINT32_MAX, UINT16_MAX));
    TEST_ASSERT_EQUAL_UINT64((uint64_t)UINT32_MAX << 16U,
                             davar_multiply_by_small_by_parts(UINT32_MAX, 0x10000U));
    for (int32_t a = 65530; a < 65545; a++) { /* where one multiplication is no longer enough */
        TEST_ASSERT_EQUAL_UINT64((uint64_t)((int64_t)a * a), davar_square_i32_by_parts(a));
        TEST_ASSERT_EQUAL_UINT64((uint64_t)((int64_t)a * a), davar_square_i32_by_parts(-a));
    }
    TEST_ASSERT_EQUAL_UINT64(UINT64_C(1) << 62U, davar_square_i32_by_parts(INT32_MIN));
    TEST_ASSERT_EQUAL_UINT64((uint64_t)((int64_t)INT32_MAX * INT16_MIN),
                             davar_multiply_by_i16_by_parts(INT32_MAX, INT16_MIN));
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

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_products_of_64_bits_agree_however_they_are_made);
    RUN_TEST(test_sums_of_128_bits_are_those_of_256);
    RUN_TEST(test_products_of_32_bits_agree_however_they_are_made);
    RUN_TEST(test_small_factors_and_squares_agree_however_they_are_made);
    RUN_TEST(test_leading_zeros_agree);
    RUN_TEST(test_wide_integers_obey_the_laws_of_a_ring);
    RUN_TEST(test_signed_values_widen_and_multiply);
    RUN_TEST(test_a_wide_integer_is_cut_to_its_leading_bits);
    return UNITY_END();
}
