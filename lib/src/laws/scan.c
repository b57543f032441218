/* davar - the likelihood ratio of one variance against two. */
#include "laws/scan.h"

#include "core/window.h"
#include "number/real.h"

void davar_stretch(davar_stretch_t *stretch, const davar_spread_t *from, const davar_spread_t *to,
                   const davar_glr_config_t *config, uint32_t f)
{
    const davar_spread_t sum = spread_between(from, to);
    stretch->from = from;
    stretch->to = to;
    stretch->blocks = sum.blocks;
    stretch->exponent = spread_exponent(&sum);
    stretch->begin = spread_bits(from, stretch->exponent);
    const uint32_t mantissa = spread_bits(&sum, stretch->exponent);
    stretch->sum = mantissa >> 11U;
    stretch->weight = davar_upper_product(3U * f * config->bias, mantissa) >> 12U;
    stretch->logarithm = INT32_MIN;
    stretch->degrees = config->degrees;
}

#define ERROR 2048U /* above 2 blocks: the part and the sum are within one unit */

/* E_o, E_n: the blocks that the parts would have if both were as loud as the whole. x - 1 - ln x is
 * at most (x - 1)^2 / 2 above 1 and (x - 1)^2 / (2 x) below, so
 *
 *     G <= nu/2 (E_o - N_o)^2 / min(P, Q)
 *
 * with P the blocks of the louder part and Q the E of the other: the least of all four. Here a
 * block is `sum`, so no quotient is computed. E is within ERROR. */
bool davar_likelihood_may_reach(const davar_stretch_t *stretch, const davar_spread_t *split,
                                uint32_t limit)
{
    const uint32_t blocks = stretch->blocks;
    const uint32_t part =
        smaller((spread_bits(split, stretch->exponent) - stretch->begin) >> 11U, stretch->sum);
    const uint32_t expected = part * blocks; /* below 2^31 with 1023 blocks */
    const uint32_t there = stretch->sum * (split->blocks - stretch->from->blocks);
    const uint32_t low = smaller(expected, there);
    const uint32_t high = (expected > there) ? expected : there;
    const uint32_t least = smaller(low, (stretch->sum * blocks) - high);
    const uint32_t size = ((high - low + ERROR) >> 15U) + 1U; /* below 2^16 */
    const uint32_t bound =
        davar_upper_product(2U * (least - smaller(least, ERROR)), stretch->weight * limit);
    return ((size * size) / 2U) >= bound;
}

/* N ln(mean of the whole / mean of this part), 24 digits */
static uint64_t part_of(const davar_stretch_t *stretch, const davar_spread_t *part)
{
    return davar_multiply_i32(stretch->logarithm - spread_logarithm_of_mean(part),
                              (int32_t)part->blocks);
}

int32_t davar_likelihood_gain(davar_stretch_t *stretch, const davar_spread_t *split)
{
    if (stretch->logarithm == INT32_MIN) {
        const davar_spread_t both = spread_between(stretch->from, stretch->to);
        stretch->logarithm = spread_logarithm_of_mean(&both);
    }
    const davar_spread_t older = spread_between(stretch->from, split);
    const davar_spread_t newer = spread_between(split, stretch->to);
    const uint64_t sum =
        part_of(stretch, &older) + part_of(stretch, &newer); /* >= 0 up to rounding */
    return (int32_t)((int64_t)davar_scale_u64(sum, stretch->degrees) >> (24U + 1U - GAIN_DIGITS));
}

/* --- the scan over dyadic ages ---------------------------------------------------------------- */

#define PART_LEAST 2U     /* blocks in each part of a split, at least */
#define LN_2_ABOVE 45427U /* rounded up, 16 digits */

/* One scan: what its splits share, and the best of them. */
typedef struct {
    const davar_glr_t *state;
    const davar_glr_config_t *config;
    davar_stretch_t stretch;
    uint32_t room;       /* blocks beyond the least of each part */
    davar_split_t *best; /* one per threshold, the lowest first */
    uint32_t count;
} scan_t;

/* Compares a gain with the thresholds f(n) (1 + 1 / (3 nu n)) (h - ln n); n is at least 2, and h is
 * above ln n + 1. */
static void compare(scan_t *scan, int32_t gain, uint32_t n, uint32_t age, uint32_t level)
{
    const uint32_t logarithm = (uint32_t)davar_logarithm_of_count(n) >> 8U;
    const uint32_t bias = davar_divided(scan->config->bias, n);
    const uint32_t f = davar_glr_dispersion(scan->state, 31U - davar_leading_zeros_32(n));
    for (uint32_t i = 0U; i < scan->count; i++) {
        davar_split_t *const best = &scan->best[i];
        const uint32_t plain =
            (uint32_t)(davar_multiply_u32(f, best->threshold - logarithm) >> 16U);
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

/* Tests the split at `age`, which is below 2^(level + 2) and has a record at this level. If the
 * record is not after the beginning, the split has no older block. The bound comes first, because
 * it needs no logarithm. */
static void test_split(scan_t *scan, uint32_t age, uint32_t level)
{
    const davar_spread_t *const split = glr_record(scan->state, level, scan->state->now.at - age);
    const uint32_t older = split->blocks - scan->stretch.from->blocks;
    if ((older - PART_LEAST) > scan->room) {
        return;
    }
    const uint32_t limit = scan->best[0].threshold - ((level + 2U) * LN_2_ABOVE);
    if (davar_likelihood_may_reach(&scan->stretch, split, limit >> 10U)) {
        const uint32_t n = smaller(older, scan->stretch.blocks - older);
        compare(scan, davar_likelihood_gain(&scan->stretch, split), n, age, level);
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
    scan_t scan;
    scan.room = state->now.sum.blocks - begin->sum.blocks - (2U * PART_LEAST);
    if ((int32_t)scan.room < 0) {
        return;
    }
    scan.state = state;
    scan.config = config;
    scan.best = split;
    scan.count = count;
    davar_stretch(&scan.stretch, &begin->sum, &state->now.sum, config,
                  davar_glr_dispersion(state, GLR_MANY));
    test_split(&scan, 2U, 0U);
    test_split(&scan, 3U, 0U);
    test_older(&scan);
}
