/* davar tests - the detector after a filter, whitened (10.16): false alarms and delays, at several
 * rates and in coarse counts. Fixed seeds. Prints tables of lib/src/detector/DESIGN.md. */
#include "davar/davar.h"
#include "davar/fit.h"
#include "detector/glr.h"
#include "filter_cases.h"
#include "filtered_noise.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>

#ifndef SEED
#define SEED 1U /* any other must pass, too */
#endif

#define LSB_PER_SIGMA 30.0
#define BLOCK 10U

#define LONG_AVERAGE 9U

void setUp(void) {}

void tearDown(void) {}

/* ---- the detector, whose samples this test whitens (10.16) ---- */

typedef struct {
    davar_glr_t state;
    davar_glr_config_t config;
    davar_glr_event_t event;
    int32_t first;
    int32_t second;
    int32_t before;
    int32_t earlier;
    int32_t sum;
    uint64_t squares;
    uint32_t count;
    bool has_past;
} detector_t;

static detector_t detector;
static filtered_noise_t noise;

static void start(const davar_filter_t *assumed, double rate_hz, double per_hour)
{
    const davar_glr_wish_t wish = {rate_hz, per_hour, 300.0, 600U * BLOCK, BLOCK, 2U, false};
    davar_config_t config = davar_default_config;
    memset(&detector, 0, sizeof detector);
    if (assumed != NULL) {
        davar_whiten(&config, assumed);
    }
    davar_glr_start(&detector.config, &wish);
    detector.config.floor =
        davar_glr_floor(detector.config.block, config.glr.whiten_first, config.glr.whiten_second);
    davar_glr_reset(&detector.state);
    detector.first = config.glr.whiten_first;
    detector.second = config.glr.whiten_second;
}

/* True at the end of a block, which has an event. */
static bool push(double value)
{
    detector_t *const d = &detector;
    const int32_t sample = (int32_t)floor(value + 0.5);
    d->before = d->has_past ? d->before : sample;
    d->earlier = d->has_past ? d->earlier : sample;
    d->has_past = true;
    const int32_t rest =
        sample - (((d->first * d->before) + (d->second * d->earlier) + 8192) >> 14U);
    d->earlier = d->before;
    d->before = sample;
    d->sum += rest;
    d->squares += (uint64_t)((int64_t)rest * rest);
    d->count++;
    if (d->count < BLOCK) {
        return false;
    }
    davar_glr_push_q15(&d->state, &d->config, d->sum, d->squares, &d->event);
    d->sum = 0;
    d->squares = 0U;
    d->count = 0U;
    return true;
}

static double alarms_in(uint64_t samples, double sigma)
{
    double count = 0.0;
    const double mean = random_uniform(&noise.random); /* a part of a count */
    for (uint64_t i = 0U; i < samples; i++) {
        if (push(mean + (sigma * filtered_noise_next(&noise, 1.0)))) {
            count += detector.event.is_alarm ? 1.0 : 0.0;
        }
    }
    return count;
}

/* ---- false alarms ---- */

typedef struct {
    double rate_hz;
    double per_hour;
    double hours;
} setting_t;

static const setting_t settings[] = {{100.0, 1.0, 150.0}, {1000.0, 5.0, 20.0}, {8000.0, 20.0, 3.0}};
#define SETTINGS (sizeof settings / sizeof settings[0])

/* The share of the stated alarms that came, and how many were stated. */
static double false_alarms(const davar_filter_t *filter, const davar_filter_t *assumed,
                           const setting_t *setting, double sigma, double *stated)
{
    filtered_noise_start(&noise, filter, SEED);
    start(assumed, setting->rate_hz, setting->per_hour);
    *stated = setting->hours * setting->per_hour;
    return alarms_in((uint64_t)(setting->hours * 3600.0 * setting->rate_hz), sigma) / *stated;
}

/* 25 percent, and three standard errors of the count. */
static void assert_within_a_quarter(double share, double stated)
{
    const double slack = 3.0 / sqrt(stated);
    TEST_ASSERT_TRUE(share < (1.25 + slack));
    TEST_ASSERT_TRUE(share > (0.75 - slack));
}

static void test_the_rate_of_false_alarms_holds_behind_every_filter(void)
{
    printf("| filter | 100 Hz, 1 /h | 1 kHz, 5 /h | 8 kHz, 20 /h | all |\n");
    for (size_t c = 0U; c < CASES; c++) {
        double came = 0.0;
        double all = 0.0;
        printf("| %s |", cases[c].name);
        for (size_t s = 0U; s < SETTINGS; s++) {
            double stated = 0.0;
            const double share = false_alarms(&cases[c].filter, &cases[c].filter, &settings[s],
                                              LSB_PER_SIGMA, &stated);
            printf(" %.2f |", share);
            assert_within_a_quarter(share, stated);
            came += share * stated;
            all += stated;
        }
        printf(" %.2f |\n", came / all);
        assert_within_a_quarter(came / all, all);
    }
}

/* ---- coarse counts ---- */

/* In fine counts the rate holds; in coarse ones it becomes 0. In between, correlation that whitening
 * leaves is hidden from the dispersion: the average of 8 has up to twice the stated alarms. */
static void test_rounding_raises_no_alarms(void)
{
    static const double sigmas[] = {10.0, 3.0, 1.0, 0.5, 0.3};
    static const size_t which[] = {1U, NARROW_CASE, LESS_NARROW_CASE, LONG_AVERAGE};
    const setting_t setting = {100.0, 1.0, 40.0};
    printf("| filter | 10 counts | 3 | 1 | 0.5 | 0.3 |\n");
    for (size_t i = 0U; i < (sizeof which / sizeof which[0]); i++) {
        printf("| %s |", cases[which[i]].name);
        for (size_t s = 0U; s < (sizeof sigmas / sizeof sigmas[0]); s++) {
            double stated = 0.0;
            const davar_filter_t *const filter = &cases[which[i]].filter;
            const double share = false_alarms(filter, filter, &setting, sigmas[s], &stated);
            printf(" %.2f |", share);
            const double most = ((sigmas[s] > 1.0) && (which[i] == LONG_AVERAGE)) ? 2.0 : 1.25;
            TEST_ASSERT_TRUE(share < (most + (3.0 / sqrt(stated))));
        }
        printf("\n");
    }
}

/* ---- delays ---- */

#define TRIALS 200U
#define QUIET 4000U
#define PATIENCE 6000U

static int ascending(const void *a, const void *b)
{
    const double difference = *(const double *)a - *(const double *)b;
    return (difference > 0.0) - (difference < 0.0);
}

/* Seconds from a change of 1.5 to the alarm at 100 Hz and one false alarm in 2 h: the median, and
 * nine in ten. */
static double delay_of(const davar_filter_t *filter, const davar_filter_t *assumed, double sigma,
                       double *nine)
{
    static double delay[TRIALS];
    filtered_noise_start(&noise, filter, SEED + 1U);
    for (uint32_t t = 0U; t < TRIALS; t++) {
        start(assumed, 100.0, 0.5);
        const double mean = random_uniform(&noise.random);
        const uint32_t quiet = QUIET + (uint32_t)(random_next(&noise.random) % 5120U);
        for (uint32_t i = 0U; i < quiet; i++) {
            (void)push(mean + (sigma * filtered_noise_next(&noise, 1.0)));
        }
        uint32_t i = 1U;
        while ((i < PATIENCE) && !(push(mean + (sigma * filtered_noise_next(&noise, 1.5))) &&
                                   detector.event.is_alarm)) {
            i++;
        }
        delay[t] = (double)i / 100.0;
    }
    qsort(delay, TRIALS, sizeof *delay, ascending);
    *nine = delay[(TRIALS * 9U) / 10U];
    return delay[TRIALS / 2U];
}

static void test_a_change_of_1_5_is_detected_within_1_5_seconds(void)
{
    printf("| filter | whitened | not whitened |\n");
    for (size_t c = 0U; c < CASES; c++) {
        double nine[2];
        const davar_filter_t *const filter = &cases[c].filter;
        const double whitened = delay_of(filter, filter, LSB_PER_SIGMA, &nine[0]);
        const double plain = delay_of(filter, NULL, LSB_PER_SIGMA, &nine[1]);
        printf("| %s | %.2f (%.2f) | %.2f (%.2f) |\n", cases[c].name, whitened, nine[0], plain,
               nine[1]);
        TEST_ASSERT_TRUE(whitened < 1.5);
        /* 10 %, and three standard errors of the ratio of two medians */
        TEST_ASSERT_TRUE(whitened < (1.37 * plain));
    }
}

static void test_a_wrong_cutoff_does_no_harm(void)
{
    static const size_t which[] = {1U, NARROW_CASE, LESS_NARROW_CASE, 5U};
    printf("| filter | cutoff | false alarms, 100 Hz, 1 /h | delay |\n");
    for (size_t i = 0U; i < (sizeof which / sizeof which[0]); i++) {
        for (int sign = -1; sign <= 1; sign += 2) {
            davar_filter_t assumed = cases[which[i]].filter;
            double stated = 0.0;
            assumed.cutoff *= 1.0 + (0.2 * sign);
            const double share = false_alarms(&cases[which[i]].filter, &assumed, &settings[0],
                                              LSB_PER_SIGMA, &stated);
            assert_within_a_quarter(share, stated);
            double nine = 0.0;
            const double delay = delay_of(&cases[which[i]].filter, &assumed, LSB_PER_SIGMA, &nine);
            printf("| %s | %+d %% | %.2f | %.2f (%.2f) |\n", cases[which[i]].name, 20 * sign, share,
                   delay, nine);
            TEST_ASSERT_TRUE(delay < 1.5);
        }
    }
}

/* What coarse counts cost: after narrow filters whitening then delays the alarm. */
static void test_delays_in_coarse_counts(void)
{
    static const double sigmas[] = {10.0, 5.0, 3.0, 1.0};
    static const size_t which[] = {1U, NARROW_CASE, LESS_NARROW_CASE, LONG_AVERAGE};
    printf("| filter | 10 counts | 5 | 3 | 1 | not whitened, 3 | 1 |\n");
    for (size_t i = 0U; i < (sizeof which / sizeof which[0]); i++) {
        const davar_filter_t *const filter = &cases[which[i]].filter;
        double nine = 0.0;
        printf("| %s |", cases[which[i]].name);
        for (size_t s = 0U; s < 4U; s++) {
            printf(" %.2f |", delay_of(filter, filter, sigmas[s], &nine));
        }
        printf(" %.2f |", delay_of(filter, NULL, 3.0, &nine));
        printf(" %.2f |\n", delay_of(filter, NULL, 1.0, &nine));
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_the_rate_of_false_alarms_holds_behind_every_filter);
    RUN_TEST(test_rounding_raises_no_alarms);
    RUN_TEST(test_a_change_of_1_5_is_detected_within_1_5_seconds);
    RUN_TEST(test_a_wrong_cutoff_does_no_harm);
    RUN_TEST(test_delays_in_coarse_counts);
    return UNITY_END();
}
