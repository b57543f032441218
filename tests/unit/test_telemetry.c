/* davar tests - telemetry: addresses, the limits of values, and packets byte by byte. tests/dialects
 * decodes a million of them with other decoders. */
#include "davar/telemetry.h"
#include "packet.h"
#include "unity.h"

#include <math.h>
#include <string.h>

static const davar_telemetry_address_t home = {
    .channel = 1U, .node = 42U, .system = 7U, .subject = 3700U};
static davar_result_t result;
static davar_telemetry_t telemetry;
static davar_packet_t packet;

void setUp(void)
{
    memset(&packet, 0, sizeof packet);
    result = (davar_result_t){.epoch = 0x1234567890U, .window_samples = 600U, .kurtosis = 3.0};
    for (size_t k = 0; k < DAVAR_COEFFICIENT_COUNT; k++) {
        result.coefficient[k] =
            (davar_coefficient_t){.present = true, .value = 1.0, .low = 0.5, .high = 2.0};
    }
}

void tearDown(void) {}

static void begin(const davar_dialect_t *dialect)
{
    TEST_ASSERT_TRUE(davar_telemetry_init(&telemetry, dialect, &home, 100.0));
    davar_telemetry_begin(&telemetry, &result, 5000000U);
}

static bool is_accepted(const davar_dialect_t *dialect, davar_telemetry_address_t from)
{
    const davar_telemetry_t before = telemetry;
    const bool accepted = davar_telemetry_init(&telemetry, dialect, &from, 100.0);
    if (!accepted) {
        TEST_ASSERT_EQUAL_MEMORY(&before, &telemetry, sizeof telemetry);
    }
    return accepted;
}

static void test_an_address_outside_a_dialect_is_refused(void)
{
    memset(&telemetry, 0x5A, sizeof telemetry);
    const davar_dialect_t *const dialects[] = {&davar_mavlink, &davar_mavlink_gyro_noise,
                                               &davar_dronecan, &davar_cyphal};
    for (size_t i = 0; i < 4U; i++) {
        const bool is_can = (i >= 2U);
        TEST_ASSERT_TRUE(
            is_accepted(dialects[i], (davar_telemetry_address_t){9U, 127U, 1U, 8191U}));
        TEST_ASSERT_FALSE(is_accepted(dialects[i], (davar_telemetry_address_t){10U, 1U, 1U, 1U}));
        TEST_ASSERT_FALSE(is_accepted(dialects[i], (davar_telemetry_address_t){0U, 0U, 1U, 1U}));
        TEST_ASSERT_EQUAL(!is_can,
                          is_accepted(dialects[i], (davar_telemetry_address_t){0U, 128U, 1U, 1U}));
        TEST_ASSERT_EQUAL(is_can,
                          is_accepted(dialects[i], (davar_telemetry_address_t){0U, 1U, 0U, 1U}));
        TEST_ASSERT_EQUAL(dialects[i] != &davar_cyphal,
                          is_accepted(dialects[i], (davar_telemetry_address_t){0U, 1U, 1U, 8192U}));
    }
}

/* A sender of three axes: the receiver must find one sequence without a hole. */
static void test_the_channels_of_a_sender_share_its_sequence(void)
{
    static const davar_dialect_t *const dialects[] = {&davar_mavlink, &davar_dronecan,
                                                      &davar_cyphal};
    for (size_t i = 0U; i < 3U; i++) {
        uint32_t count = 0U;
        begin(dialects[i]);
        for (uint32_t number = 0U; number < 12U; number++) {
            TEST_ASSERT_TRUE(davar_telemetry_set_channel(&telemetry, (uint8_t)(number % 3U)));
            davar_telemetry_begin(&telemetry, &result, 0U);
            for (; davar_telemetry_next(&telemetry, &packet); count++) {
                const uint8_t number_byte = packet.data[(i == 0U) ? 4U : (packet.length - 1U)];
                TEST_ASSERT_EQUAL(count % 32U, number_byte & 31U);
            }
            if (i == 1U) { /* the last frame: BHX, BHY, BHZ */
                TEST_ASSERT_EQUAL('X' + number % 3U, packet.data[6]);
            }
        }
    }
    TEST_ASSERT_TRUE(davar_telemetry_set_channel(&telemetry, 9U));
    TEST_ASSERT_FALSE(davar_telemetry_set_channel(&telemetry, 10U));
    TEST_ASSERT_EQUAL(9, telemetry.from.channel);
}

/* The heartbeat at a time; NULL: none is due. */
static const davar_packet_t *heartbeat_at(uint64_t time_us)
{
    return davar_telemetry_heartbeat(&telemetry, time_us, &packet) ? &packet : NULL;
}

/* DroneCAN and Cyphal allow at most a second between two on the average: a late call does not delay
 * those that follow. They go on after a clock that jumps. */
static void test_a_heartbeat_comes_once_a_second(void)
{
    static const struct {
        uint64_t time_us;
        bool due;
    } calls[] = {
        {0U, true},        {999999U, false},
        {1000000U, true},  {1999999U, false},
        {7000000U, true},  {7999999U, false},
        {50000000U, true}, {50000000U, false},
        {3000000U, true},  {3999999U, false},
        {4000000U, true},  {6000000U, true}, /* a second late: one heartbeat is left out */
        {6999999U, false},
    };
    uint32_t count = 0U;
    TEST_ASSERT_TRUE(davar_telemetry_init(&telemetry, &davar_cyphal, &home, 100.0));
    for (size_t i = 0U; i < sizeof calls / sizeof calls[0]; i++) {
        const davar_packet_t before = packet;
        TEST_ASSERT_EQUAL(calls[i].due, heartbeat_at(calls[i].time_us) != NULL);
        TEST_ASSERT_TRUE(calls[i].due || (before.length == packet.length));
        TEST_ASSERT_TRUE(calls[i].due ||
                         (memcmp(before.data, packet.data, sizeof packet.data) == 0));
    }
    TEST_ASSERT_TRUE(davar_telemetry_init(&telemetry, &davar_cyphal, &home, 100.0));
    for (uint64_t time_us = 0U; time_us <= 100000000U; time_us += 333000U) {
        count += (heartbeat_at(time_us) != NULL) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL(100, count);
}

/* MAVLink counts all packets of a sender, DroneCAN and Cyphal those of each type. */
static void test_heartbeats_count_in_the_sequence_of_mavlink_only(void)
{
    begin(&davar_mavlink);
    TEST_ASSERT_NOT_NULL(heartbeat_at(0U));
    TEST_ASSERT_TRUE(davar_telemetry_next(&telemetry, &packet));
    TEST_ASSERT_EQUAL(1, packet.data[4]);
    begin(&davar_dronecan);
    for (uint32_t i = 0U; i < 40U; i++) {
        TEST_ASSERT_NOT_NULL(heartbeat_at((uint64_t)i * 1000000U));
        TEST_ASSERT_EQUAL_HEX8(0xC0U | (i % 32U), packet.data[7]);
    }
    TEST_ASSERT_TRUE(davar_telemetry_next(&telemetry, &packet));
    TEST_ASSERT_EQUAL_HEX8(0xC0U, packet.data[7]);
}

static void check_arw(double value, uint32_t value_bits, uint32_t high_bits)
{
    result.coefficient[DAVAR_ANGLE_RANDOM_WALK] =
        (davar_coefficient_t){.value = value, .low = value, .high = value};
    begin(&davar_cyphal);
    TEST_ASSERT_EQUAL_HEX32(value_bits, davar_quantity(&telemetry, QUANTITY_ARW));
    TEST_ASSERT_EQUAL_HEX32(value_bits, davar_quantity(&telemetry, QUANTITY_ARW_LOW));
    TEST_ASSERT_EQUAL_HEX32(high_bits, davar_quantity(&telemetry, QUANTITY_ARW_HIGH));
}

static void test_what_is_no_magnitude_is_absent_and_no_upper_limit_is_infinite(void)
{
    const uint32_t nan_bits = 0x7FC00000U;
    check_arw(0.25, 0x3E800000U, 0x3E800000U);
    check_arw(0.0, 0U, 0U);
    check_arw(1e-31, 0U, 0U);
    check_arw(1e31, nan_bits, 0x7F800000U);
    check_arw((double)INFINITY, nan_bits, 0x7F800000U);
    check_arw(-(double)INFINITY, nan_bits, nan_bits);
    check_arw(-1.0, nan_bits, nan_bits);
    check_arw(-(double)NAN, nan_bits, nan_bits);
}

static void test_a_variance_is_the_density_of_the_noise_times_the_rate(void)
{
    const double degree = 3.14159265358979323846 / 180.0;
    davar_coefficient_t *arw = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
    arw->value = 0.3; /* 0.3 deg after an hour: 0.005 deg after a second */
    TEST_ASSERT_DOUBLE_WITHIN(1e-18, 0.005 * degree * 0.005 * degree * 400.0,
                              davar_rate_variance(&result, 400.0));
    TEST_ASSERT_TRUE(isnan(davar_rate_variance(&result, 0.0)));
    TEST_ASSERT_TRUE(isnan(davar_rate_variance(&result, (double)NAN)));
    arw->value = (double)NAN;
    TEST_ASSERT_TRUE(isnan(davar_rate_variance(&result, 400.0)));
}

static uint32_t half_of(double variance)
{
    const double gyro[3] = {variance, 1.0, (double)NAN};
    const double accel[3] = {-1.0, 0.0, variance};
    uint8_t bytes[DAVAR_COVARIANCE_BYTES];
    static const uint8_t middle[8] = {0x00, 0x3C, 0x00, 0x7E, 0x00, 0x7E, 0x00, 0x00};
    davar_dronecan_covariance(gyro, accel, bytes);
    TEST_ASSERT_EQUAL_MEMORY(middle, bytes + 2, sizeof middle);
    TEST_ASSERT_EQUAL_MEMORY(bytes, bytes + 10, 2U);
    return (uint32_t)bytes[0] | ((uint32_t)bytes[1] << 8U);
}

static void test_a_variance_is_the_nearest_float16_and_never_rounds_to_no_noise(void)
{
    static const struct {
        double variance;
        uint16_t half;
    } cases[] = {
        {1.0, 0x3C00},
        {1e-12, 0x0001},
        {1e-40, 0x0001},
        {1.5 * 0x1p-24, 0x0002}, /* a tie, to even */
        {2.5 * 0x1p-24, 0x0002},
        {6.103515625e-05, 0x0400},
        {6.1035e-05, 0x0400}, /* rounds up to a normal number */
        {1.0 + 1.0 / 1024.0, 0x3C01},
        {1.0 + 1.0 / 2048.0, 0x3C00},
        {1.0 + 3.0 / 2048.0, 0x3C02},
        {65504.0, 0x7BFF},
        {65519.0, 0x7BFF},
        {65520.0, 0x7C00},
        {1e20, 0x7C00},
        {1e31, 0x7C00},
        {INFINITY, 0x7C00},
        {-INFINITY, 0x7E00},
        {0.0, 0x0000},
    };
    for (size_t i = 0U; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_EQUAL_HEX16(cases[i].half, half_of(cases[i].variance));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_an_address_outside_a_dialect_is_refused);
    RUN_TEST(test_the_channels_of_a_sender_share_its_sequence);
    RUN_TEST(test_a_heartbeat_comes_once_a_second);
    RUN_TEST(test_heartbeats_count_in_the_sequence_of_mavlink_only);
    RUN_TEST(test_what_is_no_magnitude_is_absent_and_no_upper_limit_is_infinite);
    RUN_TEST(test_a_variance_is_the_density_of_the_noise_times_the_rate);
    RUN_TEST(test_a_variance_is_the_nearest_float16_and_never_rounds_to_no_noise);
    return UNITY_END();
}
