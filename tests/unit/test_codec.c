/* davar tests - frames: cases that tests/wire does not reach without Python, and rejected
 * values. */
#include "davar/can_decode.h"
#include "davar/glr.h"
#include "davar/slcan.h"
#include "unity.h"

#include <math.h>
#include <string.h>

static const uint32_t taus[10] = {1, 2, 4, 8, 16, 32, 64, 128, 256, 512};
static davar_config_t config;
static davar_encoder_t encoder;
static davar_result_t result;
static davar_glr_report_t report;
static davar_can_health_t health;
static davar_frame_t frame;
static davar_decoded_t wire;

void setUp(void)
{
    config = (davar_config_t){.rate_hz = 100.0, .stride = 7U, .taus = taus, .tau_count = 3};
    health = (davar_can_health_t){{0}};
    result = (davar_result_t){.epoch = 0x123456789AU,
                              .window_samples = 600U,
                              .unstable = true,
                              .kurtosis = 3.1,
                              .contribution = (double)NAN,
                              .tau_count = 3};
    for (size_t t = 0; t < 10U; t++) {
        result.tau[t] = (davar_adev_t){
            .m = taus[t], .adev = 0.5 + (double)t, .low = 0.4 + (double)t, .high = 0.6 + (double)t};
    }
    for (size_t k = 0; k < DAVAR_COEFFICIENT_COUNT; k++) {
        result.coefficient[k] =
            (davar_coefficient_t){.value = 1.0 + (double)k, .low = 0.5, .high = 9.0};
    }
}

void tearDown(void) {}

static size_t count_frames(uint8_t content, uint8_t tau_count)
{
    size_t count = 0;
    config.tau_count = tau_count;
    result.tau_count = tau_count;
    TEST_ASSERT_TRUE(davar_encoder_init(&encoder, &config, DAVAR_CAN_BASE, 0U, content));
    davar_encoder_begin(&encoder, &result, &report, &health);
    while (davar_encoder_next(&encoder, &frame)) {
        TEST_ASSERT_EQUAL(DAVAR_DECODED, davar_decode(&frame, DAVAR_CAN_BASE, &wire));
        count++;
    }
    return count;
}

/* Those of a change are sent if law glr reported: one, or all four. */
static void test_a_report_adds_frames_to_a_result(void)
{
    config.law = &davar_law_glr_q15;
    TEST_ASSERT_EQUAL(7, count_frames(0U, 3U));
    TEST_ASSERT_EQUAL(13, count_frames(DAVAR_SEND_ADEV, 3U));
    TEST_ASSERT_TRUE(davar_encoder_init(&encoder, &config, DAVAR_CAN_BASE, 0U, 0U));
    davar_encoder_begin(&encoder, &result, NULL, &health);
    while (davar_encoder_next(&encoder, &frame)) {
        TEST_ASSERT_NOT_EQUAL(DAVAR_CAN_BASE + DAVAR_MESSAGE_CHANGE, frame.identifier);
    }
}

static void test_the_content_decides_how_many_frames_a_result_has(void)
{
    TEST_ASSERT_EQUAL(6, count_frames(0U, 3U));
    config.law = &davar_law_or; /* it reports no change */
    TEST_ASSERT_EQUAL(6, count_frames(0U, 3U));
    config.law = NULL;
    TEST_ASSERT_EQUAL(9, count_frames(DAVAR_SEND_ADEV, 3U));
    TEST_ASSERT_EQUAL(14, count_frames(DAVAR_SEND_ADEV | DAVAR_SEND_COEFFICIENTS, 3U));
    TEST_ASSERT_EQUAL(24, count_frames(DAVAR_SEND_ADEV | DAVAR_SEND_INTERVALS, 3U));
    TEST_ASSERT_EQUAL(4, count_frames(DAVAR_SEND_FD, 8U));
    result.unstable = false;
    TEST_ASSERT_EQUAL(5, count_frames(DAVAR_SEND_FD, 9U));
    TEST_ASSERT_EQUAL(6, count_frames(DAVAR_SEND_FD, 10U));
    TEST_ASSERT_EQUAL(6, count_frames(0U, 10U));
}

/* The published values of FNV-1a: "" and "foobar", of which the identifier's bytes are the first
 * two. */
static void test_the_digest_is_fnv_1a(void)
{
    frame = (davar_frame_t){.identifier = 0x6F66U, .length = 5U, .data = {0, 'o', 'b', 'a', 'r'}};
    TEST_ASSERT_EQUAL_HEX32(0xBF9CF968U, davar_frame_digest(&frame));
}

static void test_identifiers_beyond_eleven_bits_are_rejected(void)
{
    TEST_ASSERT_TRUE(davar_encoder_init(&encoder, &config, 0x7F0U, 0U, 0U));
    TEST_ASSERT_FALSE(davar_encoder_init(&encoder, &config, 0x7F1U, 0U, 0U));
    TEST_ASSERT_TRUE(davar_encoder_init(&encoder, &config, DAVAR_CAN_BASE, 34U, 0U));
    TEST_ASSERT_FALSE(davar_encoder_init(&encoder, &config, DAVAR_CAN_BASE, 35U, 0U));
}

/* The item of the first health frame of the next result. */
static uint8_t next_health_item(void)
{
    davar_encoder_begin(&encoder, &result, &report, &health);
    uint8_t item = 255U;
    while (davar_encoder_next(&encoder, &frame)) {
        TEST_ASSERT_EQUAL(DAVAR_DECODED, davar_decode(&frame, DAVAR_CAN_BASE, &wire));
        item = (wire.message == DAVAR_MESSAGE_HEALTH) ? wire.index : item;
    }
    return item;
}

static void test_a_health_counter_that_changed_goes_first(void)
{
    TEST_ASSERT_TRUE(davar_encoder_init(&encoder, &config, DAVAR_CAN_BASE, 0U, 0U));
    TEST_ASSERT_EQUAL(0, next_health_item());
    TEST_ASSERT_EQUAL(1, next_health_item());
    health.count[DAVAR_HEALTH_BUS_OFF] = 1U;
    TEST_ASSERT_EQUAL(DAVAR_HEALTH_BUS_OFF, next_health_item());
    TEST_ASSERT_EQUAL(DAVAR_HEALTH_BUS_OFF + 1, next_health_item());
}

static void test_the_counters_of_an_instance_go_to_their_frames_and_leave_the_others(void)
{
    static const davar_health_item_t own[] = {
        DAVAR_HEALTH_GAPS,
        DAVAR_HEALTH_MISSING_SAMPLES,
        DAVAR_HEALTH_SATURATED_SAMPLES,
        DAVAR_HEALTH_NOT_FINITE_SAMPLES,
        DAVAR_HEALTH_WINDOW_RESTARTS,
        DAVAR_HEALTH_RESULTS_MISSED,
        DAVAR_HEALTH_WINDOW_CUTS,
        DAVAR_HEALTH_NOISE_ALARMS,
        DAVAR_HEALTH_SHOCKS_LEFT_OUT,
    };
    static const davar_health_t counted = {.gaps = 1U,
                                           .missing = 2U,
                                           .saturated = 3U,
                                           .not_finite = 4U,
                                           .restarts = 5U,
                                           .missed = 6U,
                                           .cuts = 7U,
                                           .alarms = 8U,
                                           .shocks = 9U};
    davar_can_health_t expected = {{0}};
    health.count[DAVAR_HEALTH_BUS_OFF] = 77U;
    expected.count[DAVAR_HEALTH_BUS_OFF] = 77U;
    for (uint32_t i = 0U; i < (sizeof own / sizeof own[0]); i++) {
        expected.count[own[i]] = i + 1U;
    }
    davar_can_health(&health, &counted);
    TEST_ASSERT_EQUAL_MEMORY(&expected, &health, sizeof health);
}

static void seal(void)
{
    frame.data[0] = davar_frame_crc(&frame);
}

/* One status for each cause; a bad check is reported before a bad value. */
static void test_a_foreign_frame_is_reported(void)
{
    static const struct {
        uint16_t identifier;
        uint8_t length;
        uint8_t item;
        bool is_sealed;
        davar_decode_status_t status;
    } cases[] = {
        {0x5D4U, 8U, 15U, true, DAVAR_DECODE_VALUE},
        {0x5D6U, 8U, 2U, true, DAVAR_DECODE_VALUE},
        {0x5D6U, 8U, 64U, true, DAVAR_DECODE_VALUE},
        {0x5D7U, 8U, 33U, true, DAVAR_DECODE_VALUE},
        {0x5D7U, 8U, 33U, false, DAVAR_DECODE_CRC},
        {0x5D7U, 7U, 33U, true, DAVAR_DECODE_LENGTH},
        {0x5DCU, 8U, 3U, true, DAVAR_DECODE_VALUE},
        {0x5DCU, 8U, 7U << 2U, true, DAVAR_DECODE_VALUE},
        {0x5DDU, 7U, 33U, true, DAVAR_DECODE_FOREIGN},
        {0x5CFU, 8U, 33U, true, DAVAR_DECODE_FOREIGN},
    };
    for (size_t i = 0U; i < sizeof cases / sizeof cases[0]; i++) {
        frame = (davar_frame_t){.identifier = cases[i].identifier,
                                .length = cases[i].length,
                                .data = {0, 0, cases[i].item}};
        seal();
        frame.data[0] = (uint8_t)(frame.data[0] + (cases[i].is_sealed ? 0U : 1U));
        TEST_ASSERT_EQUAL(cases[i].status, davar_decode(&frame, DAVAR_CAN_BASE, &wire));
    }
}

/* The receiver's status for a frame with this float (or count) after these bytes of its header. */
static davar_decode_status_t status_of(uint16_t identifier, uint8_t index, float value)
{
    frame = (davar_frame_t){.identifier = identifier, .length = 8U, .data = {0, 0, index}};
    memcpy(&frame.data[4], &value, sizeof value);
    seal();
    return davar_decode(&frame, DAVAR_CAN_BASE, &wire);
}

#define INDEX_OF_HIGH 10U /* an upper limit may be infinite */

static void test_impossible_values_are_rejected_and_absent_ones_are_not(void)
{
    static const float values[] = {0.0F,  1e-29F,   3.0F,  9e29F,  NAN,      -9.7e-32F,
                                   -1.0F, 9.7e-32F, 2e30F, 1e-40F, INFINITY, -INFINITY};
    static const struct {
        uint16_t identifier;
        uint8_t index;
        uint16_t accepted; /* bit i: values[i] */
    } cases[] = {
        {0x5D0U, 0U, 0x01FU},
        {0x5D3U, 0U, 0x01FU},
        {0x5D4U, 0U, 0x01FU},
        {0x5D4U, 9U, 0x01FU},
        {0x5D4U, INDEX_OF_HIGH, 0x41FU},
        {0x5D7U, 0U, 0x05FU}, /* a deviation from the model has a sign */
        {0x5D7U, DAVAR_MONITOR_HEALTH, 0x01FU},
        {0x5D1U, 0U, 0x000U}, /* a window of 0 samples */
        {0x5D1U, 1U, 0xFFFU},
        {0x5D6U, DAVAR_SETUP_STRIDE, 0xFFEU},
        {0x5D6U, DAVAR_SETUP_TAU, 0xFFEU},
        {0x5D6U, DAVAR_SETUP_RATE, 0x00EU},
        {0x5D6U, DAVAR_SETUP_UNIT, 0x00EU},
        {0x5D6U, DAVAR_SETUP_UNIT + 1U, 0x000U}, /* no such item */
        {0x5DBU, 0U, 0x000U},                    /* a result has at least one frame */
        {0x5DBU, 1U, 0xFFFU},
        {0x5DCU, 0U, 0x01FU},
        {0x5DCU, 1U, 0x01FU},
        {0x5DCU, DAVAR_FLOOR_HIGH, 0x41FU},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        for (size_t k = 0; k < sizeof values / sizeof values[0]; k++) {
            const bool good = ((cases[i].accepted >> k) & 1U) != 0U;
            TEST_ASSERT_EQUAL(good ? DAVAR_DECODED : DAVAR_DECODE_VALUE,
                              status_of(cases[i].identifier, cases[i].index, values[k]));
        }
    }
}

static davar_decode_status_t status_of_fd(void)
{
    TEST_ASSERT_TRUE(davar_encoder_init(&encoder, &config, DAVAR_CAN_BASE, 0U, DAVAR_SEND_FD));
    davar_encoder_begin(&encoder, &result, &report, &health);
    TEST_ASSERT_TRUE(davar_encoder_next(&encoder, &frame));
    return davar_decode(&frame, DAVAR_CAN_BASE, &wire);
}

/* The status of an FD frame with another float32 at this byte. */
static davar_decode_status_t status_of_fd_with(size_t at, float value)
{
    (void)status_of_fd();
    memcpy(&frame.data[at], &value, sizeof value);
    seal();
    return davar_decode(&frame, DAVAR_CAN_BASE, &wire);
}

static void test_every_value_of_an_fd_frame_is_looked_at(void)
{
    TEST_ASSERT_EQUAL(DAVAR_DECODED, status_of_fd());
    TEST_ASSERT_EQUAL(DAVAR_DECODED, status_of_fd_with(4U, NAN));
    TEST_ASSERT_EQUAL(DAVAR_DECODE_VALUE, status_of_fd_with(4U, -1.0F)); /* ARW */
    for (size_t at = 16U; at < 64U; at += 4U) { /* the other coefficients, then the deviations */
        TEST_ASSERT_EQUAL(DAVAR_DECODED, status_of_fd_with(at, NAN));
        TEST_ASSERT_EQUAL(DAVAR_DECODE_VALUE, status_of_fd_with(at, -1.0F));
        TEST_ASSERT_EQUAL(DAVAR_DECODE_VALUE, status_of_fd_with(at, 2e30F));
    }
    setUp();
    result.window_samples = 0U;
    TEST_ASSERT_EQUAL(DAVAR_DECODE_VALUE, status_of_fd());
}

static bool slcan(const char *text)
{
    return davar_slcan_decode(text, strlen(text), &frame);
}

static void test_slcan_text_goes_there_and_back(void)
{
    char text[DAVAR_SLCAN_BYTES];
    const davar_frame_t sent = {
        .identifier = 0x5D1U, .length = 8U, .data = {0, 1, 0x9A, 0xBC, 0xDE, 0xF0, 0x7F, 255}};
    TEST_ASSERT_EQUAL(22, davar_slcan_encode(&sent, text));
    TEST_ASSERT_EQUAL_STRING_LEN("t5D1800019ABCDEF07FFF\r", text, 22);
    TEST_ASSERT_TRUE(davar_slcan_decode(text, 21U, &frame));
    TEST_ASSERT_EQUAL_HEX16(sent.identifier, frame.identifier);
    TEST_ASSERT_EQUAL_MEMORY(sent.data, frame.data, 8);
    TEST_ASSERT_TRUE(slcan("t5d1800019abcdef07fff"));
    TEST_ASSERT_EQUAL_HEX16(sent.identifier, frame.identifier);
    TEST_ASSERT_EQUAL_MEMORY(sent.data, frame.data, 8);
    TEST_ASSERT_TRUE(slcan("t5D12AB011234")); /* with a time stamp */
    TEST_ASSERT_TRUE(slcan("t5D10"));
}

static void test_slcan_text_that_is_no_frame_is_rejected(void)
{
    static const char *const bad[] = {
        "",      "t5D1",      "T5D10",        "t5G10",         "t5D1x",
        "t8000", "t5D19000",  "t5D12AB0",     "t5D12AB0G1",    "t5D12AB011",
        "r5D10", "t5D12AB:1", "t5D12AB01123", "t5D12AB01123G", "t5D1@",
        "t5D1-"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        TEST_ASSERT_FALSE_MESSAGE(slcan(bad[i]), bad[i]);
    }
}

static davar_decode_status_t seen(void)
{
    return davar_decode(&frame, DAVAR_CAN_BASE, &wire);
}

static void assert_raw(davar_raw_form_t form, uint32_t number, int32_t first, int32_t second)
{
    TEST_ASSERT_EQUAL(DAVAR_DECODED, seen());
    TEST_ASSERT_EQUAL(DAVAR_MESSAGE_RAW, wire.message);
    TEST_ASSERT_EQUAL_UINT8(form, wire.index);
    TEST_ASSERT_EQUAL_UINT32(number, wire.number);
    TEST_ASSERT_EQUAL_INT32(first, wire.count[0]);
    TEST_ASSERT_EQUAL_INT32(second, wire.count[1]);
}

static void test_raw_counts_go_in_pairs_where_they_are_narrow_and_follow_each_other(void)
{
    static const struct {
        uint64_t index;
        int32_t count;
        bool sends; /* ... this frame: */
        davar_raw_form_t form;
        uint32_t number;
        int32_t first;
        int32_t second;
    } cases[] = {
        {0x123456789AU, -32768, false, DAVAR_RAW_PAIR, 0U, 0, 0},
        {0x123456789BU, 32767, true, DAVAR_RAW_PAIR, 0x2789AU, -32768, 32767},
        {10U, 5, false, DAVAR_RAW_PAIR, 0U, 0, 0},
        {12U, 6, true, DAVAR_RAW_COUNT, 10U, 5, 0},     /* a gap */
        {13U, 32768, true, DAVAR_RAW_COUNT, 12U, 6, 0}, /* too wide */
        {14U, -32769, true, DAVAR_RAW_COUNT, 13U, 32768, 0},
        {15U, 7, true, DAVAR_RAW_COUNT, 14U, -32769, 0},
        {16U, -32769, true, DAVAR_RAW_COUNT, 15U, 7, 0}, /* whichever count is too wide */
    };
    TEST_ASSERT_TRUE(davar_encoder_init(&encoder, &config, DAVAR_CAN_BASE, 0U, DAVAR_SEND_RAW));
    TEST_ASSERT_FALSE(davar_encoder_raw_rest(&encoder, &frame));
    for (size_t i = 0U; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_EQUAL(cases[i].sends,
                          davar_encoder_raw(&encoder, cases[i].index, cases[i].count, &frame));
        if (cases[i].sends) {
            assert_raw(cases[i].form, cases[i].number, cases[i].first, cases[i].second);
        }
    }
    TEST_ASSERT_TRUE(davar_encoder_raw_rest(&encoder, &frame));
    assert_raw(DAVAR_RAW_COUNT, 16U, -32769, 0);
    TEST_ASSERT_EQUAL_UINT8(6U, wire.counter);
}

static void test_a_raw_rate_that_no_encoder_sends_is_rejected(void)
{
    static const float none = INFINITY;
    TEST_ASSERT_TRUE(davar_encoder_init(&encoder, &config, DAVAR_CAN_BASE, 0U, DAVAR_SEND_RAW));
    davar_encoder_raw_f32(&encoder, 0U, -2.5F, &frame);
    assert_raw(DAVAR_RAW_RATE, 0U, 0, 0);
    TEST_ASSERT_EQUAL_FLOAT(-2.5F, wire.value);
    memcpy(&frame.data[4], &none, sizeof none);
    seal();
    TEST_ASSERT_EQUAL(DAVAR_DECODE_VALUE, seen());
    frame.data[1] |= 0x30U; /* form 3 */
    seal();
    TEST_ASSERT_EQUAL(DAVAR_DECODE_VALUE, seen());
}

/* Floats have no count: 1. */
static void test_the_setup_contains_the_size_of_a_count_when_counts_are_sent(void)
{
    static const double units[] = {0.05, 0.0};
    for (size_t i = 0U; i < 2U; i++) {
        bool is_sent = false;
        config.unit_per_count = units[i];
        TEST_ASSERT_TRUE(davar_encoder_init(&encoder, &config, DAVAR_CAN_BASE, 0U, DAVAR_SEND_RAW));
        for (unsigned n = 0U; n < 6U; n++) {
            davar_encoder_begin(&encoder, &result, &report, &health);
            while (davar_encoder_next(&encoder, &frame)) {
                TEST_ASSERT_EQUAL(DAVAR_DECODED, seen());
                if ((wire.message == DAVAR_MESSAGE_SETUP) && (wire.index == DAVAR_SETUP_UNIT)) {
                    TEST_ASSERT_EQUAL_FLOAT((i == 0U) ? 0.05F : 1.0F, wire.value);
                    is_sent = true;
                }
            }
        }
        TEST_ASSERT_TRUE(is_sent);
    }
}

/* SAE J1850's check value: the checksum of "123456789" is 4B. */
static void test_the_checksum_is_sae_j1850_s(void)
{
    davar_frame_t nine = {
        .identifier = 0x3231U, .length = 8U, .data = {0xEEU, '3', '4', '5', '6', '7', '8', '9'}};
    TEST_ASSERT_EQUAL_HEX8(0x4BU, davar_frame_crc(&nine));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_the_content_decides_how_many_frames_a_result_has);
    RUN_TEST(test_a_report_adds_frames_to_a_result);
    RUN_TEST(test_the_digest_is_fnv_1a);
    RUN_TEST(test_identifiers_beyond_eleven_bits_are_rejected);
    RUN_TEST(test_a_health_counter_that_changed_goes_first);
    RUN_TEST(test_the_counters_of_an_instance_go_to_their_frames_and_leave_the_others);
    RUN_TEST(test_a_foreign_frame_is_reported);
    RUN_TEST(test_impossible_values_are_rejected_and_absent_ones_are_not);
    RUN_TEST(test_every_value_of_an_fd_frame_is_looked_at);
    RUN_TEST(test_slcan_text_goes_there_and_back);
    RUN_TEST(test_slcan_text_that_is_no_frame_is_rejected);
    RUN_TEST(test_raw_counts_go_in_pairs_where_they_are_narrow_and_follow_each_other);
    RUN_TEST(test_a_raw_rate_that_no_encoder_sends_is_rejected);
    RUN_TEST(test_the_setup_contains_the_size_of_a_count_when_counts_are_sent);
    RUN_TEST(test_the_checksum_is_sae_j1850_s);
    return UNITY_END();
}
