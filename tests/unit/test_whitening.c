/* davar tests - whitening before the detector (10.16): law glr after a filter compared with
 * a detector of blocks that the test whitens itself, from the samples since the last gap. */
#include "davar/davar.h"
#include "laws/glr.h"

#include "random.h"
#include "reported.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define BLOCK 10
#define SAMPLES 40000U

typedef enum { Q15, Q31 } type_t;

static const uint32_t taus[] = {1U, 2U, 4U};
static davar_config_t config;
static davar_t davar;
static davar_result_t result;
static davar_glr_report_t report;
static uint64_t memory[4096];
static int32_t stream[SAMPLES];
static bool gap_before[SAMPLES];

void setUp(void)
{
    config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 0.5;
    config.window.longest = 6000U;
    config.window.shortest = 20U;
    config.window.grow = 1U;
    config.window.gaps_max = 64U;
    config.moments.segment = 0U;
    config.stride = 10U;
    config.taus = taus;
    config.tau_count = 3U;
    config.glr.false_alarms_per_hour = 1.0;
    config.glr.whiten_first = 26000;
    config.glr.whiten_second = -11000;
    config.glr.whiten_level = 12.5;
    config.glr.whiten_tolerance = 0.25;
}

void tearDown(void) {}

/* Noise with the poles of the whitening, whose size changes and which has shocks. */
static void make_stream(uint64_t seed, double sigma, double offset, double most)
{
    random_t random = random_seeded(seed);
    double x[3] = {0.0, 0.0, 0.0};
    double size = sigma;
    for (uint32_t i = 0U; i < SAMPLES; i++) {
        if ((random_next(&random) % 4000U) == 0U) {
            size = sigma * exp(2.0 * (random_uniform(&random) - 0.5));
        }
        x[0] = (1.587 * x[1]) - (0.671 * x[2]) + (size * random_gauss(&random));
        x[2] = x[1];
        x[1] = x[0];
        const bool is_shock = (random_next(&random) % 2000U) == 0U;
        const double value = floor(x[0] + offset + (is_shock ? (100.0 * size) : 0.0) + 0.5);
        stream[i] = (int32_t)fmax(-most - 1.0, fmin(most, value));
        gap_before[i] = (random_next(&random) % 1500U) == 0U;
    }
}

/* ---- the same with the test's own arithmetic ---- */

static davar_glr_t state;
static davar_glr_config_t thresholds;
static davar_glr_event_t event;
static uint32_t alarms;
static uint32_t cuts;
static uint32_t shocks;
static davar_spread_t older;
static int32_t gain;
static bool has_changed;
static davar_spread_t since; /* sum where the section began */
static davar_spread_t lost;  /* shocks since then */
static uint32_t compared;    /* runs of 64 blocks; f is compared with 5 after each */
static uint32_t withheld;    /* runs until the interval is shown again */

static void reference_start(void)
{
    const davar_glr_wish_t wish = {100.0, 1.0, 300.0, 6000U, BLOCK, 2U};
    davar_glr_start(&thresholds, &wish);
    thresholds.floor =
        davar_glr_floor(thresholds.block, config.glr.whiten_first, config.glr.whiten_second);
    davar_glr_reset(&state);
    alarms = 0U;
    cuts = 0U;
    shocks = 0U;
    has_changed = false;
    memset(&since, 0, sizeof since);
    memset(&lost, 0, sizeof lost);
    compared = 0U;
    withheld = 0U;
}

/* x[0] is the newest of three samples. */
static int64_t rest_of(const int64_t x[3], int64_t limit)
{
    const double predicted = ((double)config.glr.whiten_first * (double)x[1] +
                              (double)config.glr.whiten_second * (double)x[2]) /
                             16384.0;
    const int64_t rest = x[0] - (int64_t)floor(predicted + 0.5);
    return (rest > limit) ? limit : ((rest < (-limit - 1)) ? (-limit - 1) : rest);
}

static void begin_section(void)
{
    since = state.now.sum;
    memset(&lost, 0, sizeof lost);
}

static void reference_compare(void)
{
    const uint32_t turn = (state.now.at + 1U) / 64U;
    if (turn != compared) {
        const bool is_heavy = davar_glr_dispersion(&state, GLR_TYPICAL) > (5U * 4096U);
        compared = turn;
        withheld = is_heavy ? 256U : ((withheld > 0U) ? (withheld - 1U) : 0U);
        if (is_heavy) {
            begin_section();
        }
    }
}

static void reference_note(void)
{
    alarms += event.is_alarm ? 1U : 0U;
    cuts += event.is_cut ? 1U : 0U;
    shocks += (event.dropped > 0U) ? 1U : 0U;
    if (event.dropped > 0U) {
        spread_add(&lost, &event.shock);
    }
    reference_compare();
    if (event.is_alarm) {
        begin_section();
        older = event.older;
        gain = event.gain;
        has_changed = true;
    }
}

static void reference_block(const int64_t e[BLOCK])
{
    int64_t sum = 0;
    davar_u128_t squares = {0U, 0U};
    for (int i = 0; i < BLOCK; i++) {
        const davar_u128_t square = {(uint64_t)(e[i] * e[i]), 0U};
        sum += e[i];
        squares = davar_u128_add(squares, square);
    }
    davar_glr_push_q31(&state, &thresholds, sum, &squares, &event);
    reference_note();
}

static void reference_gap(void)
{
    davar_glr_skip(&state, &thresholds, &event);
}

static double level_of(const davar_spread_t *sum)
{
    const double nu = BLOCK - 1.0;
    const double a = config.glr.whiten_first / 16384.0;
    const double b = config.glr.whiten_second / 16384.0;
    const double floor_of_block = floor((BLOCK * nu * (1.0 + (2.0 * ((a * a) + (b * b))))) + 0.5);
    const double total = ((double)sum->high * 18446744073709551616.0) + (double)sum->low;
    const double square =
        (total - (sum->blocks * floor_of_block)) / (12.0 * BLOCK * nu * sum->blocks);
    return 12.5 * 0.5 * sqrt(square);
}

/* Variance in counts, and without `rounding`. */
static double variance_of(const davar_spread_t *sum, double rounding)
{
    const double total = ((double)sum->high * 18446744073709551616.0) + (double)sum->low;
    return fmax(0.0, (total / (12.0 * BLOCK * (BLOCK - 1.0) * sum->blocks)) - rounding);
}

/* Variance about the mean of a block that independent errors of 1/12 in the samples get, and that
 * of rounding what they predict. */
static double rounding_in_blocks(void)
{
    const double h[3] = {1.0, -config.glr.whiten_first / 16384.0,
                         -config.glr.whiten_second / 16384.0};
    double sum = 1.0;
    for (int k = 0; k < BLOCK; k++) {
        for (int l = 0; l < BLOCK; l++) {
            const double weight = (((k == l) ? 1.0 : 0.0) - (1.0 / BLOCK)) / (BLOCK - 1.0);
            for (int i = 0; i < 3; i++) {
                const int j = i + k - l;
                sum += ((j >= 0) && (j < 3)) ? (weight * h[i] * h[j]) : 0.0;
            }
        }
    }
    return sum / 12.0;
}

/* In 40 000 samples, only an alarm or heavy tails begin a section. */
static void assert_steady(void)
{
    const double rounding =
        (thresholds.floor / (12.0 * BLOCK * (BLOCK - 1.0))) + rounding_in_blocks();
    davar_spread_t steady = spread_between(&since, &state.now.sum);
    const bool is_known =
        (withheld == 0U) &&
        (state.single.count >= floor(fmin(1536.0, 512.0 * pow(result.dispersion, 2.0))));
    if (report.steady.samples == 0U) {
        TEST_ASSERT_TRUE(!is_known || (steady.blocks < 80U) ||
                         (variance_of(&steady, rounding) < 0.5) || (result.dispersion > 5.0));
        return;
    }
    TEST_ASSERT_TRUE(is_known && (result.dispersion <= 5.0));
    const double level = 12.5 * 0.5 * sqrt(variance_of(&steady, rounding));
    TEST_ASSERT_EQUAL_UINT64((uint64_t)steady.blocks * BLOCK, report.steady.samples);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3 * level, level, report.steady.level);
    if (!(report.steady.low > 0.0)) {
        return; /* rounding alone may explain it */
    }
    const double low = pow(report.steady.low * 1.25 / (12.5 * 0.5), 2.0); /* whiten_tolerance */
    const double s =
        sqrt(variance_of(&steady, 0.0) / (low + rounding + (1.0 / 6.0))) - 1.0; /* 1/4 - 1/12 */
    spread_add(&steady, &lost);
    const double high = (variance_of(&steady, 0.0) / pow(1.0 - s, 2.0)) - rounding + (1.0 / 12.0);
    TEST_ASSERT_TRUE((s > 0.0) && (s < 0.5));
    TEST_ASSERT_DOUBLE_WITHIN(2e-3 * report.steady.high, 1.25 * 12.5 * 0.5 * sqrt(high),
                              report.steady.high);
}

static void assert_same(void)
{
    const davar_health_t health = davar_health(&davar);
    TEST_ASSERT_EQUAL_UINT32(alarms, health.alarms);
    TEST_ASSERT_EQUAL_UINT32(cuts, health.cuts);
    TEST_ASSERT_EQUAL_UINT32(shocks, health.shocks);
    if (take_reported(&davar, &result, &report)) {
        const double f = (double)davar_glr_dispersion(&state, GLR_TYPICAL) / 4096.0;
        TEST_ASSERT_EQUAL_DOUBLE(f, result.dispersion);
        TEST_ASSERT_EQUAL_UINT32(has_changed ? 1U : 0U, report.change.m);
        if (has_changed) {
            const davar_spread_t newer = spread_between(&state.alarm.sum, &state.now.sum);
            TEST_ASSERT_EQUAL_DOUBLE((double)gain / 4096.0, report.change.gain);
            TEST_ASSERT_DOUBLE_WITHIN(1e-8 * level_of(&older), level_of(&older),
                                      report.change.older);
            TEST_ASSERT_DOUBLE_WITHIN(1e-8 * level_of(&newer), level_of(&newer),
                                      report.change.newer);
        }
        assert_steady();
    }
}

/* ---- both ---- */

static void push_one(type_t type, int32_t sample)
{
    if (type == Q15) {
        const int16_t narrow = (int16_t)sample;
        davar_push_q15(&davar, &narrow, 1U);
    } else {
        davar_push_q31(&davar, &sample, 1U);
    }
}

static void init(type_t type)
{
    config.law = (type == Q15) ? &davar_law_glr_q15 : &davar_law_glr_q31;
    memset(memory, 0xA5, sizeof memory);
    TEST_ASSERT_EQUAL(DAVAR_OK, (type == Q15)
                                    ? davar_init_q15(&davar, &config, memory, sizeof memory)
                                    : davar_init_q31(&davar, &config, memory, sizeof memory));
}

static void compare(type_t type, int64_t limit)
{
    int64_t x[3] = {0, 0, 0};
    int64_t e[BLOCK];
    int filled = 0;
    bool has_past = false;
    init(type);
    reference_start();
    for (uint32_t i = 0U; i < SAMPLES; i++) {
        if (gap_before[i]) {
            davar_gap(&davar, 3U);
            reference_gap();
            filled = 0;
            has_past = false;
        }
        x[2] = has_past ? x[1] : stream[i];
        x[1] = has_past ? x[0] : stream[i];
        x[0] = stream[i];
        has_past = true;
        push_one(type, stream[i]);
        e[filled] = rest_of(x, limit);
        filled++;
        if (filled == BLOCK) {
            filled = 0;
            reference_block(e);
            assert_same();
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT32(1U, alarms + cuts);
}

static void test_blocks_of_16_bits_are_whitened(void)
{
    make_stream(1U, 8.0, 1000.0, 32767.0);
    compare(Q15, 32767);
    TEST_ASSERT_GREATER_THAN_UINT32(3U, alarms);
    TEST_ASSERT_GREATER_THAN_UINT32(2U, shocks);
    make_stream(2U, 0.7, -0.3, 32767.0);
    compare(Q15, 32767);
}

static void test_blocks_of_32_bits_are_whitened(void)
{
    config.sample_bits = 32U;
    make_stream(3U, 80000.0, -3e7, 2147483647.0);
    compare(Q31, 2147483647);
    TEST_ASSERT_GREATER_THAN_UINT32(3U, alarms);
    TEST_ASSERT_GREATER_THAN_UINT32(2U, shocks);
}

/* Full scale, up and down: what is left of a sample is clamped to the range of a sample. */
static void test_the_rest_is_clamped_and_no_sum_overflows(void)
{
    static const int16_t signs[][2] = {{32767, 16385}, {-32767, -16385}, {-32767, 16385},
                                       {16384, 32767}, {-16384, -32767}, {0, 16385}};
    for (size_t s = 0U; s < (sizeof signs / sizeof signs[0]); s++) {
        config.glr.whiten_first = signs[s][0];
        config.glr.whiten_second = signs[s][1];
        make_stream(4U + s, 30000.0, 0.0, 32767.0);
        config.sample_bits = 16U;
        compare(Q15, 32767);
        config.sample_bits = 32U;
        make_stream(4U + s, 2e9, 0.0, 2147483647.0);
        compare(Q31, 2147483647);
    }
}

static davar_status_t status_of(int16_t first, int16_t second, double level)
{
    config.glr.whiten_first = first;
    config.glr.whiten_second = second;
    config.glr.whiten_second = second;
    config.glr.whiten_level = level;
    return davar_init_q15(&davar, &config, memory, sizeof memory);
}

static void test_settings_out_of_range_are_rejected(void)
{
    config.law = &davar_law_glr_q15;
    TEST_ASSERT_EQUAL(DAVAR_OK, status_of(0, 0, 0.0));
    TEST_ASSERT_EQUAL(DAVAR_OK, status_of(32767, -16385, 1e-9));
    TEST_ASSERT_EQUAL(DAVAR_OK, status_of(-32767, 16385, 1e9));
    TEST_ASSERT_EQUAL(DAVAR_ERR_TRACKING, status_of(32767, -16386, 1.0));
    TEST_ASSERT_EQUAL(DAVAR_ERR_TRACKING, status_of(INT16_MIN, INT16_MIN, 1.0));
    TEST_ASSERT_EQUAL(DAVAR_ERR_TRACKING, status_of(1, 0, 0.0));
    TEST_ASSERT_EQUAL(DAVAR_ERR_TRACKING, status_of(0, 1, 0.0));
    TEST_ASSERT_EQUAL(DAVAR_ERR_TRACKING, status_of(0, 1, -1.0));
    TEST_ASSERT_EQUAL(DAVAR_ERR_TRACKING, status_of(1, 0, 1.1e9));
    TEST_ASSERT_EQUAL(DAVAR_ERR_TRACKING, status_of(1, 0, (double)NAN));
    config.glr.whiten_tolerance = 100.0;
    TEST_ASSERT_EQUAL(DAVAR_OK, status_of(1, 0, 1.0));
    config.glr.whiten_tolerance = 100.1;
    TEST_ASSERT_EQUAL(DAVAR_ERR_TRACKING, status_of(1, 0, 1.0));
    config.glr.whiten_tolerance = -1e-9;
    TEST_ASSERT_EQUAL(DAVAR_ERR_TRACKING, status_of(1, 0, 1.0));
    TEST_ASSERT_EQUAL(DAVAR_OK, status_of(0, 0, 1.0));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_blocks_of_16_bits_are_whitened);
    RUN_TEST(test_blocks_of_32_bits_are_whitened);
    RUN_TEST(test_the_rest_is_clamped_and_no_sum_overflows);
    RUN_TEST(test_settings_out_of_range_are_rejected);
    return UNITY_END();
}
