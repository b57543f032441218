/* davar tests - results of any bits as frames and as the packets of autopilots: each frame decodes
 * and is within its ranges, each packet fits, and the number of both is limited. */
#include "davar/can.h"
#include "davar/can_decode.h"
#include "davar/davar.h"
#include "davar/kalman.h"
#include "davar/slcan.h"
#include "davar/small.h"
#include "davar/telemetry.h"
#include "davar/torn.h"
#include "digest.h"
#include "fuzzing.h"
#include "random.h"

#include <math.h>
#include <string.h>

static const uint32_t taus[DAVAR_TAUS_MAX] = {1U};
static davar_config_t config;
static davar_result_t result;
static davar_glr_report_t report;
static davar_misfit_t misfit;
static davar_floor_result_t noise_floor;
static davar_can_health_t health;
static davar_encoder_t encoder;
static davar_telemetry_t telemetry;

/* Of any magnitude. */
static uint64_t magnitude(bytes_t *bytes)
{
    const uint32_t shift = byte(bytes) % 64U;
    return word(bytes, 8U) >> shift;
}

/* Any bits; or a usual number, none, infinity, 0, negative. */
static double any(bytes_t *bytes)
{
    static const double special[] = {0.0, -0.0, -1.0, 1.0};
    const uint8_t kind = byte(bytes);
    if (kind < 32U) {
        const uint64_t bits = word(bytes, 8U);
        double value;
        memcpy(&value, &bits, sizeof value);
        return value;
    }
    if (kind < 64U) {
        return (kind < 48U) ? (double)NAN : ((kind < 56U) ? (double)INFINITY : -(double)INFINITY);
    }
    return (kind < 96U) ? special[kind % 4U] : ldexp((double)byte(bytes), (int)kind - 170);
}

static void choose_result(bytes_t *bytes)
{
    result = (davar_result_t){.epoch = word(bytes, 8U), .tau_count = config.tau_count};
    result.window_samples = (uint32_t)word(bytes, 8U);
    result.window_samples += (result.window_samples == 0U) ? 1U : 0U;
    report.cut_age_samples = (uint32_t)word(bytes, 8U);
    report.change = (davar_change_t){.m = (uint32_t)word(bytes, 8U) % 5000U};
    report.change.older = any(bytes);
    report.change.newer = any(bytes);
    report.change.gain = any(bytes);
    const uint8_t flags = byte(bytes);
    result.unstable = (flags & 1U) != 0U;
    report.young = (flags & 2U) != 0U;
    report.alarm = (flags & 4U) != 0U;
    result.noise = (davar_noise_t)(byte(bytes) % ((unsigned)DAVAR_NOISE_FILTERED + 1U));
    result.kurtosis = any(bytes);
    result.contribution = any(bytes);
    result.dispersion = any(bytes);
    for (uint8_t t = 0U; t < result.tau_count; t++) {
        davar_adev_t *const tau = &result.tau[t];
        tau->m = t + 1U;
        tau->differences = byte(bytes) % 3U;
        tau->adev = any(bytes);
        tau->low = any(bytes);
        tau->high = any(bytes);
        tau->edf = any(bytes);
        misfit.tau[t].deviation = any(bytes);
    }
    for (int kind = 0; kind < (int)DAVAR_COEFFICIENT_COUNT; kind++) {
        davar_coefficient_t *const coefficient = &result.coefficient[kind];
        coefficient->present = (byte(bytes) % 2U) != 0U;
        coefficient->value = any(bytes);
        coefficient->low = any(bytes);
        coefficient->high = any(bytes);
    }
    noise_floor.why = (davar_floor_why_t)(byte(bytes) % ((unsigned)DAVAR_FLOOR_STILL + 1U));
    noise_floor.value = (float)any(bytes);
    noise_floor.low = (float)any(bytes);
    noise_floor.high = (float)any(bytes);
    misfit.health = any(bytes);
    misfit.worst = byte(bytes) % (uint8_t)(result.tau_count + 1U);
    misfit.compared = byte(bytes) % (uint8_t)(result.tau_count + 1U);
    misfit.tau_count = result.tau_count;
    for (unsigned i = 0U; i < (unsigned)DAVAR_HEALTH_COUNT; i++) {
        health.count[i] = (uint32_t)magnitude(bytes);
    }
}

/* --- frames --- */

/* CRC-8/SAE-J1850 bit by bit, independent of the table of the library. */
static uint8_t crc_of(const davar_frame_t *frame)
{
    uint8_t crc = 0xFFU;
    for (unsigned i = 0U; i < (frame->length + 1U); i++) {
        const unsigned identifier = (i == 0U) ? frame->identifier & 0xFFU : frame->identifier >> 8U;
        crc = (uint8_t)(crc ^ ((i < 2U) ? identifier : frame->data[i - 1U]));
        for (unsigned bit = 0U; bit < 8U; bit++) {
            crc = (uint8_t)(((crc & 0x80U) != 0U) ? ((unsigned)crc << 1U) ^ 0x1DU
                                                  : (unsigned)crc << 1U);
        }
    }
    return (uint8_t)~crc;
}

static void check_frame(const davar_frame_t *frame)
{
    davar_decoded_t wire;
    REQUIRE((frame->length == 8U) || (frame->length == 64U));
    REQUIRE(crc_of(frame) == frame->data[0]);
    REQUIRE(davar_frame_crc(frame) == frame->data[0]);
    REQUIRE(davar_decode(frame, DAVAR_CAN_BASE, &wire) == DAVAR_DECODED);
    if ((wire.message == DAVAR_MESSAGE_ARW) || (wire.message == DAVAR_MESSAGE_ADEV)) {
        REQUIRE(is_magnitude(wire.value));
    }
    add(davar_frame_digest(frame));
    if (frame->length <= 8U) { /* a serial line has no CAN FD */
        char text[DAVAR_SLCAN_BYTES];
        davar_frame_t again;
        const size_t length = davar_slcan_encode(frame, text);
        REQUIRE(davar_slcan_decode(text, length - 1U, &again));
        REQUIRE((again.identifier == frame->identifier) && (again.length == frame->length));
        REQUIRE(memcmp(again.data, frame->data, frame->length) == 0);
    }
}

static void check_frames(void)
{
    davar_frame_t frame;
    for (uint32_t frames = 0U; davar_encoder_next(&encoder, &frame); frames++) {
        check_frame(&frame);
        REQUIRE(frames < 300U);
    }
}

static void send(bytes_t *bytes)
{
    davar_encoder_session(&encoder, byte(bytes));
    const uint8_t absent = byte(bytes);
    davar_encoder_monitor(&encoder, ((absent % 4U) == 0U) ? NULL : &misfit);
    davar_encoder_floor(&encoder, ((absent % 5U) == 0U) ? NULL : &noise_floor);
    davar_encoder_begin(&encoder, &result, ((absent % 3U) == 0U) ? NULL : &report, &health);
    check_frames();
}

static void send_raw(bytes_t *bytes)
{
    davar_frame_t frame;
    uint64_t index = word(bytes, 8U);
    for (uint32_t left = between(bytes, 1U, 40U); left > 0U; left--) {
        const bool jumps = (byte(bytes) % 8U) == 0U;
        index += 1U + (jumps ? word(bytes, 8U) : 0U);
        if ((byte(bytes) % 2U) == 0U) {
            davar_encoder_raw_f32(&encoder, index, (float)any(bytes), &frame);
            check_frame(&frame);
        } else if (davar_encoder_raw(&encoder, index, (int32_t)magnitude(bytes), &frame)) {
            check_frame(&frame);
        }
    }
    if (davar_encoder_raw_rest(&encoder, &frame)) {
        check_frame(&frame);
    }
}

/* --- the dialects of autopilots --- */

static void add_packet(const davar_packet_t *packet)
{
    REQUIRE((packet->length > 0U) && (packet->length <= DAVAR_PACKET_BYTES));
    REQUIRE(packet->identifier < (UINT32_C(1) << 29U));
    add(packet->identifier);
    for (uint32_t i = 0U; i < packet->length; i++) {
        add(packet->data[i]);
    }
}

static void send_telemetry(bytes_t *bytes)
{
    static const davar_dialect_t *const dialects[] = {&davar_mavlink, &davar_mavlink_gyro_noise,
                                                      &davar_dronecan, &davar_cyphal};
    davar_telemetry_address_t from = {.channel = (uint8_t)between(bytes, 0U, 11U)};
    from.node = byte(bytes);
    from.system = byte(bytes);
    from.subject = (uint16_t)(word(bytes, 8U) % 9000U);
    davar_packet_t packet;
    if (!davar_telemetry_init(&telemetry, dialects[byte(bytes) % 4U], &from, 100.0)) {
        return;
    }
    REQUIRE(from.channel <= DAVAR_TELEMETRY_CHANNEL_LAST);
    uint64_t now = magnitude(bytes);
    for (uint32_t left = between(bytes, 1U, 5U); left > 0U; left--) {
        uint32_t packets = 0U;
        davar_telemetry_floor(&telemetry, ((now % 5U) == 0U) ? NULL : &noise_floor);
        now += magnitude(bytes);
        if (davar_telemetry_heartbeat(&telemetry, now, &packet)) {
            add_packet(&packet);
            REQUIRE(!davar_telemetry_heartbeat(&telemetry, now, &packet));
        }
        davar_telemetry_begin(&telemetry, &result, ((now % 3U) == 0U) ? NULL : &report, now);
        while (davar_telemetry_next(&telemetry, &packet)) {
            add_packet(&packet);
            REQUIRE(++packets <= 6U);
        }
        const uint8_t channel = byte(bytes) % 16U;
        REQUIRE(davar_telemetry_set_channel(&telemetry, channel) ==
                (channel <= DAVAR_TELEMETRY_CHANNEL_LAST));
    }
}

static void send_covariance(bytes_t *bytes)
{
    uint8_t half[DAVAR_COVARIANCE_BYTES];
    double gyro[3];
    double accel[3];
    for (unsigned i = 0U; i < 3U; i++) {
        gyro[i] = any(bytes);
        accel[i] = any(bytes);
    }
    davar_dronecan_covariance(gyro, accel, half);
    for (uint32_t i = 0U; i < DAVAR_COVARIANCE_BYTES; i += 2U) {
        const double variance = (i < 6U) ? gyro[i / 2U] : accel[(i - 6U) / 2U];
        const uint32_t bits = half[i] | ((uint32_t)half[i + 1U] << 8U);
        const bool is_nan = (bits & 0x7FFFU) > 0x7C00U;
        REQUIRE(is_nan == (isnan(variance) || (variance < 0.0)));
        REQUIRE(is_nan || ((bits & 0x8000U) == 0U) || !(variance > 0.0));
        REQUIRE(!(variance > 0.0) || ((bits & 0x7FFFU) > 0U));
        add(bits);
    }
    const double arw = davar_arw_to_use(&result, any(bytes));
    const double white = davar_rate_density(arw, DAVAR_DEG_PER_S);
    add_double(davar_rate_variance(white, 100.0));
    add_double(davar_process_variance(davar_walk_density(arw, DAVAR_RAD_PER_S), 0.01));
}

/* --- torn reads --- */

static void tear(bytes_t *bytes)
{
    davar_torn_t torn;
    uint32_t delivered = 0U;
    uint32_t pushed = 0U;
    davar_torn_init(&torn);
    for (uint32_t left = between(bytes, 1U, 200U); left > 0U; left--) {
        int32_t sample = 0;
        const davar_torn_step_t step = davar_torn_push(&torn, (int32_t)magnitude(bytes), &sample);
        pushed++;
        delivered += (step != DAVAR_TORN_NOTHING) ? 1U : 0U;
        REQUIRE((step != DAVAR_TORN_NOTHING) || (pushed == 1U));
        REQUIRE(delivered == (pushed - 1U));
        add((uint64_t)step + ((uint64_t)(uint32_t)sample << 32U));
    }
}

/* --- the small pipeline --- */

static void require_equal(const davar_result_t *one, const davar_result_t *other)
{
    const davar_coefficient_t *const walk = &one->coefficient[DAVAR_ANGLE_RANDOM_WALK];
    const davar_coefficient_t *const same = &other->coefficient[DAVAR_ANGLE_RANDOM_WALK];
    REQUIRE((one->epoch == other->epoch) && (one->noise == other->noise));
    REQUIRE((one->unstable == other->unstable) && (one->equal_samples == other->equal_samples));
    REQUIRE(is_same(walk->value, same->value));
    REQUIRE(is_same(walk->high, same->high));
}

/* Samples of any size and gaps, of which an instance of the library makes the same results. */
static void push_small(uint64_t seed)
{
    static const uint32_t octaves[] = {1U, 2U, 4U};
    static const davar_config_t fixed = {.rate_hz = 100.0,
                                         .unit_per_count = 0.01,
                                         .stride = 12U,
                                         .window = {.longest = 36U, .shortest = 36U},
                                         .taus = octaves,
                                         .tau_count = 3U};
    static uint64_t memory[64];
    static davar_plan_t plan;
    static davar_t davar;
    static davar_result_t usual;
    static davar_result_t found;
    static int16_t ring[37];
    static davar_small_t small;
    davar_small_plan_t constant = {.unit_per_count = 0.01, .stride = 12U};
    random_t random = random_seeded(seed);
    const unsigned shift = 48U + (unsigned)(random_next(&random) % 16U);
    davar_plan_init_white(&plan, octaves, 3U);
    usual = (davar_result_t){.window_samples = 36U, .unit_per_count = 0.01, .tau_count = 3U};
    for (uint8_t t = 0U; t < 3U; t++) {
        usual.tau[t].m = octaves[t];
        usual.tau[t].differences = 37U - (2U * octaves[t]);
        usual.tau[t].adev = 1.0;
    }
    (void)davar_fit_white(&plan, 100.0, &usual);
    constant.fit = plan.white;
    davar_small_start(&small, &constant, ring);
    davar_small_restart(&small);
    REQUIRE(davar_init_q15(&davar, &fixed, memory, sizeof memory) == DAVAR_OK);
    for (uint32_t i = 0U; i < 400U; i++) {
        const int16_t sample = (int16_t)((int64_t)random_next(&random) >> shift);
        davar_push_q15(&davar, &sample, 1U);
        davar_small_push(&small, &sample, 1U);
        if ((random_next(&random) % 100U) == 0U) {
            davar_gap(&davar, 1U);
            davar_small_gap(&small, 1U);
        }
        const bool waits = davar_take(&davar, &usual);
        REQUIRE(davar_small_take(&small, &found) == waits);
        if (waits) {
            (void)davar_fit_white(&plan, 100.0, &usual);
            require_equal(&usual, &found);
        }
    }
    REQUIRE(davar_small_health(&small).restarts == davar_health(&davar).restarts);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bytes_t bytes = {data, data + size};
    config = davar_default_config;
    config.taus = taus;
    config.tau_count = (uint8_t)between(&bytes, 1U, DAVAR_TAUS_MAX);
    config.rate_hz = 100.0;
    config.unit_per_count = 0.01;
    const uint8_t channel = byte(&bytes) % 16U;
    if (!davar_encoder_init(&encoder, &config, DAVAR_CAN_BASE, channel, byte(&bytes))) {
        return 0;
    }
    while (bytes.next < bytes.end) {
        choose_result(&bytes);
        send(&bytes);
        send_raw(&bytes);
        send_telemetry(&bytes);
        send_covariance(&bytes);
        tear(&bytes);
    }
    push_small(digest);
    davar_encoder_finish(&encoder, &health);
    check_frames();
    return 0;
}
