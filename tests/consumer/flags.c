/* Streams, fits, limits and frames, chosen so that a compiler that changes floating-point
 * arithmetic changes at least one bit. Prints a checksum of the bits. The program itself computes
 * in integers. */
#include "davar/davar.h"
#include "davar/monitor.h"
#include "davar/wire.h"

#include <stdio.h>
#include <string.h>

#define SAMPLES 9000U
#define TAUS 7U

static const uint32_t taus[TAUS] = {1U, 2U, 4U, 8U, 16U, 32U, 64U};
static uint64_t memory[16384];
static davar_t davar;
static davar_plan_t plan;
static davar_result_t result;
static davar_encoder_t encoder;
static davar_monitor_t monitor;
static uint64_t sum = UINT64_C(14695981039346656037);
static uint32_t state;

static void add(uint64_t value)
{
    sum = (sum ^ value) * UINT64_C(1099511628211);
}

static void add_double(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    add(((bits << 1U) > (UINT64_C(0x7FF) << 53U)) ? 1U : bits); /* all NaN are equal */
}

static double double_of_bits(uint64_t bits)
{
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static float float_of_bits(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* xorshift; the sum of four parts of it is nearly Gaussian, 0 on average. */
static int32_t noise(void)
{
    state ^= state << 13U;
    state ^= state >> 17U;
    state ^= state << 5U;
    return (int32_t)((state & 255U) + ((state >> 8U) & 255U) + ((state >> 16U) & 255U) +
                     (state >> 24U)) -
           510;
}

/* White noise, then white noise with a random walk, then a ramp and quantization added: the fit
 * uses every term. */
static int32_t count_at(uint32_t i)
{
    static int32_t walk;
    walk = (i == 0U) ? 0 : (walk + (((i / 3000U) == 1U) ? (noise() / 24) : 0));
    const int32_t ramp = ((i / 3000U) == 2U) ? (int32_t)((i - 6000U) / 4U) : 0;
    const int32_t rough = ((i / 1500U) == 5U) ? ((((int32_t)i % 2) * 900) - 450) : 0;
    return noise() + walk + ramp + rough;
}

static void add_frames(const davar_misfit_t *misfit)
{
    static const davar_wire_health_t health;
    davar_frame_t frame;
    davar_encoder_monitor(&encoder, misfit);
    davar_encoder_begin(&encoder, &result, &health);
    while (davar_encoder_next(&encoder, &frame)) {
        for (uint32_t i = 0U; i < frame.length; i++) {
            add(frame.data[i]);
        }
    }
}

static void add_result(void)
{
    static davar_misfit_t misfit;
    for (uint32_t t = 0U; t < result.tau_count; t++) {
        add_double(result.tau[t].adev);
        add_double(result.tau[t].low);
        add_double(result.tau[t].high);
        add_double(result.tau[t].edf);
    }
    for (uint32_t k = 0U; k < DAVAR_COEFFICIENT_COUNT; k++) {
        add(result.coefficient[k].present ? 1U : 0U);
        add_double(result.coefficient[k].value);
        add_double(result.coefficient[k].low);
        add_double(result.coefficient[k].high);
    }
    add_double(result.kurtosis);
    add_double(result.contribution);
    add_double(result.dispersion);
    add_double(result.change.older);
    add_double(result.change.gain);
    add_double(result.steady.low);
    add_double(result.steady.high);
    davar_monitor_update(&monitor, &result, &misfit);
    add_double(misfit.health);
    add_double(misfit.slow);
    add_frames(&misfit);
}

static void take(double rate_hz)
{
    while (davar_take(&davar, &result)) {
        davar_result_t white = result;
        (void)davar_fit_white(&plan, rate_hz, &white);
        add_double(white.coefficient[DAVAR_ANGLE_RANDOM_WALK].low);
        add_double(white.coefficient[DAVAR_BIAS_INSTABILITY].high);
        davar_fit(&plan, rate_hz, &result);
        add_result();
    }
}

/* A float stream with NaN, infinity, tiny and saturating values. */
static float rate_at(uint32_t i, int32_t count)
{
    static const uint32_t special[] = {0x7FC00000U, 0x7F800000U, 0xFF800000U,
                                       0x00000001U, 0x7F7FFFFFU, 0x80000000U};
    return ((i % 700U) == 650U) ? float_of_bits(special[(i / 700U) % 6U]) : (float)count;
}

static void push(char type, uint32_t i)
{
    const int32_t count = count_at(i);
    const int16_t narrow = (int16_t)count;
    const int32_t wide = count * 1024;
    const float rate = rate_at(i, count);
    switch (type) {
    case 'q':
        davar_push_q15(&davar, &narrow, 1U);
        break;
    case 'w':
        davar_push_q31(&davar, &wide, 1U);
        break;
    default:
        davar_push_f32(&davar, &rate, 1U);
        break;
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

static void run(char type, const davar_config_t *config)
{
    static const davar_model_tau_t model[] = {
        {1U, 300.0, 0.0625}, {8U, 100.0, 0.125}, {64U, 35.0, 0.0}};
    state = 2463534242U;
    add((uint64_t)start(type, config));
    add(davar_encoder_init(&encoder, config, DAVAR_WIRE_BASE, 0U, 23U) ? 1U : 0U);
    add(davar_monitor_init(&monitor, model, 3U, DAVAR_MONITOR_MEMORY) ? 1U : 0U);
    for (uint32_t i = 0U; i < SAMPLES; i++) {
        push(type, i);
        take(config->rate_hz);
        if ((i % 2500U) == 2400U) {
            davar_gap(&davar, 7U);
        }
    }
    while (davar_flush(&davar)) {
        take(config->rate_hz);
    }
    const davar_health_t health = davar_health(&davar);
    add(health.gaps + (health.saturated * 1024U));
    add(health.not_finite + (health.alarms * 1024U));
}

static void run_all(const davar_config_t *base)
{
    static const char types[] = {'q', 'w', 'f'};
    for (uint32_t way = 0U; way < 12U; way++) {
        davar_config_t config = *base;
        const bool tracked = (way / 3U) == 3U;
        const davar_law_t *const glr = ((way % 3U) == 0U) ? &davar_law_glr_q15 : &davar_law_glr_q31;
        config.law = tracked ? glr : (((way / 3U) == 0U) ? NULL : &davar_law_or);
        config.window.mode =
            (((way / 3U) == 2U) || tracked) ? DAVAR_MODE_TRAILING : DAVAR_MODE_CENTRED;
        config.moments.segment = tracked ? 0U : 100U;
        config.window.shortest = tracked ? 20U : 400U;
        config.window.grow = (config.window.mode == DAVAR_MODE_TRAILING) ? 1U : 2U;
        run(types[way % 3U], &config);
    }
}

/* The limits of the settings, by their bits: just inside and just outside of 1e-50 and 1e50, and
 * not finite. */
static void add_limits(const davar_config_t *base)
{
    static const uint64_t bits[] = {0x358DEE7A4AD4B81FU, 0x358DEE7A4AD4B81DU, 0x4A511B0EC57E649AU,
                                    0x4A511B0EC57E649BU, 0x7FF0000000000000U, 0x7FF8000000000000U,
                                    0x8000000000000000U, 0x0000000000000001U, 0x3BC79CA10C924223U,
                                    0x3BC79CA10C924222U, 0x4415AF1D78B58C41U, 0xBFF0000000000000U};
    for (uint32_t i = 0U; i < (sizeof bits / sizeof bits[0]); i++) {
        davar_config_t config = *base;
        config.rate_hz = double_of_bits(bits[i]);
        add((uint64_t)davar_init_q15(&davar, &config, memory, sizeof memory));
        config.rate_hz = base->rate_hz;
        config.full_scale = double_of_bits(bits[i]);
        add((uint64_t)davar_init_f32(&davar, &config, memory, sizeof memory));
        config.full_scale = base->full_scale;
        config.moments.kurtosis_high = double_of_bits(bits[i]);
        add((uint64_t)davar_init_q31(&davar, &config, memory, sizeof memory));
    }
}

int main(void)
{
    davar_config_t config = davar_default_config;
    config.window.mode = DAVAR_MODE_CENTRED;
    uint32_t geometric[DAVAR_TAUS_MAX];
    config.rate_hz = double_of_bits(0x4058E66666666666U); /* 99.6 */
    config.unit_per_count = double_of_bits(0x3FA70A3D70A3D70AU);
    config.full_scale = 1048576.0;
    config.taus = taus;
    config.tau_count = TAUS;
    config.stride = 150U;
    config.window.mirrored_end = true;
    davar_plan_init_white(&plan, taus, TAUS);
    add_limits(&config);
    run_all(&config);
    for (uint32_t window = 20U; window < 60000U; window += 1111U) {
        const uint8_t count = davar_taus_geometric(window, 12U, geometric, DAVAR_TAUS_MAX);
        for (uint32_t t = 0U; t < count; t++) {
            add(geometric[t]);
        }
    }
    (void)printf("%08lx%08lx\n", (unsigned long)(sum >> 32U), (unsigned long)(sum & UINT32_MAX));
    return 0;
}
