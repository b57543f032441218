/* davar tests - chains of public calls: push, gap, take, any fit, monitor, encode, decode, save,
 * restore, flush, reset. Every number that reaches a caller is in its range or absent, and every
 * sample and every result is used or counted. `digest` adds up all that the caller gets. */
#include "davar/can.h"
#include "davar/can_decode.h"
#include "davar/content.h"
#include "davar/davar.h"
#include "davar/fit.h"
#include "davar/monitor.h"
#include "davar/state.h"
#include "davar_law_id.h"
#include "digest.h"
#include "fuzzing.h"
#include "random.h"

#include <math.h>
#include <string.h>

#define MEMORY_WORDS 8192
#define SLOT ((size_t)8 * MEMORY_WORDS)

#include "cells.h"
#include "shape.h"
#define BLOCK_MAX 256U

/* An instance and its caller's counts. */
typedef struct {
    davar_t davar;
    uint32_t taken;
} user_t;

static const uint32_t taus[5] = {1U, 2U, 3U, 7U, 12U};
static uint64_t memory[2][MEMORY_WORDS];
static davar_config_t config;
static type_t type;
static user_t users[2]; /* of the same stream: the second one takes after every result */
static bool single;     /* every sample is a push */
static bool ended;
static uint64_t pushed;  /* samples since init or reset */
static uint32_t missing; /* reported as missing */
static davar_plan_t plan;
static davar_model_tau_t model[5];
static davar_monitor_t monitor;
static davar_misfit_t misfit;
static davar_encoder_t encoder;
static davar_result_t result;
static davar_glr_report_t report;

static void check_result(bool is_fitted)
{
    add_fields(&result, &report);
    for (uint32_t t = 0U; t < result.tau_count; t++) {
        check_deviation(&result.tau[t]);
    }
    for (int kind = 0; kind < (int)DAVAR_COEFFICIENT_COUNT; kind++) {
        check_coefficient(&result.coefficient[kind]);
    }
    REQUIRE(strcmp(davar_noise_text(result.noise), davar_noise_text((davar_noise_t)99)) != 0);
    REQUIRE(is_fitted || (result.noise == DAVAR_NOISE_UNKNOWN));
    REQUIRE((result.noise != DAVAR_NOISE_WHITE) ||
            result.coefficient[DAVAR_ANGLE_RANDOM_WALK].present);
}

/* --- valid monitors and frames --- */

static void watch(void)
{
    davar_monitor_update(&monitor, &result, &misfit);
    uint8_t measured = 0U;
    for (uint32_t t = 0U; t < result.tau_count; t++) {
        measured = (uint8_t)(measured + ((result.tau[t].differences > 0U) ? 1U : 0U));
    }
    REQUIRE(misfit.compared == measured);
    REQUIRE((measured > 0U) ? is_number(misfit.health) : (isnan(misfit.health) != 0));
    REQUIRE((measured == 0U) || (is_number(misfit.fast) && is_number(misfit.slow) &&
                                 (misfit.worst < result.tau_count)));
    add_double(misfit.health);
    add_double(misfit.fast);
    add_double(misfit.slow);
    add(misfit.worst);
    for (uint32_t t = 0U; t < misfit.tau_count; t++) {
        add((uint64_t)misfit.tau[t].match);
        add_double(misfit.tau[t].deviation);
        add_double(misfit.tau[t].mean_deviation);
    }
}

static void send(const davar_t *davar)
{
    const davar_health_t of_instance = davar_health(davar);
    davar_can_health_t health = {{0U}};
    davar_frame_t frame;
    davar_decoded_t wire;
    davar_can_health(&health, &of_instance);
    davar_encoder_begin(&encoder, &result, &report, &health);
    for (uint32_t frames = 0U; davar_encoder_next(&encoder, &frame); frames++) {
        REQUIRE(frames < 200U);
        add(frame.identifier + ((uint64_t)frame.length << 32U));
        for (uint32_t i = 0U; i < frame.length; i++) {
            add(frame.data[i]);
        }
        REQUIRE(davar_decode(&frame, DAVAR_CAN_BASE, &wire) == DAVAR_DECODED);
        if (wire.message == DAVAR_MESSAGE_ADEV) {
            REQUIRE(isnan(wire.value) == (result.tau[wire.index].differences == 0U));
        }
        if (wire.message == DAVAR_MESSAGE_ARW) {
            REQUIRE(isnan(wire.value) == !result.coefficient[DAVAR_ANGLE_RANDOM_WALK].present);
        }
        if ((wire.message == DAVAR_MESSAGE_MONITOR) && (wire.index == DAVAR_MONITOR_HEALTH)) {
            REQUIRE((isnan(wire.value) != 0) == (isnan(misfit.health) != 0));
        }
    }
}

static void use(const davar_t *davar, bytes_t *bytes)
{
    const uint8_t what = byte(bytes);
    check_result(false);
    if ((what % 4U) == 1U) {
        (void)davar_fit_white(&plan, config.rate_hz, &result);
    } else if ((what % 4U) == 2U) {
        davar_fit(&plan, config.rate_hz, &result);
    } else if ((what % 4U) == 3U) {
        (void)davar_fit_white_ready(&plan, config.rate_hz, &result);
    }
    check_result((what % 4U) != 0U);
    if ((what & 4U) != 0U) {
        watch();
    }
    if ((what & 8U) != 0U) {
        send(davar);
    }
}

/* --- samples and results --- */

static davar_status_t init(unsigned which)
{
    static davar_status_t (*const inits[])(davar_t *, const davar_config_t *, void *, size_t) = {
        davar_init_q15, davar_init_q31, davar_init_f32};
    memset(memory[which], 0xA5, sizeof memory[which]);
    return inits[type](&users[which].davar, &config, memory[which], sizeof memory[which]);
}

typedef struct {
    int16_t q15[BLOCK_MAX];
    int32_t q31[BLOCK_MAX];
    float f32[BLOCK_MAX];
} block_t;

static size_t push_until(davar_t *davar, const block_t *block, size_t from, size_t count)
{
    return (type == Q15)   ? davar_push_until_result_q15(davar, &block->q15[from], count)
           : (type == Q31) ? davar_push_until_result_q31(davar, &block->q31[from], count)
                           : davar_push_until_result_f32(davar, &block->f32[from], count);
}

static void push_whole(davar_t *davar, const block_t *block, size_t from, size_t count)
{
    if (type == Q15) {
        davar_push_q15(davar, &block->q15[from], count);
    } else if (type == Q31) {
        davar_push_q31(davar, &block->q31[from], count);
    } else {
        davar_push_f32(davar, &block->f32[from], count);
    }
}

/* Time has advanced by every pushed sample: the newest result is less than a stride
 * old, and with law glr less than the samples that may wait. */
static void check_epoch(void)
{
    const uint64_t late = (davar_law_id(&config) == DAVAR_LAW_ID_GLR)
                              ? ((config.glr.shock_blocks + 3U) * config.glr.block)
                              : 0U;
    REQUIRE((result.epoch < pushed) && ((result.epoch + config.stride + late) >= pushed));
}

static void take_second(void)
{
    davar_result_t other;
    users[1].taken += davar_take(&users[1].davar, &other) ? 1U : 0U;
}

static void take_both(bytes_t *bytes)
{
    if (davar_take(&users[0].davar, &result)) {
        davar_glr_report(&users[0].davar, &report);
        users[0].taken++;
        check_epoch();
        use(&users[0].davar, bytes);
    }
    take_second();
}

/* The second user misses nothing. The first has taken, missed or not yet taken the same number of
 * results. */
static void check_counts(void)
{
    const davar_health_t health = davar_health(&users[0].davar);
    const davar_health_t other = davar_health(&users[1].davar);
    const uint32_t waits =
        (users[0].davar.produced != users[0].davar.seen) && users[0].davar.ready ? 1U : 0U;
    REQUIRE(other.missed == 0U);
    REQUIRE((users[0].taken + health.missed + waits) == users[1].taken);
    REQUIRE((health.missing == missing) && (health.missing == other.missing));
    REQUIRE((health.gaps == other.gaps) && (health.saturated == other.saturated));
    add(health.gaps + ((uint64_t)health.missing << 32U));
    add(health.saturated + ((uint64_t)health.not_finite << 32U));
    add(health.restarts + ((uint64_t)health.missed << 32U));
    add(health.cuts + ((uint64_t)health.alarms << 32U));
    add(health.shocks);
}

/* Noise of some level, with a walk, a line or nothing added; constant values; or rails. A few bytes
 * define a block. */
static void fill(block_t *block, bytes_t *bytes, size_t count)
{
    static const int32_t full = 8388607;
    const uint32_t shift = between(bytes, 0U, 23U);
    const uint8_t kind = byte(bytes);
    random_t random = random_seeded(byte(bytes));
    int32_t beside = 0;
    for (size_t i = 0; i < count; i++) {
        const int32_t noise = (int32_t)(random_next(&random) >> 40U) - full - 1; /* 24 bits */
        if ((kind % 4U) == 1U) {
            beside += (noise >> shift) / 4;
        } else if ((kind % 4U) == 2U) {
            beside = ((i / 5U) % 2U == 0U) ? (full >> shift) : -(full >> shift);
        }
        int32_t value = (noise >> shift) + beside;
        value =
            (kind >= 240U) ? ((noise < 0) ? -full - 1 : full) : ((kind >= 224U) ? beside : value);
        value = (value > full) ? full : ((value < -full - 1) ? -full - 1 : value);
        block->q15[i] = (int16_t)(value / 256);
        block->q31[i] = value;
        block->f32[i] = (float)value * (300.0F / (float)full);
    }
}

static void push(bytes_t *bytes)
{
    block_t block;
    const size_t count = between(bytes, 0U, 255U);
    fill(&block, bytes, count);
    if (ended) {
        return;
    }
    for (size_t done = 0U; done < count; done += single ? 1U : count) {
        push_whole(&users[0].davar, &block, done, single ? 1U : count);
    }
    for (size_t done = 0U; done < count;) {
        const size_t offered = single ? 1U : (count - done);
        const size_t more = push_until(&users[1].davar, &block, done, offered);
        REQUIRE((more >= 1U) && (more <= offered));
        done += more;
        const uint32_t taken = users[1].taken;
        take_second();
        add((users[1].taken != taken) ? done : 0U);
    }
    pushed += count;
}

static void lose(bytes_t *bytes)
{
    const uint32_t lost = between(bytes, 1U, 200U);
    if (!ended) {
        davar_gap(&users[0].davar, lost);
        davar_gap(&users[1].davar, lost);
        missing += lost;
        take_second();
    }
}

static void flush(bytes_t *bytes)
{
    while (davar_flush(&users[1].davar)) {
        REQUIRE(davar_flush(&users[0].davar));
        ended = true;
        if (byte(bytes) % 2U == 0U) {
            take_both(bytes);
        } else {
            take_second();
        }
    }
    REQUIRE(!davar_flush(&users[0].davar));
    ended = ended || (users[0].davar.accepts == 0U);
}

static void reset(bytes_t *bytes)
{
    (void)bytes;
    for (unsigned i = 0U; i < 2U; i++) {
        davar_reset(&users[i].davar);
        users[i].taken = 0U;
    }
    ended = false;
    pushed = 0U;
    missing = 0U;
}

static void through_the_dark(bytes_t *bytes)
{
    (void)bytes;
    REQUIRE(davar_state_bytes(&users[0].davar) <= SLOT);
    const davar_state_status_t status = davar_state_save(&users[0].davar, &storage);
    REQUIRE(strcmp(davar_state_status_text(status), "ok") == 0);
    REQUIRE(strcmp(davar_status_text(init(0U)), "ok") == 0);
    REQUIRE(davar_state_restore(&users[0].davar, &storage) == DAVAR_STATE_OK);
    davar_layout_t layout;
    davar_content_layout(&users[0].davar, &layout);
    davar_content_t content;
    REQUIRE(layout.bytes < davar_state_bytes(&users[0].davar));
    davar_content_read(&users[0].davar, &content);
    davar_content_write(&users[0].davar, &content); /* changes nothing */
}

/* --- a trial --- */

static void choose(bytes_t *bytes)
{
    config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 0.01;
    config.full_scale = 300.0;
    type = (type_t)between(bytes, 0U, 2U);
    config.law = davar_law_of_id((davar_law_id_t)between(bytes, 0U, 4U), type != Q15);
    config.window.longest = 2U * between(bytes, 4U, 80U);
    config.window.shortest = 2U * between(bytes, 2U, config.window.longest / 2U);
    config.moments.segment = between(bytes, 0U, config.window.shortest - 1U);
    config.window.shrink = between(bytes, 1U, 9U);
    config.stride = between(bytes, 1U, 40U);
    config.engine = davar_grid_of(between(bytes, 0U, 1U) != 0U, type != Q15);
    config.window.gaps_max = (uint16_t)between(bytes, 0U, 5U);
    config.glr.block = between(bytes, 5U, 12U);
    config.glr.shock_blocks = between(bytes, 0U, 2U);
    const uint8_t what = byte(bytes);
    config.glr.whiten_first = (int16_t)((what < 240U) ? (512 * (what >> 2U)) : 0);
    config.glr.whiten_second = (int16_t)(((what & 2U) != 0U) ? -11000 : 0);
    config.glr.whiten_level = 1.0;
    config.taus = taus;
    config.tau_count = (uint8_t)between(bytes, 1U, 5U);
    single = byte(bytes) % 2U != 0U;
}

/* Not declared, none, and two low-passes. */
static void start_plan(bytes_t *bytes)
{
    static const shape_t low_pass[] = {{.poles = 0U},
                                       {.cutoff = 0.2, .poles = 1U},
                                       {.cutoff = 0.1, .uncertainty = 0.1, .poles = 2U}};
    const uint32_t which = between(bytes, 0U, 3U);
    if (which == 3U) {
        davar_plan_init(&plan, taus, config.tau_count);
    } else {
        plan_shape(&plan, taus, config.tau_count, &low_pass[which]);
    }
}

static void start(bytes_t *bytes)
{
    memset(cells, 0, sizeof cells);
    for (uint32_t t = 0U; t < config.tau_count; t++) {
        model[t] = (davar_model_tau_t){.m = taus[t]};
        model[t].adev_dps = 0.1 * (double)between(bytes, 1U, 100U);
        model[t].relative_tolerance = 0.02 * (double)(byte(bytes) % 3U);
    }
    start_plan(bytes);
    const davar_monitor_status_t status =
        davar_monitor_init(&monitor, model, config.tau_count, DAVAR_MONITOR_MEMORY);
    REQUIRE(strcmp(davar_monitor_status_text(status), "ok") == 0);
    misfit = (davar_misfit_t){.health = (double)NAN, .fast = (double)NAN, .slow = (double)NAN};
    REQUIRE(davar_encoder_init(&encoder, &config, DAVAR_CAN_BASE, 0U,
                               DAVAR_SEND_ADEV | DAVAR_SEND_COEFFICIENTS | DAVAR_SEND_INTERVALS |
                                   DAVAR_SEND_MONITOR));
    davar_encoder_monitor(&encoder, &misfit);
    reset(bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static void (*const actions[])(bytes_t *) = {
        lose, through_the_dark, flush, reset, take_both, take_both, take_both, push, push, push};
    bytes_t bytes = {data, data + size};
    choose(&bytes);
    if ((init(0U) != DAVAR_OK) || (init(1U) != DAVAR_OK)) {
        return 0;
    }
    start(&bytes);
    while (bytes.next < bytes.end) {
        actions[byte(&bytes) % 10U](&bytes);
        check_counts();
    }
    return 0;
}
