/* davar - the scan of the likelihood ratio over dyadic ages. */
#include "track/scan.h"

#include "number/real.h"
#include "track/likelihood.h"

#define LN_2_ABOVE 45427U /* 16 digits */

/* What all splits of one scan share. */
typedef struct {
    const davar_glr_config_t *config;
    davar_stretch_t stretch;
    uint32_t f;
} scan_t;

/* f (1 + 1 / (3 nu n)) (h - ln n); h is above ln n + 1 */
static int32_t threshold_at(const scan_t *scan, uint32_t h, uint32_t n)
{
    const uint32_t logarithm = (uint32_t)davar_logarithm_of_count(n) >> 8U;
    const uint32_t plain = (uint32_t)(davar_multiply_u32(scan->f, h - logarithm) >> 16U);
    const uint32_t bias = davar_divided(scan->config->bias, n);
    return (int32_t)(plain + (uint32_t)(davar_multiply_u32(plain, bias) >> 16U));
}

/* Not above any threshold at n; 6 digits. */
static uint32_t threshold_below(const scan_t *scan, uint32_t h, uint32_t n)
{
    const uint32_t logarithm = (32U - davar_leading_zeros_32(n)) * LN_2_ABOVE;
    return (uint32_t)(davar_multiply_u32(scan->f, h - logarithm) >> 22U);
}

static uint32_t smaller_part(const davar_stretch_t *stretch, const davar_spread_t *older)
{
    const uint32_t newer = stretch->sum.blocks - older->blocks;
    return (newer < older->blocks) ? newer : older->blocks;
}

static void compare(const scan_t *scan, davar_split_t *split, int32_t gain, uint32_t n, uint32_t age, uint32_t level)
{
    const int32_t excess = gain - threshold_at(scan, split->threshold, n);
    if (excess > split->excess) {
        split->excess = excess;
        split->gain = gain;
        split->age = age;
        split->level = level;
    }
}

void davar_glr_scan(const davar_glr_t *state, const davar_glr_config_t *config, const davar_glr_place_t *begin,
                    davar_split_t *split, uint32_t count)
{
    const uint32_t at = state->now.at;
    const davar_spread_t sum = spread_between(&begin->sum, &state->now.sum);
    if (sum.blocks < (2U * config->least)) {
        return;
    }
    scan_t scan = {config, {{0U, 0U, 0U}, 0, 0U, 0, 0U}, davar_glr_dispersion(state)};
    davar_stretch(&scan.stretch, &sum, config->degrees);
    /* An age of 2^level was one of 2 * 2^(level - 1) an octave before; the last octave reaches beyond any beginning. */
    for (uint32_t level = 0U; ((at >> level) << level) == at; level++) {
        for (uint32_t c = GLR_RECORDS / 2U; c < GLR_RECORDS; c++) {
            const uint32_t age = c << level;
            if (age >= (at - begin->at)) {
                return;
            }
            const davar_spread_t older = spread_between(&begin->sum, glr_record(state, level, at - age));
            const uint32_t n = smaller_part(&scan.stretch, &older);
            if ((n < config->least) ||
                !davar_likelihood_may_reach(&scan.stretch, &older, threshold_below(&scan, split[0].threshold, n))) {
                continue;
            }
            const int32_t gain = davar_likelihood_gain(&scan.stretch, &older);
            for (uint32_t i = 0U; i < count; i++) {
                compare(&scan, &split[i], gain, n, age, level);
            }
        }
    }
}
