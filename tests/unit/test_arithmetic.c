/* davar tests - the wide integers against arithmetic done another way, and both ways to multiply. */
#include "number_q31.h"

#include "davar/davar.h"
#include "random.h"
#include "unity.h"

void setUp(void) {}
void tearDown(void) {}

static uint64_t any(random_t *random)
{
    static const uint64_t edges[6] = {0U, 1U, UINT64_MAX, UINT64_C(1) << 63U, UINT32_MAX, UINT64_C(1) << 32U};
    const uint64_t bits = random_next(random);
    return ((bits % 4U) == 0U) ? edges[(bits >> 8U) % 6U] : random_next(random);
}

/* Schoolbook in 8-bit digits: slow and obvious. */
static davar_u128_t multiply_by_bytes(uint64_t a, uint64_t b)
{
    uint32_t digit[17] = {0};
    for (unsigned i = 0U; i < 8U; i++) {
        for (unsigned j = 0U; j < 8U; j++) {
            digit[i + j] += (uint32_t)((a >> (8U * i)) & 0xFFU) * (uint32_t)((b >> (8U * j)) & 0xFFU);
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

static void same_u128(davar_u128_t expected, davar_u128_t actual)
{
    TEST_ASSERT_EQUAL_UINT64(expected.low, actual.low);
    TEST_ASSERT_EQUAL_UINT64(expected.high, actual.high);
}

/* Against the 256-bit integers, whose limbs carry in a loop. */
static void test_sums_of_128_bits_agree_however_they_are_made(void)
{
    random_t random = random_seeded(3U);
    for (unsigned i = 0U; i < 20000U; i++) {
        const davar_u128_t a = {any(&random), any(&random)};
        const davar_u128_t b = {any(&random), any(&random)};
        const uint32_t factor = (uint32_t)any(&random);
        const wide_t sum = wide_add(wide_from_u128(a), wide_from_u128(b));
        const wide_t difference = wide_subtract(wide_from_u128(a), wide_from_u128(b));
        const wide_t product = wide_scale(wide_from_u128(a), factor);
        const davar_u128_t expected_sum = {sum.limb[0], sum.limb[1]};
        const davar_u128_t expected_difference = {difference.limb[0], difference.limb[1]};
        const davar_u128_t expected_product = {product.limb[0], product.limb[1]};
        same_u128(expected_sum, davar_u128_add(a, b));
        same_u128(expected_sum, davar_u128_add_by_parts(a, b));
        same_u128(expected_difference, davar_u128_subtract(a, b));
        same_u128(expected_difference, davar_u128_subtract_by_parts(a, b));
        same_u128(expected_product, davar_u128_scale(a, factor));
    }
}

static void test_leading_zeros_agree(void)
{
    for (uint32_t shift = 0U; shift < 64U; shift++) {
        const uint64_t value = (UINT64_C(1) << shift) | (shift > 3U ? 5U : 0U);
        TEST_ASSERT_EQUAL_UINT32(63U - shift, davar_leading_zeros(value));
        TEST_ASSERT_EQUAL_UINT32(63U - shift, davar_leading_zeros_by_halving(value));
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

/* Ring laws hold modulo 2^256 for every operand: each ties two ways of computing together. */
static void test_wide_integers_obey_the_laws_of_a_ring(void)
{
    random_t random = random_seeded(2U);
    for (unsigned i = 0U; i < 5000U; i++) {
        const wide_t a = any_wide(&random);
        const wide_t b = any_wide(&random);
        const wide_t c = any_wide(&random);
        const uint64_t factor = any(&random);
        same_wide(a, wide_subtract(wide_add(a, b), b));
        same_wide(wide_multiply(a, b), wide_multiply(b, a));
        same_wide(wide_add(wide_multiply(a, b), wide_multiply(a, c)), wide_multiply(a, wide_add(b, c)));
        const davar_u128_t whole_factor = {factor, 0U};
        same_wide(wide_multiply(a, wide_from_u128(whole_factor)), wide_scale(a, factor));
        same_wide(wide_subtract(wide_from_i64(0), a), wide_multiply(a, wide_from_i64(-1)));
    }
}

static void test_signed_values_widen_and_multiply(void)
{
    const davar_u128_t minus_three = davar_multiply_i64(-1, 3);
    same_wide(wide_from_i64(-3), wide_from_i128(minus_three));
    same_wide(wide_from_i64(12), wide_multiply(wide_from_i64(-4), wide_from_i128(minus_three)));
    const davar_u128_t huge = davar_multiply_i64(INT64_MIN, INT64_MIN);
    TEST_ASSERT_EQUAL_UINT64(UINT64_C(1) << 62U, huge.high);
    TEST_ASSERT_EQUAL_UINT64(0U, huge.low);
    const davar_u128_t negative = davar_multiply_i64(INT64_MIN, 1);
    TEST_ASSERT_EQUAL_UINT64(UINT64_MAX, negative.high);
    TEST_ASSERT_EQUAL_UINT64(UINT64_C(1) << 63U, negative.low);
}

/* The 64 leading bits, wherever the leading bit stands. */
static void test_a_wide_integer_is_cut_to_its_leading_bits(void)
{
    for (uint32_t top = 0U; top < 256U; top++) {
        wide_t wide = {{0}};
        wide.limb[top / 64U] |= UINT64_C(1) << (top % 64U);
        if (top >= 63U) {
            const uint32_t last = top - 63U; /* the lowest bit that is kept */
            wide.limb[last / 64U] |= UINT64_C(1) << (last % 64U);
        }
        const davar_magnitude_t magnitude = wide_magnitude(wide);
        TEST_ASSERT_EQUAL_INT32((int32_t)top - 63, magnitude.exponent);
        TEST_ASSERT_EQUAL_HEX64((UINT64_C(1) << 63U) | ((top > 63U) ? 1U : 0U) | ((top == 63U) ? 1U : 0U),
                                magnitude.mantissa);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_products_of_64_bits_agree_however_they_are_made);
    RUN_TEST(test_sums_of_128_bits_agree_however_they_are_made);
    RUN_TEST(test_leading_zeros_agree);
    RUN_TEST(test_wide_integers_obey_the_laws_of_a_ring);
    RUN_TEST(test_signed_values_widen_and_multiply);
    RUN_TEST(test_a_wide_integer_is_cut_to_its_leading_bits);
    return UNITY_END();
}
