/* Runs streams through every configuration that a build can disable, with fits, frames and a
 * monitor. Prints the status of init, a checksum of the bits of all results and the number of gaps.
 * Its own arithmetic is exact: where a compiler flag changes a bit, it has changed the library. */
#include "davar/can.h"
#include "davar/cascade.h"
#include "davar/davar.h"
#include "davar/fit.h"
#include "davar/monitor.h"
#include "digest.h"
#include "reported.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SAMPLES 3000
#define PIECE 1000 /* samples; a gap follows each */
#define TAUS 7U
#define RATE_HZ 99.6
#define UNIT 0.045

static const uint32_t taus[2][TAUS] = {{1, 2, 5, 11, 20, 37, 60}, {1, 2, 4, 8, 16, 32, 64}};
static uint64_t memory[8192];
static davar_t davar;
static davar_plan_t plan;
static davar_encoder_t encoder;
static davar_monitor_t monitor;
static davar_result_t result;
static davar_glr_report_t changes;

static void add_frames(const davar_misfit_t *misfit)
{
    static const davar_can_health_t health;
    davar_frame_t frame;
    davar_encoder_monitor(&encoder, misfit);
    davar_encoder_begin(&encoder, &result, &changes, &health);
    while (davar_encoder_next(&encoder, &frame)) {
        for (uint32_t i = 0U; i < frame.length; i++) {
            add(frame.data[i]);
        }
    }
}

static void add_result(const davar_config_t *config)
{
    static davar_misfit_t misfit;
    davar_result_t white = result;
    (void)davar_fit_white(&plan, config->rate_hz, &white);
    add_fields(&white, &changes);
    davar_fit(&plan, config->rate_hz, &result);
    add_fields(&result, &changes);
    davar_monitor_update(&monitor, &result, &misfit);
    add_double(misfit.health);
    add_double(misfit.slow);
    add_frames(&misfit);
}

/* Starts with white noise, which becomes louder. Then come a walk, a ramp and coarse steps, so that
 * the fit uses every term. */
static int32_t count_at(int i)
{
    static int32_t walk;
    const uint32_t x = (uint32_t)i * 2654435761U;
    const int32_t noise = (int32_t)(((x >> 16U) % 201U) + ((x >> 8U) % 101U)) - 150;
    walk = (i == 0) ? 0 : (walk + (((i / 700) == 2) ? (noise / 4) : 0));
    switch (i / 700) {
    case 1:
        return noise + (int32_t)(x >> 24U);
    case 3:
        return noise + walk + (((i % 2) * 900) - 450);
    default:
        return noise + walk + ((i >= 2800) ? (4 * (i - 2800)) : 0);
    }
}

static int16_t narrow[SAMPLES];
static int32_t wide[SAMPLES];
static float rates[SAMPLES]; /* also NaN, infinity, tiny and saturating ones */

static void make_samples(void)
{
    static const uint32_t special[] = {0x7FC00000U, 0x7F800000U, 0xFF800000U,
                                       0x00000001U, 0x7F7FFFFFU, 0x80000000U};
    for (int i = 0; i < SAMPLES; i++) {
        const int32_t count = count_at(i);
        narrow[i] = (int16_t)count;
        wide[i] = count * 1024;
        rates[i] = (float)count;
        if ((i % 450) == 449) {
            memcpy(&rates[i], &special[(i / 450) % 6], sizeof rates[i]);
        }
    }
}

static size_t push_until_result(char type, size_t from, size_t count)
{
    switch (type) {
    case 'q':
        return davar_push_until_result_q15(&davar, narrow + from, count);
    case 'w':
        return davar_push_until_result_q31(&davar, wide + from, count);
    default:
        return davar_push_until_result_f32(&davar, rates + from, count);
    }
}

/* Adds every result, or one in ten if each sample has one. */
static void take(const davar_config_t *config)
{
    if (take_reported(&davar, &result, &changes) &&
        ((config->stride > 1U) || ((result.epoch % 10U) == 0U))) {
        add_result(config);
    }
}

/* Returns the number of gaps. */
static uint32_t push(char type, const davar_config_t *config)
{
    for (size_t done = 0U; done < SAMPLES;) {
        done += push_until_result(type, done, PIECE - (done % PIECE));
        take(config);
        if ((done % PIECE) == 0U) {
            davar_gap(&davar, 3);
        }
    }
    while (davar_flush(&davar)) {
        take(config);
    }
    const davar_health_t health = davar_health(&davar);
    add(health.gaps + (health.saturated * UINT64_C(1024)));
    add(health.not_finite + (health.alarms * UINT64_C(1024)));
    return health.gaps;
}

static davar_status_t start(char type, const davar_config_t *config)
{
    static davar_status_t (*const inits[])(davar_t *, const davar_config_t *, void *, size_t) = {
        davar_init_q15, davar_init_q31, davar_init_f32};
    return inits[(type == 'q') ? 0 : ((type == 'w') ? 1 : 2)](&davar, config, memory,
                                                              sizeof memory);
}

static void report(char type, const char *way, const char *status, uint32_t gaps)
{
    printf("%c%s %s %016llx %u\n", type, way, status,
           (strcmp(status, "ok") == 0) ? (unsigned long long)digest : 0U, (unsigned)gaps);
}

/* The same for a cascade: "qc" and so on. */
static void run_cascade(char type)
{
    static const davar_cascade_config_t config = {.rate_hz = RATE_HZ,
                                                  .unit_per_count = UNIT,
                                                  .full_scale = 1048576.0,
                                                  .shortest = 64,
                                                  .tau_count = 5,
                                                  .clusters = 4};
    static davar_cascade_t cascade;
    davar_cascade_status_t status = DAVAR_CASCADE_OK;
    digest_begin();
    if (type == 'q') {
        status = davar_cascade_init_q15(&cascade, &config, memory, sizeof memory);
    } else if (type == 'w') {
        status = davar_cascade_init_q31(&cascade, &config, memory, sizeof memory);
    } else {
        status = davar_cascade_init_f32(&cascade, &config, memory, sizeof memory);
    }
    if (status == DAVAR_CASCADE_OK) {
        if (type == 'q') {
            davar_cascade_push_q15(&cascade, narrow, SAMPLES);
        } else if (type == 'w') {
            davar_cascade_push_q31(&cascade, wide, SAMPLES);
        } else {
            davar_cascade_push_f32(&cascade, rates, SAMPLES);
        }
        result = (davar_result_t){0};
        (void)davar_cascade_append(&cascade, &result);
        add_fields(&result, &changes);
    }
    report(type, "c", davar_cascade_status_text(status), 0U);
}

/* "ql" and so on: the limits of the settings, by their bits: just inside and just outside of 1e-50
 * and 1e50, of 1e-20 and 1e20, not finite, subnormal, negative. */
static void run_limits(char type, const davar_config_t *base)
{
    static const uint64_t bits[] = {0x358DEE7A4AD4B81FU, 0x358DEE7A4AD4B81DU, 0x4A511B0EC57E649AU,
                                    0x4A511B0EC57E649BU, 0x7FF0000000000000U, 0x7FF8000000000000U,
                                    0x8000000000000000U, 0x0000000000000001U, 0x3BC79CA10C924223U,
                                    0x3BC79CA10C924222U, 0x4415AF1D78B58C41U, 0xBFF0000000000000U};
    davar_config_t config = *base;
    double *const settings[] = {&config.rate_hz, &config.full_scale, &config.moments.kurtosis_high};
    const davar_status_t status = start(type, &config);
    digest_begin();
    for (size_t s = 0U; s < 3U; s++) {
        const double usual = *settings[s];
        for (size_t i = 0U; i < (sizeof bits / sizeof bits[0]); i++) {
            memcpy(settings[s], &bits[i], sizeof bits[i]);
            add((uint64_t)start(type, &config));
        }
        *settings[s] = usual;
    }
    report(type, "l", davar_status_text(status), 0U);
}

/* Bits of the number: adaptive 1, stride 2. 4 and 5 are law glr, 5 with a stride. */
static davar_config_t configured(char type, int number, bool automatic)
{
    davar_config_t config = davar_default_config;
    const bool tracked = number >= 4;
    config.rate_hz = RATE_HZ;
    config.unit_per_count = UNIT;
    config.full_scale = 1048576.0;
    config.window.longest = 200;
    config.window.shortest = tracked ? 20 : 120;
    config.law = (number & 1) != 0 ? &davar_law_or : NULL;
    config.moments.segment = ((number & 1) != 0) && !tracked ? 40 : 0;
    if (tracked) {
        config.law = (type == 'q') ? &davar_law_glr_q15 : &davar_law_glr_q31;
    }
    config.stride = ((number & 2) != 0) || (number == 5) ? 20 : 1;
    const davar_engine_t *const grid =
        (type == 'q') ? &davar_engine_grid_q15 : &davar_engine_grid_q31;
    config.engine = automatic ? NULL : grid;
    config.taus = taus[number & 1];
    config.tau_count = TAUS;
    return config;
}

static void run(char type, int number, bool automatic)
{
    static const davar_model_tau_t model[] = {{1, 4.0, 0.0625}, {2, 3.0, 0.125}};
    const davar_config_t config = configured(type, number, automatic);
    const char way[] = {(char)('0' + number), automatic ? 'a' : '\0', '\0'};
    const davar_status_t status = start(type, &config);
    davar_plan_init_white(&plan, config.taus, TAUS);
    if (!davar_encoder_init(&encoder, &config, DAVAR_CAN_BASE, 0U, 23U) ||
        (davar_monitor_init(&monitor, model, 2U, DAVAR_MONITOR_MEMORY) != DAVAR_MONITOR_OK)) {
        fputs("options: the encoder or the monitor cannot be initialized\n", stderr);
        exit(1);
    }
    digest_begin();
    const uint32_t gaps = (status == DAVAR_OK) ? push(type, &config) : 0U;
    report(type, way, davar_status_text(status), gaps);
}

int main(void)
{
    make_samples();
    for (const char *type = "qwf"; *type != '\0'; type++) {
        const davar_config_t plain = configured(*type, 0, false);
        for (int number = 0; number < 6; number++) {
            run(*type, number, false);
        }
        for (int number = 2; number < 4; number++) {
            run(*type, number, true);
        }
        run_cascade(*type);
        run_limits(*type, &plain);
    }
    return 0;
}
