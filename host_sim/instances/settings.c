/* davar-sim - configuration. */
#include "instances/settings.h"

#define TABLE_ROWS_PER_WINDOW 8U /* for a person to read */

/* Devices compute trailing windows, and law glr has no others. */
static bool is_centred(const options_t *options)
{
    const bool is_usual = (options->setup.law != DAVAR_LAW_ID_GLR) && (options->device == NULL);
    return (options->mode == MODE_CENTRED) && (is_usual || options->mode_given);
}

static bool check_torn(const options_t *options, sim_error_t *error)
{
    return !options->setup.skips_torn ||
           ((options->setup.lsb > 0.0) && (options->arith == ARITH_FIXED)) ||
           sim_fail(error, "--skip-torn-reads: a torn read is off by a power of two in counts: "
                           "give --lsb, and not --arith float");
}

/* A centred window grows by a sample at each end. */
bool settings_make(settings_t *settings, const options_t *options, sim_error_t *error)
{
    davar_config_t *const config = &settings->config;
    const bool good = setup_configure(&options->setup, config, settings->taus, error);
    if ((options->out == OUT_TABLE) && !options->setup.stride.given) {
        const uint32_t stride = config->window.longest / TABLE_ROWS_PER_WINDOW;
        config->stride = (stride > 0U) ? stride : 1U;
    }
    settings->is_centred = is_centred(options);
    config->full_scale = (options->full_scale > 0.0) ? options->full_scale : 1.0;
    if (settings->is_centred && !options->setup.grow.given) {
        config->window.grow = 2U;
    }
    /* A grid stores the gaps of the newest window and of the next one. At most one gap precedes
     * each sample. */
    config->window.gaps_max = (config->window.longest < (UINT16_MAX / 2U))
                                  ? (uint16_t)(2U * config->window.longest)
                                  : UINT16_MAX;
    return good && check_torn(options, error) && settings_check(settings, options, error);
}

static bool is_centred_step(uint32_t samples)
{
    return (samples == 0U) || (samples == 2U);
}

/* The rules of centred windows, which the library does not know. */
static bool check_centred(const davar_config_t *config, sim_error_t *error)
{
    if (davar_law_id(config) == DAVAR_LAW_ID_GLR) {
        return sim_fail(error, "--mode centred: not for --law glr, whose windows end at the "
                               "newest sample; give --mode trailing, or another law");
    }
    if (((config->window.longest % 2U) != 0U) || ((config->window.shortest % 2U) != 0U)) {
        return sim_fail(error, "--window-max or --window-min: window_max or window_min odd in "
                               "centred mode");
    }
    return (is_centred_step(config->window.grow) && is_centred_step(config->window.shrink)) ||
           sim_fail(error, "--grow or --shrink: grow or shrink would move a window edge backwards "
                           "(centred: 0 or 2)");
}

/* The widest count that quantise_plan may choose; 0 leaves it to the type. */
static uint8_t widest_count(const options_t *options)
{
    if (options->arith == ARITH_FLOAT) {
        return 0U;
    }
    return (options->setup.lsb > 0.0) ? (uint8_t)options->bits : 32U;
}

bool settings_check(const settings_t *settings, const options_t *options, sim_error_t *error)
{
    davar_config_t config = settings->config;
    config.sample_bits = widest_count(options);
    return setup_check(&config, options->arith == ARITH_FLOAT, error) &&
           (!settings->is_centred || check_centred(&config, error));
}

/* Centred: half a window gives the first epoch, because the ends are mirrored. Trailing: the
 * shortest window gives it. In both cases the first epoch is the last sample of a stride. */
uint64_t settings_samples_needed(const settings_t *settings)
{
    const davar_config_t *const config = &settings->config;
    const uint64_t stride = config->stride;
    if (!settings->is_centred) {
        return (config->window.shortest + stride - 1U) / stride * stride;
    }
    const uint64_t half = config->window.longest / 2U;
    return (half > stride) ? half : stride;
}
