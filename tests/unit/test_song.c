/* davar tests - the verdicts of the paper's law: in 32 bits compared with the exact ones and with K
 * and S in doubles, never wrong, and certain unless a bound is extremely close; and the exact ones
 * on the bounds. */
#include "laws/song.h"
#include "number/q15.inc"

#include "number/q15_moments.inc"

#include "davar/davar.h"
#include "random.h"
#include "unity.h"

#include <float.h>
#include <math.h>

#define TRIALS 20000U
#define SAMPLES 40U

/* Samples with both forms of their moments. */
typedef struct {
    davar_central_t exact;
    davar_rough_t rough;
} moments_of_t;

static davar_config_t config;
static random_t source;
static moments_of_t whole;
static moments_of_t first;

void setUp(void)
{
    config = davar_default_config;
    source = random_seeded(31U);
}

void tearDown(void) {}

static uint32_t below(uint32_t bound)
{
    return (uint32_t)(random_next(&source) % bound);
}

static moments_of_t moments_of(const powers_t *sums, uint32_t n)
{
    moments_of_t moments;
    powers_central(sums, n, &moments.exact);
    powers_rough(sums, n, &moments.rough);
    return moments;
}

static int16_t clamped(int32_t value)
{
    return (int16_t)((value > 32767) ? 32767 : ((value < -32768) ? -32768 : value));
}

/* Samples of any size about any mean, a few of them larger. */
static moments_of_t any_moments(uint32_t size, uint32_t samples)
{
    powers_t sums = {0};
    const int32_t mean = (int32_t)below(65536U) - 32768;
    const uint32_t n = 8U + below(samples);
    for (uint32_t i = 0U; i < n; i++) {
        const uint32_t width = (below(16U) == 0U) ? (4U * size) : size;
        powers_add(&sums, clamped(mean + (int32_t)below(2U * width + 1U) - (int32_t)width));
    }
    return moments_of(&sums, n);
}

/* Two sets of samples with a variance; the second of similar size as the first, or of another. */
static void choose_moments(void)
{
    do {
        const uint32_t size = 1U + (below(20000U) >> below(14U));
        const uint32_t samples = (below(16U) == 0U) ? 3000U : SAMPLES;
        whole = any_moments(size, samples);
        first = any_moments((below(4U) == 0U) ? (1U + below(5000U)) : size, samples);
    } while ((whole.exact.second.mantissa == 0U) || (first.exact.second.mantissa == 0U));
}

static davar_place_t verdict(davar_rule_t rule)
{
    davar_song_bounds_t bounds;
    davar_song_bounds(&bounds, &config);
    const davar_place_t enough = (rule == RULE_AND) ? ROUGH_INSIDE : ROUGH_OUTSIDE;
    const davar_place_t kurtosis = davar_rough_kurtosis(&bounds, &whole.rough);
    const bool decides =
        (kurtosis == ROUGH_UNSURE) || (kurtosis == enough) || (rule == RULE_KURTOSIS);
    return decides ? kurtosis : davar_rough_contribution(&bounds, &whole.rough, &first.rough);
}

/* Extremely close to the value, or not. True: so far that the decision must be certain. */
static bool choose_bound(double value, double *bound)
{
    const uint32_t bits = 1U + below(36U);
    const double distance = ldexp(1.0 + value, -(int)bits);
    *bound = ((below(2U) == 0U) || (distance > value)) ? (value + distance) : (value - distance);
    return bits < 18U;
}

/* The place is that of the exact test; `must_know`: it is certain. */
static void check(davar_rule_t rule, bool outside, bool must_know)
{
    const davar_place_t rough = verdict(rule);
    if (must_know) {
        TEST_ASSERT_NOT_EQUAL(ROUGH_UNSURE, rough);
    }
    if (rough != ROUGH_UNSURE) {
        TEST_ASSERT_EQUAL(outside ? ROUGH_OUTSIDE : ROUGH_INSIDE, rough);
        TEST_ASSERT_EQUAL(outside,
                          davar_moments_unstable(&config, rule, &whole.exact, &first.exact));
    }
}

static bool is_known(const moments_of_t *moments)
{
    return moments->rough.under != 0U;
}

static void test_kurtosis_against_one_bound_or_the_other(void)
{
    for (uint32_t i = 0U; i < TRIALS; i++) {
        choose_moments();
        const double kurtosis = davar_kurtosis(&whole.exact);
        const bool upper = (i % 2U) == 0U;
        double bound;
        const bool far = choose_bound(kurtosis, &bound) && is_known(&whole) && (bound < 15.9) &&
                         (!upper || (bound > 0.001));
        config.moments.kurtosis_low = upper ? 0.0 : bound;
        config.moments.kurtosis_high = upper ? bound : 1e300;
        check(RULE_KURTOSIS, upper ? (kurtosis > bound) : (kurtosis < bound),
              far && (upper || (kurtosis < 15.9)));
    }
}

/* Contributions of 1 and more may be left to the exact path. */
static void test_contribution_against_one_bound_or_the_other(void)
{
    config.moments.kurtosis_low = 0.0;
    config.moments.kurtosis_high = 1e300;
    for (uint32_t i = 0U; i < TRIALS; i++) {
        choose_moments();
        const double contribution = davar_contribution(&whole.exact, &first.exact);
        const bool upper = (i % 2U) == 0U;
        double bound;
        const bool far =
            choose_bound(contribution, &bound) && (contribution < 0.99) && (contribution > 1e-4) &&
            (bound > 1e-4) && (bound < 0.99) && is_known(&whole) && is_known(&first) &&
            (davar_kurtosis(&whole.exact) < 15.9) && (davar_kurtosis(&first.exact) < 15.9);
        config.moments.contribution_low = upper ? 0.0 : bound;
        config.moments.contribution_high = upper ? bound : 3.9;
        check(RULE_OR, upper ? (contribution > bound) : (contribution < bound), far);
    }
}

/* With the paper's bounds the exact path is hardly ever needed, whatever the mean. */
static void test_the_usual_bounds_are_nearly_always_decided(void)
{
    uint32_t unsure = 0U;
    for (uint32_t i = 0U; i < TRIALS; i++) {
        const uint32_t size = 20U + below(3000U);
        whole = any_moments(size, SAMPLES);
        first = any_moments(size, SAMPLES);
        unsure += (verdict(RULE_OR) == ROUGH_UNSURE) ? 1U : 0U;
    }
    TEST_ASSERT_LESS_THAN_UINT32(TRIALS / 1000U, unsure);
}

/* The largest samples that the window may have for 96 bits: every second one at either end. */
static void test_large_windows_and_samples_are_right_or_left_to_the_exact_way(void)
{
    config.moments.kurtosis_low = 0.99; /* K = 1 */
    config.moments.kurtosis_high = 1.01;
    uint32_t known = 0U;
    for (uint32_t bits = 2U; bits < 17U; bits++) {
        for (uint32_t size = 1U; size < 32768U; size = (2U * size) + 1U) {
            const uint32_t n = (UINT32_C(1) << bits) - ((bits == 16U) ? 0U : 2U);
            powers_t sums = {0};
            for (uint32_t i = 0U; i < n; i++) {
                powers_add(&sums, (int16_t)(((i % 2U) == 0U) ? (int32_t)size : -(int32_t)size));
            }
            whole = moments_of(&sums, n);
            const davar_place_t rough = verdict(RULE_KURTOSIS);
            TEST_ASSERT_NOT_EQUAL(ROUGH_OUTSIDE, rough);
            known += (rough == ROUGH_INSIDE) ? 1U : 0U;
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT32(100U, known);
}

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

static moments_of_t moments_of_list(const int16_t sample[8])
{
    powers_t sums = {0};
    for (uint32_t i = 0U; i < 8U; i++) {
        powers_add(&sums, sample[i]);
    }
    return moments_of(&sums, 8U);
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
            TEST_ASSERT_DOUBLE_WITHIN(4e-15 * expected, expected, davar_kurtosis(&central));
        }
    }
}

/* K = 1 exactly of half and half, 7/3 of one in four: S = 4/3. A value on a bound is inside it, and
 * so is one that is not defined. Also subnormal bounds and both zeros. */
static void test_a_value_on_its_bound_or_undefined_is_inside(void)
{
    static const int16_t halves[8] = {-7, 7, -7, 7, -7, 7, -7, 7};
    static const int16_t quarter[8] = {9, 0, 0, 0, 9, 0, 0, 0};
    static const int16_t constant[8] = {5, 5, 5, 5, 5, 5, 5, 5};
    static const struct {
        const int16_t *all;
        const int16_t *early;
        double kurtosis[2]; /* bounds */
        double contribution[2];
        davar_rule_t rule;
        bool unstable;
    } cases[] = {
        {halves, halves, {1.0, 1.0}, {0.0, 0.0}, RULE_KURTOSIS, false},
        {halves, halves, {1.0 + DBL_EPSILON, 2.0}, {0.0, 0.0}, RULE_KURTOSIS, true},
        {halves, halves, {0.0, 1.0 - (DBL_EPSILON / 2.0)}, {0.0, 0.0}, RULE_KURTOSIS, true},
        {halves, halves, {0.0, 0.0}, {0.0, 0.0}, RULE_KURTOSIS, true},
        {halves, halves, {-0.0, 1.0}, {0.0, 0.0}, RULE_KURTOSIS, false},
        {halves, quarter, {0.0, 4.0}, {0.0, 1.34}, RULE_OR, false},
        {halves, quarter, {0.0, 4.0}, {0.0, 1.33}, RULE_OR, true},
        {halves, quarter, {0.0, 4.0}, {1.34, 2.0}, RULE_OR, true},
        {halves, quarter, {0.0, 4.0}, {-0.0, 1.34}, RULE_OR, false},
        {halves, quarter, {0.0, 4.0}, {-0.0, 5e-324}, RULE_OR, true},
        {halves, halves, {0.0, 4.0}, {0.0, 0.0}, RULE_OR, false}, /* S = 0 */
        {halves, quarter, {0.0, 0.5}, {0.0, 1.34}, RULE_AND, false},
        {halves, quarter, {0.0, 0.5}, {0.0, 1.33}, RULE_AND, true},
        {constant, constant, {0.0, 4.0}, {1.0, 1.0}, RULE_OR, false},
        {halves, constant, {0.0, 4.0}, {1.0, 1.0}, RULE_OR, false},
        {constant, halves, {1.0, 1.0}, {1.0, 1.0}, RULE_AND, false},
    };
    for (size_t i = 0U; i < sizeof cases / sizeof cases[0]; i++) {
        whole = moments_of_list(cases[i].all);
        first = moments_of_list(cases[i].early);
        config.moments.kurtosis_low = cases[i].kurtosis[0];
        config.moments.kurtosis_high = cases[i].kurtosis[1];
        config.moments.contribution_low = cases[i].contribution[0];
        config.moments.contribution_high = cases[i].contribution[1];
        check(cases[i].rule, cases[i].unstable, false);
        TEST_ASSERT_EQUAL(cases[i].unstable, davar_moments_unstable(&config, cases[i].rule,
                                                                    &whole.exact, &first.exact));
        TEST_ASSERT_EQUAL(cases[i].all == constant, isnan(davar_kurtosis(&whole.exact)));
        TEST_ASSERT_EQUAL((cases[i].all == constant) || (cases[i].early == constant),
                          isnan(davar_contribution(&whole.exact, &first.exact)));
    }
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
            const davar_central_t all = central_of(sample, n);
            const double product = (double)(upper * (n - upper));
            const double kurtosis =
                ((double)(n * n) - (3.0 * product)) / product; /* one rounding */
            const double above = nextafter(kurtosis, 1e300);
            const double under = nextafter(kurtosis, 0.0);
            config.moments.kurtosis_low = under;
            config.moments.kurtosis_high = above;
            TEST_ASSERT_FALSE(davar_moments_unstable(&config, RULE_KURTOSIS, &all, &all));
            config.moments.kurtosis_high = under;
            TEST_ASSERT_TRUE(davar_moments_unstable(&config, RULE_KURTOSIS, &all, &all));
            config.moments.kurtosis_low = above;
            config.moments.kurtosis_high = nextafter(above, 1e300);
            TEST_ASSERT_TRUE(davar_moments_unstable(&config, RULE_KURTOSIS, &all, &all));
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
            TEST_ASSERT_FALSE(davar_moments_unstable(&config, RULE_OR, &part[0], &part[1]));
            config.moments.contribution_high = contribution - hair;
            TEST_ASSERT_TRUE(davar_moments_unstable(&config, RULE_OR, &part[0], &part[1]));
            config.moments.contribution_low = contribution + hair;
            config.moments.contribution_high = contribution + (2.0 * hair);
            TEST_ASSERT_TRUE(davar_moments_unstable(&config, RULE_OR, &part[0], &part[1]));
            TEST_ASSERT_DOUBLE_WITHIN(hair, contribution, davar_contribution(&part[0], &part[1]));
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_kurtosis_against_one_bound_or_the_other);
    RUN_TEST(test_contribution_against_one_bound_or_the_other);
    RUN_TEST(test_the_usual_bounds_are_nearly_always_decided);
    RUN_TEST(test_large_windows_and_samples_are_right_or_left_to_the_exact_way);
    RUN_TEST(test_kurtosis_of_two_values_whatever_their_mean_and_size);
    RUN_TEST(test_a_value_on_its_bound_or_undefined_is_inside);
    RUN_TEST(test_the_next_double_is_on_the_other_side);
    RUN_TEST(test_contributions_hair_close_to_their_bounds);
    return UNITY_END();
}
