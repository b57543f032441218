/* davar tests - decisions exactly on the bounds, where only exact arithmetic is right. */
#include "pipeline/type_q15.inc"

#include "davar/davar.h"
#include "unity.h"

#include <math.h>

static davar_config_t config;

void setUp(void)
{
    config = davar_default_config;
    config.window.mode = DAVAR_MODE_CENTRED;
}

void tearDown(void) {}

static davar_central_t central_of(const int16_t *sample, uint32_t n)
{
    powers_t sums = {0};
    for (uint32_t i = 0U; i < n; i++) {
        powers_add(&sums, sample[i]);
    }
    davar_central_t central;
    powers_central(&sums, n, &central);
    return central;
}

/* Two values, p of n samples the upper one: K = (1 - 3 p q) / (p q) exactly, q = n - p as fractions
 * of n. */
static void test_kurtosis_of_two_values_whatever_their_mean_and_size(void)
{
    static const int16_t lower[3] = {-32768, 0, 32766};
    int16_t sample[64];
    for (unsigned v = 0U; v < 3U; v++) {
        for (uint32_t upper = 1U; upper < 64U; upper++) {
            for (uint32_t i = 0U; i < 64U; i++) {
                sample[i] = (i < upper) ? 32767 : lower[v];
            }
            const davar_central_t central = central_of(sample, 64U);
            const double p = (double)upper / 64.0;
            const double expected = (1.0 / (p * (1.0 - p))) - 3.0;
            TEST_ASSERT_DOUBLE_WITHIN(4e-15 * expected, expected, davar_song_kurtosis(&central));
        }
    }
}

/* Half and half: K = 1 exactly. A value on a bound is inside it. */
static void test_a_value_on_its_bound_is_inside(void)
{
    const int16_t halves[4] = {-7, 7, -7, 7};
    const davar_central_t whole = central_of(halves, 4U);
    config.moments.kurtosis_low = 1.0;
    config.moments.kurtosis_high = 1.0;
    TEST_ASSERT_FALSE(davar_song_unstable(&config, SONG_KURTOSIS, &whole, &whole));
    config.moments.kurtosis_low = nextafter(1.0, 2.0);
    config.moments.kurtosis_high = 2.0;
    TEST_ASSERT_TRUE(davar_song_unstable(&config, SONG_KURTOSIS, &whole, &whole));
    config.moments.kurtosis_low = 0.0;
    config.moments.kurtosis_high = nextafter(1.0, 0.0);
    TEST_ASSERT_TRUE(davar_song_unstable(&config, SONG_KURTOSIS, &whole, &whole));
    config.moments.kurtosis_high = 0.0;
    TEST_ASSERT_TRUE(davar_song_unstable(&config, SONG_KURTOSIS, &whole, &whole));
    config.moments.kurtosis_low = -0.0;
    config.moments.kurtosis_high = 1.0;
    TEST_ASSERT_FALSE(davar_song_unstable(&config, SONG_KURTOSIS, &whole, &whole));
}

/* K = 1 against Km = 7/3 (one in four of three): S = 4/3. Also subnormal and zero bounds. */
static void test_contribution_on_both_sides_of_its_bounds(void)
{
    const int16_t quarter[8] = {9, 0, 0, 0, 9, 0, 0, 0};
    const int16_t halves[4] = {-7, 7, -7, 7};
    const davar_central_t first = central_of(quarter, 8U);
    const davar_central_t whole = central_of(halves, 4U);
    TEST_ASSERT_DOUBLE_WITHIN(1e-15, 4.0 / 3.0, davar_song_contribution(&whole, &first));
    config.moments.kurtosis_low = 0.0;
    config.moments.contribution_high = 1.34;
    TEST_ASSERT_FALSE(davar_song_unstable(&config, SONG_OR, &whole, &first));
    config.moments.contribution_high = 1.33;
    TEST_ASSERT_TRUE(davar_song_unstable(&config, SONG_OR, &whole, &first));
    config.moments.contribution_low = 1.34;
    config.moments.contribution_high = 2.0;
    TEST_ASSERT_TRUE(davar_song_unstable(&config, SONG_OR, &whole, &first));
    config.moments.contribution_low = 0.0;
    config.moments.contribution_high = 0.0;
    TEST_ASSERT_FALSE(davar_song_unstable(&config, SONG_OR, &whole, &whole)); /* S = 0 */
    config.moments.contribution_low = -0.0;
    config.moments.contribution_high = 1.34;
    TEST_ASSERT_FALSE(davar_song_unstable(&config, SONG_OR, &whole, &first));
    config.moments.contribution_high = 5e-324;
    TEST_ASSERT_TRUE(davar_song_unstable(&config, SONG_OR, &whole, &first));
}

static void test_each_rule_reads_its_own_flags(void)
{
    const int16_t spike[8] = {90, 0, 0, 0, 0, 0, 0, 0};
    const int16_t halves[4] = {-7, 7, -7, 7};
    const davar_central_t peaked = central_of(spike, 8U); /* K = 6.14 */
    const davar_central_t flat = central_of(halves, 4U);
    config.moments.kurtosis_low = 0.0;
    const struct {
        davar_song_rule_t rule;
        bool kurtosis_only;
        bool contribution_only;
        bool both;
    } expected[] = {
        {SONG_KURTOSIS, true, false, true},
        {SONG_OR, true, true, true},
        {SONG_AND, false, false, true},
    };
    for (unsigned i = 0U; i < 3U; i++) {
        TEST_ASSERT_EQUAL(expected[i].kurtosis_only,
                          davar_song_unstable(&config, expected[i].rule, &peaked, &peaked));
        TEST_ASSERT_EQUAL(expected[i].contribution_only,
                          davar_song_unstable(&config, expected[i].rule, &flat, &peaked));
        TEST_ASSERT_EQUAL(expected[i].both,
                          davar_song_unstable(&config, expected[i].rule, &peaked, &flat));
    }
}

static void test_without_variance_nothing_is_defined_and_nothing_unstable(void)
{
    const int16_t constant[4] = {5, 5, 5, 5};
    const int16_t halves[4] = {-7, 7, -7, 7};
    const davar_central_t none = central_of(constant, 4U);
    const davar_central_t some = central_of(halves, 4U);
    config.moments.kurtosis_low = 0.0;
    config.moments.contribution_low = 1.0;
    config.moments.contribution_high = 1.0;
    TEST_ASSERT_FALSE(davar_song_unstable(&config, SONG_OR, &none, &none));
    TEST_ASSERT_FALSE(davar_song_unstable(&config, SONG_OR, &some, &none));
    TEST_ASSERT_TRUE(isnan(davar_song_kurtosis(&none)));
    TEST_ASSERT_TRUE(isnan(davar_song_contribution(&some, &none)));
    TEST_ASSERT_TRUE(isnan(davar_song_contribution(&none, &some)));
}

/* The nearest double of K is within half its last bit: the neighbour above is above K, the one
 * below is below. */
static void test_the_next_double_is_on_the_other_side(void)
{
    int16_t sample[61];
    for (uint32_t n = 7U; n <= 61U; n += 9U) {
        for (uint32_t upper = 1U; upper < n; upper++) {
            for (uint32_t i = 0U; i < n; i++) {
                sample[i] = (i < upper) ? 900 : -33;
            }
            const davar_central_t whole = central_of(sample, n);
            const double product = (double)(upper * (n - upper));
            const double kurtosis =
                ((double)(n * n) - (3.0 * product)) / product; /* one rounding */
            const double above = nextafter(kurtosis, 1e300);
            const double under = nextafter(kurtosis, 0.0);
            config.moments.kurtosis_low = under;
            config.moments.kurtosis_high = above;
            TEST_ASSERT_FALSE(davar_song_unstable(&config, SONG_KURTOSIS, &whole, &whole));
            config.moments.kurtosis_high = under;
            TEST_ASSERT_TRUE(davar_song_unstable(&config, SONG_KURTOSIS, &whole, &whole));
            config.moments.kurtosis_low = above;
            config.moments.kurtosis_high = nextafter(above, 1e300);
            TEST_ASSERT_TRUE(davar_song_unstable(&config, SONG_KURTOSIS, &whole, &whole));
        }
    }
}

/* S = |K - Km| / K of two values each, in doubles within 2^-50 of K and Km; bounds 2^-44 away are on their side. */
static void test_contributions_hair_close_to_their_bounds(void)
{
    int16_t sample[64];
    config.moments.kurtosis_low = 0.0;
    config.moments.kurtosis_high = 1e300;
    for (uint32_t a = 3U; a < 60U; a += 4U) {
        for (uint32_t b = 2U; b < 63U; b++) {
            davar_central_t part[2];
            double kurtosis[2];
            for (uint32_t k = 0U; k < 2U; k++) {
                const uint32_t upper = (k == 0U) ? a : b;
                for (uint32_t i = 0U; i < 64U; i++) {
                    sample[i] = (i < upper) ? (int16_t)(50 + (int16_t)b) : -3;
                }
                part[k] = central_of(sample, 64U);
                const double product = (double)(upper * (64U - upper));
                kurtosis[k] = (4096.0 - (3.0 * product)) / product;
            }
            const double contribution = fabs(kurtosis[0] - kurtosis[1]) / kurtosis[0];
            const double hair = ldexp(1.0 + contribution, -44);
            if (contribution < 0.01) {
                continue;
            }
            config.moments.contribution_low = contribution - hair;
            config.moments.contribution_high = contribution + hair;
            TEST_ASSERT_FALSE(davar_song_unstable(&config, SONG_OR, &part[0], &part[1]));
            config.moments.contribution_high = contribution - hair;
            TEST_ASSERT_TRUE(davar_song_unstable(&config, SONG_OR, &part[0], &part[1]));
            config.moments.contribution_low = contribution + hair;
            config.moments.contribution_high = contribution + (2.0 * hair);
            TEST_ASSERT_TRUE(davar_song_unstable(&config, SONG_OR, &part[0], &part[1]));
            TEST_ASSERT_DOUBLE_WITHIN(hair, contribution,
                                      davar_song_contribution(&part[0], &part[1]));
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_kurtosis_of_two_values_whatever_their_mean_and_size);
    RUN_TEST(test_a_value_on_its_bound_is_inside);
    RUN_TEST(test_contribution_on_both_sides_of_its_bounds);
    RUN_TEST(test_each_rule_reads_its_own_flags);
    RUN_TEST(test_without_variance_nothing_is_defined_and_nothing_unstable);
    RUN_TEST(test_the_next_double_is_on_the_other_side);
    RUN_TEST(test_contributions_hair_close_to_their_bounds);
    return UNITY_END();
}
