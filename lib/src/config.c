/* davar - every reason to refuse a configuration, one small test each. */
#include "config.h"

#include "common/choice.h"
#include "number/real.h"
#include "track/glr.h"

const davar_config_t davar_default_config = {
    .mode = DAVAR_MODE_CENTRED,
    .policy = DAVAR_POLICY_OR,
    .window_max = 600U,
    .window_min = 400U,
    .segment = 100U,
    .kurtosis_low = 2.5,
    .kurtosis_high = 3.3,
    .contribution_low = 0.0,
    .contribution_high = 0.07,
    .grow = 2U,
    .shrink = 2U,
    .stride = 1U,
    .false_alarms_per_hour = 0.01,
    .cut_interval_s = 300.0,
    .block = 10U,
    .shock_blocks = 2U,
    .gaps_max = 4U,
};

/* Keeps every sum of a window length and a step inside 32 bits. */
#define STRIDE_MAX 16777216U

/* Of numbers from 0 on, by their bits, which rise with them; what is negative or NaN is beyond all. */
DAVAR_APART static bool is_between(double low, double value, double high)
{
    return (davar_bits_of_double(low) <= davar_bits_of_double(value)) &&
           (davar_bits_of_double(value) <= davar_bits_of_double(high));
}

/* Far enough inside the range of a double that no square of an Allan variance leaves it. */
DAVAR_APART static bool positive_finite(double value)
{
    return is_between(1e-50, value, 1e50);
}

DAVAR_APART static bool bounds_valid(double low, double high)
{
    return is_between(0.0, low, high) && is_between(0.0, high, 1e300);
}

static bool centred(const davar_config_t *config)
{
    return (config->mode == DAVAR_MODE_CENTRED) && (config->policy != DAVAR_POLICY_GLR);
}

static uint32_t sample_bits(const davar_config_t *config, const davar_number_t *number)
{
    return (config->sample_bits == 0U) ? number->sample_bits_default : config->sample_bits;
}

static davar_status_t check_scale(const davar_config_t *config, const davar_number_t *number, bool is_float)
{
    if (!positive_finite(config->rate_hz)) {
        return DAVAR_ERR_RATE;
    }
    if (is_float) {
        /* Float has room for the quantum and its inverse only well inside its range. */
        return is_between(1e-20, config->full_scale, 1e20) ? DAVAR_OK : DAVAR_ERR_SCALE;
    }
    if (!positive_finite(config->unit_per_count)) {
        return DAVAR_ERR_SCALE;
    }
    const uint32_t bits = sample_bits(config, number);
    return ((bits >= 2U) && (bits <= number->sample_bits_max)) ? DAVAR_OK : DAVAR_ERR_SAMPLE_BITS;
}

static davar_status_t check_window(const davar_config_t *config, const davar_number_t *number)
{
    const bool odd = ((config->window_max % 2U) != 0U) || ((config->window_min % 2U) != 0U);
    if ((config->window_max < 4U) || (config->window_max > number->window_max)) {
        return DAVAR_ERR_WINDOW_MAX;
    }
    if ((config->window_min == 0U) || (config->window_min > config->window_max)) {
        return DAVAR_ERR_WINDOW_MIN;
    }
    return (centred(config) && odd) ? DAVAR_ERR_WINDOW_ODD : DAVAR_OK;
}

static davar_status_t check_stationarity(const davar_config_t *config)
{
    const bool switched_off = (config->segment == 0U) && !is_judged(config);
    if ((config->segment >= config->window_min) || ((config->segment == 0U) && !switched_off)) {
        return DAVAR_ERR_SEGMENT;
    }
    if (!DAVAR_ADAPTIVE) {
        return DAVAR_OK;
    }
    if (!bounds_valid(config->kurtosis_low, config->kurtosis_high)) {
        return DAVAR_ERR_KURTOSIS;
    }
    if (!bounds_valid(config->contribution_low, config->contribution_high)) {
        return DAVAR_ERR_CONTRIBUTION;
    }
    return DAVAR_OK;
}

static bool step_valid(const davar_config_t *config, uint32_t step)
{
    return !centred(config) || (step == 0U) || (step == 2U);
}

static davar_status_t check_motion(const davar_config_t *config)
{
    if ((config->stride == 0U) || (config->stride > STRIDE_MAX)) {
        return DAVAR_ERR_STRIDE;
    }
    if (config->stride > config->window_max) {
        return DAVAR_ERR_STRIDE_LONG;
    }
    if (!step_valid(config, config->grow) || !step_valid(config, config->shrink)) {
        return DAVAR_ERR_STEP;
    }
    if (((uint32_t)config->engine > (uint32_t)DAVAR_ENGINE_EDGES) ||
        (has_tracker(config) && (config->engine == DAVAR_ENGINE_EDGES) &&
         ((config->stride > 1U) || looks_back(config)))) {
        return DAVAR_ERR_ENGINE;
    }
    const bool too_far = ((uint64_t)config->shrink * config->stride) > (uint64_t)INT32_MAX;
    return too_far ? DAVAR_ERR_SHRINK : DAVAR_OK;
}

/* On a grid a window of policy glr begins between two blocks: is one of window_min .. window_max samples among them at every epoch? */
static bool fits_between_blocks(const davar_config_t *config)
{
    const bool ends_between = ((config->stride % config->block) == 0U);
    const uint32_t longest = ends_between ? (config->window_max - (config->window_max % config->block))
                                          : (config->window_max - (config->block - 1U));
    return !has_grid(config) || (longest >= config->window_min);
}

static davar_status_t check_tracking(const davar_config_t *config)
{
    if (!has_tracker(config)) {
        return DAVAR_OK;
    }
    const bool rates =
        is_between(1e-9, config->false_alarms_per_hour, 1e9) && is_between(1e-9, config->cut_interval_s, 1e9);
    const bool blocks =
        (config->block >= GLR_BLOCK_MIN) && (config->block <= GLR_BLOCK_MAX) && (config->shock_blocks <= GLR_SHOCK_MAX);
    const bool window = blocks && ((config->window_max / 8U) >= config->block) &&
                        (config->window_max <= (GLR_LONGEST * config->block)) && fits_between_blocks(config);
    const bool clusters =
        (config->long_cluster <= GLR_CLUSTER_MAX) && blocks && ((config->long_cluster % (4U * config->block)) == 0U);
    const bool about = !looks_back(config) || (blocks && ((config->window_max / 2U) >= half_in_samples(config)));
    return (rates && clusters && window && about) ? DAVAR_OK : DAVAR_ERR_TRACKING;
}

/* Can window_max squares of a difference of m samples each overflow the sum (2.4)? */
static bool overflows(const davar_config_t *config, const davar_number_t *number, bool is_float, uint32_t m)
{
    const uint32_t bits = is_float ? DAVAR_FLOAT_BITS : sample_bits(config, number);
    const uint32_t room_bits = number->sum_bits - (2U * bits);
    const double squares = davar_scale(davar_double_of_u64((uint64_t)config->window_max * m), davar_double_of_u64(m));
    return davar_bits_of_double(squares) >= ((uint64_t)(1023U + room_bits) << 52U); /* 2^room_bits */
}

static davar_status_t check_taus(const davar_config_t *config, const davar_number_t *number, bool is_float)
{
    if ((config->tau_count == 0U) || (config->tau_count > DAVAR_TAUS_MAX)) {
        return DAVAR_ERR_TAU_COUNT;
    }
    for (uint32_t t = 1U; t < config->tau_count; t++) {
        if (config->taus[t] <= config->taus[t - 1U]) {
            return DAVAR_ERR_TAU_ORDER;
        }
    }
    const uint32_t largest = config->taus[config->tau_count - 1U];
    if (config->taus[0] == 0U) {
        return DAVAR_ERR_TAU_ZERO;
    }
    if (largest > (config->window_max / 2U)) {
        return DAVAR_ERR_TAU_LONG;
    }
    return overflows(config, number, is_float, largest) ? DAVAR_ERR_TAU_OVERFLOW : DAVAR_OK;
}

static bool needs_grid(const davar_config_t *config)
{
    const bool about = (config->mode == DAVAR_MODE_CENTRED) && (config->policy == DAVAR_POLICY_GLR);
    return (config->engine == DAVAR_ENGINE_GRID) && ((config->stride > 1U) || about);
}

static bool is_built(const davar_config_t *config)
{
    return (!needs_grid(config) || DAVAR_GRID) && (DAVAR_CENTRED || (config->mode != DAVAR_MODE_CENTRED)) &&
           (DAVAR_ADAPTIVE || ((config->policy == DAVAR_POLICY_FIXED) && (config->segment == 0U))) &&
           (DAVAR_TRACKING || (config->policy != DAVAR_POLICY_GLR));
}

DAVAR_RARE davar_status_t davar_config_check(const davar_config_t *config, const davar_number_t *number, bool is_float)
{
    if ((config == NULL) || (config->taus == NULL)) {
        return DAVAR_ERR_NULL;
    }
    if (!is_built(config)) {
        return DAVAR_ERR_BUILD;
    }
    davar_status_t status = check_scale(config, number, is_float);
    if ((status == DAVAR_OK) && (config->mode != DAVAR_MODE_CENTRED) && (config->mode != DAVAR_MODE_TRAILING)) {
        status = DAVAR_ERR_MODE;
    }
    if ((status == DAVAR_OK) && ((uint32_t)config->policy > (uint32_t)DAVAR_POLICY_GLR)) {
        status = DAVAR_ERR_POLICY;
    }
    if (status == DAVAR_OK) {
        status = check_window(config, number);
    }
    if (status == DAVAR_OK) {
        status = check_stationarity(config);
    }
    if (status == DAVAR_OK) {
        status = check_motion(config);
    }
    if (status == DAVAR_OK) {
        status = check_tracking(config);
    }
    return (status == DAVAR_OK) ? check_taus(config, number, is_float) : status;
}
