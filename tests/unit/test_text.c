/* davar tests - what the simulator reads: decimal_parse gives the bits of strtod, decimal_print the
 * bytes of snprintf, on every path; and the median time step is that of sorting. */
#include "common/decimal.h"
#include "random.h"
#include "recording/median.h"
#include "unity.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RANDOM_TEXTS 300000U

void setUp(void) {}

void tearDown(void) {}

static uint64_t bits_of(double value)
{
    uint64_t bits = 0U;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static void assert_like_strtod(const char *text)
{
    char *expected_end = NULL;
    const double expected = strtod(text, &expected_end);
    const char *end = text;
    double value = 0.0;
    const decimal_status_t status = decimal_parse(&end, &value);
    if (!isfinite(expected)) {
        TEST_ASSERT_EQUAL_MESSAGE(DECIMAL_RANGE, status, text);
        TEST_ASSERT_EQUAL_PTR_MESSAGE(text, end, text);
        return;
    }
    TEST_ASSERT_EQUAL_MESSAGE(DECIMAL_OK, status, text);
    TEST_ASSERT_EQUAL_PTR_MESSAGE(expected_end, end, text);
    TEST_ASSERT_EQUAL_HEX64_MESSAGE(bits_of(expected), bits_of(value), text);
}

/* Ordinary ones, the edges of the exact case, the ends of the range, and where the cursor stops. */
static void test_numbers_are_read_like_those_of_strtod(void)
{
    /* clang-format off */
    static const char *const TEXTS[] = {
        "0", "-0", "+0.0", "1", "-1", "12.5", ".5", "5.", "-.25", "0.1", "1e3", "1E-3",
        "1e+3", "00012.500", "0.00763358778625954", "123456789.987654321",
        "9007199254740991", "9007199254740992", "9007199254740993", "9007199254740992e22",
        "9007199254740993e22", "9007199254740992e-22", "9007199254740992e23", "1e22",
        "1e23", "1e-22", "1e-23", "9999999999999999999", "18446744073709551615",
        "99999999999999999999", "0.1000000000000000055511", "0.3000000000000000444",
        "8.5e22", "0.000000000000000000001", "1.0000000000000000000000",
        "123456789012345678901234567890", "1.7976931348623157e308",
        "1.7976931348623159e308", "-1e309", "1e999", "1e99999999999999999999",
        "1e-99999999999999999999", "0e99999999999999999999", "2.2250738585072014e-308",
        "4.9e-324", "2e-324", "-1e-400", "0.0e-999999", "1,2", "1 ", "1.5\r", "1e", "1e+",
        "1.e", "1..2", "1-2", "1.5e3.7", "7dps",
    };
    /* clang-format on */
    for (size_t i = 0; i < sizeof TEXTS / sizeof TEXTS[0]; i++) {
        assert_like_strtod(TEXTS[i]);
    }
}

/* 0.000...1e100010: neither half has a meaning without the other. */
static void test_very_long_numbers(void)
{
    static char text[200003];
    memset(text, '0', sizeof text - 1U);
    text[0] = '1';
    assert_like_strtod(text);
    text[0] = '0';
    text[1] = '.';
    text[sizeof text - 2U] = '7';
    assert_like_strtod(text);
    memcpy(text + sizeof text - 8U, "1e20000", 8U);
    assert_like_strtod(text);
    (void)snprintf(text + 100006, sizeof text - 100006U, "1e100010");
    assert_like_strtod(text);
    (void)snprintf(text + 90006, sizeof text - 90006U, "1e90010");
    assert_like_strtod(text);
}

/* Hexadecimal is read as its leading zero. */
static void test_other_texts_than_decimal_numbers_are_rejected_without_effect(void)
{
    const char *hexadecimal = "0x10";
    const char *rest = hexadecimal;
    double zero = 1.0;
    static const char *const TEXTS[] = {"",    "-",   "+",    ".",  "-.", "e5", ".e5",
                                        "nan", "inf", "-inf", " 1", "x",  ",",  "+-1"};
    for (size_t i = 0; i < sizeof TEXTS / sizeof TEXTS[0]; i++) {
        const char *end = TEXTS[i];
        double value = 42.0;
        TEST_ASSERT_EQUAL_MESSAGE(DECIMAL_SYNTAX, decimal_parse(&end, &value), TEXTS[i]);
        TEST_ASSERT_EQUAL_PTR(TEXTS[i], end);
        TEST_ASSERT_EQUAL_HEX64(bits_of(42.0), bits_of(value));
    }
    TEST_ASSERT_EQUAL(DECIMAL_OK, decimal_parse(&rest, &zero));
    TEST_ASSERT_EQUAL_PTR(hexadecimal + 1, rest);
}

/* Texts like those in recordings, and some that are not. */
static void random_text(random_t *random, char *text, size_t size)
{
    const int digits = (int)(random_next(random) % 21U);
    const int exponent = (int)(random_next(random) % 80U) - 40;
    const double value =
        ldexp((double)(int64_t)random_next(random), (int)(random_next(random) % 160U) - 120);
    switch (random_next(random) % 4U) {
    case 0:
        (void)snprintf(text, size, "%.*f", digits, fmod(value, 1e6));
        break;
    case 1:
        (void)snprintf(text, size, "%.*e", digits, value);
        break;
    case 2:
        (void)snprintf(text, size, "%.17g", value);
        break;
    default:
        (void)snprintf(text, size, "%" PRIu64 "e%d",
                       random_next(random) >> (random_next(random) % 64U), exponent);
        break;
    }
}

static void test_random_numbers(void)
{
    random_t random = random_seeded(1U);
    char text[128];
    for (uint32_t i = 0U; i < RANDOM_TEXTS; i++) {
        random_text(&random, text, sizeof text);
        assert_like_strtod(text);
    }
}

static void assert_like_snprintf(double value)
{
    for (int digits = 1; digits <= DECIMAL_DIGITS_MAX; digits++) {
        char expected[64];
        char text[DECIMAL_TEXT_BYTES];
        (void)snprintf(expected, sizeof expected, "%.*g", digits, value);
        TEST_ASSERT_EQUAL(strlen(expected), decimal_print(value, digits, text));
        TEST_ASSERT_EQUAL_STRING(expected, text);
    }
}

static void test_numbers_are_printed_like_those_of_snprintf(void)
{
    /* clang-format off */
    static const double VALUES[] = {
        0.0, 1.0, 0.5, 2.5, 0.125, 12.5, 1e5, 1e8, 1e9, 1e15, 1e16, 1e17, 1e22, 1e-4, 1e-5, 1e-10,
        0.1, 0.3, 1.0 / 3, 2.0 / 3, 123456789.0, 1e-19, 1e-20, 1e300, 1e-300, 9.5, 99.5,
        999999999.5, 0x1p-30, 0x1p53, 0x1p63, 0x1p64, 4.9e-324, DBL_MIN, DBL_MAX, INFINITY,
        1234567.5, 0.00012345678950000001,
    };
    /* clang-format on */
    for (size_t i = 0; i < sizeof VALUES / sizeof VALUES[0]; i++) {
        assert_like_snprintf(VALUES[i]);
        assert_like_snprintf(-VALUES[i]);
    }
}

/* Neighbours of powers of ten, and halves between two last digits: multiples of 2^-k. */
static void test_numbers_where_a_digit_decides_are_printed_like_those_of_snprintf(void)
{
    static const double factors[] = {1.0, 0.99999999949999, 0.9999999995, 0.99999999950001};
    for (int power = -30; power <= 30; power++) {
        const double value = pow(10.0, power);
        assert_like_snprintf(nextafter(value, 0.0));
        assert_like_snprintf(nextafter(value, INFINITY));
        for (size_t i = 0; i < sizeof factors / sizeof factors[0]; i++) {
            assert_like_snprintf(value * factors[i]);
        }
        for (int odd = 1; odd < 200; odd += 2) {
            assert_like_snprintf(ldexp(odd, -2 * abs(power)));
            assert_like_snprintf(123456.0 + ldexp(odd, 1 - 2 * abs(power)));
        }
    }
}

static void test_random_numbers_are_printed_like_those_of_snprintf(void)
{
    random_t random = random_seeded(2U);
    for (uint32_t i = 0U; i < RANDOM_TEXTS / 10U; i++) {
        const double value =
            ldexp((double)(int64_t)random_next(&random), (int)(random_next(&random) % 160U) - 140);
        assert_like_snprintf(value);
        assert_like_snprintf((double)(float)value);
        assert_like_snprintf(rint(value * 1e3) * 1e-3);
    }
}

static void test_whole_numbers_are_printed_like_those_of_snprintf(void)
{
    random_t random = random_seeded(3U);
    uint64_t value = 0U;
    for (uint32_t i = 0U; i < RANDOM_TEXTS / 10U; i++) {
        char expected[64];
        char text[DECIMAL_TEXT_BYTES];
        (void)snprintf(expected, sizeof expected, "%" PRIu64, value);
        TEST_ASSERT_EQUAL(strlen(expected), decimal_print_whole(value, text));
        TEST_ASSERT_EQUAL_STRING(expected, text);
        value = (i == 0U) ? UINT64_MAX : (random_next(&random) >> (random_next(&random) % 64U));
    }
}

#define STAMPS_MAX 20000U

static double steps[STAMPS_MAX];

static int by_size(const void *a, const void *b)
{
    const double *left = a;
    const double *right = b;
    return (*left > *right) - (*left < *right);
}

/* The median of the steps is that of sorting. */
static void assert_median(const double *stamps, size_t count)
{
    sim_error_t error = {{0}};
    spool_t times;
    double median_s = -1.0;
    TEST_ASSERT_TRUE(spool_open(&times, 1U, &error));
    for (size_t i = 0; i < count; i++) {
        TEST_ASSERT_TRUE(spool_put(&times, &stamps[i], &error));
        if (i > 0U) {
            steps[i - 1U] = stamps[i] - stamps[i - 1U];
        }
    }
    TEST_ASSERT_TRUE(spool_flush(&times, &error) && median_step(&times, &median_s, &error));
    spool_close(&times);
    qsort(steps, count - 1U, sizeof steps[0], by_size);
    const double lower = steps[(count - 2U) / 2U];
    const double expected = lower + 0.5 * (steps[(count - 1U) / 2U] - lower);
    TEST_ASSERT_EQUAL_HEX64(bits_of(expected), bits_of(median_s));
}

/* Chunks of the spool overlap: at lengths near theirs a step could be lost. */
static void test_the_median_step_is_that_of_sorting(void)
{
    static const size_t COUNTS[] = {2U, 3U, 4U, 4095U, 4096U, 4097U, 8191U, 8192U, 19999U, 20000U};
    static const double few[] = {0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0};
    static double stamps[STAMPS_MAX];
    random_t random = random_seeded(3U);
    for (size_t c = 0; c < sizeof COUNTS / sizeof COUNTS[0]; c++) {
        for (size_t i = 1; i < COUNTS[c]; i++) {
            const double jitter = random_uniform(&random);
            stamps[i] = stamps[i - 1U] + 0.01 * ((jitter < 0.2) ? 0.0 : jitter);
        }
        assert_median(stamps, COUNTS[c]);
    }
    for (size_t i = 0; i < STAMPS_MAX; i++) { /* steps that differ in the last bit only */
        stamps[i] = 0.001 * (double)i;
    }
    assert_median(stamps, STAMPS_MAX);
    assert_median(few, sizeof few / sizeof few[0]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_numbers_are_read_like_those_of_strtod);
    RUN_TEST(test_very_long_numbers);
    RUN_TEST(test_other_texts_than_decimal_numbers_are_rejected_without_effect);
    RUN_TEST(test_random_numbers);
    RUN_TEST(test_numbers_are_printed_like_those_of_snprintf);
    RUN_TEST(test_numbers_where_a_digit_decides_are_printed_like_those_of_snprintf);
    RUN_TEST(test_random_numbers_are_printed_like_those_of_snprintf);
    RUN_TEST(test_whole_numbers_are_printed_like_those_of_snprintf);
    RUN_TEST(test_the_median_step_is_that_of_sorting);
    return UNITY_END();
}
