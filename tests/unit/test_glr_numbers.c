/* davar tests - the numbers of the detector of changes: logarithm, gain, levels, dispersion,
 * thresholds and constants compared with their formulas, and the counts of its state. */
#include "laws/glr.h"
#include "laws/scan.h"

#include "glr_fixture.h"

static double times_logarithm_of_mean(const davar_spread_t *sum)
{
    const double mean =
        (((double)sum->high * 18446744073709551616.0) + (double)sum->low) / (double)sum->blocks;
    return (double)sum->blocks * log(mean);
}

static davar_spread_t random_spread(uint32_t blocks)
{
    const uint32_t down = (uint32_t)(random_next(&rng) % 96U);
    const uint64_t low = random_next(&rng);
    const uint32_t high = (uint32_t)(random_next(&rng) >> 34U);
    const davar_spread_t wide = {low, high >> (down % 32U), blocks};
    const davar_spread_t narrow = {(low >> (down % 58U)) | 1U, 0U, blocks};
    return (down < 48U) ? wide : narrow;
}

static void test_the_gain_is_the_formulas_and_the_bound_never_below(void)
{
    uint32_t spared = 0U;
    for (uint32_t i = 0U; i < 20000U; i++) {
        davar_spread_t older = random_spread(1U + (uint32_t)(random_next(&rng) % 500U));
        davar_spread_t sum = random_spread(1U + (uint32_t)(random_next(&rng) % 500U));
        if ((i % 2U) != 0U) { /* similar parts */
            older.low = (uint64_t)older.blocks << 40U;
            older.high = 0U;
            sum.low = 1U + (uint64_t)(exp(0.3 * random_gauss(&rng)) *
                                      (double)((uint64_t)sum.blocks << 40U));
            sum.high = 0U;
        }
        const davar_spread_t newer = sum;
        spread_add(&sum, &older);
        davar_stretch_t stretch;
        const uint32_t f = 4096U + (uint32_t)(random_next(&rng) % 61440U);
        davar_stretch(&stretch, &no_blocks, &sum, &config, f);
        const double exact =
            4.5 * (times_logarithm_of_mean(&sum) - times_logarithm_of_mean(&older) -
                   times_logarithm_of_mean(&newer));
        const int32_t gain = davar_likelihood_gain(&stretch, &older);
        TEST_ASSERT_DOUBLE_WITHIN(3e-3 + (1e-7 * exact), exact, (double)gain / 4096.0);
        const uint32_t limit = 64U + (uint32_t)(random_next(&rng) % 3000U);
        const bool may = davar_likelihood_may_reach(&stretch, &older, limit);
        TEST_ASSERT_TRUE(may || ((exact * 64.0) < ((double)limit * f / 4096.0)));
        spared += may ? 0U : 1U;
    }
    TEST_ASSERT_GREATER_THAN_UINT32(1000U, spared);
}

/* (10.6) for every block size: rounded down to 16 digits, half a digit on average. A constant that
 * is one digit off fails. */
static void test_thresholds_of_every_block_are_the_formulas(void)
{
    double alarm = 0.0;
    double cut = 0.0;
    double least = 0.0;
    davar_glr_wish_t wish = usual;
    for (wish.block = GLR_BLOCK_MIN; wish.block <= GLR_BLOCK_MAX; wish.block++) {
        const double blocks = 100.0 / wish.block;
        wish.false_alarms_per_hour = 0.01;
        davar_glr_start(&config, &wish);
        alarm += (double)config.alarm - (65536.0 * (log(360000.0 * blocks) + 1.2));
        cut += config.cut - (65536.0 * (log(300.0 * blocks) + 1.8));
        wish.false_alarms_per_hour = 1e6;
        davar_glr_start(&config, &wish);
        const uint32_t longest = 6000U / wish.block;
        least += (double)config.alarm - (65536.0 * (log(fmin(longest, GLR_LONGEST)) + 1.0));
    }
    const double sizes = (double)(GLR_BLOCK_MAX - GLR_BLOCK_MIN + 1U);
    TEST_ASSERT_DOUBLE_WITHIN(0.5, -0.5, alarm / sizes);
    TEST_ASSERT_DOUBLE_WITHIN(0.5, -0.5, cut / sizes);
    TEST_ASSERT_DOUBLE_WITHIN(0.5, -0.5, least / sizes);
}

static uint32_t at_least_one(uint32_t count)
{
    return (count > 0U) ? count : 1U;
}

/* A window that is longer than the records, and one of a single block. */
static void test_the_ends_of_the_constants(void)
{
    davar_glr_wish_t wish = usual;
    wish.longest = 1U << 20U;
    wish.block = 5U;
    davar_glr_start(&config, &wish);
    TEST_ASSERT_EQUAL(GLR_LONGEST, config.longest);
    TEST_ASSERT_EQUAL(GLR_LEVELS, config.levels);
    wish.block = 400U;
    davar_glr_start(&config, &wish);
    TEST_ASSERT_EQUAL(1, config.near);
}

/* The constants documented in glr.h, for every block size and windows near those that need one
 * level more. */
static void test_constants_of_every_block_are_as_stated(void)
{
    davar_glr_wish_t wish = usual;
    for (wish.block = GLR_BLOCK_MIN; wish.block <= GLR_BLOCK_MAX; wish.block++) {
        for (uint32_t i = 3U; i < 24U; i++) {
            const uint32_t blocks = (6U << (i / 3U)) + 1U - (i % 3U);
            const double nu = wish.block - 1.0;
            const uint32_t longest = (blocks < 768U) ? blocks : 768U;
            uint32_t levels = 1U;
            while ((3U << (levels - 1U)) < longest) {
                levels++;
            }
            wish.longest = (blocks * wish.block) + (blocks % wish.block);
            davar_glr_start(&config, &wish);
            TEST_ASSERT_EQUAL_UINT32(wish.block, config.block);
            TEST_ASSERT_EQUAL_UINT32(wish.block - 1U, config.degrees);
            TEST_ASSERT_EQUAL_UINT32(wish.block * (wish.block - 1U), config.floor);
            TEST_ASSERT_EQUAL_UINT32(longest, config.longest);
            TEST_ASSERT_EQUAL_UINT32(levels, config.levels);
            TEST_ASSERT_EQUAL_UINT32(2U, config.shock);
            TEST_ASSERT_EQUAL_UINT32(256U * ((wish.block >= 18U) ? 3U : 5U), config.outlier);
            TEST_ASSERT_DOUBLE_WITHIN(1.0, 65536.0 * nu * nu / (4.0 * (nu + 1.0)), config.step);
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, 65536.0 * 8.0 * nu / 4.0, config.step_of_8);
            TEST_ASSERT_DOUBLE_WITHIN(1.0, 65536.0 / (3.0 * nu), config.bias);
            TEST_ASSERT_EQUAL_UINT32(at_least_one(150U / wish.block), config.near);
            TEST_ASSERT_EQUAL_UINT32(at_least_one(600U / wish.block), config.far);
        }
    }
}

/* The upper half of a product of two. */
static uint32_t upper(uint32_t a, uint32_t b)
{
    return (uint32_t)(((uint64_t)a * b) >> 32U);
}

/* The formula stated in logarithm.c, its tables recomputed: bit for bit, in each of its 32
 * intervals. */
static void test_the_logarithm_is_the_formula_of_its_tables(void)
{
    for (uint32_t i = 0U; i < 32U; i++) {
        const uint32_t edge = (uint32_t)llround(2147483648.0 * log(1.0 + (i / 32.0)));
        const uint32_t inverse = (uint32_t)llround(2147483648.0 / (1.0 + (i / 32.0)));
        for (uint32_t k = 0U; k < 1000U; k++) {
            const uint32_t beyond = (k == 0U) ? 0U : ((uint32_t)random_next(&rng) & 0x3FFFFFFU);
            const uint32_t x = upper(beyond << 5U, inverse);
            const uint32_t square = upper(x, x);
            const uint32_t rest =
                (x >> 4U) - (square >> 8U) + (((upper(square, x) >> 10U) * 83U) >> 8U);
            TEST_ASSERT_EQUAL_INT32((edge + rest) >> 7U,
                                    davar_logarithm(((32U + i) << 26U) | beyond, -31));
        }
    }
    TEST_ASSERT_EQUAL(0, davar_logarithm_of_count(1U));
    const int32_t ln_2 = (int32_t)lround(16777216.0 * log(2.0));
    for (int32_t exponent = -63; exponent <= 64; exponent++) {
        TEST_ASSERT_EQUAL_INT32((exponent + 31) * ln_2, davar_logarithm(0x80000000U, exponent));
    }
}

/* After 2^32 blocks the count of blocks is 0 again, which every power of two divides. */
static void test_the_count_of_blocks_wraps(void)
{
    state.now.at = 0U - 512U;
    state.cut.at = state.now.at;
    state.alarm.at = state.now.at;
    push_quiet(1000U);
    TEST_ASSERT_EQUAL_UINT32(488U, state.now.at);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(12U, blocks_to_alarm(60.0, 20U));
}

/* The root of a mean square, however large the sums are. */
static void test_a_level_is_the_root_of_the_mean(void)
{
    random_t random = random_seeded(7U);
    for (uint32_t i = 0U; i < 2000U; i++) {
        const uint32_t blocks = 1U + (uint32_t)(random_next(&random) % 768U);
        const uint64_t low = random_next(&random) >> (random_next(&random) % 44U);
        const uint32_t high = ((i % 2U) == 0U) ? 0U : (uint32_t)(random_next(&random) >> 40U);
        const davar_spread_t sum = {low | (UINT64_C(1) << 20U), high, blocks};
        const double square =
            (((high * 18446744073709551616.0) + (double)sum.low) - (90.0 * blocks)) /
            (1080.0 * blocks);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9 * sqrt(square), sqrt(square),
                                  davar_spread_level(&sum, 90U, 1080U));
    }
}

/* (10.3), each move from where phi was, in doubles: a mean that forgets, of squared steps that
 * weigh nine phi at most. */
static void test_the_dispersion_moves_as_the_formula_says(void)
{
    static const uint32_t memories[2] = {11U, 8U};
    for (uint32_t k = 0U; k < 2U; k++) {
        davar_dispersion_t dispersion;
        davar_dispersion_start(&dispersion);
        double before = 0.0;
        for (uint32_t n = 0U; n < 6000U; n++) {
            const double width = (n < 3000U) ? 0.5 : ((n < 4500U) ? 4.0 : 0.01);
            const int32_t logarithm = (int32_t)lround(16777216.0 * width * random_gauss(&rng));
            const double phi = dispersion.phi / 16777216.0;
            const double step = (logarithm / 16777216.0) - before;
            davar_dispersion_learn(&dispersion, logarithm, config.step, memories[k]);
            before = logarithm / 16777216.0;
            const double nu = config.block - 1.0;
            const double unit = 1.0 / (2.0 * (2.0 / nu) * (1.0 + (1.0 / nu)));
            const double square = fmin(step * step * unit, 9.0 * phi);
            const double share = fmax(1.0 / (n + 15.0), ldexp(1.0, -(int)memories[k]));
            const double next =
                (n == 0U) ? phi : fmin(fmax(phi + ((square - phi) * share), 0.25), 14.0);
            const double cut = ldexp(2.0 * fabs(step) * unit, -12); /* a step has 12 digits */
            TEST_ASSERT_DOUBLE_WITHIN(4e-7 + (share * (cut + (2e-4 * square))), next,
                                      dispersion.phi / 16777216.0);
        }
    }
}

static void test_wide_samples_decide_as_narrow_ones_whatever_their_size(void)
{
    static davar_glr_t wide;
    static davar_glr_event_t other;
    davar_glr_reset(&wide);
    for (uint32_t n = 0U; n < 2000U; n++) {
        const double sigma = ((n / 300U) % 2U == 0U) ? 2000.0 : 8000.0;
        int64_t sum = 0;
        uint64_t squares = 0U;
        for (uint32_t i = 0U; i < 10U; i++) {
            const int16_t sample = rounded(sigma * random_gauss(&rng));
            sum += sample;
            squares += (uint64_t)(sample * (int64_t)sample);
        }
        if ((n % 97U) >= 95U) { /* a shock */
            sum += 30000;
            squares += UINT64_C(900000000);
        }
        const davar_u128_t scaled = {squares << 32U, squares >> 32U};
        davar_glr_push_q15(&state, &config, (int32_t)sum, squares, &event);
        davar_glr_push_q31(&wide, &config, sum * 65536, &scaled, &other);
        TEST_ASSERT_EQUAL(event.is_alarm, other.is_alarm);
        TEST_ASSERT_EQUAL(event.dropped, other.dropped);
        TEST_ASSERT_EQUAL_UINT32(state.cut.at, wide.cut.at);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_the_gain_is_the_formulas_and_the_bound_never_below);
    RUN_TEST(test_the_count_of_blocks_wraps);
    RUN_TEST(test_thresholds_of_every_block_are_the_formulas);
    RUN_TEST(test_the_ends_of_the_constants);
    RUN_TEST(test_constants_of_every_block_are_as_stated);
    RUN_TEST(test_the_logarithm_is_the_formula_of_its_tables);
    RUN_TEST(test_a_level_is_the_root_of_the_mean);
    RUN_TEST(test_the_dispersion_moves_as_the_formula_says);
    RUN_TEST(test_wide_samples_decide_as_narrow_ones_whatever_their_size);
    return UNITY_END();
}
