/* davar-sim - configuration. Defaults follow window_max in the proportions of the paper, 600 : 400
 * : 100. */
#include "instances/settings.h"

#include "davar/davar.h"

#include <inttypes.h>
#include <stdio.h>

#define GLR_BLOCKS 600U

static uint32_t either(const optional_u32_t *option, uint32_t otherwise)
{
    return option->given ? option->value : otherwise;
}

/* Devices compute trailing windows, and law glr has no others. */
static bool is_centred(const options_t *options)
{
    const bool is_usual = (options->law != DAVAR_LAW_ID_GLR) && (options->device == NULL);
    return (options->mode == MODE_CENTRED) && (is_usual || options->mode_given);
}

static uint32_t at_least_1(uint32_t value)
{
    return (value > 1U) ? value : 1U;
}

static void set_window(davar_config_t *config, const options_t *options)
{
    if (options->window_max.given) {
        const uint32_t longest = options->window_max.value;
        config->window.longest = longest;
        config->window.shortest = (uint32_t)((uint64_t)longest * 2U / 3U) & ~UINT32_C(1);
        config->moments.segment = at_least_1(longest / 6U);
    }
    config->window.shortest = either(&options->window_min, config->window.shortest);
    config->moments.segment = either(&options->segment, config->moments.segment);
}

/* Law glr: the longest window has 600 blocks, the shortest has two, and there are no moments. */
static void set_tracking(davar_config_t *config, const options_t *options)
{
    if (options->law != DAVAR_LAW_ID_GLR) {
        return;
    }
    config->glr.block = either(&options->block, config->glr.block);
    config->glr.shock_blocks = either(&options->shock_blocks, config->glr.shock_blocks);
    if (options->false_alarms_per_hour > 0.0) {
        config->glr.false_alarms_per_hour = options->false_alarms_per_hour;
    }
    if (options->cut_interval_s > 0.0) {
        config->glr.cut_interval_s = options->cut_interval_s;
    }
    config->window.longest = either(&options->window_max, GLR_BLOCKS * config->glr.block);
    config->window.shortest = either(&options->window_min, 2U * config->glr.block);
    config->moments.segment = either(&options->segment, 0U);
    config->window.grow = either(&options->grow, 1U);
}

/* A trailing window grows by the newest sample, a centred one by a sample at each end. */
static void set_steps(settings_t *settings, const options_t *options)
{
    davar_config_t *const config = &settings->config;
    config->window.grow = either(&options->grow, settings->is_centred ? 2U : config->window.grow);
    config->window.shrink = either(&options->shrink, config->window.shrink);
    config->stride = either(&options->stride, config->stride);
    config->engine = davar_engine_of(options->uses_grid, true);
}

static void set_bounds(davar_config_t *config, const options_t *options)
{
    if (options->kurtosis.given) {
        config->moments.kurtosis_low = options->kurtosis.low;
        config->moments.kurtosis_high = options->kurtosis.high;
    }
    if (options->contribution.given) {
        config->moments.contribution_low = options->contribution.low;
        config->moments.contribution_high = options->contribution.high;
    }
}

static void set_taus(settings_t *settings, const options_t *options)
{
    davar_config_t *config = &settings->config;
    config->taus = settings->taus;
    switch (options->taus_kind) {
    case TAUS_LIST:
        config->tau_count = (uint8_t)options->tau_count;
        for (size_t t = 0; t < options->tau_count; t++) {
            settings->taus[t] = options->taus[t];
        }
        break;
    case TAUS_GEOMETRIC:
        config->tau_count = davar_taus_geometric(
            config->window.longest, (uint8_t)options->taus_wanted, settings->taus, DAVAR_TAUS_MAX);
        break;
    case TAUS_OCTAVE:
    default:
        config->tau_count =
            davar_taus_octave(config->window.longest, settings->taus, DAVAR_TAUS_MAX);
        break;
    }
}

static bool check_unstable_rate(const options_t *options, sim_error_t *error)
{
    if (!(options->unstable_rate > 0.0)) {
        return true;
    }
    if (options->kurtosis.given || options->contribution.given) {
        return sim_fail(error, "--unstable-rate: sets the ranges of --kurtosis and --contribution; "
                               "give either it or them");
    }
    return (options->law != DAVAR_LAW_ID_GLR) ||
           sim_fail(error, "--unstable-rate: not for --law glr, which has "
                           "--false-alarms-per-hour");
}

static bool check_torn(const options_t *options, sim_error_t *error)
{
    return !options->skips_torn || ((options->lsb > 0.0) && (options->arith == ARITH_FIXED)) ||
           sim_fail(error, "--skip-torn-reads: a torn read is off by a power of two in counts: "
                           "give --lsb, and not --arith float");
}

bool settings_make(settings_t *settings, const options_t *options, sim_error_t *error)
{
    davar_config_t *config = &settings->config;
    *config = davar_default_config;
    settings->is_centred = is_centred(options);
    config->rate_hz = (options->rate_hz > 0.0) ? options->rate_hz : 1.0;
    config->unit_per_count = (options->lsb > 0.0) ? options->lsb : 1.0;
    config->full_scale = (options->full_scale > 0.0) ? options->full_scale : 1.0;
    config->law = davar_law_of_id(options->law, true);
    set_window(config, options);
    set_steps(settings, options);
    set_bounds(config, options);
    set_tracking(config, options);
    set_taus(settings, options);
    /* A grid stores the gaps of the newest window and of the next one. At most one gap precedes
     * each sample. */
    config->window.gaps_max = (config->window.longest < (UINT16_MAX / 2U))
                                  ? (uint16_t)(2U * config->window.longest)
                                  : UINT16_MAX;
    return check_unstable_rate(options, error) && check_torn(options, error) &&
           settings_check(settings, options, error);
}

static bool is_centred_step(uint32_t samples)
{
    return (samples == 0U) || (samples == 2U);
}

/* The rules of centred windows, which the library does not know. */
static bool check_centred(const davar_config_t *config, sim_error_t *error)
{
    if ((config->law != NULL) && (config->law->push != NULL)) {
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
    return (options->lsb > 0.0) ? (uint8_t)options->bits : 32U;
}

/* davar_init_* checks the configuration before the memory. Without memory, "too small" therefore
 * means that the configuration is accepted. */
bool settings_check(const settings_t *settings, const options_t *options, sim_error_t *error)
{
    davar_t probe;
    uint64_t no_memory[1] = {0};
    davar_config_t config = settings->config;
    config.sample_bits = widest_count(options);
    const davar_status_t status = (options->arith == ARITH_FLOAT)
                                      ? davar_init_f32(&probe, &config, no_memory, 0)
                                      : davar_init_q31(&probe, &config, no_memory, 0);
    if ((status != DAVAR_OK) && (status != DAVAR_ERR_MEMORY_SIZE)) {
        return settings_fail(status, options, error);
    }
    return !settings->is_centred || check_centred(&config, error);
}

/* The option that caused a status; "internal" if no option did. */
static const char *option_of(davar_status_t status, const options_t *options)
{
    static const char *const OPTION[] = {
        [DAVAR_ERR_RATE] = "--rate",
        [DAVAR_ERR_SCALE] = "--lsb",
        [DAVAR_ERR_SAMPLE_BITS] = "--bits",
        [DAVAR_ERR_LAW] = "--law",
        [DAVAR_ERR_WINDOW_MAX] = "--window-max",
        [DAVAR_ERR_WINDOW_MIN] = "--window-min",
        [DAVAR_ERR_SEGMENT] = "--segment",
        [DAVAR_ERR_KURTOSIS] = "--kurtosis",
        [DAVAR_ERR_CONTRIBUTION] = "--contribution",
        [DAVAR_ERR_SHRINK] = "--shrink",
        [DAVAR_ERR_STRIDE] = "--stride",
        [DAVAR_ERR_STRIDE_LONG] = "--stride or --window-max",
        [DAVAR_ERR_ENGINE] = "--engine",
        [DAVAR_ERR_TRACKING] = "--law glr",
        [DAVAR_ERR_TAU_COUNT] = "--taus",
        [DAVAR_ERR_TAU_ORDER] = "--taus",
        [DAVAR_ERR_TAU_ZERO] = "--taus",
        [DAVAR_ERR_TAU_LONG] = "--taus",
        [DAVAR_ERR_TAU_OVERFLOW] = "--taus or --window-max",
    };
    if ((status == DAVAR_ERR_SCALE) && (options->arith == ARITH_FLOAT)) {
        return "--full-scale";
    }
    const bool known =
        ((size_t)status < sizeof OPTION / sizeof OPTION[0]) && (OPTION[status] != NULL);
    return known ? OPTION[status] : "internal";
}

bool settings_fail(davar_status_t status, const options_t *options, sim_error_t *error)
{
    return sim_fail(error, "%s: %s", option_of(status, options), davar_status_text(status));
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
