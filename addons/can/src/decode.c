/* davar - decodes frames, the inverse of encode.c, for gateways and other devices. */
#include "davar/can_decode.h"

#include "frame_layout.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define KIND_COUNT 15U

static uint32_t get(const davar_frame_t *frame, davar_signal_t at)
{
    uint32_t raw = 0U;
    for (uint32_t bit = 0U; bit < at.bits; bit++) {
        const uint32_t where = at.start + bit;
        raw |= (((uint32_t)frame->data[where / 8U] >> (where % 8U)) & 1U) << bit;
    }
    return raw;
}

static float get_float(const davar_frame_t *frame, davar_signal_t at)
{
    const uint32_t raw = get(frame, at);
    float value = 0.0F;
    memcpy(&value, &raw, sizeof value);
    return value;
}

static float get_scaled(const davar_frame_t *frame, const davar_scaled_t *scaled)
{
    const uint32_t raw = get(frame, scaled->at);
    return (raw == (1U << scaled->at.bits) - 1U) ? NAN : (float)raw * scaled->unit;
}

/* The uncertainty of ARW, or why ARW is absent. Other raw values of an absent ARW mean nothing. */
static void read_arw(const davar_frame_t *frame, const davar_scaled_t *uncertainty,
                     davar_decoded_t *wire)
{
    const uint32_t code = (1U << uncertainty->at.bits) - 1U - get(frame, uncertainty->at);
    wire->relative_uncertainty = get_scaled(frame, uncertainty);
    if (isnan(wire->value) && (code <= (uint32_t)DAVAR_NOISE_FILTERED)) {
        wire->noise = (davar_noise_t)code;
        wire->relative_uncertainty = NAN;
    }
}

/* Absent, or a plausible magnitude. */
static bool is_magnitude(float value)
{
    const bool tiny = (value > 0.0F) && (value < DAVAR_CAN_LEAST);
    return isnan(value) || ((value >= 0.0F) && !tiny && (value <= DAVAR_CAN_MOST));
}

static bool is_coefficient(const davar_decoded_t *wire)
{
    const bool unbounded = (wire->index >= 2U * DAVAR_COEFFICIENT_COUNT) && (wire->value > FLT_MAX);
    return unbounded || is_magnitude(wire->value);
}

static bool is_setup(const davar_decoded_t *wire)
{
    if ((wire->index == (uint8_t)DAVAR_SETUP_RATE) || (wire->index == (uint8_t)DAVAR_SETUP_UNIT)) {
        return (wire->value > 0.0F) && is_magnitude(wire->value);
    }
    return ((wire->index == (uint8_t)DAVAR_SETUP_STRIDE) ||
            (wire->index >= (uint8_t)DAVAR_SETUP_TAU)) &&
           (wire->number > 0U);
}

static bool is_monitor(const davar_decoded_t *wire)
{
    return is_magnitude((wire->index < DAVAR_MONITOR_HEALTH) ? fabsf(wire->value) : wire->value);
}

static bool is_fd(const davar_decoded_t *wire)
{
    bool good = (wire->window_samples > 0U);
    for (uint8_t k = 0U; k < (uint8_t)DAVAR_COEFFICIENT_COUNT; k++) {
        good = is_magnitude(wire->coefficient[k]) && good;
    }
    for (uint8_t t = 0U; t < DAVAR_FD_TAUS; t++) {
        good = is_magnitude(wire->adev[t]) && good;
    }
    return good;
}

static bool read_fd(const davar_frame_t *frame, davar_decoded_t *wire)
{
    static const uint8_t kinds[4] = {DAVAR_QUANTIZATION, DAVAR_BIAS_INSTABILITY,
                                     DAVAR_RATE_RANDOM_WALK, DAVAR_RATE_RAMP};
    wire->number = get(frame, fd_epoch);
    wire->window_samples = get(frame, signal_window_samples);
    wire->unstable = (get(frame, signal_unstable) != 0U);
    read_arw(frame, &fd_arw_relative_uncertainty, wire);
    wire->kurtosis = get_scaled(frame, &fd_kurtosis);
    wire->contribution = get_scaled(frame, &fd_contribution);
    wire->coefficient[DAVAR_ANGLE_RANDOM_WALK] = wire->value;
    for (uint8_t k = 0U; k < 4U; k++) {
        wire->coefficient[kinds[k]] = get_float(frame, fd_coefficient[k]);
    }
    for (uint8_t t = 0U; t < DAVAR_FD_TAUS; t++) {
        wire->adev[t] = get_float(frame, fd_adev[t]);
    }
    return is_fd(wire);
}

static bool read_state(const davar_frame_t *frame, davar_decoded_t *wire)
{
    wire->window_samples = get(frame, signal_window_samples);
    wire->unstable = (get(frame, signal_unstable) != 0U);
    return wire->window_samples > 0U;
}

static bool read_stationarity(const davar_frame_t *frame, davar_decoded_t *wire)
{
    wire->kurtosis = get_scaled(frame, &signal_kurtosis);
    wire->contribution = get_scaled(frame, &signal_contribution);
    return true;
}

static bool read_arw_frame(const davar_frame_t *frame, davar_decoded_t *wire)
{
    read_arw(frame, &signal_arw_relative_uncertainty, wire);
    return is_magnitude(wire->value);
}

static bool read_adev(const davar_frame_t *frame, davar_decoded_t *wire)
{
    wire->index = (uint8_t)get(frame, signal_tau_index);
    wire->relative_uncertainty = get_scaled(frame, &signal_adev_relative_uncertainty);
    return is_magnitude(wire->value);
}

static bool read_index(const davar_frame_t *frame, davar_signal_t at, uint32_t count,
                       davar_decoded_t *wire)
{
    wire->index = (uint8_t)get(frame, at);
    return wire->index < count;
}

/* False: an impossible level or gain. */
static bool read_change(const davar_frame_t *frame, davar_decoded_t *wire)
{
    wire->index = (uint8_t)get(frame, signal_change_item);
    wire->alarm = (get(frame, signal_alarm) != 0U);
    wire->young = (get(frame, signal_young) != 0U);
    wire->change_m = get(frame, signal_change_cluster_samples);
    if (wire->index == (uint8_t)DAVAR_CHANGE_CUT) {
        wire->cut_age_samples = get(frame, signal_cut_age);
        wire->dispersion = get_scaled(frame, &signal_dispersion);
        return true;
    }
    return is_magnitude(wire->value);
}

/* False: an undefined form, or an impossible rate. */
static bool read_raw(const davar_frame_t *frame, davar_decoded_t *wire)
{
    wire->index = (uint8_t)get(frame, signal_form);
    wire->number = get(frame, signal_index);
    if (wire->index == (uint8_t)DAVAR_RAW_PAIR) {
        wire->count[0] = (int16_t)get(frame, signal_count0);
        wire->count[1] = (int16_t)get(frame, signal_count1);
        return true;
    }
    wire->count[0] =
        (wire->index == (uint8_t)DAVAR_RAW_COUNT) ? (int32_t)get(frame, signal_value) : 0;
    return (wire->index == (uint8_t)DAVAR_RAW_COUNT) ||
           ((wire->index == (uint8_t)DAVAR_RAW_RATE) && is_magnitude(fabsf(wire->value)));
}

/* False: a result without frames. */
static bool read_end(const davar_frame_t *frame, davar_decoded_t *wire)
{
    wire->index = (uint8_t)get(frame, signal_frames);
    wire->session = (uint8_t)get(frame, signal_session);
    return wire->index > 0U;
}

static bool read_coefficient(const davar_frame_t *frame, davar_decoded_t *wire)
{
    return read_index(frame, signal_kind, KIND_COUNT, wire) && is_coefficient(wire);
}

static bool read_health(const davar_frame_t *frame, davar_decoded_t *wire)
{
    wire->session = (uint8_t)get(frame, signal_session);
    return read_index(frame, signal_health_index, (uint32_t)DAVAR_HEALTH_COUNT, wire);
}

static bool read_setup(const davar_frame_t *frame, davar_decoded_t *wire)
{
    wire->session = (uint8_t)get(frame, signal_session);
    return read_index(frame, signal_item, (uint32_t)DAVAR_SETUP_TAU + 32U, wire) && is_setup(wire);
}

static bool read_monitor(const davar_frame_t *frame, davar_decoded_t *wire)
{
    wire->worst = (uint8_t)get(frame, signal_worst_tau);
    return read_index(frame, signal_monitor_index, DAVAR_MONITOR_HEALTH + 1U, wire) &&
           is_monitor(wire);
}

static bool read_floor(const davar_frame_t *frame, davar_decoded_t *wire)
{
    const uint32_t why = get(frame, signal_floor_why);
    const bool is_known = (why <= (uint32_t)DAVAR_FLOOR_STILL) &&
                          read_index(frame, signal_floor_kind, DAVAR_FLOOR_HIGH + 1U, wire);
    wire->floor_why = (davar_floor_why_t)why;
    return is_known && (is_magnitude(wire->value) ||
                        ((wire->index == DAVAR_FLOOR_HIGH) && (wire->value > FLT_MAX)));
}

/* Reads the fields of this message except `value` and `number`. False: an undefined index or
 * value. */
static bool read_message(const davar_frame_t *frame, davar_decoded_t *wire)
{
    static bool (*const read[])(const davar_frame_t *, davar_decoded_t *) = {
        [DAVAR_MESSAGE_ARW] = read_arw_frame,
        [DAVAR_MESSAGE_STATE] = read_state,
        [DAVAR_MESSAGE_STATIONARITY] = read_stationarity,
        [DAVAR_MESSAGE_ADEV] = read_adev,
        [DAVAR_MESSAGE_COEFFICIENT] = read_coefficient,
        [DAVAR_MESSAGE_HEALTH] = read_health,
        [DAVAR_MESSAGE_SETUP] = read_setup,
        [DAVAR_MESSAGE_MONITOR] = read_monitor,
        [DAVAR_MESSAGE_RESULT_FD] = read_fd,
        [DAVAR_MESSAGE_RAW] = read_raw,
        [DAVAR_MESSAGE_CHANGE] = read_change,
        [DAVAR_MESSAGE_END] = read_end,
        [DAVAR_MESSAGE_FLOOR] = read_floor,
    };
    _Static_assert((sizeof read / sizeof read[0]) == (size_t)DAVAR_MESSAGE_COUNT,
                   "every message has a reader");
    return read[wire->message](frame, wire);
}

davar_decode_status_t davar_decode(const davar_frame_t *frame, uint16_t base, davar_decoded_t *wire)
{
    const uint32_t offset =
        (uint32_t)frame->identifier - base; /* wraps if below base, to far above the last message */
    const uint32_t message = offset % DAVAR_CAN_STEP;
    if ((frame->identifier < base) || (message_length(message) == 0U)) {
        return DAVAR_DECODE_FOREIGN;
    }
    if (frame->length != message_length(message)) {
        return DAVAR_DECODE_LENGTH;
    }
    if (get(frame, signal_crc) != davar_frame_crc(frame)) {
        return DAVAR_DECODE_CRC;
    }
    *wire = (davar_decoded_t){.message = (davar_message_t)message,
                              .channel = (uint8_t)(offset / DAVAR_CAN_STEP),
                              .counter = (uint8_t)get(frame, signal_counter),
                              .result = (uint8_t)get(frame, signal_result),
                              .value = get_float(frame, signal_value),
                              .number = get(frame, signal_value)};
    return read_message(frame, wire) ? DAVAR_DECODED : DAVAR_DECODE_VALUE;
}
