/* davar tests - false alarms and power of the monitor: noise with a known Allan variance through
 * the whole library, fixed seeds. Prints the table of DESIGN (9.6). */
#include "davar/cascade.h"
#include "davar/davar.h"
#include "davar/monitor.h"
#include "gyro_noise.h"
#include "unity.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define WINDOW 600U
#define WINDOWS 12000U
#define STRETCH 100U /* windows of one record; the monitor restarts with each */
#define TAUS 7U

/* With a cascade: sizes up to 4096 samples, which remember 41 000 to 74 000 samples. */
#define LONG_TAUS 6U
#define LONG_CLUSTERS 8U
#define LONG_STRETCH 1000U
#define LONG_WINDOWS 60000U
#define SAMPLES ((size_t)LONG_STRETCH * WINDOW)

/* The step of a program between davar_take and the monitor. */
typedef enum { FIT_ALL = 0, FIT_WHITE, FIT_NOTHING } fit_t;

typedef struct {
    gyro_noise_t truth;
    gyro_noise_t model;
    double tolerance;
    uint32_t stride;
    fit_t fit;
    bool cascade;
} scenario_t;

/* Percent of results whose number is above 1. */
typedef struct {
    double fast;
    double slow;
    double health;
} alarms_t;

static const uint32_t taus[TAUS + LONG_TAUS] = {1,   2,   4,   8,    16,   32,  64,
                                                128, 256, 512, 1024, 2048, 4096};
static const davar_cascade_config_t long_config = {.rate_hz = 1.0,
                                                   .full_scale = 65536.0,
                                                   .shortest = 128U,
                                                   .tau_count = LONG_TAUS,
                                                   .clusters = LONG_CLUSTERS};
static uint64_t long_memory[DAVAR_CASCADE_MEMORY(F32, LONG_TAUS) / 8U];
static davar_cascade_t cascade;
static davar_model_tau_t table[TAUS + LONG_TAUS];
static davar_t davar;
static davar_monitor_t monitor;
static davar_plan_t plan;
static davar_result_t result;
static davar_misfit_t misfit;
static uint64_t memory[1 << 14];
static double rate[SAMPLES];
static float samples[SAMPLES];

void setUp(void) {}

void tearDown(void) {}

static uint8_t taus_of(const scenario_t *scenario)
{
    return (uint8_t)(scenario->cascade ? (TAUS + LONG_TAUS) : TAUS);
}

static void start(const scenario_t *scenario, davar_config_t *config)
{
    const uint8_t count = taus_of(scenario);
    *config = davar_default_config;
    config->window.mode = DAVAR_MODE_CENTRED;
    config->rate_hz = 1.0;
    config->full_scale = 65536.0;
    config->window.mode = DAVAR_MODE_TRAILING;
    config->law = NULL;
    config->window.longest = WINDOW;
    config->window.shortest = WINDOW;
    config->window.grow = 1U;
    config->stride = scenario->stride;
    config->taus = taus;
    config->tau_count = TAUS;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_f32(&davar, config, memory, sizeof memory));
    TEST_ASSERT_EQUAL(
        DAVAR_OK, davar_cascade_init_f32(&cascade, &long_config, long_memory, sizeof long_memory));
    for (size_t t = 0; t < count; t++) {
        table[t] = (davar_model_tau_t){taus[t], sqrt(gyro_noise_avar(&scenario->model, taus[t])),
                                       scenario->tolerance};
    }
    davar_plan_init_white(&plan, taus, count);
    TEST_ASSERT_TRUE(davar_monitor_init(&monitor, table, count, DAVAR_MONITOR_MEMORY));
}

static void fit(fit_t kind)
{
    if (kind == FIT_ALL) {
        davar_fit(&plan, 1.0, &result);
    } else if (kind == FIT_WHITE) {
        (void)davar_fit_white(&plan, 1.0, &result);
    }
}

/* The record is long enough for every size of a cascade. */
static bool is_complete(const scenario_t *scenario)
{
    return !scenario->cascade || (result.tau[TAUS + LONG_TAUS - 1U].differences > 0U);
}

static void count(const scenario_t *scenario, alarms_t *alarms, unsigned *results)
{
    davar_monitor_update(&monitor, &result, &misfit);
    if (!is_complete(scenario)) {
        return;
    }
    TEST_ASSERT_EQUAL(taus_of(scenario), misfit.compared);
    alarms->fast += (misfit.fast > 1.0) ? 1.0 : 0.0;
    alarms->slow += (misfit.slow > 1.0) ? 1.0 : 0.0;
    alarms->health += (misfit.health > 1.0) ? 1.0 : 0.0;
    (*results)++;
}

static unsigned stretch_of(const scenario_t *scenario)
{
    return scenario->cascade ? LONG_STRETCH : STRETCH;
}

static void watch(const scenario_t *scenario, random_t *random, alarms_t *alarms, unsigned *results)
{
    davar_config_t config;
    const size_t length = (size_t)stretch_of(scenario) * WINDOW;
    start(scenario, &config);
    gyro_noise_fill(&scenario->truth, random, rate, length);
    for (size_t i = 0; i < length; i++) {
        samples[i] = (float)rate[i];
    }
    for (size_t done = 0; done < length;) {
        const size_t pushed = davar_push_until_result_f32(&davar, samples + done, length - done);
        if (scenario->cascade) {
            davar_cascade_push_f32(&cascade, samples + done, pushed);
        }
        done += pushed;
        if (davar_take(&davar, &result)) {
            if (scenario->cascade) {
                (void)davar_cascade_append(&cascade, &result);
            }
            fit(scenario->fit);
            count(scenario, alarms, results);
        }
    }
}

static alarms_t run(const char *name, const scenario_t *scenario, unsigned windows)
{
    random_t random = random_seeded(2024U);
    alarms_t alarms = {0};
    unsigned results = 0U;
    for (unsigned n = 0U; n < windows; n += stretch_of(scenario)) {
        watch(scenario, &random, &alarms, &results);
    }
    alarms.fast *= 100.0 / results;
    alarms.slow *= 100.0 / results;
    alarms.health *= 100.0 / results;
    printf("| %s | %u | %.0f %% | %.2f | %.2f | %.2f |\n", name, (unsigned)scenario->stride,
           100.0 * scenario->tolerance, alarms.fast, alarms.slow, alarms.health);
    return alarms;
}

static void assert_quiet_after(fit_t kind, const char *name, gyro_noise_t noise, uint32_t stride)
{
    const scenario_t scenario = {noise, noise, 0.0, stride, kind, false};
    const alarms_t alarms = run(name, &scenario, WINDOWS);
    /* 1 % is stated; three standard errors of 12000 windows, of which the slow mean keeps 32
     * together */
    TEST_ASSERT_TRUE(alarms.fast <= 1.0 + 3.0 * 0.1);
    TEST_ASSERT_TRUE(alarms.health <= 1.0 + 3.0 * 0.4);
}

static void assert_quiet(const char *name, gyro_noise_t noise, uint32_t stride)
{
    assert_quiet_after(FIT_ALL, name, noise, stride);
}

static void test_noise_that_follows_the_model_raises_no_alarm(void)
{
    assert_quiet("white", (gyro_noise_t){.white = 1.0}, WINDOW);
    assert_quiet("white 1 + BI 0.1", (gyro_noise_t){.white = 1.0, .flicker = 0.1}, WINDOW);
    assert_quiet("white 1 + BI 0.5", (gyro_noise_t){.white = 1.0, .flicker = 0.5}, WINDOW);
    assert_quiet("white 1 + RRW 0.02", (gyro_noise_t){.white = 1.0, .walk = 0.02}, WINDOW);
    assert_quiet("white 1 + RRW 0.3", (gyro_noise_t){.white = 1.0, .walk = 0.3}, WINDOW);
    assert_quiet("white 1 + Q 1", (gyro_noise_t){.white = 1.0, .quantization = 1.0}, WINDOW);
}

static void test_overlapping_windows_alarm_no_more_often(void)
{
    assert_quiet("white", (gyro_noise_t){.white = 1.0}, 60U);
}

static void test_the_rate_holds_whatever_fit_ran(void)
{
    assert_quiet_after(FIT_NOTHING, "white, no fit", (gyro_noise_t){.white = 1.0}, WINDOW);
    assert_quiet_after(FIT_NOTHING, "white 1 + RRW 0.3, no fit",
                       (gyro_noise_t){.white = 1.0, .walk = 0.3}, WINDOW);
    assert_quiet_after(FIT_NOTHING, "white 1 + Q 1, no fit",
                       (gyro_noise_t){.white = 1.0, .quantization = 1.0}, WINDOW);
    assert_quiet_after(FIT_WHITE, "white 1 + BI 0.5, white fit",
                       (gyro_noise_t){.white = 1.0, .flicker = 0.5}, WINDOW);
    assert_quiet_after(FIT_WHITE, "white 1 + RRW 0.3, white fit",
                       (gyro_noise_t){.white = 1.0, .walk = 0.3}, WINDOW);
    assert_quiet_after(FIT_WHITE, "white 1 + Q 1, white fit",
                       (gyro_noise_t){.white = 1.0, .quantization = 1.0}, WINDOW);
}

/* Results overlap by up to 99 %; the longest sizes of a record are 8 to 15 independent values. */
static void assert_quiet_cascade(const char *name, gyro_noise_t noise, fit_t kind)
{
    const scenario_t scenario = {noise, noise, 0.0, WINDOW, kind, true};
    const alarms_t alarms = run(name, &scenario, LONG_WINDOWS);
    TEST_ASSERT_TRUE(alarms.fast <= 0.5 + 3.0 * 0.2);
    TEST_ASSERT_TRUE(alarms.slow <= 0.5 + 3.0 * 0.4);
}

static void test_long_sizes_of_a_cascade_alarm_no_more_often(void)
{
    assert_quiet_cascade("cascade: white", (gyro_noise_t){.white = 1.0}, FIT_ALL);
    assert_quiet_cascade("cascade: white 1 + RRW 0.002",
                         (gyro_noise_t){.white = 1.0, .walk = 0.002}, FIT_ALL);
    assert_quiet_cascade("cascade: white 1 + BI 0.05",
                         (gyro_noise_t){.white = 1.0, .flicker = 0.05}, FIT_ALL);
    assert_quiet_cascade("cascade: white, no fit", (gyro_noise_t){.white = 1.0}, FIT_NOTHING);
}

static void test_a_change_is_detected_whatever_fit_ran(void)
{
    const gyro_noise_t model = {.white = 1.0};
    const scenario_t louder = {{.white = 1.5}, model, 0.02, WINDOW, FIT_NOTHING, false};
    const scenario_t drift = {{.white = 1.5, .walk = 0.3}, model, 0.02, WINDOW, FIT_WHITE, false};
    TEST_ASSERT_TRUE(run("white 1.5 for 1, no fit", &louder, 2000U).fast > 99.0);
    TEST_ASSERT_TRUE(run("white 1.5 + RRW 0.3 for white 1, white fit", &drift, 2000U).fast > 99.0);
}

static void test_a_large_change_is_detected_immediately_and_a_small_one_in_time(void)
{
    const gyro_noise_t model = {.white = 1.0};
    const scenario_t louder = {{.white = 1.5}, model, 0.02, WINDOW, FIT_ALL, false};
    const scenario_t little = {{.white = 1.08}, model, 0.02, WINDOW, FIT_ALL, false};
    const scenario_t drift = {{.white = 1.0, .walk = 0.02}, model, 0.02, WINDOW, FIT_ALL, false};
    const scenario_t unit = {{.white = 1.02}, model, 0.02, WINDOW, FIT_ALL, false};
    TEST_ASSERT_TRUE(run("white 1.5 for 1", &louder, 2000U).fast > 99.0);
    const alarms_t small = run("white 1.08 for 1", &little, 2000U);
    TEST_ASSERT_TRUE(small.fast < 20.0);
    TEST_ASSERT_TRUE(small.slow > 60.0);
    TEST_ASSERT_TRUE(run("white 1 + RRW 0.02 for white 1", &drift, 2000U).slow > 80.0);
    TEST_ASSERT_TRUE(run("white 1.02 for 1", &unit, 2000U).health <= 1.0);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_noise_that_follows_the_model_raises_no_alarm);
    RUN_TEST(test_overlapping_windows_alarm_no_more_often);
    RUN_TEST(test_the_rate_holds_whatever_fit_ran);
    RUN_TEST(test_long_sizes_of_a_cascade_alarm_no_more_often);
    RUN_TEST(test_a_change_is_detected_whatever_fit_ran);
    RUN_TEST(test_a_large_change_is_detected_immediately_and_a_small_one_in_time);
    return UNITY_END();
}
