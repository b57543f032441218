/* davar - the scan of the likelihood ratio over dyadic ages. */
#include "track/scan.h"

#include "number/real.h"
#include "track/likelihood.h"

#define LN_2_ABOVE 45427U /* 16 digits */

/* What all splits of one scan share. */
typedef struct {
    const davar_glr_t *state;
    const davar_glr_config_t *config;
    const davar_glr_place_t *begin;
    davar_stretch_t stretch;
    uint32_t f;
    davar_split_t *best; /* of each threshold, the lowest first */
    uint32_t count;
} scan_t;

/* Not above any threshold at n; 6 digits. */
static uint32_t threshold_below(const scan_t *scan, uint32_t n)
{
    const uint32_t logarithm = (32U - davar_leading_zeros_32(n)) * LN_2_ABOVE;
    return (uint32_t)(davar_multiply_u32(scan->f, scan->best[0].threshold - logarithm) >> 22U);
}

static uint32_t smaller_part(const davar_stretch_t *stretch, const davar_spread_t *older)
{
    const uint32_t newer = stretch->sum.blocks - older->blocks;
    return (newer < older->blocks) ? newer : older->blocks;
}

/* A gain against the thresholds f (1 + 1 / (3 nu n)) (h - ln n); h is above ln n + 1. */
static void compare(scan_t *scan, int32_t gain, uint32_t n, uint32_t age, uint32_t level)
{
    const uint32_t logarithm = (uint32_t)davar_logarithm_of_count(n) >> 8U;
    const uint32_t bias = davar_divided(scan->config->bias, n);
    for (uint32_t i = 0U; i < scan->count; i++) {
        davar_split_t *const best = &scan->best[i];
        const uint32_t plain = (uint32_t)(davar_multiply_u32(scan->f, best->threshold - logarithm) >> 16U);
        const int32_t excess = gain - (int32_t)(plain + (uint32_t)(davar_multiply_u32(plain, bias) >> 16U));
        if (excess > best->excess) {
            best->excess = excess;
            best->gain = gain;
            best->age = age;
            best->level = level;
        }
    }
}

/* The split at `age`, where a record of this level is. */
static void ask(scan_t *scan, uint32_t age, uint32_t level)
{
    if (age >= glr_age(scan->state, scan->begin)) {
        return;
    }
    const davar_spread_t older =
        spread_between(&scan->begin->sum, glr_record(scan->state, level, scan->state->now.at - age));
    const uint32_t n = smaller_part(&scan->stretch, &older);
    if ((n >= scan->config->least) && davar_likelihood_may_reach(&scan->stretch, &older, threshold_below(scan, n))) {
        compare(scan, davar_likelihood_gain(&scan->stretch, &older), n, age, level);
    }
}

/* The level whose turn it is at a place that 2 divides: at 2^(l - 1) times an odd number it is l, so that no block asks two; `levels`
 * when it is none's. */
static uint32_t level_in_turn(uint32_t at, uint32_t levels)
{
    uint32_t level = 2U;
    while ((level < levels) && (((at >> (level - 1U)) & 1U) == 0U)) {
        level++;
    }
    return level;
}

static void ask_older(scan_t *scan)
{
    if ((scan->state->now.at & 1U) != 0U) {
        ask(scan, 5U, 1U);
        return;
    }
    ask(scan, 4U, 1U);
    const uint32_t level = level_in_turn(scan->state->now.at, scan->config->levels);
    if (level < scan->config->levels) {
        ask(scan, 3U << (level - 1U), level);
        ask(scan, 5U << (level - 1U), level);
    }
}

void davar_glr_scan(const davar_glr_t *state, const davar_glr_config_t *config, const davar_glr_place_t *begin,
                    davar_split_t *split, uint32_t count)
{
    const davar_spread_t sum = spread_between(&begin->sum, &state->now.sum);
    if (sum.blocks < (2U * config->least)) {
        return;
    }
    scan_t scan = {state, config, begin, {{0U, 0U, 0U}, 0, 0U, 0, 0U}, davar_glr_dispersion(state), split, count};
    davar_stretch(&scan.stretch, &sum, config->degrees);
    ask(&scan, 2U, 0U);
    ask(&scan, 3U, 0U);
    ask_older(&scan);
}
