/* Runs one stream through every configuration that a build can disable. Prints the status of init,
 * and a checksum of the bits of all results. */
#include "davar/cascade.h"
#include "davar/davar.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define SAMPLES 2000

static const uint32_t taus[] = {1, 2, 5, 11};
static uint64_t memory[2048];
static davar_t davar;
static davar_plan_t plan;
static uint64_t sum;

static void add(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    sum = (sum ^ (isnan(value) ? 1U : bits)) * UINT64_C(1099511628211);
}

static void add_result(const davar_config_t *config, davar_result_t *result)
{
    davar_fit(&plan, config->rate_hz, result);
    add((double)result->epoch);
    add((double)result->window_samples + result->kurtosis);
    for (int t = 0; t < result->tau_count; t++) {
        add(result->tau[t].adev);
        add(result->tau[t].high);
    }
    for (int k = 0; k < DAVAR_COEFFICIENT_COUNT; k++) {
        add(result->coefficient[k].value);
        add(result->coefficient[k].high);
    }
}

static int32_t count_at(int i)
{
    const uint32_t x = (uint32_t)i * 2654435761U;
    return (int32_t)(((x >> 16U) % 201U) + ((x >> 8U) % 101U)) - 150 +
           ((i / 700) % 2 != 0 ? (int32_t)(x >> 24U) : 0);
}

static int16_t narrow[SAMPLES];
static int32_t wide[SAMPLES];
static float rates[SAMPLES];

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

static void push_all(char type, size_t count, const davar_config_t *config)
{
    static davar_result_t result;
    for (size_t done = 0; done < count;) {
        done += push_until_result(type, done, count - done);
        if (davar_take(&davar, &result)) {
            add_result(config, &result);
        }
    }
}

static void push(char type, const davar_config_t *config)
{
    static davar_result_t result;
    for (int i = 0; i < SAMPLES; i++) {
        wide[i] = count_at(i);
        narrow[i] = (int16_t)wide[i];
        rates[i] = 0.01F * (float)wide[i];
    }
    if (type == 'q') {
        push_all(type, SAMPLES / 2, config);
        davar_gap(&davar, 3);
    }
    push_all(type, SAMPLES, config);
    while (davar_flush(&davar) && davar_take(&davar, &result)) {
        add_result(config, &result);
    }
}

static davar_status_t start(char type, const davar_config_t *config)
{
    switch (type) {
    case 'q':
        return davar_init_q15(&davar, config, memory, sizeof memory);
    case 'w':
        return davar_init_q31(&davar, config, memory, sizeof memory);
    default:
        return davar_init_f32(&davar, config, memory, sizeof memory);
    }
}

/* The same for a cascade: "qc" and so on. */
static void run_cascade(char type)
{
    static const davar_cascade_config_t config = {.rate_hz = 100.0,
                                                  .unit_per_count = 0.01,
                                                  .full_scale = 100.0,
                                                  .shortest = 64,
                                                  .tau_count = 5,
                                                  .clusters = 4};
    static davar_cascade_t cascade;
    static davar_result_t result;
    davar_status_t status = DAVAR_OK;
    sum = 0;
    if (type == 'q') {
        status = davar_cascade_init_q15(&cascade, &config, memory, sizeof memory);
    } else if (type == 'w') {
        status = davar_cascade_init_q31(&cascade, &config, memory, sizeof memory);
    } else {
        status = davar_cascade_init_f32(&cascade, &config, memory, sizeof memory);
    }
    for (int i = 0; (i < SAMPLES) && (status == DAVAR_OK); i++) {
        const int32_t wide_count = count_at(i);
        const int16_t count = (int16_t)wide_count;
        const float rate = 0.01F * (float)wide_count;
        if (type == 'q') {
            davar_cascade_push_q15(&cascade, &count, 1);
        } else if (type == 'w') {
            davar_cascade_push_q31(&cascade, &wide_count, 1);
        } else {
            davar_cascade_push_f32(&cascade, &rate, 1);
        }
    }
    if (status == DAVAR_OK) {
        result.tau_count = 0U;
        (void)davar_cascade_append(&cascade, &result);
        for (int t = 0; t < result.tau_count; t++) {
            add(result.tau[t].adev);
            add(result.tau[t].high);
        }
    }
    printf("%cc %s %016llx\n", type, davar_status_text(status), (unsigned long long)sum);
}

int main(void)
{
    static const char types[] = {'q', 'w', 'f'};
    davar_plan_init_white(&plan, taus, 4);
    for (int all = 0; all < 42; all++) {
        const int number = all % 14;
        const bool automatic = number >= 10;
        const int way = automatic ? (number - 6) : number; /* 4 to 7 once more */
        const bool tracked = way >= 8;
        davar_config_t config = davar_default_config;
        config.window.mode = DAVAR_MODE_CENTRED;
        config.rate_hz = 100.0;
        config.unit_per_count = 0.01;
        config.full_scale = 100.0;
        config.window.longest = 200;
        config.window.shortest = 120;
        config.moments.segment = (way & 1) != 0 ? 40 : 0;
        config.law = (way & 1) != 0 ? &davar_law_or : NULL;
        if (tracked) {
            config.law = (types[all / 14] == 'q') ? &davar_law_glr_q15 : &davar_law_glr_q31;
            config.moments.segment = 0;
            config.window.shortest = 20;
        }
        config.window.mode = (way & 2) != 0 ? DAVAR_MODE_CENTRED : DAVAR_MODE_TRAILING;
        config.stride = ((way & 4) != 0) || (way == 9) ? 20 : 1;
        config.engine = automatic ? DAVAR_ENGINE_AUTO : DAVAR_ENGINE_GRID;
        config.window.mirrored_end = true;
        config.taus = taus;
        config.tau_count = 4;
        const char type = types[all / 14];
        const davar_status_t status = start(type, &config);
        sum = 0;
        if (status == DAVAR_OK) {
            push(type, &config);
        }
        printf("%c%d%s %s %016llx\n", type, way, automatic ? "a" : "", davar_status_text(status),
               (unsigned long long)sum);
    }
    for (int type = 0; type < 3; type++) {
        run_cascade(types[type]);
    }
    return 0;
}
