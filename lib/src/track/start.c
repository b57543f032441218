/* davar - from the rates that a user states to the thresholds of the detector. */
#include "number/ieee.h"
#include "number/real.h"
#include "number/scaled.h"
#include "track/glr.h"

#define OF_ALARM 78643          /* 1.2, 16 digits: c of the thresholds (10.6) */
#define OF_CUT 117965           /* 1.8 */
#define OF_CLUSTERS 65536       /* 1; fitted with the degrees below */
#define DEGREES_OF_CLUSTERS 97U /* 0.38, 8 digits */
#define MARGIN 65536            /* 1, 16 digits: a threshold stays so far above ln of the longest part */

static int32_t logarithm_of(double value)
{
    const scaled_t scaled = scaled_of_double(value);
    return davar_logarithm(scaled.mantissa, scaled.exponent);
}

/* ln(T rate / K) + c, T the seconds from one false decision to the next. */
static uint32_t threshold_of(double seconds, const davar_glr_wish_t *wish, int32_t c, uint32_t longest)
{
    const int32_t blocks = logarithm_of(seconds) + logarithm_of(wish->rate_hz) - davar_logarithm_of_count(wish->block);
    const int32_t h = (blocks / 256) + c;
    const int32_t least = (davar_logarithm_of_count(longest) / 256) + MARGIN;
    return (uint32_t)((h > least) ? h : least);
}

/* Blocks for as many samples, at least one. */
static uint32_t blocks_of(uint32_t samples, uint32_t block)
{
    return (samples > block) ? (samples / block) : 1U;
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
    config->alarm = threshold_of(davar_divide(3600.0, wish->false_alarms_per_hour), wish, OF_ALARM, config->longest);
    config->cut = threshold_of(wish->cut_interval_s, wish, OF_CUT, config->longest);
    config->cut = (config->cut < config->alarm) ? config->cut : config->alarm;
    config->step = davar_divided((nu * nu) << 14U, nu + 1U);
    config->step_of_8 = nu << 17U;
    config->bias = davar_divided(UINT32_C(1) << 16U, 3U * nu);
    config->near = blocks_of(150U, wish->block);
    config->far = blocks_of(600U, wish->block);
    config->half = wish->is_centred ? half_in_blocks(wish->block) : 0U;
}

/* Neighbours share three quarters of their samples: 0.38 degrees of freedom each, and 16 of them at least are a part. Sums of so many
 * samples are Gaussian whatever the samples are, so that nothing is to be learned of their scatter. */
void davar_glr_start_clusters(davar_glr_config_t *config, const davar_glr_wish_t *wish)
{
    const uint32_t m = 4U * wish->block;
    config->block = wish->block;
    config->degrees = DEGREES_OF_CLUSTERS;
    config->floor = m;
    config->least = 16U;
    config->longest = GLR_LONGEST;
    config->levels = GLR_LEVELS;
    config->shock = 0U;
    config->outlier = 0U;
    config->alarm = threshold_of(davar_divide(3600.0, wish->false_alarms_per_hour), wish, OF_CLUSTERS, GLR_LONGEST);
    config->cut = config->alarm;
    config->step = 0U;
    config->step_of_8 = 0U;
    config->bias = davar_divided(UINT32_C(1) << 24U, 3U * DEGREES_OF_CLUSTERS);
    config->near = 1U;
    config->far = 1U;
    config->half = 0U;
}
