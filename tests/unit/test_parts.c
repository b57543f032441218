/* davar tests - the parts of a filter (5.20) to (5.22): their spectra by the definition of each, and
 * their ranges. */
#include "davar/filter.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define PI 3.14159265358979324

static davar_filter_t filter;

void setUp(void)
{
    memset(&filter, 0, sizeof filter);
}

void tearDown(void) {}

/* ---- spectra ---- */

static double biquad(double frequency, double cutoff)
{
    return 1.0 / (1.0 + pow(tan(PI * frequency) / tan(PI * cutoff), 4.0));
}

static double pt1(double frequency, double cutoff)
{
    const double k = 2.0 * PI * cutoff / (1.0 + (2.0 * PI * cutoff));
    const double decay = 1.0 - k;
    return k * k / (1.0 - (2.0 * decay * cos(2.0 * PI * frequency)) + (decay * decay));
}

/* Squared size of c[0] + c[1] z + c[2] z^2. */
static double power(double frequency, double first, double second, double third)
{
    const double angle = 2.0 * PI * frequency;
    const double re = first + (second * cos(angle)) + (third * cos(2.0 * angle));
    const double im = (second * sin(angle)) + (third * sin(2.0 * angle));
    return (re * re) + (im * im);
}

static double notch(double frequency, double centre, double q)
{
    const double alpha = sin(2.0 * PI * centre) / (2.0 * q);
    const double middle = -2.0 * cos(2.0 * PI * centre);
    return power(frequency, 1.0, middle, 1.0) / power(frequency, 1.0 + alpha, middle, 1.0 - alpha);
}

static double average(double frequency, int length)
{
    const double half = PI * frequency;
    return pow(sin(length * half) / (length * sin(half)), 2.0);
}

static void test_digital_parts_have_the_spectrum_of_their_definition(void)
{
    static const double b[] = {0.5, 0.25, -0.1};
    static const double a[] = {1.0, -0.3};
    davar_filter_biquad(&filter, 0.12);
    davar_filter_pt1(&filter, 0.2);
    davar_filter_notch(&filter, 0.3, 2.5);
    davar_filter_average(&filter, 2U, 3U);
    davar_filter_average(&filter, 1U, 40U);
    davar_filter_ba(&filter, b, 3U, a, 2U);
    TEST_ASSERT_TRUE(davar_filter_is_valid(&filter));
    TEST_ASSERT_EQUAL_UINT8(1U, filter.averages);
    for (int i = 1; i < 50; i++) {
        const double f = 0.01 * i;
        const double given =
            power(f, 0.5, 0.25, -0.1) / power(f, 1.0, -0.3, 0.0) * pow(0.7 / 0.65, 2.0);
        const double expected = biquad(f, 0.12) * pt1(f, 0.2) * notch(f, 0.3, 2.5) *
                                pow(average(f, 3), 2.0) * average(f, 40) * given;
        TEST_ASSERT_DOUBLE_WITHIN(1e-12 + (1e-9 * expected), expected,
                                  davar_filter_power(&filter, f));
    }
}

/* Every third sample of the mean of three after a biquad and a PT1: the sum over the aliases. */
static void test_a_decimated_part_has_the_spectrum_of_its_aliases(void)
{
    davar_filter_biquad(&filter, 0.05);
    davar_filter_pt1(&filter, 0.1);
    davar_filter_cic(&filter, 2U, 3U);
    TEST_ASSERT_TRUE(davar_filter_is_valid(&filter));
    double zero = 0.0;
    for (int i = 0; i <= 50; i++) {
        double sum = 0.0;
        for (int alias = 0; alias < 3; alias++) {
            const double f = (0.01 * i + alias + 1e-9) / 3.0;
            sum += biquad(f, 0.05) * pt1(f, 0.1) * pow(average(f, 3), 2.0);
        }
        zero = (i == 0) ? sum : zero;
        TEST_ASSERT_DOUBLE_WITHIN(1e-7, sum / zero, davar_filter_power(&filter, 0.01 * i));
    }
}

/* ---- ranges ---- */

static double ones[DAVAR_FILTER_ZEROS + 2U];

static bool valid(void)
{
    const bool is_valid = davar_filter_is_valid(&filter);
    setUp();
    return is_valid;
}

#define VALID(call) (davar_filter_##call, valid())

static void test_a_part_in_its_range_is_valid(void)
{
    const double a[] = {1.0, 0.1};
    const double minus[] = {-1.0};
    TEST_ASSERT_TRUE(VALID(low_pass(&filter, 4.0, 1U, 0.5)));
    TEST_ASSERT_TRUE(VALID(low_pass(&filter, 0.002, 2U, 0.0)));
    TEST_ASSERT_TRUE(VALID(biquad(&filter, 0.49)));
    TEST_ASSERT_TRUE(VALID(pt1(&filter, 4.0)));
    TEST_ASSERT_TRUE(VALID(notch(&filter, 0.2, 0.1)));
    TEST_ASSERT_TRUE(VALID(notch(&filter, 0.2, 100.0)));
    TEST_ASSERT_TRUE(VALID(average(&filter, 8U, 128U)));
    TEST_ASSERT_TRUE(VALID(average(&filter, 1U, 1U)));
    TEST_ASSERT_TRUE(VALID(cic(&filter, 8U, 4096U)));
    TEST_ASSERT_TRUE(VALID(cic(&filter, 1U, 1U)));
    TEST_ASSERT_TRUE(VALID(sum(&filter, 4096U)));
    TEST_ASSERT_TRUE(VALID(sum(&filter, 1U)));
    TEST_ASSERT_TRUE(VALID(ba(&filter, ones, DAVAR_FILTER_ZEROS + 1U, a, 2U)));
    TEST_ASSERT_TRUE(VALID(ba(&filter, minus, 1U, NULL, 0U)));
}

static void test_a_part_out_of_its_range_is_not(void)
{
    const double a[DAVAR_FILTER_POLES + 2U] = {1.0};
    const double below[] = {0.9, 0.1};
    const double above[] = {1.1, 0.1};
    TEST_ASSERT_FALSE(VALID(low_pass(&filter, 0.0, 1U, 0.1)));
    TEST_ASSERT_FALSE(VALID(low_pass(&filter, 4.1, 1U, 0.1)));
    TEST_ASSERT_FALSE(VALID(low_pass(&filter, 0.1, 0U, 0.1)));
    TEST_ASSERT_FALSE(VALID(low_pass(&filter, 0.1, 3U, 0.1)));
    TEST_ASSERT_FALSE(VALID(low_pass(&filter, 0.1, 1U, 0.6)));
    TEST_ASSERT_FALSE(VALID(biquad(&filter, 0.0)));
    TEST_ASSERT_FALSE(VALID(biquad(&filter, 0.5)));
    TEST_ASSERT_FALSE(VALID(pt1(&filter, 0.0)));
    TEST_ASSERT_FALSE(VALID(pt1(&filter, 4.1)));
    TEST_ASSERT_FALSE(VALID(notch(&filter, 0.0, 1.0)));
    TEST_ASSERT_FALSE(VALID(notch(&filter, 0.5, 1.0)));
    TEST_ASSERT_FALSE(VALID(notch(&filter, 0.2, 0.09)));
    TEST_ASSERT_FALSE(VALID(notch(&filter, 0.2, 101.0)));
    TEST_ASSERT_FALSE(VALID(average(&filter, 0U, 2U)));
    TEST_ASSERT_FALSE(VALID(average(&filter, 9U, 2U)));
    TEST_ASSERT_FALSE(VALID(average(&filter, 1U, 0U)));
    TEST_ASSERT_FALSE(VALID(average(&filter, 8U, 129U)));
    TEST_ASSERT_FALSE(VALID(cic(&filter, 0U, 2U)));
    TEST_ASSERT_FALSE(VALID(cic(&filter, 9U, 2U)));
    TEST_ASSERT_FALSE(VALID(cic(&filter, 1U, 0U)));
    TEST_ASSERT_FALSE(VALID(cic(&filter, 1U, 4097U)));
    TEST_ASSERT_FALSE(VALID(sum(&filter, 0U)));
    TEST_ASSERT_FALSE(VALID(sum(&filter, 4097U)));
    TEST_ASSERT_FALSE(VALID(ba(&filter, ones, 0U, a, 1U)));
    TEST_ASSERT_FALSE(VALID(ba(&filter, ones, DAVAR_FILTER_ZEROS + 2U, a, 1U)));
    TEST_ASSERT_FALSE(VALID(ba(&filter, ones, 1U, a, DAVAR_FILTER_POLES + 2U)));
    TEST_ASSERT_FALSE(VALID(ba(&filter, ones, 1U, below, 2U)));
    TEST_ASSERT_FALSE(VALID(ba(&filter, ones, 1U, above, 2U)));
}

/* Too many poles, zeros or averages; an analogue low-pass that is not first; anything after a sum; a
 * part after one that is out of its range. */
static void test_a_series_that_is_too_long_or_in_another_order_is_not(void)
{
    for (int i = 0; i < 4; i++) {
        davar_filter_biquad(&filter, 0.3);
    }
    TEST_ASSERT_TRUE(davar_filter_is_valid(&filter));
    TEST_ASSERT_FALSE(VALID(pt1(&filter, 0.3)));
    davar_filter_ba(&filter, ones, DAVAR_FILTER_ZEROS + 1U, NULL, 0U);
    TEST_ASSERT_FALSE(VALID(ba(&filter, ones, 2U, NULL, 0U)));
    davar_filter_ba(&filter, ones, DAVAR_FILTER_ZEROS + 1U, NULL, 0U);
    TEST_ASSERT_FALSE(VALID(cic(&filter, 8U, 2U)));
    davar_filter_average(&filter, 1U, 100U);
    TEST_ASSERT_FALSE(VALID(average(&filter, 1U, 100U)));
    davar_filter_average(&filter, 1U, 100U);
    TEST_ASSERT_FALSE(VALID(cic(&filter, 1U, 2U)));
    davar_filter_average(&filter, 1U, 100U);
    TEST_ASSERT_FALSE(VALID(low_pass(&filter, 0.1, 1U, 0.1)));
    davar_filter_biquad(&filter, 0.1);
    TEST_ASSERT_FALSE(VALID(low_pass(&filter, 0.1, 1U, 0.1)));
    davar_filter_sum(&filter, 2U);
    TEST_ASSERT_FALSE(VALID(biquad(&filter, 0.1)));
    davar_filter_biquad(&filter, 0.6);
    TEST_ASSERT_FALSE(VALID(biquad(&filter, 0.1)));
}

/* Counts that are summed: white noise has the variance 1, and half a step too. */
static void test_a_sum_has_the_scatter_of_its_counts(void)
{
    davar_filter_sum(&filter, 8U);
    TEST_ASSERT_EQUAL_UINT16(8U, filter.summed);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.0, filter.count_variance);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.0, filter.count_step);
    setUp();
    davar_filter_pt1(&filter, 0.05);
    davar_filter_sum(&filter, 8U);
    const double k = 2.0 * PI * 0.05 / (1.0 + (2.0 * PI * 0.05));
    const double variance = k * k / (1.0 - ((1.0 - k) * (1.0 - k)));
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, variance, filter.count_variance);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, variance * k, filter.count_step);
}

int main(void)
{
    for (uint32_t i = 0U; i < (DAVAR_FILTER_ZEROS + 2U); i++) {
        ones[i] = 1.0;
    }
    UNITY_BEGIN();
    RUN_TEST(test_digital_parts_have_the_spectrum_of_their_definition);
    RUN_TEST(test_a_decimated_part_has_the_spectrum_of_its_aliases);
    RUN_TEST(test_a_part_in_its_range_is_valid);
    RUN_TEST(test_a_part_out_of_its_range_is_not);
    RUN_TEST(test_a_series_that_is_too_long_or_in_another_order_is_not);
    RUN_TEST(test_a_sum_has_the_scatter_of_its_counts);
    return UNITY_END();
}
