/* davar tests - telemetry: addresses, the limits of values, and packets byte by byte. tests/dialects
 * decodes a million of them with other decoders. */
#include "davar/glr.h"
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
    davar_telemetry_begin(&telemetry, &result, NULL, 5000000U);
}

static uint32_t count_packets(const davar_dialect_t *dialect)
{
    uint32_t count = 0U;
    begin(dialect);
    while (davar_telemetry_next(&telemetry, &packet)) {
        count++;
    }
    return count;
}

static void test_each_dialect_has_its_number_of_packets(void)
{
    TEST_ASSERT_EQUAL(3, count_packets(&davar_mavlink));
    TEST_ASSERT_EQUAL(1, count_packets(&davar_mavlink_gyro_noise));
    TEST_ASSERT_EQUAL(6, count_packets(&davar_dronecan));
    TEST_ASSERT_EQUAL(1, count_packets(&davar_cyphal));
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

/* Checksum of the header and payload by the definition of CRC-16/MCRF4XX, bit by bit. */
static uint16_t crc_of(const uint8_t *bytes, size_t count, uint8_t extra)
{
    uint32_t crc = 0xFFFFU;
    for (size_t i = 0; i <= count; i++) {
        crc ^= (i < count) ? bytes[i] : extra;
        for (int bit = 0; bit < 8; bit++) {
            crc = ((crc & 1U) != 0U) ? (crc >> 1U) ^ 0x8408U : crc >> 1U;
        }
    }
    return (uint16_t)crc;
}

static void test_a_mavlink_packet_byte_by_byte(void)
{
    static const uint8_t wanted[] = {0xFD, 13, 0, 0, 0,    7,    42,  251, 0,   0,   0x88, 0x13,
                                     0,    0,  0, 0, 0x80, 0x3F, 'A', 'R', 'W', '_', 'Y'};
    const uint16_t crc = crc_of(wanted + 1, sizeof wanted - 1U, 170U);
    begin(&davar_mavlink);
    TEST_ASSERT_TRUE(davar_telemetry_next(&telemetry, &packet));
    TEST_ASSERT_EQUAL(sizeof wanted + 2U, packet.length);
    TEST_ASSERT_EQUAL_MEMORY(wanted, packet.data, sizeof wanted);
    TEST_ASSERT_EQUAL(crc & 0xFFU, packet.data[sizeof wanted]);
    TEST_ASSERT_EQUAL(crc >> 8U, packet.data[sizeof wanted + 1U]);
}

static void test_a_payload_loses_its_trailing_zeros_but_not_its_first_byte(void)
{
    for (size_t k = 0; k < DAVAR_COEFFICIENT_COUNT; k++) {
        result.coefficient[k] = (davar_coefficient_t){0};
    }
    result.kurtosis = 0.0;
    result.epoch = 0U;
    result.window_samples = 0U;
    const davar_telemetry_address_t first = {.channel = 0U, .node = 1U, .system = 1U};
    TEST_ASSERT_TRUE(davar_telemetry_init(&telemetry, &davar_mavlink_gyro_noise, &first, 0.0));
    davar_telemetry_begin(&telemetry, &result, NULL, 0U);
    TEST_ASSERT_TRUE(davar_telemetry_next(&telemetry, &packet));
    TEST_ASSERT_EQUAL(1, packet.data[1]);
    TEST_ASSERT_EQUAL(10 + 1 + 2, packet.length);
}

static void test_a_dronecan_frame_byte_by_byte(void)
{
    static const uint8_t wanted[] = {0, 0, 0x80, 0x3F, 'A', 'R', 'Y', 0xC0};
    begin(&davar_dronecan);
    TEST_ASSERT_TRUE(davar_telemetry_next(&telemetry, &packet));
    TEST_ASSERT_EQUAL_HEX32(0x183FF22AU, packet.identifier); /* priority 24, 16370, 42 */
    TEST_ASSERT_EQUAL(8, packet.length);
    TEST_ASSERT_EQUAL_MEMORY(wanted, packet.data, 8U);
}

static void test_a_cyphal_frame_fills_64_bytes(void)
{
    static const uint8_t start[] = {0x90, 0x78, 0x56, 0x34, 0x58, 0x02, 0, 0, 0, 0, 0x80, 0x3F};
    begin(&davar_cyphal);
    TEST_ASSERT_TRUE(davar_telemetry_next(&telemetry, &packet));
    TEST_ASSERT_EQUAL_HEX32(0x146E742AU, packet.identifier); /* priority 5, subject 3700, 42 */
    TEST_ASSERT_EQUAL(64, packet.length);
    TEST_ASSERT_EQUAL_MEMORY(start, packet.data, sizeof start);
    TEST_ASSERT_EQUAL(1, packet.data[60]); /* channel */
    TEST_ASSERT_EQUAL_HEX8(0U, packet.data[62]);
    TEST_ASSERT_EQUAL_HEX8(0xE0U, packet.data[63]);
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
            davar_telemetry_begin(&telemetry, &result, NULL, 0U);
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

static void check_heartbeat(const davar_dialect_t *dialect, uint32_t identifier,
                            const uint8_t *wanted, uint8_t length)
{
    TEST_ASSERT_TRUE(davar_telemetry_init(&telemetry, dialect, &home, 100.0));
    TEST_ASSERT_NOT_NULL(heartbeat_at(0U));
    TEST_ASSERT_NOT_NULL(heartbeat_at(UINT64_C(0x04030201) * 1000000U));
    TEST_ASSERT_EQUAL_HEX32(identifier, packet.identifier);
    TEST_ASSERT_EQUAL(length, packet.length);
    TEST_ASSERT_EQUAL_MEMORY(wanted, packet.data, length);
}

static void test_the_heartbeat_of_each_dialect_byte_by_byte(void)
{
    uint8_t mavlink[21] = {0xFD, 9, 0, 0, 1, 7, 42, 0, 0, 0, 0, 0, 0, 0, 18, 8, 0, 4, 3};
    const uint16_t crc = crc_of(mavlink + 1, 18U, 50U);
    mavlink[19] = (uint8_t)(crc & 0xFFU);
    mavlink[20] = (uint8_t)(crc >> 8U);
    check_heartbeat(&davar_mavlink, 0U, mavlink, sizeof mavlink);
    check_heartbeat(&davar_mavlink_gyro_noise, 0U, mavlink, sizeof mavlink);
    static const uint8_t status[] = {1, 2, 3, 4, 0, 0, 0, 0xC1};
    check_heartbeat(&davar_dronecan, 0x1801552AU, status, sizeof status); /* 24, 341, 42 */
    static const uint8_t beat[] = {1, 2, 3, 4, 0, 0, 0, 0xE1};
    check_heartbeat(&davar_cyphal, 0x147D552AU, beat, sizeof beat); /* 5, 7509, 42 */
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

/* Without a report, only those of the result are set. */
static void test_each_flag_is_one_bit_of_state(void)
{
    result.noise = DAVAR_NOISE_FILTERED;
    for (uint32_t flags = 0U; flags < 8U; flags++) {
        const davar_glr_report_t report = {.young = (flags & 2U) != 0U,
                                           .alarm = (flags & 4U) != 0U};
        result.unstable = (flags & 1U) != 0U;
        davar_telemetry_begin(&telemetry, &result, &report, 0U);
        TEST_ASSERT_EQUAL(5U + (8U * flags), davar_quantity_state(&telemetry));
        davar_telemetry_begin(&telemetry, &result, NULL, 0U);
        TEST_ASSERT_EQUAL(5U + (8U * (flags & 1U)), davar_quantity_state(&telemetry));
    }
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

static void test_the_axes_have_names(void)
{
    static const char letters[] = "XYZ3456789";
    for (uint8_t channel = 0U; channel <= DAVAR_TELEMETRY_CHANNEL_LAST; channel++) {
        TEST_ASSERT_EQUAL(letters[channel], davar_axis_letter(channel));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_each_dialect_has_its_number_of_packets);
    RUN_TEST(test_an_address_outside_a_dialect_is_refused);
    RUN_TEST(test_a_mavlink_packet_byte_by_byte);
    RUN_TEST(test_a_payload_loses_its_trailing_zeros_but_not_its_first_byte);
    RUN_TEST(test_a_dronecan_frame_byte_by_byte);
    RUN_TEST(test_a_cyphal_frame_fills_64_bytes);
    RUN_TEST(test_the_channels_of_a_sender_share_its_sequence);
    RUN_TEST(test_a_heartbeat_comes_once_a_second);
    RUN_TEST(test_the_heartbeat_of_each_dialect_byte_by_byte);
    RUN_TEST(test_heartbeats_count_in_the_sequence_of_mavlink_only);
    RUN_TEST(test_each_flag_is_one_bit_of_state);
    RUN_TEST(test_what_is_no_magnitude_is_absent_and_no_upper_limit_is_infinite);
    RUN_TEST(test_a_variance_is_the_nearest_float16_and_never_rounds_to_no_noise);
    RUN_TEST(test_the_axes_have_names);
    return UNITY_END();
}
