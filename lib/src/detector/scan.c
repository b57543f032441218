/* davar - the likelihood ratio of one variance against two. */
#include "detector/scan.h"

#include "core/window.h"
#include "number/real.h"

void davar_stretch(davar_stretch_t *stretch, const davar_spread_t *sum, uint32_t degrees)
{
    spread_copy(&stretch->sum, sum);
    stretch->degrees = degrees;
    stretch->exponent = spread_exponent(sum);
    const uint32_t mantissa = spread_bits(sum, stretch->exponent);
    stretch->reciprocal = davar_reciprocal_of_mantissa(mantissa);
    stretch->logarithm = INT32_MIN;
}

/* E_o, E_n: the blocks that the parts would have if both were as loud as the whole. x - 1 - ln x is
 * at most (x - 1)^2 / 2 above 1 and (x - 1)^2 / (2 x) below, so
 *
 *     G <= nu/4 (E_o - N_o)^2 (1/P + 1/Q)
 *
 * with P the blocks of the louder part and Q the E of the other. */
bool davar_likelihood_may_reach(const davar_stretch_t *stretch, const davar_spread_t *older,
                                uint32_t limit)
{
    const uint32_t blocks = stretch->sum.blocks;
    const uint32_t share = davar_upper_product(spread_bits(older, stretch->exponent),
                                               stretch->reciprocal); /* 31 digits */
    const uint32_t expected = (share >> 10U) * blocks; /* E_o, 21 digits, within 2^-10 */
    const uint32_t there = older->blocks << 21U;
    const bool is_louder = (expected > there);
    const uint32_t excess = is_louder ? (expected - there) : (there - expected);
    const uint32_t size = (excess >> 15U) + 1U; /* 6 digits; below 2^16 with 1023 blocks */
    const uint32_t newer = (blocks << 21U) - (is_louder ? expected : there);
    const uint32_t quiet = is_louder ? newer : expected;
    const uint32_t loud = is_louder ? there : newer;
    const uint32_t p = loud >> 18U; /* 3 digits */
    const uint32_t q = (quiet >> 18U) - (((quiet >> 18U) != 0U) ? 1U : 0U);
    const uint64_t bound =
        davar_multiply_u32(size * size, ((stretch->degrees * (p + q)) >> 8U) + 1U); /* 15 digits */
    return bound >= (davar_multiply_u32(p * q, limit) << 5U);
}

/* N ln(mean of the whole / mean of this part), 24 digits */
static uint64_t part_of(const davar_stretch_t *stretch, const davar_spread_t *part)
{
    return davar_multiply_i32(stretch->logarithm - spread_logarithm_of_mean(part),
                              (int32_t)part->blocks);
}

int32_t davar_likelihood_gain(davar_stretch_t *stretch, const davar_spread_t *older)
{
    if (stretch->logarithm == INT32_MIN) {
        stretch->logarithm = spread_logarithm_of_mean(&stretch->sum);
    }
    const davar_spread_t newer = spread_between(older, &stretch->sum);
    const uint64_t sum =
        part_of(stretch, older) + part_of(stretch, &newer); /* >= 0 up to rounding */
    return (int32_t)((int64_t)davar_scale_u64(sum, stretch->degrees) >>
                     (24U + 8U + 1U - GAIN_DIGITS));
}

/* --- the scan over dyadic ages ---------------------------------------------------------------- */

#define LN_2_ABOVE 45427U /* rounded up, 16 digits */

/* One scan: what its splits share, and the best of them. */
typedef struct {
    const davar_glr_t *state;
    const davar_glr_config_t *config;
    const davar_glr_place_t *begin;
    davar_stretch_t stretch;
    uint32_t f;
    davar_split_t *best; /* one per threshold, the lowest first */
    uint32_t count;
} scan_t;

/* Compares a gain with the thresholds f (1 + 1 / (3 nu n)) (h - ln n); h is above ln n + 1. */
static void compare(scan_t *scan, int32_t gain, uint32_t n, uint32_t age, uint32_t level)
{
    const uint32_t logarithm = (uint32_t)davar_logarithm_of_count(n) >> 8U;
    const uint32_t bias = davar_divided(scan->config->bias, n);
    for (uint32_t i = 0U; i < scan->count; i++) {
        davar_split_t *const best = &scan->best[i];
        const uint32_t plain =
            (uint32_t)(davar_multiply_u32(scan->f, best->threshold - logarithm) >> 16U);
        const int32_t excess =
            gain - (int32_t)(plain + (uint32_t)(davar_multiply_u32(plain, bias) >> 16U));
        if (excess > best->excess) {
            best->excess = excess;
            best->gain = gain;
            best->age = age;
            best->level = level;
        }
    }
}

/* Tests the split at `age`, where this level has a record. A bound below every threshold (6 digits)
 * comes first, because it needs no logarithm. */
static void test_split(scan_t *scan, uint32_t age, uint32_t level)
{
    if (age >= glr_age(scan->state, scan->begin)) {
        return;
    }
    const davar_spread_t older = spread_between(
        &scan->begin->sum, glr_record(scan->state, level, scan->state->now.at - age));
    const uint32_t n = smaller(older.blocks, scan->stretch.sum.blocks - older.blocks);
    if (n < scan->config->least) {
        return;
    }
    const uint32_t above_ln_n = (32U - davar_leading_zeros_32(n)) * LN_2_ABOVE;
    const uint64_t limit = davar_multiply_u32(scan->f, scan->best[0].threshold - above_ln_n);
    if (davar_likelihood_may_reach(&scan->stretch, &older, (uint32_t)(limit >> 22U))) {
        compare(scan, davar_likelihood_gain(&scan->stretch, &older), n, age, level);
    }
}

/* Splits at ages above 3. Levels from 2 on take turns: level l at odd multiples of 2^(l - 1), so a
 * block tests one at most. */
static void test_older(scan_t *scan)
{
    const uint32_t at = scan->state->now.at;
    if ((at & 1U) != 0U) {
        test_split(scan, 5U, 1U);
        return;
    }
    test_split(scan, 4U, 1U);
    const uint32_t levels = scan->config->levels;
    uint32_t level = 2U;
    while ((level < levels) && (((at >> (level - 1U)) & 1U) == 0U)) {
        level++;
    }
    if (level < levels) {
        test_split(scan, 3U << (level - 1U), level);
        test_split(scan, 5U << (level - 1U), level);
    }
}

void davar_glr_scan(const davar_glr_t *state, const davar_glr_config_t *config,
                    const davar_glr_place_t *begin, davar_split_t *split, uint32_t count)
{
    const davar_spread_t sum = spread_between(&begin->sum, &state->now.sum);
    if (sum.blocks < (2U * config->least)) {
        return;
    }
    scan_t scan = {
        state, config, begin, {{0U, 0U, 0U}, 0, 0U, 0, 0U}, davar_glr_dispersion(state, config),
        split, count};
    davar_stretch(&scan.stretch, &sum, config->degrees);
    test_split(&scan, 2U, 0U);
    test_split(&scan, 3U, 0U);
    test_older(&scan);
}
