/* davar tests - what a setup of tools/davar-plan delivers on simulated noise of this machine.
 *
 *   setup_promises SEED TRIALS SIGMA
 *
 * FILTER: initialiser of the gyro's filter. SAMPLE: type of a sample. SIGMA: of a sample after the
 * filter, in units of a sample. UNIT: deg/s of a sample's unit; RATE: Hz; QUIET: samples before a
 * change; STRIDE: of the setup; ALARMS: 1 for law glr. Prints the median
 * of half the interval over the value in percent, the share of intervals that hold the truth, and
 * the samples after a doubling within which nine in ten trials show it: by an alarm with law glr,
 * otherwise by an interval that holds the new value. */
#include "davar_setup.h"
#include "filtered_noise.h"

#include <stdio.h>
#include <stdlib.h>

#define LATEST 200000U

static filtered_noise_t noise;
static SAMPLE samples[DAVAR_SETUP_AXES];

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

static double quantile(double values[], size_t count, double share)
{
    qsort(values, count, sizeof values[0], compare);
    return (count > 0U) ? values[(size_t)(share * (double)(count - 1U))] : -1.0;
}

/* One sample of every axis; the result of the first axis, or null. */
static const davar_result_t *step(double sigma)
{
    for (size_t a = 0U; a < DAVAR_SETUP_AXES; a++) {
        const double value = filtered_noise_next(&noise, sigma);
        samples[a] = (SAMPLE)(((SAMPLE)0.5 > (SAMPLE)0) ? value : rint(value));
    }
    davar_setup_push(samples, 1U);
    return davar_setup_take(0U);
}

static bool shows(const davar_result_t *result, double truth)
{
    const davar_coefficient_t *const walk = &result->coefficient[DAVAR_ANGLE_RANDOM_WALK];
    return ALARMS ? result->alarm
                  : (walk->present && (walk->low <= truth) && (truth <= walk->high));
}

int main(int count, char *words[])
{
    static double widths[LATEST];
    static double late[10000];
    static autocovariance_t autocovariance;
    size_t shown = 0U;
    size_t held = 0U;
    if (count != 4) {
        return 2;
    }
    const size_t trials = (size_t)atoi(words[2]);
    const double sigma = atof(words[3]);
    const davar_filter_t filter = FILTER;
    filtered_noise_start(&noise, &filter, (uint64_t)atoi(words[1]));
    autocovariance_of(&filter, &autocovariance);
    const double truth = 60.0 * UNIT * sigma / sqrt(autocovariance.r[0] * RATE);
    for (size_t trial = 0U; trial < trials; trial++) {
        if (davar_setup_start() != DAVAR_OK) {
            return 1;
        }
        const davar_result_t *result = NULL;
        for (size_t i = 0U; i < (QUIET + (trial % STRIDE)); i++) {
            const davar_result_t *const newest = step(sigma);
            result = (newest != NULL) ? newest : result;
        }
        const davar_coefficient_t *const walk = &result->coefficient[DAVAR_ANGLE_RANDOM_WALK];
        if (walk->present) {
            widths[shown] = 50.0 * (walk->high - walk->low) / walk->value;
            shown++;
            held += ((walk->low <= truth) && (truth <= walk->high)) ? 1U : 0U;
        }
        size_t after = 0U;
        do {
            result = step(2.0 * sigma);
            after++;
        } while ((after < LATEST) && ((result == NULL) || !shows(result, 2.0 * truth)));
        late[trial] = (double)after;
    }
    printf("shown %.4f\nheld %.4f\nwidth %.4f\n", (double)shown / (double)trials,
           (double)held / (double)shown, quantile(widths, shown, 0.5));
    printf("late %.0f\n", quantile(late, trials, 0.9));
    return 0;
}
