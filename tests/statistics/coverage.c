/* davar tests - coverage of the intervals of davar_fit. */
#include "coverage.h"

#include "davar/fit.h"

#include <stdio.h>
#include <stdlib.h>

static double adev_of(const double *phase, uint32_t window, uint32_t m)
{
    double sum = 0.0;
    for (uint32_t i = 0; i + 2U * m <= window; i++) {
        const double d = phase[i + 2U * m] - 2.0 * phase[i + m] + phase[i];
        sum += d * d;
    }
    return sqrt(sum / (2.0 * (double)m * (double)m * (double)(window - 2U * m + 1U)));
}

static void observe(const scenario_t *scenario, random_t *random, double *phase, davar_result_t *result)
{
    gyro_noise_fill(&scenario->noise, random, phase + 1, scenario->window);
    phase[0] = 0.0;
    for (uint32_t i = 1; i <= scenario->window; i++) {
        phase[i] += phase[i - 1U];
    }
    result->window_samples = scenario->window;
    result->tau_count = scenario->tau_count;
    for (int t = 0; t < scenario->tau_count; t++) {
        davar_adev_t *tau = &result->tau[t];
        tau->m = scenario->taus[t];
        tau->differences = scenario->window - 2U * tau->m + 1U;
        tau->adev = adev_of(phase, scenario->window, tau->m);
    }
}

static void true_coefficients(const gyro_noise_t *noise, double truth[])
{
    truth[DAVAR_QUANTIZATION] = noise->quantization;
    truth[DAVAR_ANGLE_RANDOM_WALK] = 60.0 * noise->white;
    truth[DAVAR_BIAS_INSTABILITY] = 3600.0 * noise->flicker;
    truth[DAVAR_RATE_RANDOM_WALK] = 216000.0 * noise->walk;
    truth[DAVAR_RATE_RAMP] = 12960000.0 * noise->ramp;
}

static void count_window(const scenario_t *scenario, const davar_result_t *result, coverage_t *sum)
{
    double truth[DAVAR_COEFFICIENT_COUNT];
    bool extra = false;
    true_coefficients(&scenario->noise, truth);
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        const davar_coefficient_t *c = &result->coefficient[k];
        const bool holds = (!c->present || (truth[k] >= c->low)) && (truth[k] <= c->high);
        sum->coefficient[k] += holds ? 1.0 : 0.0;
        sum->present[k] += c->present ? 1.0 : 0.0;
        extra = extra || (c->present && !(truth[k] > 0.0));
    }
    sum->extra += extra ? 1.0 : 0.0;
    for (int t = 0; t < result->tau_count; t++) {
        const double adev = sqrt(gyro_noise_avar(&scenario->noise, result->tau[t].m));
        sum->adev[t] += ((adev >= result->tau[t].low) && (adev <= result->tau[t].high)) ? 1.0 : 0.0;
    }
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

static void average(coverage_t *sum, unsigned windows)
{
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        sum->coefficient[k] /= windows;
        sum->present[k] /= windows;
    }
    for (int t = 0; t < DAVAR_TAUS_MAX; t++) {
        sum->adev[t] /= windows;
    }
    sum->extra /= windows;
}

void coverage_run(const scenario_t *scenario, unsigned windows, uint64_t seed, coverage_t *coverage)
{
    random_t random = random_seeded(seed);
    double *phase = malloc((scenario->window + 1U) * sizeof *phase);
    double *ratio = malloc(windows * sizeof *ratio);
    static davar_result_t result;
    davar_fit_plan_t plan;
    if ((phase == NULL) || (ratio == NULL)) {
        abort();
    }
    *coverage = (coverage_t){0};
    davar_fit_plan(&plan, scenario->taus, scenario->tau_count);
    for (unsigned i = 0; i < windows; i++) {
        observe(scenario, &random, phase, &result);
        davar_fit(&plan, 1.0, &result);
        count_window(scenario, &result, coverage);
        const davar_coefficient_t *arw = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
        ratio[i] = arw->present ? arw->high / arw->low : (double)INFINITY;
    }
    average(coverage, windows);
    qsort(ratio, windows, sizeof *ratio, ascending);
    coverage->arw_ratio = ratio[windows / 2U];
    free(ratio);
    free(phase);
}

void coverage_print(const scenario_t *scenario, unsigned windows, const coverage_t *coverage)
{
    static const char letter[] = "QNBKR";
    printf("%-26s W=%-5u %u windows; ADEV", scenario->name, (unsigned)scenario->window, windows);
    for (int t = 0; t < scenario->tau_count; t++) {
        printf(" %.1f", 100.0 * coverage->adev[t]);
    }
    printf("\n    ARW %.1f (high/low %.2f), extra term %.1f;", 100.0 * coverage->coefficient[DAVAR_ANGLE_RANDOM_WALK],
           coverage->arw_ratio, 100.0 * coverage->extra);
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        printf(" %c %.0f/%.1f", letter[k], 100.0 * coverage->present[k], 100.0 * coverage->coefficient[k]);
    }
    printf(" (reported / statement true)\n");
}
