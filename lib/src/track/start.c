/* davar - from the rates that a user states to the thresholds of the detector. */
#include "number/ieee.h"
#include "number/real.h"
#include "number/scaled.h"
#include "track/glr.h"

#define FIRST 81920U  /* 1.25, 16 digits: c of the thresholds for blocks of 25 and four records an octave (7.2) */
#define PER_LN 23637U /* 0.25 / ln 2, 16 digits */
#define MARGIN 65536U /* 1, 16 digits: a threshold stays so far above ln of the longest part */

static int32_t logarithm_of(double value)
{
    const scaled_t scaled = scaled_of_double(value);
    return davar_logarithm(scaled.mantissa, scaled.exponent);
}

/* ln(T rate / K) + 1.25 + 0.25 log2(25 / K), T the seconds from one false decision to the next. */
static uint32_t threshold_of(double seconds, double rate_hz, uint32_t block, uint32_t longest)
{
    const int32_t of_block = davar_logarithm_of_count(block);
    const int32_t blocks = logarithm_of(seconds) + logarithm_of(rate_hz) - of_block;
    const int32_t correction = (davar_logarithm_of_count(25U) - of_block) / 256;
    const int32_t h = (blocks / 256) + (int32_t)FIRST + (int32_t)(((int64_t)correction * (int32_t)PER_LN) / 65536);
    const int32_t least = (davar_logarithm_of_count(longest) / 256) + (int32_t)MARGIN;
    return (uint32_t)((h > least) ? h : least);
}

static uint32_t levels_for(uint32_t longest)
{
    uint32_t levels = 1U;
    while ((levels < GLR_LEVELS) && (((GLR_RECORDS - 1U) << (levels - 1U)) < longest)) {
        levels++;
    }
    return levels;
}

void davar_glr_start(davar_glr_config_t *config, const davar_glr_wish_t *wish)
{
    const uint32_t nu = wish->block - 1U;
    const uint32_t longest = wish->longest / wish->block;
    config->block = wish->block;
    config->degrees = nu << 8U;
    config->floor = wish->block * nu;
    config->least = 2U;
    config->longest = (longest < GLR_LONGEST) ? longest : GLR_LONGEST;
    config->levels = levels_for(config->longest);
    config->shock = wish->shock;
    config->outlier = (wish->block < 18U) ? 1280U : 768U; /* 5 or 3 */
    config->alarm =
        threshold_of(davar_divide(3600.0, wish->false_alarms_per_hour), wish->rate_hz, wish->block, config->longest);
    config->cut = threshold_of(wish->cut_interval_s, wish->rate_hz, wish->block, config->longest);
    config->cut = (config->cut < config->alarm) ? config->cut : config->alarm;
    config->step = davar_divided((nu * nu) << 14U, nu + 1U);
    config->step_of_8 = nu << 17U;
    config->bias = davar_divided(UINT32_C(1) << 16U, 3U * nu);
}
