/* davar tests - every bit as recorded here, on every machine. Other tests check that the values are
 * right. This one checks that none changes unnoticed, not even the last digit of a table. After an
 * intended change, store the number that the failure prints and describe the change in
 * CHANGELOG.md. */
#include "davar/davar.h"
#include "davar/filter.h"
#include "davar/monitor.h"
#include "davar/select.h"
#include "davar/telemetry.h"
#include "davar_decode.h"
#include "davar_policy.h"
#include "detector/glr.h"
#include "detector/logarithm.h"
#include "detector/scan.h"
#include "detector/spread.h"
#include "fit/plan.h"
#include "number/real.h"

#include "digest.h"
#include "random.h"
#include "unity.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define TRIALS 20000U

static random_t rng;

void setUp(void)
{
    digest_begin();
    rng = random_seeded(1U);
}

void tearDown(void) {}

static void expect(uint64_t recorded)
{
    char found[48];
    (void)snprintf(found, sizeof found, "now 0x%08" PRIX32 "%08" PRIX32, (uint32_t)(digest >> 32U),
                   (uint32_t)digest);
    TEST_ASSERT_TRUE_MESSAGE(digest == recorded, found);
}

static uint32_t random_mantissa(void)
{
    return (uint32_t)random_next(&rng) | UINT32_C(0x80000000);
}

/* 0 .. 1 */
static double random_part(void)
{
    return (double)(random_next(&rng) >> 44U) / 1048576.0;
}

/* ---- arithmetic ---- */

static void test_reciprocal_and_roots(void)
{
    for (uint32_t i = 0U; i < TRIALS; i++) {
        const uint32_t mantissa = random_mantissa();
        add(davar_reciprocal_of_mantissa(mantissa));
        add(davar_root_of_mantissa_by_integers(mantissa >> (i % 2U)));
        add(davar_divided(mantissa, (i % 5000U) + 1U));
    }
    expect(UINT64_C(0x0027F042EA847C72));
}

static void test_limits_of_chi_square(void)
{
    for (uint32_t i = 1U; i <= TRIALS; i++) {
        add(davar_chi_square_low((UINT32_C(1) << 30U) / TRIALS * i));
        const scaled_t edf = {random_mantissa(), (int32_t)(i % 20U) - 31};
        scaled_t low;
        scaled_t high;
        davar_chi_square(edf, &low, &high);
        add(low.mantissa);
        add((uint32_t)low.exponent);
        add(high.mantissa);
        add((uint32_t)high.exponent);
    }
    expect(UINT64_C(0x27738D4A07288338));
}

static void test_likelihood(void)
{
    static const davar_spread_t none = {0U, 0U, 0U};
    davar_glr_config_t config;
    for (uint32_t i = 0U; i < TRIALS; i++) {
        const uint32_t blocks = 2U + (uint32_t)(random_next(&rng) % 1022U);
        const uint32_t of_older = 1U + (uint32_t)(random_next(&rng) % (blocks - 1U));
        const uint64_t a = (random_next(&rng) >> (24U + (i % 20U))) * of_older;
        const uint64_t b =
            (random_next(&rng) >> (24U + ((i + (i / 20U)) % 20U))) * (blocks - of_older);
        const davar_spread_t older = {a + 1U, 0U, of_older};
        const davar_spread_t whole = {a + b + 2U, 0U, blocks};
        davar_stretch_t stretch;
        config.degrees = 256U * (1U + (i % 30U));
        config.bias = davar_divided(UINT32_C(1) << 16U, 3U * (1U + (i % 30U)));
        davar_stretch(&stretch, &none, &whole, &config, 4096U);
        for (uint32_t limit = 64U; limit < 100000U; limit *= 3U) {
            add(davar_likelihood_may_reach(&stretch, &older, limit) ? 1U : 0U);
        }
        add((uint32_t)davar_likelihood_gain(&stretch, &older));
    }
    expect(UINT64_C(0x817FF2C006BF400F));
}

/* Of every length, up to 96 bits. */
static void test_logarithm_of_a_sum(void)
{
    for (uint32_t i = 0U; i < TRIALS; i++) {
        const uint32_t shift = i % 96U;
        const uint64_t low = random_next(&rng);
        const davar_spread_t some = {
            (shift < 32U) ? low : ((low | (UINT64_C(1) << 63U)) >> (shift - 32U)),
            (shift < 32U) ? (random_mantissa() >> shift) : 0U, 1U};
        add((uint32_t)spread_logarithm(&some));
        add(spread_bits(&some, spread_exponent(&some)));
    }
    expect(UINT64_C(0x023A0A75943D7784));
}

static void test_deviations_from_a_model(void)
{
    for (uint32_t i = 0U; i < 400U; i++) {
        const davar_model_tau_t model = {
            .m = 1U, .adev_dps = 1.0, .relative_tolerance = 0.01 * (double)(i % 3U)};
        add_double(davar_deviation(ldexp(1.5, (int)(i / 4U) - 50), 1.0 + (double)(i * 7U), &model));
        add_double(davar_deviation(0.99e6 + (100.0 * i), 100.0, &model));
        add_double(davar_deviation(0.99e-6 + (1e-10 * i), 100.0, &model));
    }
    expect(UINT64_C(0xAE7BFEE13E9CE469));
}

static void test_dispersion(void)
{
    davar_dispersion_t dispersion;
    davar_dispersion_start(&dispersion);
    for (uint32_t i = 0U; i < TRIALS; i++) {
        const uint32_t loud = (uint32_t)random_next(&rng) >> (6U + ((i / 2000U) % 4U));
        davar_dispersion_learn(&dispersion, (int32_t)loud, 30000U + i, 6U + (i % 4U));
        add(dispersion.phi);
    }
    expect(UINT64_C(0x5DDB0AC15A940E69));
}

/* ---- results ---- */

#define SAMPLES 6000U

static const uint32_t taus[] = {1U, 2U, 5U, 11U, 32U};
static uint64_t memory[20000];
static davar_t davar;
static davar_plan_t plan;
static davar_result_t result;

static void add_result(double rate_hz)
{
    add_fields(&result);
    (void)davar_fit_white(&plan, rate_hz, &result);
    add_fields(&result);
}

/* Nearly Gaussian noise of 12 counts: loud for a while, a ramp, a line, shocks of a sample and of
 * two blocks, saturation. */
static int32_t sample_at(uint32_t i)
{
    int32_t value = 0;
    for (uint32_t k = 0U; k < 6U; k++) {
        value += (int32_t)(random_next(&rng) >> 60U) - 8;
    }
    value *= (((i / 900U) % 3U) == 1U) ? 4 : 1;
    value += ((i > 4000U) ? (int32_t)((i - 4000U) / 20U) : 0) + (((i / 8U) % 2U) == 0U ? 2 : -2);
    value += ((i % 1500U) == 1100U) ? 700 : 0;
    value *= (((i % 1500U) >= 400U) && ((i % 1500U) < 416U)) ? (((i % 1500U) < 408U) ? 40 : 12) : 1;
    return ((i % 2500U) == 2400U) ? 32767 : value;
}

static void take_all(double rate_hz)
{
    while (davar_take(&davar, &result)) {
        add_result(rate_hz);
    }
}

static void run_stream(bool is_wide, const davar_config_t *config)
{
    rng = random_seeded(7U);
    for (uint32_t i = 0U; i < SAMPLES; i++) {
        const int32_t value = sample_at(i);
        const int16_t narrow = (int16_t)value;
        const int32_t wide = value * 1000;
        if (is_wide) {
            davar_push_q31(&davar, &wide, 1U);
        } else {
            davar_push_q15(&davar, &narrow, 1U);
        }
        take_all(config->rate_hz);
        if ((i % 1700U) == 1300U) {
            davar_gap(&davar, 1U + (i / 1000U));
        }
    }
    while (davar_flush(&davar)) {
        take_all(config->rate_hz);
    }
    const davar_health_t health = davar_health(&davar);
    add(health.gaps + (health.restarts * 16U) + (health.saturated * 256U));
    add(health.shocks + (health.alarms * 1024U) + (health.cuts * 1048576U));
}

/* In memory with old content, and again after a reset, with the same bits. */
static void run(bool is_wide, const davar_config_t *config)
{
    for (uint32_t i = 0U; i < (sizeof memory / sizeof memory[0]); i++) {
        memory[i] = UINT64_C(0x0000002800000028); /* old content that could pass for a counter */
    }
    memset(&davar, 0xA5, sizeof davar);
    const davar_status_t status = is_wide ? davar_init_q31(&davar, config, memory, sizeof memory)
                                          : davar_init_q15(&davar, config, memory, sizeof memory);
    TEST_ASSERT_EQUAL_STRING("ok", davar_status_text(status));
    const uint64_t before = digest;
    run_stream(is_wide, config);
    const uint64_t first = digest;
    davar_reset(&davar);
    digest = before;
    run_stream(is_wide, config);
    TEST_ASSERT_TRUE_MESSAGE(digest == first, "different bits after a reset");
}

static davar_config_t config_of(davar_policy_t policy, davar_mode_t mode, uint32_t stride)
{
    davar_config_t config = davar_default_config;
    config.window.mode = DAVAR_MODE_CENTRED;
    config.rate_hz = 100.0;
    config.unit_per_count = 0.01;
    config.full_scale = 500.0;
    config.window.longest = 600U;
    config.window.shortest =
        (policy == DAVAR_POLICY_FIXED) ? 600U : ((policy == DAVAR_POLICY_GLR) ? 64U : 128U);
    config.moments.segment =
        ((policy == DAVAR_POLICY_FIXED) || (policy == DAVAR_POLICY_GLR)) ? 0U : 60U;
    config.law = davar_policy_law(policy, false);
    config.window.mode = mode;
    config.stride = stride;
    config.taus = taus;
    config.tau_count = 5U;
    config.window.gaps_max = 3U;
    return config;
}

static void run_policy(bool is_wide, davar_policy_t policy, davar_engine_t engine)
{
    davar_plan_init_white(&plan, taus, 5U);
    static const uint32_t strides[] = {
        1U, 20U, 7U, 23U}; /* the latter two: windows whose edges lie between results */
    for (uint32_t way = 0U; way < 8U; way++) {
        davar_config_t config =
            config_of(policy, ((way & 1U) != 0U) ? DAVAR_MODE_CENTRED : DAVAR_MODE_TRAILING,
                      strides[way / 2U]);
        config.window.mirrored_end = (way == 1U);
        config.engine = engine;
        config.glr.long_cluster =
            ((policy == DAVAR_POLICY_GLR) && (way > 3U)) ? ((way % 2U) * 80U) : 0U;
        config.glr.block = (way < 4U) ? (6U + (2U * way)) : 10U;
        davar_policy_retype(&config, is_wide);
        run(is_wide, &config);
    }
}

static void run_policies(bool is_wide, davar_engine_t engine)
{
    static const davar_policy_t policies[] = {DAVAR_POLICY_FIXED, DAVAR_POLICY_KURTOSIS,
                                              DAVAR_POLICY_OR, DAVAR_POLICY_AND};
    for (uint32_t p = 0U; p < sizeof policies / sizeof policies[0]; p++) {
        run_policy(is_wide, policies[p], engine);
    }
}

static void test_results_of_q15(void)
{
    run_policies(false, DAVAR_ENGINE_AUTO);
    expect(UINT64_C(0x40C444237E78F861));
}

static void test_results_of_q15_on_a_grid(void)
{
    run_policies(false, DAVAR_ENGINE_GRID);
    expect(UINT64_C(0xECBE9EF3B5D49BE9));
}

static void test_results_of_q31(void)
{
    run_policies(true, DAVAR_ENGINE_AUTO);
    expect(UINT64_C(0x8F87028128A2A891));
}

static void test_results_of_q31_on_a_grid(void)
{
    run_policies(true, DAVAR_ENGINE_GRID);
    expect(UINT64_C(0x600A28EE66BBD74D));
}

static void test_results_of_policy_glr(void)
{
    run_policy(false, DAVAR_POLICY_GLR, DAVAR_ENGINE_AUTO);
    expect(UINT64_C(0x79340CD8227DDF9A));
}

static void test_results_of_policy_glr_q31(void)
{
    run_policy(true, DAVAR_POLICY_GLR, DAVAR_ENGINE_AUTO);
    expect(UINT64_C(0x91DBFC7887D352D2));
}

#define OCTAVES 10U
static const uint32_t octaves[OCTAVES] = {1U, 2U, 4U, 8U, 16U, 32U, 64U, 128U, 256U, 512U};

/* ---- fits of made-up deviations: every mixture of the five terms ---- */

#if FLT_EVAL_METHOD == 0 /* a double is one: not on the x87 */
#define WINDOW 6000U

/* The Allan variance of terms of these sizes, with a random relative error of up to `scatter`. */
static void make_deviations(const double size[5], double scatter, uint8_t count)
{
    result = (davar_result_t){.window_samples = WINDOW, .epoch = WINDOW - 1U, .tau_count = count};
    for (uint32_t t = 0U; t < count; t++) {
        const double m = (double)(1U << t);
        const double variance = (size[0] / (m * m)) + (size[1] / m) + (size[2] * 0.01) +
                                (size[3] * 1e-4 * m) + (size[4] * 1e-6 * m * m);
        result.tau[t].m = 1U << t;
        result.tau[t].differences = WINDOW + 1U - (2U << t);
        result.tau[t].adev = sqrt(variance * (1.0 - scatter + (2.0 * scatter * random_part())));
    }
}

static void test_fits_of_mixtures(void)
{
    davar_plan_init_white(&plan, octaves, OCTAVES);
    for (uint32_t i = 0U; i < 310U; i++) {
        double size[5];
        for (uint32_t k = 0U; k < 5U; k++) {
            const double random = random_part();
            size[k] = (((1U + (i % 31U)) >> k) & 1U) != 0U ? (0.05 + random) : 0.0;
        }
        make_deviations(size, 0.06, OCTAVES);
        davar_fit(&plan, 100.0, &result);
        add_fields(&result);
    }
    expect(UINT64_C(0x98CA7A0140DA2B40));
}

/* Terms of any size, few cluster sizes, and each variance from nothing to twice its value: no
 * mixture explains it. */
static void test_fits_of_unlikely_deviations(void)
{
    for (uint32_t i = 0U; i < 800U; i++) {
        const uint8_t count = (uint8_t)(2U + (i % (OCTAVES - 1U)));
        double size[5];
        for (uint32_t k = 0U; k < 5U; k++) {
            const int exponent = (int)(random_next(&rng) >> 60U) - 8;
            size[k] = ldexp(random_part(), exponent);
        }
        davar_plan_init_white(&plan, octaves, count);
        make_deviations(size, (double)(i % 21U) * 0.049, count);
        for (uint32_t t = 0U; ((i % 3U) == 0U) && (t < count); t++) { /* gaps have left few */
            result.tau[t].differences = (result.tau[t].differences ^ 8191U) | ((i % 2U) << t);
        }
        const davar_result_t made = result;
        davar_fit(&plan, 100.0, &result);
        add_fields(&result);
        result = made;
        (void)davar_fit_white(&plan, 100.0, &result);
        add_fields(&result);
    }
    for (uint32_t t = 0U; t < result.tau_count; t++) { /* a sensor that is stuck */
        result.tau[t].adev = 0.0;
    }
    (void)davar_fit_white(&plan, 100.0, &result);
    add_fields(&result);
    expect(UINT64_C(0x6716216CB154D6E1));
}

/* ---- plans of filters, and fits with them ---- */

static void add_floats(const float values[], uint32_t count)
{
    for (uint32_t t = 0U; t < count; t++) {
        add(davar_bits_of_float(values[t]));
    }
}

static void add_plan(void)
{
    const uint32_t count = plan.sizes;
    add_floats(plan.gain, count);
    add_floats(plan.flicker, count);
    add_floats(plan.walk, count);
    add_floats(plan.offset, count);
    add_floats(plan.covariance, (count * (count + 1U)) / 2U);
    add_floats(plan.to_white, count);
    add_floats(plan.weight, count);
    add_floats(plan.freedom, count);
    add_floats(plan.doubtful, count);
    for (uint32_t t = 0U; t < count; t++) {
        add(plan.inverse_gain[t]);
    }
    for (uint32_t k = 0U; k < DAVAR_COEFFICIENT_COUNT; k++) {
        for (uint32_t t = 0U; t < count; t++) {
            add((uint32_t)plan.functional[k][t] + ((uint64_t)(uint32_t)plan.variance[k][t] << 32U));
        }
        add((uint64_t)(plan.variance_exponent[k] + 128));
    }
    add_floats(plan.offset_variance, DAVAR_COEFFICIENT_COUNT);
    add_floats(plan.scale, DAVAR_COEFFICIENT_COUNT);
    add_floats(plan.centre, DAVAR_COEFFICIENT_COUNT);
    add_floats(plan.unit, DAVAR_COEFFICIENT_COUNT);
    const float others[] = {plan.sample, plan.floor, plan.hidden, plan.rounding,
                            plan.misfit_spread};
    add_floats(others, 5U);
    add(plan.coarse + ((uint64_t)plan.white_bits << 32U));
    add(plan.misfit_limit);
}

#define FILTERED_SIZES 7U
static const uint32_t filtered_sizes[FILTERED_SIZES] = {1U, 2U, 3U, 7U, 16U, 40U, 6000U};
static const davar_filter_t filters[] = {{.poles = 0U},
                                         {.cutoff = 0.05, .poles = 1U, .uncertainty = 0.1},
                                         {.cutoff = 0.25, .poles = 1U},
                                         {.cutoff = 0.1, .poles = 2U, .uncertainty = 0.1},
                                         {.cutoff = 0.02, .poles = 2U, .uncertainty = 0.3},
                                         {.cutoff = 0.45, .poles = 2U},
                                         {.averages = 3U, .length = 8U, .decimation = 8U},
                                         {.averages = 1U, .length = 5U, .decimation = 3U},
                                         {.cutoff = 0.3,
                                          .poles = 2U,
                                          .uncertainty = 0.05,
                                          .averages = 2U,
                                          .length = 6U,
                                          .decimation = 4U}};
#define FILTERS (sizeof filters / sizeof filters[0])

static void test_plans_of_filters(void)
{
    for (uint32_t f = 0U; f < FILTERS; f++) {
        davar_plan_init_filtered(&plan, filtered_sizes, FILTERED_SIZES, &filters[f]);
        add_plan();
        davar_plan_solve(&plan, 4U);
        add_plan();
        davar_plan_init_filtered(&plan, &filtered_sizes[2], 4U, &filters[f]);
        add_plan();
    }
    expect(UINT64_C(0x3E1F52CB3B9B6D30));
}

/* White noise, or with a drift, or filtered more than declared, with some scatter and rounding. */
static void make_filtered(uint32_t i)
{
    const double size = ldexp(1.0 + random_part(), (int)(i % 40U) - 20);
    const double share = ((i % 4U) == 0U) ? (0.1 * random_part()) : 0.0;
    result = (davar_result_t){.window_samples = WINDOW, .epoch = WINDOW - 1U, .tau_count = 6U};
    for (uint32_t t = 0U; t < 6U; t++) {
        const double m = (double)filtered_sizes[t];
        const double low = ((i % 7U) == 0U) ? (1.0 - (0.3 * random_part() / m)) : 1.0;
        const double scatter = 1.0 + (0.05 * sqrt(m) * (random_part() - 0.5));
        const double variance = ((double)plan.gain[t] * low / m) + (share * m / 100.0);
        result.tau[t].m = filtered_sizes[t];
        result.tau[t].differences = WINDOW + 1U - (2U * filtered_sizes[t]);
        result.tau[t].adev = size * sqrt(variance * scatter);
    }
    result.unit_per_count = ((i % 3U) == 0U) ? 0.0 : (size * random_part() * random_part());
}

/* The plan of fit i: one for each filter, the last without one. */
static void start_plan(uint32_t i)
{
    if ((i % 60U) != 0U) {
        return;
    }
    if (i < (FILTERS * 60U)) {
        davar_plan_init_filtered(&plan, filtered_sizes, 6U, &filters[i / 60U]);
    } else {
        davar_plan_init(&plan, filtered_sizes, 6U);
    }
}

static void add_both_fits(void)
{
    const davar_result_t made = result;
    davar_fit(&plan, 100.0, &result);
    add((uint64_t)result.noise);
    add_fields(&result);
    result = made;
    (void)davar_fit_white(&plan, 100.0, &result);
    add((uint64_t)result.noise);
    add_fields(&result);
}

static void test_fits_behind_filters(void)
{
    for (uint32_t i = 0U; i < (FILTERS + 1U) * 60U; i++) {
        start_plan(i);
        make_filtered(i);
        add_both_fits();
    }
    expect(UINT64_C(0x59C06FDC643FC044));
}

/* The kurtosis differs from window to window, then it is that of Gaussian noise. Every fifth window
 * is shorter. */
static void test_fits_in_heavy_tails(void)
{
    for (uint32_t i = 0U; i < (FILTERS + 1U) * 60U; i++) {
        start_plan(i);
        make_filtered(i);
        if ((i % 5U) == 4U) {
            for (uint32_t t = 0U; t < 6U; t++) {
                result.tau[t].differences -= WINDOW / 2U;
            }
            result.window_samples = WINDOW / 2U;
        }
        result.kurtosis = ((i % 60U) < 40U) ? (1.0 + ldexp(random_part(), (int)(i % 9U))) : 3.0;
        add_both_fits();
        add(davar_bits_of_float(plan.half_kappa));
    }
    expect(UINT64_C(0xA536154EB5D53895));
}

/* ---- what is derived from a filter: whitening, and the bounds of the moments ---- */

/* Without the last 16 bits: libgcc for a Cortex-M4F rounds 1 - x wrongly by one unit in the last
 * place for some x near 2^-33. The exponential of a small angle has 256 times this error. */
static void add_leading_bits(double value)
{
    add(davar_bits_of_double(value) >> 16U);
}

static void test_settings_of_filters(void)
{
    static const uint16_t block[] = {7U, 10U, 25U};
    static const davar_law_t *const laws[] = {&davar_law_kurtosis, &davar_law_or, &davar_law_and};
    for (uint32_t f = 0U; f < (FILTERS * 3U); f++) {
        davar_config_t config = davar_default_config;
        config.glr.block = block[f % 3U];
        config.window.shortest = 20U << (f % 4U);
        davar_whiten(&config, &filters[f / 3U]);
        add((uint64_t)(uint16_t)config.glr.whiten_first +
            ((uint64_t)(uint16_t)config.glr.whiten_second << 16U));
        add_leading_bits(config.glr.whiten_level);
        add_leading_bits(config.glr.whiten_tolerance);
        config.law = laws[f % 3U];
        config.moments.segment = config.window.shortest / (2U + (f % 4U));
        davar_bound_unstable_rate(&config, 0.001 * (double)(1U + f), &filters[f / 3U]);
        add_leading_bits(config.moments.kurtosis_low);
        add_leading_bits(config.moments.kurtosis_high);
        add_leading_bits(config.moments.contribution_low);
        add_leading_bits(config.moments.contribution_high);
    }
    expect(UINT64_C(0xAC9EB978603DBABE));
}
#endif

/* ---- frames, and the values that a receiver reads ---- */

static void add_frame(const davar_frame_t *frame)
{
    davar_wire_t wire = {0};
    add(frame->identifier + (frame->length * UINT64_C(65536)));
    for (uint32_t i = 0U; i < frame->length; i++) {
        add(frame->data[i]);
    }
    TEST_ASSERT_EQUAL(DAVAR_DECODED, davar_decode(frame, DAVAR_WIRE_BASE, &wire));
    add(wire.message + (wire.channel * 256U) + (wire.counter * 65536U) +
        ((uint32_t)wire.result << 24U));
    add(wire.session + (wire.index * 256U) + (wire.worst * 65536U) +
        ((uint32_t)wire.unstable << 24U) + ((uint32_t)wire.alarm << 25U) +
        ((uint32_t)wire.young << 26U));
    add(wire.number + ((uint64_t)wire.window_samples << 32U));
    add((uint32_t)wire.count[0] + ((uint64_t)(uint32_t)wire.count[1] << 32U));
    add(wire.change_m + ((uint64_t)wire.cut_age_samples << 32U));
    add_float(wire.value);
    add_float(wire.relative_uncertainty);
    add_float(wire.kurtosis);
    add_float(wire.contribution);
    add_float(wire.dispersion);
    for (uint32_t t = 0U; t < DAVAR_FD_TAUS; t++) {
        add_float(wire.adev[t]);
    }
    for (uint32_t k = 0U; k < DAVAR_COEFFICIENT_COUNT; k++) {
        add_float(wire.coefficient[k]);
    }
}

static double random_size(void)
{
    return 1e-4 + ((double)(random_next(&rng) >> 44U) / 65536.0);
}

/* Sometimes more than any signal can represent. */
static double random_share(void)
{
    const double unit = ((random_next(&rng) >> 61U) == 0U) ? 1e-4 : 40.0;
    return random_size() / unit;
}

/* A result with a value in every field that is sent. */
static void make_result(uint32_t turn)
{
    result = (davar_result_t){.tau_count = 10U,
                              .unstable = (turn % 2U) != 0U,
                              .alarm = (turn % 3U) == 0U,
                              .young = (turn % 5U) == 0U,
                              .change = {.m = 1U << (turn % 8U)}};
    result.epoch =
        random_next(&rng) >> 24U; /* one by one: the order of initializers is the compiler's */
    result.window_samples = 1U + (uint32_t)(random_next(&rng) >> 44U);
    result.kurtosis = 2.0 + random_share();
    result.contribution = random_share();
    result.change.older = random_size();
    result.change.newer = random_size();
    result.change.gain = 9.0 + random_size();
    result.cut_age_samples = (uint32_t)(random_next(&rng) >> 46U);
    result.dispersion = random_share();
    for (uint32_t t = 0U; t < 10U; t++) {
        const double adev = random_size();
        result.tau[t] = (davar_adev_t){
            .m = 1U << t, .adev = adev, .low = 0.8 * adev, .high = 1.3 * adev, .differences = 100U};
    }
    for (uint32_t k = 0U; k < DAVAR_COEFFICIENT_COUNT; k++) {
        const double value = random_size();
        result.coefficient[k] = (davar_coefficient_t){
            .value = value, .low = 0.7 * value, .high = (1.0 + (2.0 * random_part())) * value};
    }
}

static void send_results(const davar_config_t *config, uint8_t content,
                         const davar_misfit_t *misfit)
{
    davar_encoder_t encoder;
    davar_frame_t frame;
    davar_wire_health_t health = {{0}};
    TEST_ASSERT_TRUE(davar_encoder_init(&encoder, config, DAVAR_WIRE_BASE, 1U, content));
    davar_encoder_monitor(&encoder, misfit);
    davar_encoder_session(&encoder, 77U);
    for (uint32_t turn = 0U; turn < 30U; turn++) {
        make_result(turn);
        health.count[turn % DAVAR_HEALTH_COUNT] += (uint32_t)(random_next(&rng) >> 33U);
        davar_encoder_begin(&encoder, &result, &health);
        while (davar_encoder_next(&encoder, &frame)) {
            add_frame(&frame);
        }
        for (uint32_t i = 0U; i < 3U; i++) {
            const int32_t count = (int32_t)((uint32_t)random_next(&rng) >> ((turn % 2U) * 17U));
            if (davar_encoder_raw(&encoder, turn * 50U + i, count, &frame)) {
                add_frame(&frame);
            }
        }
        if (davar_encoder_raw_rest(&encoder, &frame)) {
            add_frame(&frame);
        }
        davar_encoder_raw_f32(&encoder, turn, (float)random_size(), &frame);
        add_frame(&frame);
    }
    davar_encoder_finish(&encoder, &health);
    while (davar_encoder_next(&encoder, &frame)) {
        add_frame(&frame);
    }
}

/* ---- which of several gyros ---- */

static void add_verdict(const davar_select_verdict_t *verdict, uint32_t gyros)
{
    for (uint32_t i = 0U; i < gyros; i++) {
        add_float(verdict->weight[i]);
        add(verdict->fault[i]);
    }
    add(verdict->chosen);
    add((verdict->switched ? 1U : 0U) + (verdict->usable ? 2U : 0U) +
        (verdict->disagree ? 4U : 0U) + (verdict->hidden ? 8U : 0U));
}

/* Block t of a flight: common motion at times, one gyro louder than the others, a mean that jumps,
 * missing samples, a stuck gyro, a very loud one. */
static void add_rates(float *rates, const davar_select_config_t *config, uint32_t t)
{
    const double motion = (((t / 50U) % 2U) == 1U) ? random_uniform(&rng) : 0.0;
    for (uint32_t i = 0U; i < config->gyros; i++) {
        const bool last = ((i + 1U) == config->gyros);
        const double noise = ((t / 100U) % config->gyros == i) ? 3.0 : 1.0;
        const double size = (last && (t >= 500U) && (t < 560U)) ? 20.0 : noise;
        for (uint32_t a = 0U; a < config->axes; a++) {
            float *const rate = &rates[(i * config->axes) + a];
            const double sample = random_uniform(&rng) + random_uniform(&rng) - 1.0;
            const double mean = ((i == 0U) && (t >= 300U) && (t < 380U)) ? 6.0 : 0.1 * i;
            if (last && (t >= 450U) && (t < 460U)) {
                continue;
            }
            *rate = (float)(mean + (9.0 * motion) + (size * sample));
            if ((i == 1U) && (t >= 400U) && (t < 404U)) {
                *rate = NAN;
            }
        }
    }
}

static void test_selection_of_gyros(void)
{
    for (uint32_t k = 0U; k < 9U; k++) {
        const davar_select_config_t config = {.gyros = (uint8_t)(2U + (k % 3U)),
                                              .axes = (uint8_t)(1U + (k / 3U)),
                                              .block = 8U,
                                              .rate_hz = 70.0F,
                                              DAVAR_SELECT_DEFAULTS};
        davar_select_t select;
        davar_select_gyro_t gyro[DAVAR_SELECT_GYROS];
        davar_select_pair_t pair[DAVAR_SELECT_PAIRS(DAVAR_SELECT_GYROS)];
        davar_select_verdict_t verdict;
        float rates[DAVAR_SELECT_GYROS * DAVAR_SELECT_AXES] = {0.0F};
        TEST_ASSERT_TRUE(davar_select_init(&select, &config, gyro, pair));
        add_float(select.threshold);
        for (uint32_t t = 0U; t < 700U; t++) {
            do {
                add_rates(rates, &config, t);
            } while (!davar_select_add(&select, rates));
            davar_select_update(&select, &verdict);
            add_verdict(&verdict, config.gyros);
            add(gyro[config.gyros - 1U].loud);
        }
        for (uint32_t i = 0U; i < config.gyros; i++) {
            add_float(gyro[i].evidence);
            add_float(gyro[i].spread);
            add_float(gyro[i].usual);
        }
        for (uint32_t p = 0U; p < DAVAR_SELECT_PAIRS((uint32_t)config.gyros); p++) {
            add_float(pair[p].evidence);
            add_float(pair[p].noise);
            add_float(pair[p].age);
        }
    }
    expect(UINT64_C(0x2B9D70F4C6510DBF));
}

static void test_frames(void)
{
    davar_misfit_t misfit = {.health = 0.7, .worst = 2U, .tau_count = 10U};
    for (uint32_t t = 0U; t < 10U; t++) {
        misfit.tau[t] = (davar_misfit_tau_t){.deviation = 0.5 - (0.125 * (double)t),
                                             .mean_deviation = 0.25 * (double)t};
    }
    davar_config_t config = config_of(DAVAR_POLICY_GLR, DAVAR_MODE_TRAILING, 20U);
    config.taus = octaves;
    config.tau_count = 10U;
    for (uint32_t content = 0U; content < 64U; content++) {
        config.law = ((content % 3U) == 0U) ? &davar_law_or : &davar_law_glr_q15;
        send_results(&config, (uint8_t)content, &misfit);
    }
    expect(UINT64_C(0x81CD36A43E7EF1C7));
}

static void add_packet(const davar_packet_t *packet)
{
    add(packet->identifier + ((uint64_t)packet->length << 32U));
    for (uint32_t i = 0U; i < packet->length; i++) {
        add(packet->data[i]);
    }
}

static void send_telemetry(const davar_dialect_t *dialect)
{
    static const davar_telemetry_address_t from = {
        .channel = 1U, .node = 42U, .system = 7U, .subject = 3700U};
    davar_telemetry_t telemetry;
    davar_packet_t packet;
    TEST_ASSERT_TRUE(davar_telemetry_init(&telemetry, dialect, &from, 99.3));
    for (uint32_t turn = 0U; turn < 300U; turn++) {
        const uint64_t time_us = (uint64_t)turn * 300000U;
        make_result(turn);
        add_double(davar_rate_variance(&result, 99.3));
        if (davar_telemetry_heartbeat(&telemetry, time_us, &packet)) {
            add_packet(&packet);
        }
        davar_telemetry_begin(&telemetry, &result, time_us);
        while (davar_telemetry_next(&telemetry, &packet)) {
            add_packet(&packet);
        }
    }
}

static void test_packets_of_dialects(void)
{
    send_telemetry(&davar_mavlink);
    send_telemetry(&davar_mavlink_gyro_noise);
    send_telemetry(&davar_dronecan);
    send_telemetry(&davar_cyphal);
    for (uint32_t i = 0U; i < 1000U; i++) {
        const double part = random_part();
        const double gyro[3] = {part, 1e-5 * part, 1e-7 * part};
        const double accel[3] = {1e5 * part, (double)NAN, -part};
        uint8_t bytes[DAVAR_COVARIANCE_BYTES];
        davar_dronecan_covariance(gyro, accel, bytes);
        for (uint32_t k = 0U; k < DAVAR_COVARIANCE_BYTES; k++) {
            add(bytes[k]);
        }
    }
    expect(UINT64_C(0x0D404DC15405254E));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_reciprocal_and_roots);
    RUN_TEST(test_limits_of_chi_square);
    RUN_TEST(test_likelihood);
    RUN_TEST(test_logarithm_of_a_sum);
    RUN_TEST(test_deviations_from_a_model);
    RUN_TEST(test_dispersion);
    RUN_TEST(test_results_of_q15);
    RUN_TEST(test_results_of_q15_on_a_grid);
    RUN_TEST(test_results_of_q31);
    RUN_TEST(test_results_of_q31_on_a_grid);
    RUN_TEST(test_results_of_policy_glr);
    RUN_TEST(test_results_of_policy_glr_q31);
    RUN_TEST(test_selection_of_gyros);
    RUN_TEST(test_frames);
    RUN_TEST(test_packets_of_dialects);
#if FLT_EVAL_METHOD == 0
    RUN_TEST(test_fits_of_mixtures);
    RUN_TEST(test_fits_of_unlikely_deviations);
    RUN_TEST(test_plans_of_filters);
    RUN_TEST(test_fits_behind_filters);
    RUN_TEST(test_fits_in_heavy_tails);
    RUN_TEST(test_settings_of_filters);
#endif
    return UNITY_END();
}
