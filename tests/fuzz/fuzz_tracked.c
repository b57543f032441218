/* davar tests - law glr compared with brute force. The bytes select a configuration,
 * then sections of noise of any level, shocks, stuck values, gaps, delayed takes, saves and
 * restores. Every taken result is that of the samples accepted by the test's own detector. If a
 * configuration stores so few gaps that windows restart or shocks are merged, every result is
 * within its bounds. */
#include "accepted.h"
#include "davar/state.h"
#include "digest.h"
#include "fuzzing.h"
#include "reported.h"

#include <math.h>

#define MEMORY_WORDS 8192
#define SLOT ((size_t)8 * MEMORY_WORDS)
#include "cells.h"

#define TAUS 4U

static const uint32_t taus[4][TAUS] = {
    {1U, 2U, 4U, 8U}, {1U, 3U, 7U, 16U}, {2U, 5U, 6U, 11U}, {1U, 2U, 3U, 19U}};
static davar_config_t config;
static bool is_q31;
static accepted_t accepted;
static uint32_t random_bits;
/* Two instances: a save and a restore change over to the other. */
static davar_t instances[2];
static uint64_t memory[2][MEMORY_WORDS];
static unsigned current;

static void choose_config(bytes_t *bytes)
{
    static const double rates[] = {0.01, 1.0, 100.0, 3000.0};
    config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 1.0;
    config.moments.segment = 0U;
    config.glr.block = between(bytes, GLR_BLOCK_MIN, 12U);
    config.window.longest = (8U * config.glr.block) + between(bytes, 0U, 200U);
    config.window.shortest = between(bytes, 16U, 40U);
    config.window.shrink = between(bytes, 0U, 20U);
    config.window.grow = 1U;
    config.stride = between(bytes, 1U, 60U);
    config.stride = (config.stride > 30U) ? 1U : config.stride;
    config.glr.shock_blocks = between(bytes, 0U, 2U);
    config.glr.false_alarms_per_hour = rates[between(bytes, 0U, 3U)];
    config.glr.cut_interval_s = (double)between(bytes, 1U, 100U);
    config.window.gaps_max = 400U;
    config.taus = taus[0];
    config.tau_count = TAUS;
    is_q31 = byte(bytes) % 2U != 0U;
    config.law = is_q31 ? &davar_law_glr_q31 : &davar_law_glr_q15;
}

/* The bytes after the first ones select larger blocks and strides, other cluster sizes, few gaps,
 * long windows. */
static void choose_more(bytes_t *bytes)
{
    const uint8_t what = byte(bytes);
    if ((what & 1U) != 0U) {
        config.glr.block = between(bytes, GLR_BLOCK_MIN, GLR_BLOCK_MAX);
        config.window.longest = (8U * config.glr.block) + between(bytes, 0U, 200U);
    }
    if ((what & 2U) != 0U) {
        config.stride *= between(bytes, 1U, 20U);
        config.stride =
            (config.stride < config.window.longest) ? config.stride : config.window.longest;
    }
    if ((what & 8U) != 0U) {
        config.glr.whiten_first = (int16_t)(256 * ((int32_t)byte(bytes) - 128));
        config.glr.whiten_second = (int16_t)(128 * ((int32_t)byte(bytes) - 128));
        config.glr.whiten_level = 2.0;
    }
    if ((what & 4U) != 0U) {
        config.window.gaps_max = (uint16_t)between(bytes, 1U, 4U);
    }
    config.taus = taus[(what >> 3U) % 4U];
    if ((what & 32U) != 0U) {
        config.window.longest = 600U + between(bytes, 0U, 255U);
    }
}

static davar_status_t start(unsigned which)
{
    davar_t *const davar = &instances[which];
    memset(memory[which], 0xA5, sizeof memory[which]);
    return is_q31 ? davar_init_q31(davar, &config, memory[which], sizeof memory[which])
                  : davar_init_q15(davar, &config, memory[which], sizeof memory[which]);
}

static void change_over(void)
{
    REQUIRE(davar_state_save(&instances[current], &storage) == DAVAR_STATE_OK);
    REQUIRE(start(1U - current) == DAVAR_OK);
    current = 1U - current;
    REQUIRE(davar_state_restore(&instances[current], &storage) == DAVAR_STATE_OK);
    memset(memory[1U - current], 0x5A, sizeof memory[0]); /* nothing of it may be read */
}

static void check(const davar_result_t *result, const davar_glr_report_t *report)
{
    REQUIRE((result->window_samples >= config.window.shortest) &&
            (result->window_samples <= config.window.longest));
    REQUIRE(result->epoch < accepted.now);
    REQUIRE(!report->young || (instances[current].health.cuts > 0U));
    if (config.window.gaps_max < 400U) {
        return;
    }
    const uint64_t head = accepted_head(&accepted, result->epoch);
    REQUIRE((head >= result->window_samples) && (head > 0U));
    for (uint32_t t = 0U; t < TAUS; t++) {
        uint32_t differences = 0U;
        const double m = (double)config.taus[t];
        const double sum = accepted_sum(&accepted, head - result->window_samples, head,
                                        config.taus[t], &differences);
        REQUIRE(differences == result->tau[t].differences);
        if (differences > 0U) {
            const double expected = sqrt(sum / (2.0 * m * m * (double)differences));
            REQUIRE(fabs(result->tau[t].adev - expected) <= ((is_q31 ? 3e-16 : 0.0) * expected));
        }
    }
}

static void take(void)
{
    davar_result_t result;
    davar_glr_report_t report;
    if (take_reported(&instances[current], &result, &report)) {
        add_fields(&result, &report);
        check(&result, &report);
    }
}

/* A sample within its type's bits. */
static void push(int32_t given, bool is_left)
{
    const int32_t limit = is_q31 ? 0x7FFFFF : INT16_MAX;
    const int32_t sample = (given > limit) ? limit : ((given < -limit) ? -limit : given);
    const int16_t narrow = (int16_t)sample;
    accepted_hear(&accepted, sample);
    REQUIRE((is_q31 ? davar_push_until_result_q31(&instances[current], &sample, 1U)
                    : davar_push_until_result_q15(&instances[current], &narrow, 1U)) == 1U);
    if (!is_left) {
        take();
    }
}

/* Sum of four uniform variates. */
static int32_t noise(int32_t level)
{
    int32_t sum = 0;
    for (unsigned k = 0U; k < 4U; k++) {
        random_bits = (random_bits * 1664525U) + 1013904223U;
        sum += (int32_t)(random_bits >> 24U) - 128;
    }
    return (sum * level) / 16;
}

static void gap(uint32_t missing)
{
    davar_gap(&instances[current], missing);
    accepted_gap(&accepted);
}

/* Noise over many blocks with random gaps, at times in every block. */
static void run_noise_with_gaps(int32_t level, uint32_t length, bool is_left)
{
    const uint32_t blocks = 1U + (length % 13U); /* between two gaps, about */
    for (uint32_t i = 0U; i < (10U * length); i++) {
        if (((random_bits >> 8U) % (blocks * config.glr.block)) == 0U) {
            gap(1U);
        }
        push(noise(level), is_left);
    }
}

/* One section: its kind and length. */
static void run_stretch(bytes_t *bytes)
{
    const uint8_t what = byte(bytes);
    const uint32_t length = between(bytes, 1U, 120U);
    const bool is_left = (what & 0x80U) != 0U;
    const int32_t level =
        1 << (((what >> 3U) % 16U) + (is_q31 ? 4U : 0U)); /* up to full scale and above */
    const uint8_t kind = what % 8U;
    if (kind == 0U) {
        change_over();
    } else if (kind == 1U) {
        gap(length);
    } else if (kind == 4U) {
        run_noise_with_gaps(level, length, is_left);
    } else if (kind == 2U) { /* a shock */
        for (uint32_t i = 0U; i < (1U + (length % 30U)); i++) {
            push(((i % 2U) != 0U) ? INT32_MAX : INT32_MIN, is_left);
        }
    } else {
        for (uint32_t i = 0U; i < length; i++) {
            push((kind == 3U) ? level : noise(level), is_left); /* 3: stuck */
        }
    }
}

static void same_health(void)
{
    const davar_health_t health = davar_health(&instances[current]);
    REQUIRE(health.cuts == accepted.cuts);
    REQUIRE(health.shocks == accepted.shocks);
    REQUIRE(health.alarms == accepted.alarms);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bytes_t bytes = {data, data + size};
    choose_config(&bytes);
    choose_more(&bytes);
    random_bits = 1U;
    current = 0U;
    memset(cells, 0xFF, sizeof cells);
    if (start(current) != DAVAR_OK) {
        return 0;
    }
    accepted_start(&accepted, &config);
    while (bytes.next < bytes.end) {
        run_stretch(&bytes);
    }
    take();
    accepted_end(&accepted);
    while (davar_flush(&instances[current])) {
        take();
    }
    same_health();
    return 0;
}
