/* davar tests - the encoder as a program, for Python tests that read its frames.
 *
 *   wire_probe encode SEED RESULTS CONTENT CHANNEL [floor]
 *                                                    random results: their values, then their frames
 *   wire_probe run SEED RESULTS SESSION STRIDE CONTENT FIRST CHANNEL   one run of a sender to its end
 *   wire_probe raw CHANNEL | rates CHANNEL           samples on standard input (index value): frames
 */
#include "davar/can.h"
#include "davar/glr.h"
#include "davar/slcan.h"
#include "random.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SESSION 165U

#define TAUS 32U

static const uint32_t taus[TAUS] = {
    1U << 0,  1U << 1,  1U << 2,  1U << 3,  1U << 4,  1U << 5,  1U << 6,  1U << 7,
    1U << 8,  1U << 9,  1U << 10, 1U << 11, 1U << 12, 1U << 13, 1U << 14, 1U << 15,
    1U << 16, 1U << 17, 1U << 18, 1U << 19, 1U << 20, 1U << 21, 1U << 22, 1U << 23,
    1U << 24, 1U << 25, 1U << 26, 1U << 27, 1U << 28, 1U << 29, 1U << 30, UINT32_MAX};
/* Channels from 8 onward have law glr. */
static davar_config_t config = {
    .rate_hz = 99.3, .stride = 4000000000U, .taus = taus, .tau_count = TAUS};

/* Any magnitude that a sensor could have; sometimes absent, zero or out of range. */
static double any(random_t *random)
{
    const uint64_t choice = random_next(random) % 20U;
    if (choice == 0U) {
        return (double)NAN;
    }
    return (choice == 1U) ? 0.0 : pow(10.0, 14.0 * random_uniform(random) - 7.0);
}

static void make(random_t *random, davar_result_t *result, davar_glr_report_t *report,
                 davar_can_health_t *health)
{
    *result = (davar_result_t){
        .epoch = random_next(random) >> (random_next(random) % 40U),
        .window_samples = (uint32_t)(random_next(random) >> (32U + random_next(random) % 20U)),
        .unstable = (random_next(random) & 1U) != 0U,
        .kurtosis = any(random),
        .contribution = any(random),
        .tau_count = TAUS};
    for (size_t t = 0; t < TAUS; t++) {
        const double value = any(random);
        result->tau[t] = (davar_adev_t){
            .m = taus[t], .adev = value, .low = 0.9 * value, .high = value + any(random)};
    }
    for (size_t k = 0; k < DAVAR_COEFFICIENT_COUNT; k++) {
        const double value = any(random);
        result->coefficient[k] = (davar_coefficient_t){
            .value = value, .low = 0.8 * value, .high = (value + any(random)) * 1.1};
    }
    report->alarm = (random_next(random) & 1U) != 0U;
    report->young = (random_next(random) & 1U) != 0U;
    report->cut_age_samples =
        (uint32_t)(random_next(random) >> (32U + (random_next(random) % 20U)));
    result->dispersion =
        ((random_next(random) % 8U) == 0U) ? (double)NAN : (50.0 * random_uniform(random));
    report->change = (davar_change_t){.m = (uint32_t)(random_next(random) % 513U),
                                      .older = any(random),
                                      .newer = any(random),
                                      .gain = any(random)};
    health->count[random_next(random) % DAVAR_HEALTH_COUNT] = (uint32_t)random_next(random);
    result->noise = (davar_noise_t)(random_next(random) % ((uint64_t)DAVAR_NOISE_FILTERED + 1U));
}

static void make_misfit(random_t *random, davar_misfit_t *misfit)
{
    *misfit = (davar_misfit_t){.health = any(random),
                               .tau_count = TAUS,
                               .worst = (uint8_t)(random_next(random) % (TAUS + 1U))};
    for (size_t t = 0; t < TAUS; t++) {
        misfit->tau[t].deviation = ((random_next(random) & 1U) != 0U) ? any(random) : -any(random);
    }
}

static void make_floor(random_t *random, davar_floor_result_t *floor)
{
    const double high = any(random);
    *floor = (davar_floor_result_t){.why = (davar_floor_why_t)(random_next(random) % 7U),
                                    .value = (float)any(random),
                                    .low = (float)any(random),
                                    .high = (high > 1e6) ? INFINITY : (float)high};
    (void)printf("L %d %.17g %.17g %.17g\n", (int)floor->why, (double)floor->value,
                 (double)floor->low, (double)floor->high);
}

static void print_result(const davar_result_t *result, const davar_glr_report_t *report,
                         const davar_can_health_t *health)
{
    (void)printf("R %llu %u %d %.17g %.17g %d\n", (unsigned long long)result->epoch,
                 result->window_samples, (int)result->unstable, result->kurtosis,
                 result->contribution, (int)result->noise);
    for (size_t t = 0; t < result->tau_count; t++) {
        (void)printf("T %zu %.17g %.17g %.17g\n", t, result->tau[t].adev, result->tau[t].low,
                     result->tau[t].high);
    }
    for (size_t k = 0; k < DAVAR_COEFFICIENT_COUNT; k++) {
        const davar_coefficient_t *one = &result->coefficient[k];
        (void)printf("C %zu %.17g %.17g %.17g\n", k, one->value, one->low, one->high);
    }
    (void)printf("G %d %d %u %u %.17g %.17g %.17g %.17g\n", (int)report->alarm, (int)report->young,
                 report->change.m, report->cut_age_samples, result->dispersion,
                 report->change.older, report->change.newer, report->change.gain);
    for (size_t h = 0; h < DAVAR_HEALTH_COUNT; h++) {
        (void)printf("H %zu %u\n", h, health->count[h]);
    }
}

static void print_misfit(const davar_misfit_t *misfit)
{
    (void)printf("M %.17g %u", misfit->health, misfit->worst);
    for (size_t t = 0; t < misfit->tau_count; t++) {
        (void)printf(" %.17g", misfit->tau[t].deviation);
    }
    (void)putchar('\n');
}

static void print_frame(const davar_frame_t *frame)
{
    (void)printf("F %03X ", frame->identifier);
    for (size_t i = 0; i < frame->length; i++) {
        (void)printf("%02X", frame->data[i]);
    }
    if (frame->length <= 8U) {
        char text[DAVAR_SLCAN_BYTES];
        const size_t length = davar_slcan_encode(frame, text);
        (void)printf(" %.*s", (int)(length - 1U), text);
    }
    (void)putchar('\n');
}

static int encode(char **argv)
{
    random_t random = random_seeded(strtoull(argv[2], NULL, 10));
    davar_encoder_t encoder;
    davar_result_t result;
    davar_glr_report_t report = {0};
    davar_can_health_t health = {{0}};
    davar_misfit_t misfit;
    davar_floor_result_t floor;
    davar_frame_t frame;
    config.law = (strtoul(argv[5], NULL, 10) >= 8U) ? &davar_law_glr_q15 : NULL;
    if (!davar_encoder_init(&encoder, &config, DAVAR_CAN_BASE, (uint8_t)strtoul(argv[5], NULL, 10),
                            (uint8_t)strtoul(argv[4], NULL, 10))) {
        return 2;
    }
    davar_encoder_monitor(&encoder, &misfit);
    davar_encoder_session(&encoder, SESSION);
    for (unsigned long n = strtoul(argv[3], NULL, 10); n > 0U; n--) {
        make(&random, &result, &report, &health);
        make_misfit(&random, &misfit);
        print_result(&result, &report, &health);
        print_misfit(&misfit);
        if (argv[6] != NULL) { /* "floor" */
            make_floor(&random, &floor);
            davar_encoder_floor(&encoder, &floor);
        }
        davar_encoder_begin(&encoder, &result, &report, &health);
        while (davar_encoder_next(&encoder, &frame)) {
            print_frame(&frame);
        }
    }
    return 0;
}

static void print_all(davar_encoder_t *encoder)
{
    davar_frame_t frame;
    (void)puts("R");
    while (davar_encoder_next(encoder, &frame)) {
        print_frame(&frame);
    }
}

/* Valid values, epochs of a sender that begins after sample `first`. */
static int run(char **argv)
{
    static const uint32_t few[4] = {1, 2, 4, 8};
    random_t random = random_seeded(strtoull(argv[2], NULL, 10));
    const davar_config_t own = {.rate_hz = 100.0,
                                .unit_per_count = 0.05,
                                .stride = (uint32_t)strtoul(argv[5], NULL, 10),
                                .taus = few,
                                .tau_count = 4};
    davar_encoder_t encoder;
    davar_result_t result;
    davar_glr_report_t report = {0};
    davar_can_health_t health = {{0}};
    uint64_t epoch = strtoull(argv[7], NULL, 10) - 1U;
    if (!davar_encoder_init(&encoder, &own, DAVAR_CAN_BASE, (uint8_t)strtoul(argv[8], NULL, 10),
                            (uint8_t)strtoul(argv[6], NULL, 10))) {
        return 1;
    }
    davar_encoder_session(&encoder, (uint8_t)strtoul(argv[4], NULL, 10));
    for (unsigned long n = strtoul(argv[3], NULL, 10); n > 0U; n--) {
        make(&random, &result, &report, &health);
        epoch += own.stride;
        result.epoch = epoch;
        result.window_samples = 600U;
        result.unstable = false;
        result.tau_count = 4U;
        davar_encoder_begin(&encoder, &result, &report, &health);
        print_all(&encoder);
    }
    davar_encoder_finish(&encoder, &health);
    print_all(&encoder);
    return 0;
}

/* `floats`: the values are rates, otherwise counts. */
static int raw(bool floats, char **argv)
{
    static const davar_config_t own = {.rate_hz = 100.0, .stride = 100U, .unit_per_count = 0.05};
    davar_encoder_t encoder;
    davar_frame_t frame;
    char line[256];
    if (!davar_encoder_init(&encoder, &own, DAVAR_CAN_BASE, (uint8_t)strtoul(argv[2], NULL, 10),
                            DAVAR_SEND_RAW)) {
        return 1;
    }
    while (fgets(line, sizeof line, stdin) != NULL) {
        char *value = NULL;
        const uint64_t index = strtoull(line, &value, 10);
        bool due = true;
        if (floats) {
            davar_encoder_raw_f32(&encoder, index, strtof(value, NULL), &frame);
        } else {
            due = davar_encoder_raw(&encoder, index, (int32_t)strtol(value, NULL, 10), &frame);
        }
        if (due) {
            print_frame(&frame);
        }
    }
    if (davar_encoder_raw_rest(&encoder, &frame)) {
        print_frame(&frame);
    }
    return 0;
}

int main(int argc, char **argv)
{
    if (((argc == 6) || (argc == 7)) && (strcmp(argv[1], "encode") == 0)) {
        return encode(argv);
    }
    if ((argc == 9) && (strcmp(argv[1], "run") == 0)) {
        return run(argv);
    }
    if ((argc == 3) && ((strcmp(argv[1], "raw") == 0) || (strcmp(argv[1], "rates") == 0))) {
        return raw(strcmp(argv[1], "rates") == 0, argv);
    }
    return 2;
}
