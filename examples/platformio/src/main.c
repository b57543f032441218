/* davar example - a simulated gyro at 100 samples per second. It has white noise with an angle
 * random walk of 0.3 deg/sqrt(h), and three times that from the 60th second onward. Prints the
 * results of davar once per second, and the time when it reports the change. */
#include "davar/fit.h"
#include "davar/glr.h"
#include <davar/davar.h>
#include <math.h>
#include <stdio.h>

#define RATE_HZ 100
#define SECONDS 120
#define WINDOW 3000
#define TAUS 7
#define LSB 0.005 /* deg/s per count */

static const uint32_t taus[TAUS] = {1, 2, 4, 8, 16, 32, 64};
static uint64_t memory[65536 / 8];
static davar_config_t config;
static davar_plan_t plan;
static davar_t gyro;

static double uniform(void)
{
    static uint32_t state = 1;
    state = state * 1664525U + 1013904223U;
    return ((double)state + 0.5) / 4294967296.0;
}

static int16_t next_count(int sample)
{
    const double arw = (sample < SECONDS / 2 * RATE_HZ) ? 0.3 : 0.9;
    const double sigma = arw / 60.0 * sqrt(RATE_HZ); /* deg/s */
    const double noise = sqrt(-2.0 * log(uniform())) * cos(6.283185307179586 * uniform());
    return (int16_t)lround(sigma * noise / LSB);
}

static void print_result(davar_result_t *result)
{
    davar_glr_report_t report;
    davar_glr_report(&gyro, &report);
    davar_fit(&plan, config.rate_hz, result);
    const davar_coefficient_t *arw = &result->coefficient[DAVAR_ANGLE_RANDOM_WALK];
    if ((result->epoch + 1) % RATE_HZ == 0 || report.alarm) {
        printf("%6.1f s  ARW %.3f (%.3f to %.3f) deg/sqrt(h), window %4d%s\n",
               (double)(result->epoch + 1) / RATE_HZ, arw->value, arw->low, arw->high,
               (int)result->window_samples, report.alarm ? ", the noise has changed" : "");
    }
}

static davar_status_t start(void)
{
    config = davar_default_config;
    config.rate_hz = RATE_HZ;
    config.unit_per_count = LSB;
    config.law = &davar_law_glr_q15;
    config.stride = 10;
    config.window.longest = WINDOW;
    config.window.shortest = 20;
    config.moments.segment = 0;
    config.window.shrink = 64;
    config.taus = taus;
    config.tau_count = TAUS;
    davar_plan_init_white(&plan, taus, TAUS);
    return davar_init_q15(&gyro, &config, memory, sizeof memory);
}

int main(void)
{
    static davar_result_t result;
    const davar_status_t status = start();
    if (status != DAVAR_OK) {
        printf("davar: %s\n", davar_status_text(status));
        return 1;
    }
    for (int i = 0; i < SECONDS * RATE_HZ; i++) {
        const int16_t count = next_count(i);
        davar_push_q15(&gyro, &count, 1);
        if (davar_take(&gyro, &result)) {
            print_result(&result);
        }
    }
    return 0;
}
