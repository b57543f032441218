/* davar - encodes results as frames. A table has one row per message, in the order on the wire. */
#include "davar/can.h"

#include "davar/content.h"
#include "davar/glr.h"
#include "frame_layout.h"
#include "number/real.h"

#include <math.h>

#define COUNTER_MASK 15U
/* The highest raw values of an uncertainty of ARW are absent, beyond and the reasons why ARW is
 * absent (davar_noise_t); some are spare. */
#define NOISE_CODES 8U
#define STATE_WINDOW_MAX 0x7FFFFU
#define CUT_AGE_MAX 0xFFFFFU

/* Byte i = 0 .. length of the input of both checks: two bytes of the identifier, then the data
 * without its first byte. */
static uint32_t checked_byte(const davar_frame_t *frame, uint32_t i)
{
    return (i < 2U) ? (((uint32_t)frame->identifier >> (8U * i)) & 0xFFU) : frame->data[i - 1U];
}

uint32_t davar_frame_digest(const davar_frame_t *frame)
{
    uint32_t digest = 0x811C9DC5U;
    for (uint32_t i = 0U; i <= frame->length; i++) {
        digest = (digest ^ checked_byte(frame, i)) * 0x01000193U;
    }
    return digest;
}

uint8_t davar_frame_crc(const davar_frame_t *frame)
{
    uint32_t crc = 0xFFU;
    for (uint32_t i = 0U; i <= frame->length; i++) {
        crc ^= checked_byte(frame, i);
        for (uint32_t bit = 0U; bit < 8U; bit++) {
            crc = ((crc & 0x80U) != 0U) ? ((crc << 1U) ^ 0x1DU) & 0xFFU : crc << 1U;
        }
    }
    return (uint8_t)(crc ^ 0xFFU);
}

static void put(davar_frame_t *frame, davar_signal_t at, uint32_t raw)
{
    for (uint32_t bit = 0U; bit < at.bits; bit++) {
        const uint32_t where = at.start + bit;
        const uint32_t one = (raw >> bit) & 1U;
        frame->data[where / 8U] = (uint8_t)(frame->data[where / 8U] | (one << (where % 8U)));
    }
}

static void put_float(davar_frame_t *frame, davar_signal_t at, double value)
{
    put(frame, at, davar_single_bits(value));
}

/* davar_decode accepts only these values. */
static void put_signed(davar_frame_t *frame, davar_signal_t at, double value)
{
    put_float(frame, at, davar_single_signed(value));
}

static void put_magnitude(davar_frame_t *frame, davar_signal_t at, double value)
{
    put_float(frame, at, davar_single_magnitude(value));
}

static void put_scaled(davar_frame_t *frame, const davar_scaled_t *scaled, double value)
{
    const uint32_t absent = (1U << scaled->at.bits) - 1U;
    const double raw = value * (double)scaled->per_unit + 0.5;
    if (value >= 0.0) {
        put(frame, scaled->at, (raw >= (double)absent) ? absent - 1U : (uint32_t)raw);
    } else { /* NaN too */
        put(frame, scaled->at, absent);
    }
}

static uint32_t at_most(uint32_t value, uint32_t most)
{
    return (value < most) ? value : most;
}

/* Half the 95 % interval over the value; NaN without a value. */
static double relative_uncertainty(double value, double low, double high)
{
    return 0.5 * (high - low) / value;
}

/* The angle random walk. If it is absent, its uncertainty holds the reason: all ones less
 * davar_noise_t. A value whose uncertainty would need one of those codes is sent as beyond. */
static void put_arw(davar_frame_t *frame, const davar_scaled_t *uncertainty,
                    const davar_result_t *result)
{
    const davar_coefficient_t *arw = &result->coefficient[DAVAR_ANGLE_RANDOM_WALK];
    const uint32_t absent = (1U << uncertainty->at.bits) - 1U;
    const double most = (double)(absent - NOISE_CODES) * (double)uncertainty->unit;
    const double found = relative_uncertainty(arw->value, arw->low, arw->high);
    put_magnitude(frame, signal_value, arw->value);
    if ((arw->value >= 0.0) && (arw->value <= (double)DAVAR_CAN_MOST)) {
        put_scaled(frame, uncertainty, (found > most) ? (double)INFINITY : found);
    } else { /* NaN too */
        put(frame, uncertainty->at, absent - (uint32_t)result->noise);
    }
}

/* --- the signals of one frame ----------------------------------------------------------------- */

static void fill_state(davar_encoder_t *encoder, davar_frame_t *frame)
{
    encoder->tag = encoder->counter[DAVAR_MESSAGE_STATE];
    put(frame, signal_value, (uint32_t)encoder->result->epoch);
    put(frame, signal_window_samples, at_most(encoder->result->window_samples, STATE_WINDOW_MAX));
    put(frame, signal_unstable, encoder->result->unstable ? 1U : 0U);
}

static void fill_stationarity(davar_encoder_t *encoder, davar_frame_t *frame)
{
    put_scaled(frame, &signal_kurtosis, encoder->result->kurtosis);
    put_scaled(frame, &signal_contribution, encoder->result->contribution);
}

static void fill_arw(davar_encoder_t *encoder, davar_frame_t *frame)
{
    put_arw(frame, &signal_arw_relative_uncertainty, encoder->result);
}

static void fill_change(davar_encoder_t *encoder, davar_frame_t *frame)
{
    const uint8_t index = encoder->index;
    const davar_glr_report_t *const report = encoder->report;
    const double value[DAVAR_CHANGE_COUNT] = {0.0, report->change.older, report->change.newer,
                                              report->change.gain};
    put(frame, signal_change_item, index);
    put(frame, signal_alarm, report->alarm ? 1U : 0U);
    put(frame, signal_young, report->young ? 1U : 0U);
    put(frame, signal_change_cluster_samples, report->change.m);
    if (index == (uint8_t)DAVAR_CHANGE_CUT) {
        put(frame, signal_cut_age, at_most(report->cut_age_samples, CUT_AGE_MAX));
        put_scaled(frame, &signal_dispersion, encoder->result->dispersion);
    } else {
        put_magnitude(frame, signal_value, value[index]);
    }
}

static void fill_adev(davar_encoder_t *encoder, davar_frame_t *frame)
{
    const uint8_t index = encoder->index;
    const uint8_t first = ((encoder->content & DAVAR_SEND_FD) != 0U) ? DAVAR_FD_TAUS : 0U;
    const uint8_t t = (uint8_t)(first + index);
    const davar_adev_t *tau = &encoder->result->tau[t];
    put(frame, signal_tau_index, t);
    put_scaled(frame, &signal_adev_relative_uncertainty,
               relative_uncertainty(tau->adev, tau->low, tau->high));
    put_magnitude(frame, signal_value, tau->adev);
}

static void fill_coefficient(davar_encoder_t *encoder, davar_frame_t *frame)
{
    const uint8_t index = encoder->index;
    const davar_coefficient_t *coefficient =
        &encoder->result->coefficient[index % DAVAR_COEFFICIENT_COUNT];
    const double shown[3] = {coefficient->value, coefficient->low, coefficient->high};
    const double value = shown[index / DAVAR_COEFFICIENT_COUNT];
    put(frame, signal_kind, index);
    if (index >= 2U * DAVAR_COEFFICIENT_COUNT) {
        put_float(frame, signal_value, davar_single_limit(value));
    } else {
        put_magnitude(frame, signal_value, value);
    }
}

static void fill_fd(davar_encoder_t *encoder, davar_frame_t *frame)
{
    static const uint8_t kinds[4] = {DAVAR_QUANTIZATION, DAVAR_BIAS_INSTABILITY,
                                     DAVAR_RATE_RANDOM_WALK, DAVAR_RATE_RAMP};
    const davar_result_t *result = encoder->result;
    encoder->tag = encoder->counter[DAVAR_MESSAGE_RESULT_FD];
    put(frame, signal_window_samples, at_most(result->window_samples, STATE_WINDOW_MAX));
    put(frame, signal_unstable, result->unstable ? 1U : 0U);
    put_arw(frame, &fd_arw_relative_uncertainty, result);
    put(frame, fd_epoch, (uint32_t)result->epoch);
    put_scaled(frame, &fd_contribution, result->contribution);
    put_scaled(frame, &fd_kurtosis, result->kurtosis);
    for (uint8_t k = 0U; k < 4U; k++) {
        put_magnitude(frame, fd_coefficient[k], result->coefficient[kinds[k]].value);
    }
    for (uint8_t t = 0U; t < DAVAR_FD_TAUS; t++) {
        const double adev = (t < result->tau_count) ? result->tau[t].adev : (double)NAN;
        put_magnitude(frame, fd_adev[t], adev);
    }
}

void davar_can_health(davar_can_health_t *frames, const davar_health_t *health)
{
    frames->count[DAVAR_HEALTH_GAPS] = health->gaps;
    frames->count[DAVAR_HEALTH_MISSING_SAMPLES] = health->missing;
    frames->count[DAVAR_HEALTH_SATURATED_SAMPLES] = health->saturated;
    frames->count[DAVAR_HEALTH_NOT_FINITE_SAMPLES] = health->not_finite;
    frames->count[DAVAR_HEALTH_WINDOW_RESTARTS] = health->restarts;
    frames->count[DAVAR_HEALTH_RESULTS_MISSED] = health->missed;
    frames->count[DAVAR_HEALTH_WINDOW_CUTS] = health->cuts;
    frames->count[DAVAR_HEALTH_NOISE_ALARMS] = health->alarms;
    frames->count[DAVAR_HEALTH_SHOCKS_LEFT_OUT] = health->shocks;
}

/* The next counter that has changed, otherwise the next one. */
static uint8_t next_health(const davar_encoder_t *encoder)
{
    for (uint8_t i = 0U; i < (uint8_t)DAVAR_HEALTH_COUNT; i++) {
        const uint8_t item = (uint8_t)((encoder->health_next + i) % (uint8_t)DAVAR_HEALTH_COUNT);
        if (encoder->told[item] != encoder->health->count[item]) {
            return item;
        }
    }
    return encoder->health_next;
}

static void fill_health(davar_encoder_t *encoder, davar_frame_t *frame)
{
    const uint8_t index = encoder->index;
    const uint8_t item = (encoder->result != NULL) ? next_health(encoder) : index;
    encoder->told[item] = encoder->health->count[item];
    encoder->health_next = (uint8_t)((item + 1U) % (uint8_t)DAVAR_HEALTH_COUNT);
    put(frame, signal_health_index, item);
    put(frame, signal_session, encoder->session);
    put(frame, signal_value, encoder->told[item]);
}

static void fill_setup(davar_encoder_t *encoder, davar_frame_t *frame)
{
    const davar_config_t *config = encoder->config;
    const uint8_t items =
        ((encoder->content & DAVAR_SEND_RAW) != 0U) ? 3U : 2U; /* before the taus */
    const uint8_t count = (uint8_t)(items + encoder->result->tau_count);
    const uint8_t n = (encoder->setup_next < count) ? encoder->setup_next : 0U;
    put(frame, signal_session, encoder->session);
    if (n == 0U) {
        put(frame, signal_item, (uint32_t)DAVAR_SETUP_RATE);
        put_float(frame, signal_value, config->rate_hz);
    } else if (n == 1U) {
        put(frame, signal_item, (uint32_t)DAVAR_SETUP_STRIDE);
        put(frame, signal_value, config->stride);
    } else if (n < items) {
        put(frame, signal_item, (uint32_t)DAVAR_SETUP_UNIT);
        put_float(frame, signal_value,
                  (config->unit_per_count > 0.0) ? config->unit_per_count : 1.0); /* 1 for floats */
    } else {
        put(frame, signal_item, (uint32_t)DAVAR_SETUP_TAU + n - items);
        put(frame, signal_value, encoder->result->tau[n - items].m);
    }
    encoder->setup_next = (uint8_t)(n + 1U);
}

static void fill_monitor(davar_encoder_t *encoder, davar_frame_t *frame)
{
    const uint8_t index = encoder->index;
    const davar_misfit_t *misfit = encoder->misfit;
    if (index < misfit->tau_count) {
        put(frame, signal_monitor_index, index);
        put_signed(frame, signal_value, misfit->tau[index].deviation);
    } else {
        const bool none = (misfit->worst >= misfit->tau_count);
        put(frame, signal_monitor_index, DAVAR_MONITOR_HEALTH);
        put(frame, signal_worst_tau, none ? DAVAR_MONITOR_NO_TAU : misfit->worst);
        put_magnitude(frame, signal_value, misfit->health);
    }
}

static void fill_floor(davar_encoder_t *encoder, davar_frame_t *frame)
{
    const davar_floor_result_t *const floor = encoder->floor;
    const double value[2] = {(double)floor->value, (double)floor->low};
    put(frame, signal_floor_kind, encoder->index);
    put(frame, signal_floor_why, (uint32_t)floor->why);
    if (encoder->index == DAVAR_FLOOR_HIGH) {
        put_float(frame, signal_value, davar_single_limit((double)floor->high));
    } else {
        put_magnitude(frame, signal_value, value[encoder->index]);
    }
}

static void fill_end(davar_encoder_t *encoder, davar_frame_t *frame)
{
    put(frame, signal_frames, encoder->frames);
    put(frame, signal_session, encoder->session);
    put(frame, signal_value, encoder->digest);
}

/* --- the messages of a result ----------------------------------------------------------------- */

static bool sends(const davar_encoder_t *encoder, uint8_t content)
{
    return (encoder->content & content) != 0U;
}

static uint8_t count_part(const davar_encoder_t *encoder)
{
    return sends(encoder, DAVAR_SEND_FD) ? (uint8_t)0U : (uint8_t)1U;
}

static uint8_t count_fd(const davar_encoder_t *encoder)
{
    return sends(encoder, DAVAR_SEND_FD) ? 1U : 0U;
}

static uint8_t count_change(const davar_encoder_t *encoder)
{
    if ((encoder->report == NULL) || (davar_law_id(encoder->config) != DAVAR_LAW_ID_GLR)) {
        return 0U;
    }
    return sends(encoder, DAVAR_SEND_ADEV | DAVAR_SEND_FD) ? (uint8_t)DAVAR_CHANGE_COUNT : 1U;
}

static uint8_t count_adev(const davar_encoder_t *encoder)
{
    const uint8_t taus = encoder->result->tau_count;
    if (sends(encoder, DAVAR_SEND_FD)) {
        return (taus > DAVAR_FD_TAUS) ? (uint8_t)(taus - DAVAR_FD_TAUS) : 0U;
    }
    return sends(encoder, DAVAR_SEND_ADEV) ? taus : 0U;
}

static uint8_t count_coefficients(const davar_encoder_t *encoder)
{
    if (sends(encoder, DAVAR_SEND_FD) ||
        !sends(encoder, DAVAR_SEND_COEFFICIENTS | DAVAR_SEND_INTERVALS)) {
        return 0U;
    }
    return sends(encoder, DAVAR_SEND_INTERVALS) ? 15U : 5U;
}

static uint8_t count_monitor(const davar_encoder_t *encoder)
{
    const bool there = sends(encoder, DAVAR_SEND_MONITOR) && (encoder->misfit != NULL);
    return there ? (uint8_t)(encoder->misfit->tau_count + 1U) : 0U;
}

static uint8_t count_floor(const davar_encoder_t *encoder)
{
    return (encoder->floor != NULL) ? (uint8_t)(DAVAR_FLOOR_HIGH + 1U) : 0U;
}

typedef struct {
    davar_message_t message;
    uint8_t (*count)(const davar_encoder_t *encoder); /* frames of a result; null: one */
    void (*fill)(davar_encoder_t *encoder, davar_frame_t *frame);
} stage_t;

static const stage_t stages[] = {
    {DAVAR_MESSAGE_STATE, count_part, fill_state},
    {DAVAR_MESSAGE_STATIONARITY, count_part, fill_stationarity},
    {DAVAR_MESSAGE_ARW, count_part, fill_arw},
    {DAVAR_MESSAGE_RESULT_FD, count_fd, fill_fd},
    {DAVAR_MESSAGE_CHANGE, count_change, fill_change},
    {DAVAR_MESSAGE_ADEV, count_adev, fill_adev},
    {DAVAR_MESSAGE_COEFFICIENT, count_coefficients, fill_coefficient},
    {DAVAR_MESSAGE_MONITOR, count_monitor, fill_monitor},
    {DAVAR_MESSAGE_FLOOR, count_floor, fill_floor},
    {DAVAR_MESSAGE_HEALTH, NULL, fill_health},
    {DAVAR_MESSAGE_SETUP, NULL, fill_setup},
    {DAVAR_MESSAGE_END, NULL, fill_end},
};
#define STAGE_COUNT (sizeof stages / sizeof stages[0])

/* Frames of the current stage; the end of a stream (no result) only repeats the health counters. */
static uint8_t count_frames(const davar_encoder_t *encoder)
{
    const stage_t *const stage = &stages[encoder->stage];
    if (encoder->result == NULL) {
        return (stage->message == DAVAR_MESSAGE_HEALTH) ? (uint8_t)DAVAR_HEALTH_COUNT : 0U;
    }
    return (stage->count == NULL) ? 1U : stage->count(encoder);
}

/* --- the encoder ------------------------------------------------------------------------------ */

bool davar_encoder_init(davar_encoder_t *encoder, const davar_config_t *config, uint16_t base,
                        uint8_t channel, uint8_t content)
{
    DAVAR_ASSERT((encoder != NULL) && (config != NULL));
    const uint32_t first = base + DAVAR_CAN_STEP * channel;
    if (first + DAVAR_CAN_STEP - 1U > DAVAR_CAN_LAST_ID) {
        return false;
    }
    *encoder = (davar_encoder_t){
        .config = config, .base = (uint16_t)first, .content = content, .stage = STAGE_COUNT};
    return true;
}

static void start(davar_encoder_t *encoder, const davar_result_t *result,
                  const davar_can_health_t *health)
{
    DAVAR_ASSERT(health != NULL);
    encoder->result = result;
    encoder->health = health;
    encoder->stage = 0U;
    encoder->index = 0U;
    encoder->frames = 0U;
    encoder->digest = 0U;
}

void davar_encoder_begin(davar_encoder_t *encoder, const davar_result_t *result,
                         const davar_glr_report_t *report, const davar_can_health_t *health)
{
    DAVAR_ASSERT(result != NULL);
    start(encoder, result, health);
    encoder->report = report;
}

void davar_encoder_finish(davar_encoder_t *encoder, const davar_can_health_t *health)
{
    start(encoder, NULL, health);
}

void davar_encoder_monitor(davar_encoder_t *encoder, const davar_misfit_t *misfit)
{
    DAVAR_ASSERT(encoder != NULL);
    encoder->misfit = misfit;
}

void davar_encoder_floor(davar_encoder_t *encoder, const davar_floor_result_t *floor)
{
    DAVAR_ASSERT(encoder != NULL);
    encoder->floor = floor;
}

void davar_encoder_session(davar_encoder_t *encoder, uint8_t session)
{
    DAVAR_ASSERT(encoder != NULL);
    encoder->session = session;
}

static void open_frame(const davar_encoder_t *encoder, davar_message_t message,
                       davar_frame_t *frame)
{
    *frame = (davar_frame_t){.identifier = (uint16_t)(encoder->base + (uint32_t)message),
                             .length = message_length((uint32_t)message)};
}

/* Completes the header; last, because Crc covers everything. */
static void seal(davar_encoder_t *encoder, davar_message_t message, davar_frame_t *frame)
{
    uint8_t *counter = &encoder->counter[message];
    put(frame, signal_counter, *counter);
    const bool of_result = (message != DAVAR_MESSAGE_STATE) &&
                           (message != DAVAR_MESSAGE_RESULT_FD) && (message != DAVAR_MESSAGE_RAW);
    if (of_result) {
        put(frame, signal_result, encoder->tag);
    }
    *counter = (uint8_t)((*counter + 1U) & COUNTER_MASK);
    put(frame, signal_crc, davar_frame_crc(frame));
}

bool davar_encoder_next(davar_encoder_t *encoder, davar_frame_t *frame)
{
    while ((encoder->stage < STAGE_COUNT) && (encoder->index == count_frames(encoder))) {
        encoder->stage++;
        encoder->index = 0U;
    }
    if (encoder->stage == STAGE_COUNT) {
        return false;
    }
    const stage_t *stage = &stages[encoder->stage];
    open_frame(encoder, stage->message, frame);
    stage->fill(encoder, frame);
    encoder->index++;
    seal(encoder, stage->message, frame);
    if ((stage->message != DAVAR_MESSAGE_HEALTH) && (stage->message != DAVAR_MESSAGE_SETUP)) {
        encoder->frames++;
        encoder->digest += davar_frame_digest(frame);
    }
    return true;
}

/* --- raw samples ------------------------------------------------------------------------------ */

static void open_raw(const davar_encoder_t *encoder, davar_raw_form_t form, uint32_t index,
                     davar_frame_t *frame)
{
    open_frame(encoder, DAVAR_MESSAGE_RAW, frame);
    put(frame, signal_form, (uint32_t)form);
    put(frame, signal_index, index);
}

static bool is_narrow(int32_t count)
{
    return (count >= INT16_MIN) && (count <= INT16_MAX);
}

bool davar_encoder_raw_rest(davar_encoder_t *encoder, davar_frame_t *frame)
{
    if (!encoder->raw_held) {
        return false;
    }
    open_raw(encoder, DAVAR_RAW_COUNT, encoder->raw_index, frame);
    put(frame, signal_value, (uint32_t)encoder->raw_count);
    seal(encoder, DAVAR_MESSAGE_RAW, frame);
    encoder->raw_held = false;
    return true;
}

bool davar_encoder_raw(davar_encoder_t *encoder, uint64_t index, int32_t count,
                       davar_frame_t *frame)
{
    DAVAR_ASSERT((encoder != NULL) && (frame != NULL));
    const bool follows = encoder->raw_held && ((uint32_t)index == encoder->raw_index + 1U);
    if (follows && is_narrow(encoder->raw_count) && is_narrow(count)) {
        open_raw(encoder, DAVAR_RAW_PAIR, encoder->raw_index, frame);
        put(frame, signal_count0, (uint32_t)encoder->raw_count);
        put(frame, signal_count1, (uint32_t)count);
        seal(encoder, DAVAR_MESSAGE_RAW, frame);
        encoder->raw_held = false;
        return true;
    }
    const bool sent = davar_encoder_raw_rest(encoder, frame);
    encoder->raw_held = true;
    encoder->raw_count = count;
    encoder->raw_index = (uint32_t)index;
    return sent;
}

void davar_encoder_raw_f32(davar_encoder_t *encoder, uint64_t index, float rate_dps,
                           davar_frame_t *frame)
{
    DAVAR_ASSERT((encoder != NULL) && (frame != NULL));
    open_raw(encoder, DAVAR_RAW_RATE, (uint32_t)index, frame);
    put_signed(frame, signal_value, (double)rate_dps);
    seal(encoder, DAVAR_MESSAGE_RAW, frame);
}
