/* davar-promise - what a setup can promise, for the planner in python/planner: how wide the
 * interval of the angle random walk is, how late law glr shows that the noise has doubled, and how
 * much memory an instance takes. The library itself fits simulated windows, detects simulated
 * changes and has the macros of the memory.
 *
 *   davar-promise TAUS FILTER RATE WINDOW NOISE [ALARMS LONGEST STRIDE]
 *   davar-promise FILTER RATE
 *   davar-promise memory POINTER NAME ARGUMENTS [NAME ARGUMENTS ..]
 *
 * TAUS, FILTER: as davar-plan; FILTER "-" is undeclared. RATE: Hz. WINDOW: samples of a usual
 * window. NOISE: white noise of a sample before the filter, in counts; 0: ignored. For law glr,
 * ALARMS: false alarms per hour; LONGEST, STRIDE: samples. The second form checks a filter and
 * prints the first octave that it passes, in samples. The third is that of memory.h. Prints lines
 * "name value". Exit status: 2 for an argument that the library rejects, with one line on standard
 * error. */
#include "davar/davar.h"
#include "davar/fit.h"
#include "davar/glr.h"
#include "draw.h"
#include "filtered.h"
#include "memory.h"
#include "setup/bandwidth.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TRIALS 401         /* windows */
#define CHANGES 401        /* of the noise */
#define FINE_COUNTS 1000.0 /* noise whose rounding does not matter */
#define OCTAVES 16U        /* up to the narrowest filter */
#define LATEST 20000U      /* samples after it: an alarm that has not come by then is missed */
#define SEEN_LEAST 0.96    /* of the changes */
#define ALARM_COUNTS 100.0 /* noise of an alarm whose counts are not stated */

static int reject(const char *what, const char *why)
{
    (void)fprintf(stderr, "davar-promise: %s: %s\n", what, why);
    return 2;
}

/* --- the interval --- */

/* Index of a pair of sizes, t <= u, in the plan's covariance. */
static int pair(int t, int u)
{
    return ((u * (u + 1)) / 2) + t;
}

/* Cholesky of the covariance of y (5.3) in a window of white noise, N = 1. */
static void factorise(const davar_plan_t *plan, double window, double l[])
{
    for (int u = 0; u < plan->white.count; u++) {
        for (int t = 0; t <= u; t++) {
            const double effective = window + 1.0 - (1.5 * (double)plan->m[t]);
            double left = (double)plan->covariance[pair(t, u)] / effective;
            left *= (t == u) ? 1.0001 : 1.0;
            for (int s = 0; s < t; s++) {
                left -= l[pair(s, t)] * l[pair(s, u)];
            }
            l[pair(t, u)] = (t == u) ? sqrt((left > 0.0) ? left : 0.0) : (left / l[pair(t, t)]);
        }
    }
}

/* A window of white noise as davar_take reports it, in counts. */
static void draw_window(const davar_plan_t *plan, const double l[], uint32_t window, double noise,
                        davar_result_t *result)
{
    double z[DAVAR_TAUS_MAX];
    memset(result, 0, sizeof *result);
    result->tau_count = plan->white.count;
    result->window_samples = window;
    result->unit_per_count = 1.0;
    for (int t = 0; t < plan->white.count; t++) {
        z[t] = draw_gauss();
        double y = 1.0;
        for (int s = 0; s <= t; s++) {
            y += l[pair(s, t)] * z[s];
        }
        const double m = (double)plan->m[t];
        const double square = (noise * noise * y * (double)plan->gain[t]) + (1.0 / 12.0);
        result->tau[t].m = (uint32_t)plan->m[t];
        result->tau[t].differences = window + 1U - (2U * (uint32_t)plan->m[t]);
        result->tau[t].adev = sqrt(((square > 0.0) ? square : 0.0) / m);
    }
}

/* Half the width of the 95 % interval of the angle random walk over its value, percent: the median;
 * and the share of the windows that have it. */
static void promise_interval(davar_plan_t *plan, uint32_t window, double noise)
{
    static double l[(DAVAR_TAUS_MAX * (DAVAR_TAUS_MAX + 1)) / 2];
    static double half[TRIALS];
    static davar_result_t result;
    size_t present = 0U;
    factorise(plan, window, l);
    for (int i = 0; i < TRIALS; i++) {
        draw_window(plan, l, window, noise, &result);
        (void)davar_fit_white(plan, 1.0, &result);
        const davar_coefficient_t *const walk = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
        if (walk->present) {
            half[present] = 50.0 * (walk->high - walk->low) / walk->value;
            present++;
        }
    }
    (void)printf("present_percent %.3g\n", 100.0 * (double)present / TRIALS);
    if (present > 0U) {
        (void)printf("arw_percent %.4g\n", draw_quantile(half, present, 0.5));
    }
}

/* --- the alarm --- */

static int16_t count_of(double value)
{
    return (int16_t)((value < -32767.0) ? -32767.0 : ((value > 32767.0) ? 32767.0 : rint(value)));
}

static davar_filter_t of_gyro;
static filtered_t gyro;

/* Pushes one sample. Returns whether it completes a result with an alarm. */
static bool alarm_after(davar_t *davar, double sigma, davar_result_t *result)
{
    const int16_t count = count_of(filtered_next(&gyro, &of_gyro, sigma * draw_gauss()));
    davar_glr_report_t report = {0};
    davar_push_q15(davar, &count, 1U);
    if (davar_take(davar, result)) {
        davar_glr_report(davar, &report);
    }
    return report.alarm;
}

static double delay(davar_t *davar, davar_result_t *result, double counts)
{
    const uint32_t quiet = (2U * davar->config->window.longest) +
                           (uint32_t)((double)davar->config->stride * draw_uniform());
    davar_reset(davar);
    for (uint32_t i = 0U; i < quiet; i++) {
        (void)alarm_after(davar, counts, result);
    }
    uint32_t late = 1U;
    while (!alarm_after(davar, 2.0 * counts, result) && (late < LATEST)) {
        late++;
    }
    return late;
}

/* Samples from a change to the alarm, which nine in ten do not exceed. */
static int promise_alarm(double rate_hz, uint32_t window, double alarms, uint32_t stride,
                         double counts, bool is_filtered)
{
    static const uint32_t taus[] = {1U, 2U};
    static davar_t davar;
    static davar_result_t result;
    static double late[CHANGES];
    davar_config_t config = {.rate_hz = rate_hz,
                             .unit_per_count = 1.0,
                             .stride = stride,
                             DAVAR_GLR_Q15(1U),
                             .taus = taus,
                             .tau_count = 2U};
    config.window.longest = window;
    config.glr.false_alarms_per_hour = alarms;
    if (is_filtered) {
        davar_whiten(&config, &of_gyro);
    }
    filtered_normalise(&of_gyro);
    const size_t bytes = davar_memory_size_q15(&config);
    void *const memory = calloc(1U, bytes + 8U);
    const davar_status_t status = davar_init_q15(&davar, &config, memory, bytes);
    if ((status != DAVAR_OK) || !filtered_start(&gyro, &of_gyro)) {
        free(memory);
        return reject("law glr", davar_status_text(status));
    }
    for (int i = 0; i < CHANGES; i++) {
        late[i] = delay(&davar, &result, counts);
    }
    const double nine_in_ten = draw_quantile(late, CHANGES, 0.9);
    if (draw_quantile(late, CHANGES, SEEN_LEAST) < (double)LATEST) {
        (void)printf("doubling_samples %.0f\n", nine_in_ten);
    }
    free(memory);
    return 0;
}

/* --- */

static uint8_t read_taus(const char *text, uint32_t taus[])
{
    uint8_t count = 0U;
    char *end = NULL;
    for (const char *at = text; count < DAVAR_TAUS_MAX; at = end + 1) {
        taus[count] = (uint32_t)strtoul(at, &end, 10);
        count++;
        if (*end != ',') {
            break;
        }
    }
    return count;
}

/* Returns 0, or the exit status of an error. */
static int read_filter(const char *text, double rate_hz, davar_filter_t *filter)
{
    char why[400];
    const char *const expected = bandwidth_read(text, rate_hz, filter);
    if (expected == NULL) {
        return 0;
    }
    (void)snprintf(why, sizeof why, "expected %s, found '%s'", expected, text);
    return reject("--bandwidth", why);
}

static int print_passed(const char *text, double rate_hz)
{
    static davar_plan_t plan;
    uint32_t taus[OCTAVES];
    const int status = read_filter(text, rate_hz, &of_gyro);
    if (status != 0) {
        return status;
    }
    for (uint32_t t = 0U; t < OCTAVES; t++) {
        taus[t] = UINT32_C(1) << t;
    }
    davar_plan_init_filtered(&plan, taus, OCTAVES, &of_gyro);
    (void)printf("passed_samples %u\n", (unsigned)taus[plan.white.passed]);
    return 0;
}

int main(int count, char *words[])
{
    static davar_plan_t plan;
    uint32_t taus[DAVAR_TAUS_MAX];
    bool is_filtered = false;
    if ((count > 3) && (strcmp(words[1], "memory") == 0)) {
        return print_memory(count - 2, &words[2]);
    }
    if (count == 3) {
        return print_passed(words[1], strtod(words[2], NULL));
    }
    if ((count != 6) && (count != 9)) {
        (void)fputs("davar-promise: for tools/davar-plan\n", stderr);
        return 2;
    }
    const uint8_t tau_count = read_taus(words[1], taus);
    const double rate_hz = strtod(words[3], NULL);
    const uint32_t window = (uint32_t)strtoul(words[4], NULL, 10);
    const double noise = strtod(words[5], NULL);
    if (strcmp(words[2], "-") == 0) {
        davar_plan_init(&plan, taus, tau_count);
    } else {
        const int status = read_filter(words[2], rate_hz, &of_gyro);
        if (status != 0) {
            return status;
        }
        davar_plan_init_filtered(&plan, taus, tau_count, &of_gyro);
        is_filtered = strcmp(words[2], "none") != 0;
    }
    promise_interval(&plan, window, (noise > 0.0) ? noise : FINE_COUNTS);
    return (count == 6)
               ? 0
               : promise_alarm(rate_hz, (uint32_t)strtoul(words[7], NULL, 10),
                               strtod(words[6], NULL), (uint32_t)strtoul(words[8], NULL, 10),
                               (noise > 0.0) ? noise : ALARM_COUNTS, is_filtered);
}
