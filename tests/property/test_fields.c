/* davar tests - each field of the frames over its complete range, the others at their corners:
 * decode(encode(x)) is x. Fields of 32 bits are checked half by half. Of fields with 20 or 24 bits,
 * this checks every 7th or 251st value, and `test_fields long` every one, for a minute. */
#include "davar/can_decode.h"
#include "davar/glr.h"
#include "unity.h"

#include <math.h>
#include <string.h>

static const uint32_t taus[32] = {1U};
static davar_config_t config;
static davar_encoder_t encoder;
static davar_result_t result;
static davar_glr_report_t report;
static davar_can_health_t health;
static davar_decoded_t wire;
static bool is_long;
static uint32_t step; /* from value to value of the long ranges; 1, but a prime in slower builds */

void setUp(void)
{
    config = (davar_config_t){
        .rate_hz = 100.0, .stride = 1U, .law = &davar_law_glr_q15, .taus = taus, .tau_count = 32U};
    result = (davar_result_t){.window_samples = 1U, .tau_count = 32U};
    report = (davar_glr_report_t){.young = false};
    health = (davar_can_health_t){{0}};
}

void tearDown(void) {}

static void begin(uint8_t content)
{
    TEST_ASSERT_TRUE(davar_encoder_init(&encoder, &config, DAVAR_CAN_BASE, 0U, content));
    davar_encoder_begin(&encoder, &result, &report, &health);
}

/* The next frame of this message, decoded. */
static void receive(davar_message_t message)
{
    davar_frame_t frame;
    do {
        TEST_ASSERT_TRUE(davar_encoder_next(&encoder, &frame));
    } while ((frame.identifier - DAVAR_CAN_BASE) != (uint16_t)message);
    TEST_ASSERT_EQUAL(DAVAR_DECODED, davar_decode(&frame, DAVAR_CAN_BASE, &wire));
}

/* Value i of HALVES values of 32 bits: each half over its range, the other at a corner. */
#define HALVES (UINT32_C(4) << 16U)
static uint32_t half(uint32_t i)
{
    const uint32_t low = i & 0xFFFFU;
    const uint32_t corner = ((i >> 16U) & 1U) * 0xFFFFU;
    return ((i >> 17U) == 0U) ? ((corner << 16U) | low) : ((low << 16U) | corner);
}

static void test_window_and_flag(void)
{
    for (uint32_t i = 1U; i < (UINT32_C(2) << 19U); i += step) {
        const uint32_t window = i >> 1U;
        result.window_samples = (window == 0U) ? UINT32_MAX : window;
        result.unstable = (i % 2U) != 0U;
        result.epoch = ((i / 2U) % 2U) ? UINT32_MAX : 0U;
        begin(0U);
        receive(DAVAR_MESSAGE_STATE);
        TEST_ASSERT_EQUAL_UINT32((window == 0U) ? 0x7FFFFU : window, wire.window_samples);
        TEST_ASSERT_EQUAL(result.unstable, wire.unstable);
        TEST_ASSERT_EQUAL_HEX32(result.epoch, wire.number);
    }
}

static void test_epoch(void)
{
    for (uint32_t i = 0U; i < HALVES; i += step) {
        result.epoch = half(i);
        result.window_samples = (i % 2U) ? 0x7FFFFU : 1U;
        result.unstable = (i % 3U) == 0U;
        begin(0U);
        receive(DAVAR_MESSAGE_STATE);
        TEST_ASSERT_EQUAL_HEX32(result.epoch, wire.number);
        TEST_ASSERT_EQUAL_UINT32(result.window_samples, wire.window_samples);
        TEST_ASSERT_EQUAL(result.unstable, wire.unstable);
    }
}

static double scaled(uint32_t raw, uint32_t bits, double unit)
{
    return (raw == ((1U << bits) - 1U)) ? (double)NAN : (unit * raw);
}

/* The value that addons/can/DESIGN.md gives to `raw`, as a float32. */
static void same_scaled(uint32_t raw, uint32_t bits, double unit, float found)
{
    const float expected = (float)raw * (float)unit;
    if (raw == ((1U << bits) - 1U)) {
        TEST_ASSERT_TRUE(isnan(found));
    } else {
        TEST_ASSERT_EQUAL_MEMORY(&expected, &found, sizeof found);
    }
}

static void check_stationarity(uint32_t kurtosis, uint32_t contribution)
{
    result.kurtosis = scaled(kurtosis, 24U, 1e-3);
    result.contribution = scaled(contribution, 24U, 1e-5);
    begin(0U);
    receive(DAVAR_MESSAGE_STATIONARITY);
    same_scaled(kurtosis, 24U, 1e-3, wire.kurtosis);
    same_scaled(contribution, 24U, 1e-5, wire.contribution);
}

static void test_kurtosis_and_contribution(void)
{
    for (uint32_t raw = 0U; raw < (1U << 24U); raw += is_long ? 1U : (251U * step)) {
        check_stationarity(raw, 0xFFFFFFU - raw);
        check_stationarity(raw, (raw % 2U) * 0xFFFFFFU);
        check_stationarity((raw % 2U) * 0xFFFFFFU, raw);
    }
}

static void test_arw_its_uncertainty_and_the_reasons(void)
{
    davar_coefficient_t *const arw = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
    for (uint32_t raw = 0U; raw < 0xFFF7U; raw++) {
        arw->value = (raw % 2U) ? 0.001 : 1000.0;
        arw->low = 0.0;
        arw->high = arw->value * 2e-4 * raw;
        begin(0U);
        receive(DAVAR_MESSAGE_ARW);
        same_scaled(raw, 16U, 1e-4, wire.relative_uncertainty);
        TEST_ASSERT_EQUAL(DAVAR_NOISE_UNKNOWN, wire.noise);
        TEST_ASSERT_EQUAL_FLOAT(arw->value, wire.value);
    }
    arw->high = 1e9; /* its code is a reason only where ARW is absent */
    begin(0U);
    receive(DAVAR_MESSAGE_ARW);
    TEST_ASSERT_EQUAL(DAVAR_NOISE_UNKNOWN, wire.noise);
    for (uint32_t noise = 0U; noise <= (uint32_t)DAVAR_NOISE_FILTERED; noise++) {
        arw->value = (double)NAN;
        result.noise = (davar_noise_t)noise;
        begin(0U);
        receive(DAVAR_MESSAGE_ARW);
        TEST_ASSERT_EQUAL(noise, wire.noise);
        TEST_ASSERT_TRUE(isnan(wire.value) && isnan(wire.relative_uncertainty));
    }
}

static void test_every_deviation_and_uncertainty(void)
{
    for (uint32_t raw = 0U; raw < (1U << 11U); raw++) {
        for (uint8_t t = 0U; t < 32U; t++) {
            result.tau[t].adev = ((raw + t) % 2U) ? 1e-9 : 1e9;
            result.tau[t].low = 0.0;
            result.tau[t].high = result.tau[t].adev * 2.0 * scaled(raw, 11U, 1e-3);
        }
        begin(DAVAR_SEND_ADEV);
        for (uint8_t t = 0U; t < 32U; t++) {
            receive(DAVAR_MESSAGE_ADEV);
            TEST_ASSERT_EQUAL(t, wire.index);
            TEST_ASSERT_EQUAL_FLOAT(result.tau[t].adev, wire.value);
            same_scaled(raw, 11U, 1e-3, wire.relative_uncertainty);
        }
    }
}

static void test_change(void)
{
    for (uint32_t i = 0U; i < (1U << 20U); i += is_long ? 1U : (7U * step)) {
        report.cut_age_samples = i;
        report.change.m = (i < 4096U) ? i : ((i % 2U) * 4095U);
        const uint32_t dispersion = (i < 4096U) ? (4095U - i) : ((i / 2U) % 2U * 4095U);
        result.dispersion = scaled(dispersion, 12U, 1e-2);
        report.alarm = (i % 3U) == 0U;
        report.young = (i % 5U) == 0U;
        begin(0U);
        receive(DAVAR_MESSAGE_CHANGE);
        TEST_ASSERT_EQUAL_UINT32(i, wire.cut_age_samples);
        TEST_ASSERT_EQUAL_UINT32(report.change.m, wire.change_m);
        same_scaled(dispersion, 12U, 1e-2, wire.dispersion);
        TEST_ASSERT_EQUAL(report.alarm, wire.alarm);
        TEST_ASSERT_EQUAL(report.young, wire.young);
    }
}

static void test_the_floor_its_limits_and_the_reasons(void)
{
    static const float values[] = {0.0F, 1e-30F, 0.5F, 1e30F};
    const float limits[] = {NAN, INFINITY, 3e-8F, 7e5F};
    davar_floor_result_t floor;
    for (uint32_t i = 0U; i < 4U * 4U * 7U; i++) {
        floor = (davar_floor_result_t){.why = (davar_floor_why_t)(i % 7U),
                                       .value = ((i % 7U) == 0U) ? values[i % 4U] : NAN,
                                       .low = values[(i / 4U) % 4U],
                                       .high = limits[(i / 16U) % 4U]};
        const float sent[3] = {floor.value, floor.low, floor.high};
        begin((i % 2U) ? DAVAR_SEND_FD : 0U);
        davar_encoder_floor(&encoder, &floor);
        for (uint8_t kind = 0U; kind <= DAVAR_FLOOR_HIGH; kind++) {
            receive(DAVAR_MESSAGE_FLOOR);
            TEST_ASSERT_EQUAL(kind, wire.index);
            TEST_ASSERT_EQUAL(floor.why, wire.floor_why);
            TEST_ASSERT_EQUAL(isnan(sent[kind]) != 0, isnan(wire.value) != 0);
            if (!isnan(sent[kind])) {
                TEST_ASSERT_EQUAL_MEMORY(&sent[kind], &wire.value, sizeof wire.value);
            }
        }
    }
}

/* A frame of CAN FD has narrower fields. */
static void test_a_result_in_one_frame(void)
{
    davar_coefficient_t *const arw = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
    for (uint32_t i = 1U; i < (1U << 19U); i += step) {
        const uint32_t twelve = (i >> 7U) & 0xFFFU;
        const uint32_t uncertainty = (twelve < 0xFF7U) ? twelve : 0U;
        result.window_samples = i;
        result.unstable = (i % 3U) == 0U;
        result.epoch = half(i) & 0xFFFFFFU;
        result.kurtosis = scaled(i & 0xFFFFU, 16U, 1e-3);
        result.contribution = scaled(i & 0xFFFU, 12U, 1e-3);
        arw->value = (i % 2U) ? 0.001 : 1000.0;
        arw->high = arw->value * 2e-3 * uncertainty;
        begin(DAVAR_SEND_FD);
        receive(DAVAR_MESSAGE_RESULT_FD);
        TEST_ASSERT_EQUAL_UINT32(i, wire.window_samples);
        TEST_ASSERT_EQUAL(result.unstable, wire.unstable);
        TEST_ASSERT_EQUAL_HEX32(result.epoch, wire.number);
        same_scaled(i & 0xFFFFU, 16U, 1e-3, wire.kurtosis);
        same_scaled(i & 0xFFFU, 12U, 1e-3, wire.contribution);
        same_scaled(uncertainty, 12U, 1e-3, wire.relative_uncertainty);
    }
}

/* 32 bits of an integer, and the 8 of the session. */
static void test_health_counters_and_session(void)
{
    davar_frame_t frame;
    for (uint32_t i = 0U; i < HALVES; i += step) {
        const uint8_t item = (uint8_t)(i % (uint32_t)DAVAR_HEALTH_COUNT);
        begin(0U);
        davar_encoder_session(&encoder, (uint8_t)i);
        health.count[item] = half(i);
        davar_encoder_finish(&encoder, &health);
        for (uint8_t k = 0U; k <= item; k++) {
            TEST_ASSERT_TRUE(davar_encoder_next(&encoder, &frame));
        }
        TEST_ASSERT_EQUAL(DAVAR_DECODED, davar_decode(&frame, DAVAR_CAN_BASE, &wire));
        TEST_ASSERT_EQUAL(item, wire.index);
        TEST_ASSERT_EQUAL_HEX32(half(i), wire.number);
        TEST_ASSERT_EQUAL((uint8_t)i, wire.session);
    }
}

static void test_pairs_and_counts_of_raw_samples(void)
{
    davar_frame_t frame;
    begin(DAVAR_SEND_RAW);
    for (uint32_t i = 0U; i < (1U << 18U); i += step) {
        const uint32_t corner = (i >> 16U) * 0x5555U; /* 0, 5555, AAAA, FFFF */
        const int32_t first = (int16_t)i;
        const int32_t second = (int16_t)corner;
        TEST_ASSERT_FALSE(davar_encoder_raw(&encoder, i, first, &frame));
        TEST_ASSERT_TRUE(davar_encoder_raw(&encoder, (uint64_t)i + 1U, second, &frame));
        TEST_ASSERT_EQUAL(DAVAR_DECODED, davar_decode(&frame, DAVAR_CAN_BASE, &wire));
        TEST_ASSERT_EQUAL(DAVAR_RAW_PAIR, wire.index);
        TEST_ASSERT_EQUAL_UINT32(i, wire.number);
        TEST_ASSERT_EQUAL_INT32(first, wire.count[0]);
        TEST_ASSERT_EQUAL_INT32(second, wire.count[1]);
        TEST_ASSERT_FALSE(davar_encoder_raw(&encoder, i, (int32_t)half(i), &frame));
        TEST_ASSERT_TRUE(davar_encoder_raw_rest(&encoder, &frame));
        TEST_ASSERT_EQUAL(DAVAR_DECODED, davar_decode(&frame, DAVAR_CAN_BASE, &wire));
        TEST_ASSERT_EQUAL_HEX32(half(i), (uint32_t)wire.count[0]);
    }
}

/* Every float that may be sent comes back with the same bits, every other as 0 or NaN. */
static void check_float(uint32_t bits)
{
    davar_frame_t frame;
    float value;
    memcpy(&value, &bits, sizeof value);
    davar_encoder_raw_f32(&encoder, 0U, value, &frame);
    TEST_ASSERT_EQUAL(DAVAR_DECODED, davar_decode(&frame, DAVAR_CAN_BASE, &wire));
    if (!(fabsf(value) <= DAVAR_CAN_MOST)) {
        TEST_ASSERT_TRUE(isnan(wire.value));
    } else {
        const float sent = (fabsf(value) < DAVAR_CAN_LEAST) ? 0.0F : value;
        TEST_ASSERT_EQUAL_MEMORY(&sent, &wire.value, sizeof sent);
    }
}

static void test_floats(void)
{
    begin(0U);
    for (uint32_t i = 0U; i < HALVES; i += step) {
        check_float(half(i));
    }
}

int main(int count, char **arguments)
{
    step = (PROPERTY_TRIALS < 1000U) ? 61U : 1U;
    is_long = (count > 1) && (strcmp(arguments[1], "long") == 0);
    UNITY_BEGIN();
    RUN_TEST(test_window_and_flag);
    RUN_TEST(test_epoch);
    RUN_TEST(test_kurtosis_and_contribution);
    RUN_TEST(test_arw_its_uncertainty_and_the_reasons);
    RUN_TEST(test_every_deviation_and_uncertainty);
    RUN_TEST(test_change);
    RUN_TEST(test_the_floor_its_limits_and_the_reasons);
    RUN_TEST(test_a_result_in_one_frame);
    RUN_TEST(test_health_counters_and_session);
    RUN_TEST(test_pairs_and_counts_of_raw_samples);
    RUN_TEST(test_floats);
    return UNITY_END();
}
