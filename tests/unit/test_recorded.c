/* davar tests - every bit as recorded here, on every machine. Other tests check that the values are
 * right. This one checks that none changes unnoticed, not even the last digit of a table. After an
 * intended change, store the number that the failure prints and describe the change in
 * CHANGELOG.md. */
#include "davar/davar.h"
#include "davar_law_id.h"
#include "fit/plan.h"
#include "number/real.h"

#include "digest.h"
#include "random.h"
#include "reported.h"
#include "shape.h"
#include "unity.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

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

/* 0 .. 1 */
static double random_part(void)
{
    return (double)(random_next(&rng) >> 44U) / 1048576.0;
}

/* ---- results ---- */

#define SAMPLES 6000U

static const uint32_t taus[] = {1U, 2U, 5U, 11U, 32U};
static uint64_t memory[20000];
static davar_t davar;
static davar_plan_t plan;
static davar_result_t result;
static davar_glr_report_t report;

static void add_result(double rate_hz)
{
    add_fields(&result, &report);
    (void)davar_fit_white(&plan, rate_hz, &result);
    add_fields(&result, &report);
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
    while (take_reported(&davar, &result, &report)) {
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

static davar_config_t config_of(davar_law_id_t id, uint32_t stride)
{
    davar_config_t config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 0.01;
    config.full_scale = 500.0;
    config.window.longest = 600U;
    config.window.shortest =
        (id == DAVAR_LAW_ID_FIXED) ? 600U : ((id == DAVAR_LAW_ID_GLR) ? 64U : 128U);
    config.moments.segment = ((id == DAVAR_LAW_ID_FIXED) || (id == DAVAR_LAW_ID_GLR)) ? 0U : 60U;
    config.law = davar_law_of_id(id, false);
    config.stride = stride;
    config.taus = taus;
    config.tau_count = 5U;
    config.window.gaps_max = 3U;
    return config;
}

static void run_law(bool is_wide, davar_law_id_t id, const davar_engine_t *engine)
{
    davar_plan_init_white(&plan, taus, 5U);
    static const uint32_t strides[] = {
        1U, 20U, 7U, 23U}; /* the latter two: windows whose edges lie between results */
    for (uint32_t way = 0U; way < 4U; way++) {
        davar_config_t config = config_of(id, strides[way]);
        config.engine = engine;
        config.glr.block = (way < 2U) ? (6U + (4U * way)) : 10U;
        davar_retype(&config, is_wide);
        run(is_wide, &config);
    }
}

static void test_results(void)
{
    static const struct {
        bool is_wide;
        bool is_glr;
        const davar_engine_t *engine;
        uint64_t recorded;
    } cases[] = {
        {false, false, NULL, UINT64_C(0x5CF22D5BD3CFC142)},
        {false, false, &davar_engine_grid_q15, UINT64_C(0x5CF22D5BD3CFC142)},
        {true, false, NULL, UINT64_C(0xA2C5811F216142B6)},
        {true, false, &davar_engine_grid_q15, UINT64_C(0xA2C5811F216142B6)},
        {false, true, NULL, UINT64_C(0xF0C41742E74BF7AD)},
        {true, true, NULL, UINT64_C(0x409C509560480C91)},
    };
    static const davar_law_id_t ids[] = {DAVAR_LAW_ID_FIXED, DAVAR_LAW_ID_KURTOSIS, DAVAR_LAW_ID_OR,
                                         DAVAR_LAW_ID_AND};
    for (size_t i = 0U; i < sizeof cases / sizeof cases[0]; i++) {
        digest_begin();
        for (uint32_t p = 0U; !cases[i].is_glr && (p < 4U); p++) {
            run_law(cases[i].is_wide, ids[p], cases[i].engine);
        }
        if (cases[i].is_glr) {
            run_law(cases[i].is_wide, DAVAR_LAW_ID_GLR, cases[i].engine);
        }
        expect(cases[i].recorded);
    }
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
        add_fields(&result, NULL);
        result = made;
        (void)davar_fit_white(&plan, 100.0, &result);
        add_fields(&result, NULL);
    }
    for (uint32_t t = 0U; t < result.tau_count; t++) { /* a sensor that is stuck */
        result.tau[t].adev = 0.0;
    }
    (void)davar_fit_white(&plan, 100.0, &result);
    add_fields(&result, NULL);
    expect(UINT64_C(0x50804D89A954D6E1));
}

/* ---- plans of filters, and fits with them ---- */

#define FILTERED_SIZES 7U
static const uint32_t filtered_sizes[FILTERED_SIZES] = {1U, 2U, 3U, 7U, 16U, 40U, 6000U};
static const shape_t filters[] = {{.poles = 0U},
                                  {.cutoff = 0.05, .poles = 1U, .uncertainty = 0.1},
                                  {.cutoff = 0.25, .poles = 1U},
                                  {.cutoff = 0.1, .poles = 2U, .uncertainty = 0.1},
                                  {.cutoff = 0.02, .poles = 2U, .uncertainty = 0.3},
                                  {.cutoff = 0.45, .poles = 2U},
                                  {.averages = 3U, .length = 8U, .decimation = 8U},
                                  {.averages = 1U, .length = 5U},
                                  {.cutoff = 0.3,
                                   .poles = 2U,
                                   .uncertainty = 0.05,
                                   .averages = 2U,
                                   .length = 4U,
                                   .decimation = 4U}};
#define FILTERS (sizeof filters / sizeof filters[0])

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
        plan_shape(&plan, filtered_sizes, 6U, &filters[i / 60U]);
    } else {
        davar_plan_init(&plan, filtered_sizes, 6U);
    }
}

static void add_both_fits(void)
{
    const davar_result_t made = result;
    davar_fit(&plan, 100.0, &result);
    add((uint64_t)result.noise);
    add_fields(&result, NULL);
    result = made;
    (void)davar_fit_white(&plan, 100.0, &result);
    add((uint64_t)result.noise);
    add_fields(&result, NULL);
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
    expect(UINT64_C(0xD744E635D03BE920));
}

#endif

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_results);
#if FLT_EVAL_METHOD == 0
    RUN_TEST(test_fits_of_unlikely_deviations);
    RUN_TEST(test_fits_in_heavy_tails);
#endif
    return UNITY_END();
}
