/* davar-bench - the cost of one sample on this machine, compared with code that a user would write
 * instead. Prints one `key value` line per figure (ns per sample unless the key states otherwise),
 * the median of REPEATS runs each. */
#define _POSIX_C_SOURCE 200809L

#include "davar/davar.h"
#include "davar/fit.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define REPEATS 9
#define SAMPLES 400000

typedef double (*run_t)(const davar_config_t *config);

static int16_t narrow[SAMPLES];
static float rates[SAMPLES];
static double sink; /* keeps the compiler from dropping work */

static const uint32_t octaves[8] = {1U, 2U, 4U, 8U, 16U, 32U, 64U, 128U};

/* White noise of 20 counts on a bias, from a linear congruential generator and the sum of 12
 * uniforms. */
static void make_samples(void)
{
    uint64_t state = 1U;
    for (size_t i = 0U; i < SAMPLES; i++) {
        double sum = -6.0;
        for (unsigned k = 0U; k < 12U; k++) {
            state = (state * UINT64_C(6364136223846793005)) + UINT64_C(1442695040888963407);
            sum += (double)(state >> 40U) / 16777216.0;
        }
        narrow[i] = (int16_t)lrint(20.0 * sum + 37.0);
        rates[i] = (float)narrow[i] * 0.01F;
    }
}

static double now_ns(void)
{
    struct timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time); /* other programs do not count */
    return (1e9 * (double)time.tv_sec) + (double)time.tv_nsec;
}

static int ascending(const void *a, const void *b)
{
    const double difference = *(const double *)a - *(const double *)b;
    return (difference > 0.0) - (difference < 0.0);
}

static double median_of_runs(run_t run, const davar_config_t *config)
{
    double figure[REPEATS];
    for (unsigned i = 0U; i < REPEATS; i++) {
        figure[i] = run(config);
    }
    qsort(figure, REPEATS, sizeof figure[0], ascending);
    return figure[REPEATS / 2];
}

static void *memory_of(size_t bytes)
{
    void *const memory = malloc(bytes);
    if ((memory == NULL) || (bytes == 0U)) {
        fprintf(stderr, "davar-bench: no memory, or init rejected a configuration\n");
        exit(1);
    }
    return memory;
}

static void must_start(davar_status_t status)
{
    if (status != DAVAR_OK) {
        fprintf(stderr, "davar-bench: %s\n", davar_status_text(status));
        exit(1);
    }
}

/* Pushes everything sample by sample and takes no result: the cost of having a value at each
 * sample. */
static double run_q15(const davar_config_t *config)
{
    davar_t davar;
    const size_t bytes = davar_memory_size_q15(config);
    void *const memory = memory_of(bytes);
    must_start(davar_init_q15(&davar, config, memory, bytes));
    const double start = now_ns();
    for (size_t i = 0U; i < SAMPLES;) {
        i += davar_push_until_result_q15(&davar, &narrow[i], SAMPLES - i);
    }
    const double spent = now_ns() - start;
    sink += (double)davar.produced;
    free(memory);
    return spent / SAMPLES;
}

static double run_f32(const davar_config_t *config)
{
    davar_t davar;
    const size_t bytes = davar_memory_size_f32(config);
    void *const memory = memory_of(bytes);
    must_start(davar_init_f32(&davar, config, memory, bytes));
    const double start = now_ns();
    for (size_t i = 0U; i < SAMPLES;) {
        i += davar_push_until_result_f32(&davar, &rates[i], SAMPLES - i);
    }
    const double spent = now_ns() - start;
    sink += (double)davar.produced;
    free(memory);
    return spent / SAMPLES;
}

/* One plan per window length: a machine with the memory need not adapt one plan to every window. */
#define PLANS 256U

/* Pushes everything and takes every result: kurtosis, contribution, window law and ADEV at every
 * epoch, fit and intervals every `fit_every` epochs. */
static double run_fitted(const davar_config_t *config, uint32_t fit_every)
{
    davar_t davar;
    davar_result_t result;
    uint32_t epochs = 0U;
    const size_t bytes = davar_memory_size_q15(config);
    void *const memory = memory_of(bytes);
    davar_plan_t *const plans = memory_of(PLANS * sizeof *plans);
    must_start(davar_init_q15(&davar, config, memory, bytes));
    for (size_t i = 0U; i < PLANS; i++) {
        davar_plan_init_white(&plans[i], config->taus, config->tau_count);
    }
    const double start = now_ns();
    for (size_t i = 0U; i < SAMPLES;) {
        i += davar_push_until_result_q15(&davar, &narrow[i], SAMPLES - i);
        if (davar_take(&davar, &result)) {
            if ((epochs % fit_every) == 0U) {
                davar_fit(&plans[result.window_samples % PLANS], config->rate_hz, &result);
            }
            epochs++;
            sink += result.tau[0].adev;
        }
    }
    const double spent = now_ns() - start;
    free(plans);
    free(memory);
    return spent / SAMPLES;
}

static double run_chain(const davar_config_t *config)
{
    return run_fitted(config, 1U);
}

static double run_chain_every_10(const davar_config_t *config)
{
    return run_fitted(config, 10U);
}

/* Reads every sample once: the floor of every program. */
static double run_reading(const davar_config_t *config)
{
    const double start = now_ns();
    int64_t sum = 0;
    for (unsigned repeat = 0U; repeat < 10U; repeat++) {
        for (size_t i = 0U; i < SAMPLES; i++) {
            sum += narrow[i];
        }
        sink += (double)sum * config->unit_per_count;
    }
    return (now_ns() - start) / (10.0 * SAMPLES);
}

/* The first version of a user: the complete window again at every sample, with a cumulative sum for
 * fairness. */
static double run_brute_force(const davar_config_t *config)
{
    const size_t window = config->window.longest;
    const size_t epochs = 400U;
    double *const phase = memory_of((window + epochs + 1U) * sizeof(double));
    phase[0] = 0.0;
    for (size_t i = 0U; i < (window + epochs); i++) {
        phase[i + 1U] = phase[i] + (double)narrow[i];
    }
    const double start = now_ns();
    for (size_t epoch = 0U; epoch < epochs; epoch++) {
        for (unsigned t = 0U; t < config->tau_count; t++) {
            const size_t m = config->taus[t];
            double sum = 0.0;
            for (size_t i = epoch; (i + (2U * m)) <= (epoch + window); i++) {
                const double difference = phase[i + (2U * m)] - (2.0 * phase[i + m]) + phase[i];
                sum += difference * difference;
            }
            sink += sqrt(sum);
        }
    }
    const double spent = now_ns() - start;
    free(phase);
    return spent / (double)epochs;
}

static davar_config_t plain(uint32_t window, uint8_t tau_count)
{
    davar_config_t config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 0.01;
    config.full_scale = 300.0;
    config.law = NULL;
    config.window.longest = window;
    config.window.shortest = window;
    config.moments.segment = 0U;
    config.taus = octaves;
    config.tau_count = tau_count;
    return config;
}

static davar_config_t adaptive(uint32_t stride)
{
    davar_config_t config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 0.01;
    config.taus = octaves;
    config.tau_count = 8U;
    config.stride = stride;
    return config;
}

/* A grid whose every fourth sample finds the records of an adaptive window. */
static davar_config_t fine_grid(uint32_t window)
{
    davar_config_t config = adaptive(4U);
    config.engine = &davar_engine_grid_q15;
    config.window.longest = window;
    config.window.shortest = window / 2U;
    config.moments.segment = window / 8U;
    config.tau_count = 6U;
    return config;
}

static void figure(const char *key, double value)
{
    printf("%s %.4g\n", key, value);
    fflush(stdout);
}

int main(void)
{
    make_samples();
    const davar_config_t every_sample = plain(600U, 8U);
    const davar_config_t chain = adaptive(1U);
    davar_config_t grid = adaptive(60U);
    grid.engine = &davar_engine_grid_q15;
    const davar_config_t short_window = plain(64U, 6U);
    const davar_config_t long_window = plain(65536U, 6U);
    davar_config_t block64 =
        plain(600U, 8U); /* only the newest result of a block; each push consumes the rest */
    block64.stride = 64U;
    block64.engine = &davar_engine_grid_q15;
    figure("block64_8_taus_ns_per_sample", median_of_runs(run_q15, &block64));
    figure("fixed_every_sample_8_taus_ns_per_sample", median_of_runs(run_q15, &every_sample));
    figure("float_every_sample_8_taus_ns_per_sample", median_of_runs(run_f32, &every_sample));
    figure("grid_8_taus_ns_per_sample", median_of_runs(run_chain, &grid));
    figure("full_chain_every_sample_ns_per_sample", median_of_runs(run_chain, &chain));
    figure("full_chain_fit_every_10_ns_per_sample", median_of_runs(run_chain_every_10, &chain));
    figure("full_chain_push_only_ns_per_sample", median_of_runs(run_q15, &chain));
    figure("reading_ns_per_sample", median_of_runs(run_reading, &every_sample));
    figure("brute_force_ns_per_sample", median_of_runs(run_brute_force, &every_sample));
    figure("flatness_65536_over_64",
           median_of_runs(run_q15, &long_window) / median_of_runs(run_q15, &short_window));
    const davar_config_t short_grid = fine_grid(256U);
    const davar_config_t long_grid = fine_grid(65536U);
    figure("grid_flatness_65536_over_256",
           median_of_runs(run_q15, &long_grid) / median_of_runs(run_q15, &short_grid));
    return (sink > 0.0) ? 0 : 1;
}
