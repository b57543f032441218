/* davar - every reason to reject a configuration, one small check each.
 * The order is that of davar_status_t. */
#include "davar/davar.h"

#include "core/engine.h"
#include "core/instance.h"
#include "core/window.h"
#include "number/quantum.h"
#include "number/real.h"

const davar_config_t davar_default_config = {
    DAVAR_SONG(600, 400),
    .stride = 1U,
    .glr = {.false_alarms_per_hour = 0.01,
            .cut_interval_s = 300.0,
            .block = 10U,
            .shock_blocks = 2U},
};

/* Keeps every sum of a window length and a step inside 32 bits. */
#define STRIDE_MAX 16777216U

/* The square of an Allan variance of such values stays in the range of a double. */
DAVAR_APART static bool positive_finite(double value)
{
    return davar_is_between(1e-50, value, 1e50);
}

DAVAR_APART static bool bounds_valid(double low, double high)
{
    return davar_is_between(0.0, low, high) && davar_is_between(0.0, high, 1e300);
}

static uint32_t sample_bits(const davar_config_t *config, const davar_number_t *number)
{
    return (config->sample_bits == 0U) ? number->sample_bits_default : config->sample_bits;
}

static davar_status_t check_scale(const davar_config_t *config, const davar_number_t *number,
                                  bool is_float)
{
    if (!positive_finite(config->rate_hz)) {
        return DAVAR_ERR_RATE;
    }
    if (is_float) {
        /* A float must hold the quantum and its inverse. */
        return davar_is_between(1e-20, config->full_scale, 1e20) ? DAVAR_OK : DAVAR_ERR_SCALE;
    }
    if (!positive_finite(config->unit_per_count)) {
        return DAVAR_ERR_SCALE;
    }
    const uint32_t bits = sample_bits(config, number);
    return ((bits >= 2U) && (bits <= number->sample_bits_max)) ? DAVAR_OK : DAVAR_ERR_SAMPLE_BITS;
}

static davar_status_t check_window(const davar_config_t *config, const davar_number_t *number)
{
    if ((config->window.longest < 4U) || (config->window.longest > number->window_max)) {
        return DAVAR_ERR_WINDOW_MAX;
    }
    const bool shortest_fits =
        (config->window.shortest != 0U) && (config->window.shortest <= config->window.longest);
    return shortest_fits ? DAVAR_OK : DAVAR_ERR_WINDOW_MIN;
}

static davar_status_t check_stationarity(const davar_config_t *config)
{
    const bool switched_off =
        (config->moments.segment == 0U) && !(has_law(config) && config->law->wants_moments);
    if ((config->moments.segment >= config->window.shortest) ||
        ((config->moments.segment == 0U) && !switched_off)) {
        return DAVAR_ERR_SEGMENT;
    }
    if (!DAVAR_LAWS) {
        return DAVAR_OK;
    }
    if (!bounds_valid(config->moments.kurtosis_low, config->moments.kurtosis_high)) {
        return DAVAR_ERR_KURTOSIS;
    }
    if (!bounds_valid(config->moments.contribution_low, config->moments.contribution_high)) {
        return DAVAR_ERR_CONTRIBUTION;
    }
    return DAVAR_OK;
}

static davar_status_t check_motion(const davar_config_t *config, const davar_number_t *number)
{
    if ((config->stride == 0U) || (config->stride > STRIDE_MAX)) {
        return DAVAR_ERR_STRIDE;
    }
    if (config->stride > config->window.longest) {
        return DAVAR_ERR_STRIDE_LONG;
    }
    if ((config->engine != NULL) && (config->engine->number != number)) {
        return DAVAR_ERR_ENGINE;
    }
    const bool too_far = ((uint64_t)config->window.shrink * config->stride) > (uint64_t)INT32_MAX;
    return too_far ? DAVAR_ERR_SHRINK : DAVAR_OK;
}

/* Can window.longest squares of a difference of m samples each overflow the sum (2.4)? */
static bool overflows(const davar_config_t *config, const davar_number_t *number, bool is_float,
                      uint32_t m)
{
    const uint32_t bits = is_float ? DAVAR_FLOAT_BITS : sample_bits(config, number);
    const uint32_t room_bits = number->sum_bits - (2U * bits);
    const double squares = davar_scale(davar_double_of_u64((uint64_t)config->window.longest * m),
                                       davar_double_of_u64(m));
    return davar_bits_of_double(squares) >=
           ((uint64_t)(1023U + room_bits) << 52U); /* 2^room_bits */
}

static davar_status_t check_taus(const davar_config_t *config, const davar_number_t *number,
                                 bool is_float)
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
    if (largest > (config->window.longest / 2U)) {
        return DAVAR_ERR_TAU_LONG;
    }
    return overflows(config, number, is_float, largest) ? DAVAR_ERR_TAU_OVERFLOW : DAVAR_OK;
}

static bool is_built(const davar_config_t *config)
{
    const bool needs_laws = (config->law != NULL) || (config->moments.segment != 0U);
    return DAVAR_LAWS || !needs_laws;
}

static davar_status_t check_law(const davar_config_t *config, const davar_number_t *number)
{
    const bool checks = has_law(config) && (config->law->check != NULL);
    return checks ? config->law->check(config, number) : DAVAR_OK;
}

DAVAR_RARE davar_status_t davar_config_check(const davar_config_t *config,
                                             const davar_number_t *number, bool is_float)
{
    if ((config == NULL) || (config->taus == NULL)) {
        return DAVAR_ERR_NULL;
    }
    if (!is_built(config)) {
        return DAVAR_ERR_BUILD;
    }
    davar_status_t status = check_scale(config, number, is_float);
    if (status == DAVAR_OK) {
        status = check_window(config, number);
    }
    if (status == DAVAR_OK) {
        status = check_stationarity(config);
    }
    if (status == DAVAR_OK) {
        status = check_motion(config, number);
    }
    if (status == DAVAR_OK) {
        status = check_law(config, number);
    }
    return (status == DAVAR_OK) ? check_taus(config, number, is_float) : status;
}

/* --- the reasons as text ---------------------------------------------------------------------- */

#define COUNT_OF(array) (sizeof(array) / sizeof((array)[0]))

const char *davar_status_text(davar_status_t status)
{
    static const char *const text[] = {
        [DAVAR_OK] = "ok",
        [DAVAR_ERR_NULL] = "a pointer is null (cluster sizes among them)",
        [DAVAR_ERR_BUILD] = "disabled in this build",
        [DAVAR_ERR_MEMORY_SIZE] = "memory too small for this configuration",
        [DAVAR_ERR_MEMORY_ALIGN] = "memory not aligned to 8 bytes",
        [DAVAR_ERR_RATE] = "sample rate not a positive number in range",
        [DAVAR_ERR_SCALE] = "size of a count, or full scale, not a positive number in range",
        [DAVAR_ERR_SAMPLE_BITS] = "width of a count outside what the number type holds",
        [DAVAR_ERR_LAW] = "law of another number type",
        [DAVAR_ERR_WINDOW_MAX] = "longest window below 4 samples, or too long for the number type",
        [DAVAR_ERR_WINDOW_MIN] = "shortest window 0, or above the longest",
        [DAVAR_ERR_SEGMENT] =
            "short segment not below the shortest window, or 0 (fixed window and law glr only)",
        [DAVAR_ERR_KURTOSIS] = "kurtosis bounds negative, not finite, or low above high",
        [DAVAR_ERR_CONTRIBUTION] = "contribution bounds negative, not finite, or low above high",
        [DAVAR_ERR_SHRINK] = "shrinkage above 2^31 samples per stride",
        [DAVAR_ERR_STRIDE] = "stride 0 or above 2^24",
        [DAVAR_ERR_STRIDE_LONG] =
            "stride above the longest window: samples between two windows would never count",
        [DAVAR_ERR_ENGINE] = "engine of another number type",
        [DAVAR_ERR_TRACKING] = "law glr: block, shock, window, stride or rate out of range",
        [DAVAR_ERR_TAU_COUNT] = "no cluster size, or more than this build has room for",
        [DAVAR_ERR_TAU_ORDER] = "cluster sizes not strictly ascending",
        [DAVAR_ERR_TAU_ZERO] = "cluster size 0",
        [DAVAR_ERR_TAU_LONG] = "twice the longest cluster size is above the longest window",
        [DAVAR_ERR_TAU_OVERFLOW] =
            "longest window and cluster size too large for the exact sums of this number type",
    };
    const bool known = ((size_t)status < COUNT_OF(text)) && (text[status] != NULL);
    return known ? text[status] : "unknown status";
}
