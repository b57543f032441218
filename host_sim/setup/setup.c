/* davar programs - the configuration. Defaults follow window_max in the proportions of the paper,
 * 600 : 400 : 100. */
#include "setup/setup.h"

#include "davar/davar.h"
#include "davar/fit.h"

#include <math.h>
#include <string.h>

#define GLR_BLOCKS 600U

/* A rate that follows from time stamps differs in its last digits from the nominal one. A size
 * that is longer by this factor is not too long. */
#define REACHES (1.0 + 1e-6)

static uint32_t either(const optional_u32_t *option, uint32_t otherwise)
{
    return option->given ? option->value : otherwise;
}

static double positive(double value, double otherwise)
{
    return (value > 0.0) ? value : otherwise;
}

static uint32_t at_least_1(uint32_t value)
{
    return (value > 1U) ? value : 1U;
}

static void set_window(davar_config_t *config, const setup_t *setup)
{
    if (setup->window_max.given) {
        const uint32_t longest = setup->window_max.value;
        config->window.longest = longest;
        config->window.shortest = (uint32_t)((uint64_t)longest * 2U / 3U) & ~UINT32_C(1);
        config->moments.segment = at_least_1(longest / 6U);
    }
    config->window.shortest = either(&setup->window_min, config->window.shortest);
    config->moments.segment = either(&setup->segment, config->moments.segment);
    config->window.grow = either(&setup->grow, config->window.grow);
    config->window.shrink = either(&setup->shrink, config->window.shrink);
}

/* Law glr: the longest window has 600 blocks, the shortest has two, and there are no moments. */
static void set_tracking(davar_config_t *config, const setup_t *setup)
{
    config->glr.block = either(&setup->block, config->glr.block);
    config->glr.shock_blocks = either(&setup->shock_blocks, config->glr.shock_blocks);
    config->glr.false_alarms_per_hour =
        positive(setup->false_alarms_per_hour, config->glr.false_alarms_per_hour);
    config->glr.cut_interval_s = positive(setup->cut_interval_s, config->glr.cut_interval_s);
    config->window.longest = either(&setup->window_max, GLR_BLOCKS * config->glr.block);
    config->window.shortest = either(&setup->window_min, 2U * config->glr.block);
    config->moments.segment = either(&setup->segment, 0U);
}

static void set_bounds(davar_config_t *config, const setup_t *setup)
{
    if (setup->kurtosis.given) {
        config->moments.kurtosis_low = setup->kurtosis.low;
        config->moments.kurtosis_high = setup->kurtosis.high;
    }
    if (setup->contribution.given) {
        config->moments.contribution_low = setup->contribution.low;
        config->moments.contribution_high = setup->contribution.high;
    }
}

static void set_taus(davar_config_t *config, uint32_t *taus, const setup_t *setup)
{
    config->taus = taus;
    switch (setup->taus_kind) {
    case TAUS_LIST:
        config->tau_count = (uint8_t)setup->tau_count;
        for (size_t t = 0; t < setup->tau_count; t++) {
            taus[t] = setup->taus[t];
        }
        break;
    case TAUS_GEOMETRIC:
        config->tau_count = davar_taus_geometric(config->window.longest,
                                                 (uint8_t)setup->taus_wanted, taus, DAVAR_TAUS_MAX);
        break;
    case TAUS_OCTAVE:
    default:
        config->tau_count = davar_taus_octave(config->window.longest, taus, DAVAR_TAUS_MAX);
        break;
    }
}

static bool check_unstable_rate(const setup_t *setup, sim_error_t *error)
{
    if (!(setup->unstable_rate > 0.0)) {
        return true;
    }
    if (setup->kurtosis.given || setup->contribution.given) {
        return sim_fail(error, "--unstable-rate: sets the ranges of --kurtosis and --contribution; "
                               "give either it or them");
    }
    return (setup->law != DAVAR_LAW_ID_GLR) ||
           sim_fail(error, "--unstable-rate: not for --law glr, which has "
                           "--false-alarms-per-hour");
}

bool setup_configure(const setup_t *setup, davar_config_t *config, uint32_t *taus,
                     sim_error_t *error)
{
    *config = davar_default_config;
    config->rate_hz = positive(setup->rate_hz, 1.0);
    config->unit_per_count = positive(setup->lsb, 1.0);
    config->law = davar_law_of_id(setup->law, true);
    config->stride = either(&setup->stride, config->stride);
    config->engine = davar_grid_of(setup->engine == ENGINE_GRID, true);
    set_window(config, setup);
    set_bounds(config, setup);
    if (setup->law == DAVAR_LAW_ID_GLR) {
        set_tracking(config, setup);
    }
    set_taus(config, taus, setup);
    return check_unstable_rate(setup, error);
}

/* davar_init_* checks the configuration before the memory. Without memory, "too small" therefore
 * means that the configuration is accepted. */
bool setup_check(const davar_config_t *config, bool is_float, sim_error_t *error)
{
    davar_t probe;
    uint64_t no_memory[1] = {0};
    const davar_status_t status = is_float ? davar_init_f32(&probe, config, no_memory, 0)
                                           : davar_init_q31(&probe, config, no_memory, 0);
    return (status == DAVAR_OK) || (status == DAVAR_ERR_MEMORY_SIZE) ||
           setup_fail(status, is_float, error);
}

/* The option that caused a status; "internal" if no option did. */
static const char *option_of(davar_status_t status, bool is_float)
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
    if ((status == DAVAR_ERR_SCALE) && is_float) {
        return "--full-scale";
    }
    const bool known =
        ((size_t)status < sizeof OPTION / sizeof OPTION[0]) && (OPTION[status] != NULL);
    return known ? OPTION[status] : "internal";
}

bool setup_fail(davar_status_t status, bool is_float, sim_error_t *error)
{
    return sim_fail(error, "%s: %s", option_of(status, is_float), davar_status_text(status));
}

bool setup_read_filter(setup_t *setup, const char *text, const char *other, sim_error_t *error)
{
    davar_filter_t filter;
    const char *const expected = bandwidth_read(text, 0.0, &filter);
    if (expected != NULL) {
        return sim_fail(error, "--bandwidth: expected %s%s, found '%s'", expected, other, text);
    }
    if (strlen(text) >= sizeof setup->filter) {
        return sim_fail(error, "--bandwidth: at most %u characters expected, found %zu",
                        SETUP_FILTER - 1U, strlen(text));
    }
    memcpy(setup->filter, text, strlen(text) + 1U);
    return true;
}

bool setup_filter(const setup_t *setup, double rate_hz, davar_filter_t *filter, sim_error_t *error)
{
    const char *const expected = bandwidth_read(setup->filter, rate_hz, filter);
    return (expected == NULL) ||
           sim_fail(error, "--bandwidth: expected %s (samples at %g Hz), found '%s'", expected,
                    rate_hz, setup->filter);
}

void setup_adapt(const setup_t *setup, davar_config_t *config, const davar_filter_t *filter)
{
    if ((filter != NULL) && (setup->law == DAVAR_LAW_ID_GLR)) {
        davar_whiten(config, filter);
    }
    if (setup->unstable_rate > 0.0) {
        davar_bound_unstable_rate(config, setup->unstable_rate, filter);
    }
}

/* The largest number of sizes of a cascade in addition to the window's; 0: no cascade fits. */
static uint8_t most_cascade_taus(const davar_config_t *config, davar_port_number_t number)
{
    uint8_t most = 0U;
    for (uint8_t n = 1U; (config->tau_count + n) <= DAVAR_TAUS_MAX; n++) {
        davar_curve_t curve;
        davar_cascade_t probe;
        uint64_t no_memory[1] = {0U};
        davar_curve_make(&curve, config, n); /* init checks the memory after everything else */
        if (davar_curve_start(&curve, number, &probe, no_memory, 0U) !=
            DAVAR_CASCADE_ERR_MEMORY_SIZE) {
            break;
        }
        most = n;
    }
    return most;
}

static bool fail_longest_tau(const davar_config_t *config, double first_s, uint8_t most,
                             double longest_s, sim_error_t *error)
{
    const uint32_t last = config->taus[config->tau_count - 1U];
    if ((most == 0U) && (config->tau_count == DAVAR_TAUS_MAX)) {
        return sim_fail(error,
                        "--longest-tau: at most %d cluster sizes of the window expected, found %u",
                        DAVAR_TAUS_MAX - 1, config->tau_count);
    }
    if (most == 0U) {
        return sim_fail(error,
                        "--longest-tau: a largest cluster size of the window up to 131070 samples "
                        "expected, found %u",
                        last);
    }
    return sim_fail(error,
                    "--longest-tau: from %.9g s to less than %.9g s expected at %.9g Hz after a "
                    "window with cluster sizes up to %u samples, found %.9g s",
                    first_s, ldexp(first_s, most), config->rate_hz, last, longest_s);
}

bool setup_curve(const setup_t *setup, const davar_config_t *config, davar_port_number_t number,
                 davar_curve_t *curve, sim_error_t *error)
{
    davar_curve_make(curve, config, 0U);
    if (!(setup->longest_tau_s > 0.0)) {
        return true;
    }
    const double first_s = (double)curve->cascade.shortest / config->rate_hz;
    const uint8_t most = most_cascade_taus(config, number);
    uint8_t count = 0U;
    while ((count <= most) && (ldexp(first_s, count) <= setup->longest_tau_s * REACHES)) {
        count++;
    }
    davar_curve_make(curve, config, (count <= most) ? count : 0U);
    return ((count > 0U) && (count <= most)) ||
           fail_longest_tau(config, first_s, most, setup->longest_tau_s, error);
}

bool setup_floor(const davar_config_t *config, davar_port_number_t number,
                 const davar_filter_t *filter, const char *name, davar_floor_plan_t *plan,
                 sim_error_t *error)
{
    const uint32_t widest = (number == DAVAR_PORT_Q15) ? 16U : 24U;
    const uint32_t bits = (config->sample_bits > 0U) ? config->sample_bits : widest;
    const davar_floor_config_t wanted = {.rate_hz = config->rate_hz,
                                         .unit_per_count = config->unit_per_count,
                                         .rail = (int32_t)((UINT32_C(1) << (bits - 1U)) - 1U),
                                         .filter = filter};
    if (filter == NULL) {
        return sim_fail(error,
                        "--floor: %s: the filter is unknown, and the floor reads too low where it "
                        "is; give --bandwidth FILTER, or none for raw samples",
                        name);
    }
    const davar_floor_status_t status = davar_floor_plan(plan, &wanted);
    return (status == DAVAR_FLOOR_OK) ||
           sim_fail(error, "--floor: %s", davar_floor_status_text(status));
}
