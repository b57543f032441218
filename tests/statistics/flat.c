/* davar-statistics - white noise from a part of the cluster sizes (5.23): beside motion, and after a
 * low-pass that is not declared. */
#include "filter_cases.h"
#include "filtered_noise.h"
#include "statistics.h"

#include <math.h>

#define TURN (2.0 * 3.14159265358979323846)

static double samples[LONGEST];
static filtered_noise_t source;
static autocovariance_t of_noise;

/* Starts noise of N = 1 after a filter. */
static void start(const shape_t *filter, uint32_t window, uint64_t seed)
{
    uint32_t m[DAVAR_TAUS_MAX] = {0U};
    filtered_noise_start(&source, filter, seed);
    autocovariance_of(filter, &of_noise);
    expect_window(window, m, davar_taus_octave(window, m, DAVAR_TAUS_MAX));
}

static void fill(uint32_t window)
{
    for (uint32_t n = 0U; n < window; n++) {
        samples[n] = sqrt(of_noise.r[0]) * filtered_noise_next(&source, 1.0);
    }
}

/* The sizes of the last window, for a plan. */
static void sizes_of_result(uint32_t m[])
{
    for (uint8_t t = 0U; t < result.tau_count; t++) {
        m[t] = result.tau[t].m;
    }
}

/* ---- motion ---- */

/* Sinusoids whose amplitude in standard deviations of white noise is that of 1 to 20 deg/s beside a
 * gyro of 0.0028 deg/s/sqrt(Hz) at 1 kHz, rotors, and motion without a period. */
typedef enum { SINUSOID, ROTOR, NOISE } kind_t;

typedef struct {
    const char *name;
    double cycles; /* in a sample; of noise: the bandwidth of the motion */
    double size;
    kind_t kind;
    uint32_t window;
    const char *holds;
} motion_t;

#define VALUE "N.given 97:, N.within 93.5:, N 93.5:, bias -0.5:0.5"

#define ROTORS "N.within? 90:, N 97:"

static const motion_t motions[] = {
    {"0.1 Hz 1 deg/s", 1e-4, 11.3, SINUSOID, 4440U, VALUE},
    {"0.1 Hz 20 deg/s", 1e-4, 226.0, SINUSOID, 4440U, VALUE},
    {"0.5 Hz 0.2 deg/s", 5e-4, 2.26, SINUSOID, 4440U, VALUE},
    {"0.5 Hz 5 deg/s", 5e-4, 56.5, SINUSOID, 4440U, VALUE},
    {"2 Hz 1 deg/s", 2e-3, 11.3, SINUSOID, 4440U, VALUE},
    {"0.1 Hz 20 deg/s", 1e-4, 226.0, SINUSOID, 600U, "N.given 80:, N.within 93:, N 96:"},
    {"2 Hz 1 deg/s", 2e-3, 11.3, SINUSOID, 600U, "N.given 90:, N.within 93:, N 96:"},
    {"noise to 1 Hz, 1 deg/s", 1e-3, 11.3, NOISE, 4440U, "N.given 90:, N.within 93:, N 96:"},
    {"noise to 5 Hz, 0.1 deg/s", 5e-3, 1.13, NOISE, 4440U, "N.given 90:, N.within 93:, N 96:"},
    {"noise to 20 Hz, 1 deg/s", 2e-2, 11.3, NOISE, 4440U, "N.given :3, N 97:"},
    {"50 Hz 1 deg/s", 5e-2, 11.3, SINUSOID, 4440U, "N.given :3, N 97:"},
    {"120 Hz 5 deg/s", 0.12, 56.5, SINUSOID, 4440U, "N.given :3, N 97:"},
    {"rotor of 85 Hz 5 deg/s", 0.085, 56.5, ROTOR, 4440U, ROTORS},
    {"rotor of 85 Hz 0.5 deg/s", 0.085, 5.65, ROTOR, 4440U, ROTORS},
    {"rotor of 85 Hz 0.1 deg/s", 0.085, 1.13, ROTOR, 4440U, ROTORS},
    {"rotor of 85 Hz 0.05 deg/s", 0.085, 0.565, ROTOR, 4440U, ROTORS},
    {"rotor of 210 Hz 2 deg/s", 0.21, 22.6, ROTOR, 2000U, ROTORS},
};

/* White noise through two poles, of variance 1. */
typedef struct {
    random_t random;
    double state[2];
    double gain;
} wander_t;

static double wander_next(wander_t *wander, double cycles)
{
    const double keep = exp(-TURN * cycles);
    double value = sqrt(12.0) * (random_uniform(&wander->random) - 0.5);
    for (int i = 0; i < 2; i++) {
        wander->state[i] += (1.0 - keep) * (value - wander->state[i]);
        value = wander->state[i];
    }
    return value / sqrt((1.0 - keep) / 4.0); /* of two equal poles near 1 */
}

/* The frequency of a rotor wanders by a twentieth, once in 13000 samples. */
static double rotor_next(double cycles, double from, uint32_t n, double *phase)
{
    *phase += cycles * (1.0 + 0.05 * sin(TURN * (from + n / 13000.0)));
    return sin(TURN * *phase);
}

static void move(const motion_t *motion, random_t *random, wander_t *wander)
{
    const double from = random_uniform(random);
    double phase = from;
    for (uint32_t n = 0U; n < motion->window; n++) {
        const double next = (motion->kind == NOISE)   ? wander_next(wander, motion->cycles)
                            : (motion->kind == ROTOR) ? rotor_next(motion->cycles, from, n, &phase)
                                                      : sin(TURN * (from + motion->cycles * n));
        samples[n] += motion->size * next;
    }
}

static void run_motion(const void *of, unsigned trials, uint64_t seed)
{
    static const case_t filters[] = {{"white", {.poles = 0U}},
                                     {"2 poles 0.25", {.cutoff = 0.25, .poles = 2U}}};
    const motion_t *const row = of;
    for (size_t f = 0U; f < COUNT_OF(filters); f++) {
        static score_t score;
        uint32_t m[DAVAR_TAUS_MAX] = {0U};
        random_t random = random_seeded(seed + 1U);
        wander_t wander = {.random = random_seeded(seed + 2U)};
        start(&filters[f].filter, row->window, seed);
        sizes_of_result(m);
        plan_shape(&plan, m, result.tau_count, &filters[f].filter);
        score = (score_t){0};
        for (unsigned i = 0U; i < trials; i++) {
            fill(row->window);
            move(row, &random, &wander);
            observe(samples, row->window);
            (void)davar_fit_white(&plan, 1.0, &result);
            (void)davar_fit_flat(&plan, 1.0, &result);
            score_add(&score, &result, truth_1, NULL);
        }
        label("%s, %s, L %u", row->name, filters[f].name, (unsigned)row->window);
        score_report(&score, 1.0, row->holds);
    }
}

const experiment_t flat_motion_experiment = {ROWS(motions), run_motion};

/* ---- after a filter that is not declared ---- */

static void run_undeclared(const void *of, unsigned trials, uint64_t seed)
{
    static const uint32_t windows[] = {600U, 2000U, 4440U};
    const case_t *const row = of;
    for (size_t w = 0U; w < COUNT_OF(windows); w++) {
        static score_t score;
        uint32_t m[DAVAR_TAUS_MAX] = {0U};
        start(&row->filter, windows[w], seed);
        sizes_of_result(m);
        davar_plan_init(&plan, m, result.tau_count);
        score = (score_t){0};
        for (unsigned i = 0U; i < trials; i++) {
            fill(windows[w]);
            observe(samples, windows[w]);
            (void)davar_fit_white(&plan, 1.0, &result);
            (void)davar_fit_flat(&plan, 1.0, &result);
            score_add(&score, &result, truth_1, NULL);
        }
        label("%s, not declared, L %u", row->name, (unsigned)windows[w]);
        score_report(&score, 1.0, "N.within? 90:, N 96:");
    }
}

const experiment_t flat_undeclared_experiment = {ROWS(cases), run_undeclared};
