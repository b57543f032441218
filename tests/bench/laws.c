/* davar tests - every window law on the same signals: the error of its angle random walk, and its
 * rate of alarms. 100 Hz, counts of sigma 20, a result every ten samples. Centred windows are those of davar-sim. One
 * table row per signal.
 *
 *   davar-laws [HOURS [SEED]]     HOURS of each signal (default 1) */
#include "centred/centred.h"
#include "davar/davar.h"
#include "davar/fit.h"
#include "davar/glr.h"

#include "random.h"

#include <stdio.h>
#include <stdlib.h>

#define RATE_HZ 100U
#define STRIDE 10U
#define SETTLED 12000U /* samples until every law has a full window */
#define NEAR (10U * RATE_HZ)
#define SIGMA 20.0
#define TAUS 9U

static const uint32_t taus[TAUS] = {1U, 2U, 4U, 8U, 16U, 32U, 64U, 128U, 256U};

typedef struct {
    const char *name;
    const davar_law_t *law;
    uint32_t longest;
    uint32_t shortest;
} law_t;

static const law_t laws[] = {
    {"A-DAVAR", &davar_law_or, 600U, 400U},  {"kurtosis", &davar_law_kurtosis, 600U, 400U},
    {"fixed 200", NULL, 200U, 200U},         {"fixed 600", NULL, 600U, 600U},
    {"fixed 1200", NULL, 1200U, 1200U},      {"fixed 6000", NULL, 6000U, 6000U},
    {"glr", &davar_law_glr_q15, 6000U, 20U},
};
#define LAWS (sizeof laws / sizeof laws[0])
#define CENTRED_LAWS (LAWS - 1U) /* all but glr */
#define ROWS (LAWS + 1U)         /* and an exponential mean */

/* --- signals --- */

typedef enum { STEADY, STEPS, BURSTS, RAMPS, SINE, SHOCKS, STUCK, LAPLACE, COARSE } kind_t;

typedef struct {
    const char *name;
    double size; /* ratio of a change; of a shock, sigmas */
    kind_t kind;
    uint32_t at; /* samples: of a burst, a sine's period, a shock */
} signal_t;

static const signal_t signals[] = {
    {"quiet", 1.0, STEADY, 0U},
    {"step x1.1", 1.1, STEPS, 0U},
    {"step x1.25", 1.25, STEPS, 0U},
    {"step x1.5", 1.5, STEPS, 0U},
    {"step x2", 2.0, STEPS, 0U},
    {"step x3", 3.0, STEPS, 0U},
    {"burst x3 of 1 s", 3.0, BURSTS, 100U},
    {"burst x3 of 5 s", 3.0, BURSTS, 500U},
    {"burst x3 of 20 s", 3.0, BURSTS, 2000U},
    {"ramp x3 in 30 s", 3.0, RAMPS, 3000U},
    {"sine of 60 s", 0.5, SINE, 6000U},
    {"sine of 20 s", 0.5, SINE, 2000U},
    {"shock, 1 sample", 30.0, SHOCKS, 1U},
    {"shock, 5 samples", 30.0, SHOCKS, 5U},
    {"stuck for 10 s", 0.0, STUCK, 1000U},
    {"Laplace noise", 1.0, LAPLACE, 0U},
    {"half a count", 1.0, COARSE, 0U},
};
#define SIGNALS (sizeof signals / sizeof signals[0])
#define HALF (60U * RATE_HZ) /* of a period: quiet, then changed */
#define PERIOD (2U * HALF)   /* of all repeating changes */

/* Sigma relative to that of the quiet part. */
static double level_at(const signal_t *signal, uint32_t i)
{
    const uint32_t phase = i % PERIOD;
    switch ((int)signal->kind) {
    case STEPS:
        return (phase < HALF) ? 1.0 : signal->size;
    case BURSTS:
        return ((phase >= HALF) && (phase < (HALF + signal->at))) ? signal->size : 1.0;
    case RAMPS:
        if (phase < HALF) {
            return 1.0;
        }
        return (phase < (HALF + signal->at))
                   ? (1.0 + ((signal->size - 1.0) * (double)(phase - HALF) / signal->at))
                   : signal->size;
    case SINE:
        return 1.0 +
               (signal->size * sin(6.283185307179586 * (double)(i % signal->at) / signal->at));
    default:
        return 1.0;
    }
}

/* Samples since the newest change, to which a causal law can only respond late. */
static uint32_t since_change(const signal_t *signal, uint32_t i)
{
    const uint32_t phase = i % PERIOD;
    switch ((int)signal->kind) {
    case STEPS:
    case RAMPS:
        return (phase < HALF) ? phase : (phase - HALF);
    case BURSTS:
    case SHOCKS:
    case STUCK:
        return (phase < HALF) ? UINT32_MAX : (phase - HALF);
    default:
        return UINT32_MAX;
    }
}

static int16_t sample_at(const signal_t *signal, uint32_t i, random_t *random)
{
    const uint32_t phase = i % PERIOD;
    const bool inside = (phase >= HALF) && (phase < (HALF + signal->at));
    static int16_t held;
    const double gauss = random_gauss(random);
    double value = SIGMA * level_at(signal, i) * gauss;
    if (signal->kind == LAPLACE) {
        const double u = random_uniform(random) - 0.5;
        value = ((u < 0.0) ? 1.0 : -1.0) * SIGMA * 0.7071067811865476 * log(1.0 - (2.0 * fabs(u)));
    }
    if (signal->kind == COARSE) {
        value = 0.5 * gauss;
    }
    if ((signal->kind == SHOCKS) && inside) {
        value += signal->size * SIGMA * (((phase % 2U) == 0U) ? 1.0 : -1.0);
    }
    if ((signal->kind == STUCK) && inside) {
        return held;
    }
    held = (int16_t)lround(value);
    return held;
}

/* The white noise before rounding, which the fit subtracts (5.15). */
static double truth_at(const signal_t *signal, uint32_t i)
{
    const double sigma = (signal->kind == COARSE) ? 0.5 : (SIGMA * level_at(signal, i));
    return 60.0 * sigma / sqrt((double)RATE_HZ);
}

static bool changes(const signal_t *signal)
{
    return (signal->kind != STEADY) && (signal->kind != LAPLACE) && (signal->kind != COARSE);
}

/* Samples until the next change, where a window about its epoch can already be wrong. */
static uint32_t until_change(const signal_t *signal, uint32_t i)
{
    const uint32_t phase = i % PERIOD;
    const bool twice = (signal->kind == STEPS) || (signal->kind == RAMPS);
    if (!changes(signal) || (signal->kind == SINE)) {
        return UINT32_MAX;
    }
    return (phase < HALF) ? (HALF - phase) : (twice ? (PERIOD - phase) : UINT32_MAX);
}

/* --- errors --- */

typedef struct {
    double sum;
    uint64_t count;
} mean_square_t;

typedef struct {
    mean_square_t whole;
    mean_square_t near;
    uint32_t alarms;
} errors_t;

static void add(mean_square_t *mean, double error)
{
    mean->sum += error * error;
    mean->count++;
}

static void judge(errors_t *errors, const signal_t *signal, bool is_centred, uint64_t epoch,
                  double arw)
{
    const uint32_t i = (uint32_t)epoch;
    const bool stuck = (signal->kind == STUCK) &&
                       (since_change(signal, i) < signal->at); /* there is no noise then */
    if ((i < SETTLED) || stuck) {
        return;
    }
    const double error = log(arw / truth_at(signal, i));
    add(&errors->whole, error);
    const bool before = is_centred && (until_change(signal, i) < NEAR);
    if ((since_change(signal, i) < NEAR) || before) {
        add(&errors->near, error);
    }
}

/* ARW if white noise explains the window, otherwise the value of its shortest clusters. An ADEV of
 * 0 counts as a tenth of a count. */
static double arw_of(davar_plan_t *plan, davar_result_t *result)
{
    (void)davar_fit_white(plan, RATE_HZ, result);
    const davar_coefficient_t *const arw = &result->coefficient[DAVAR_ANGLE_RANDOM_WALK];
    const double shortest = 60.0 * result->tau[0].adev / sqrt((double)RATE_HZ);
    return fmax(arw->present ? arw->value : shortest, 0.1);
}

typedef struct {
    davar_config_t config;
    davar_t davar;
    centred_t *centred; /* null: trailing */
    uint64_t memory[32768];
    davar_plan_t plan;
} instance_t;

static void start(instance_t *instance, const law_t *law, bool is_centred)
{
    davar_config_t *const config = &instance->config;
    *config = davar_default_config;
    config->rate_hz = RATE_HZ;
    config->unit_per_count = 1.0;
    config->law = law->law;
    config->window.longest = law->longest;
    config->window.shortest = law->shortest;
    config->moments.segment = (law->law == &davar_law_glr_q15) ? 0U : (law->shortest / 4U);
    config->window.grow = is_centred ? 2U : 1U;
    config->stride = STRIDE;
    config->window.gaps_max = 64U;
    config->taus = taus;
    config->tau_count = (law->longest < 600U) ? 6U : TAUS;
    davar_plan_init_white(&instance->plan, taus, config->tau_count);
    instance->centred = is_centred ? centred_open(config, DAVAR_PORT_Q15) : NULL;
    if ((is_centred && (instance->centred == NULL)) ||
        (davar_init_q15(&instance->davar, config, instance->memory, sizeof instance->memory) !=
         DAVAR_OK)) {
        fprintf(stderr, "davar-laws: %s: rejected by init\n", law->name);
        exit(1);
    }
}

/* True if the sample completes a result. */
static bool push(instance_t *instance, int16_t sample, davar_result_t *result)
{
    const davar_port_samples_t samples = {.q15 = &sample};
    if (instance->centred != NULL) {
        (void)centred_push(instance->centred, samples, 0U, 1U);
        return centred_take(instance->centred, result);
    }
    davar_push_q15(&instance->davar, &sample, 1U);
    return davar_take(&instance->davar, result);
}

/* Of the result that push has taken; centred windows have no law glr. */
static bool alarm_of(instance_t *instance)
{
    davar_glr_report_t report = {.alarm = false};
    if (instance->centred == NULL) {
        davar_glr_report(&instance->davar, &report);
    }
    return report.alarm;
}

static void run(const signal_t *signal, bool is_centred, uint32_t samples, uint64_t seed,
                errors_t errors[ROWS])
{
    static instance_t instances[LAWS];
    static davar_result_t result;
    random_t random = random_seeded(seed);
    double mean = SIGMA * SIGMA; /* exponential, of half a squared difference, over 300 samples */
    int16_t before = 0;
    const size_t count = is_centred ? CENTRED_LAWS : LAWS;
    for (size_t l = 0; l < count; l++) {
        start(&instances[l], &laws[l], is_centred);
    }
    for (uint32_t i = 0U; i < samples; i++) {
        const int16_t sample = sample_at(signal, i, &random);
        for (size_t l = 0; l < count; l++) {
            if (push(&instances[l], sample, &result)) {
                judge(&errors[l], signal, is_centred, result.epoch,
                      arw_of(&instances[l].plan, &result));
                errors[l].alarms += alarm_of(&instances[l]) ? 1U : 0U;
            }
        }
        const double difference = (double)sample - before;
        mean += ((0.5 * difference * difference) - mean) / 300.0;
        before = sample;
        if ((i % STRIDE) == (STRIDE - 1U)) {
            judge(&errors[LAWS], signal, is_centred, i, fmax(60.0 * sqrt(mean / RATE_HZ), 0.1));
        }
    }
    for (size_t l = 0; l < count; l++) {
        centred_close(instances[l].centred);
    }
}

static double rms(const mean_square_t *mean)
{
    return (mean->count == 0U) ? (double)NAN : (100.0 * sqrt(mean->sum / (double)mean->count));
}

static void print_row(const char *name, const errors_t errors[ROWS], size_t rows, bool near)
{
    printf("| %s |", name);
    for (size_t l = 0; l < rows; l++) {
        printf(" %.1f |", rms(near ? &errors[l].near : &errors[l].whole));
    }
    printf("\n");
}

static void pool(errors_t *all, const errors_t *one)
{
    all->whole.sum += one->whole.sum;
    all->whole.count += one->whole.count;
    all->near.sum += one->near.sum;
    all->near.count += one->near.count;
}

/* glr and the mean of squares use past samples only, so they have no centred form. Returns the
 * alarms of glr without a change. */
static uint32_t print_table(bool is_centred, double hours, uint64_t seed)
{
    const size_t rows = is_centred ? CENTRED_LAWS : ROWS;
    errors_t pooled[ROWS] = {{{0.0, 0U}, {0.0, 0U}, 0U}};
    uint32_t quiet_alarms = 0U;
    printf("| signal |");
    for (size_t l = 0; l < rows; l++) {
        printf(" %s |", (l < LAWS) ? laws[l].name : "exponential");
    }
    printf("\n|---|");
    for (size_t l = 0; l < rows; l++) {
        printf("---|");
    }
    printf("\n");
    for (size_t s = 0; s < SIGNALS; s++) {
        errors_t errors[ROWS] = {{{0.0, 0U}, {0.0, 0U}, 0U}};
        run(&signals[s], is_centred, (uint32_t)(hours * 3600.0 * RATE_HZ), seed + s, errors);
        print_row(signals[s].name, errors, rows, false);
        for (size_t l = 0; changes(&signals[s]) && (l < ROWS); l++) {
            pool(&pooled[l], &errors[l]);
        }
        quiet_alarms += changes(&signals[s]) ? 0U : errors[LAWS - 1U].alarms;
    }
    print_row("all that change", pooled, rows, false);
    print_row("... within 10 s of a change", pooled, rows, true);
    return quiet_alarms;
}

int main(int argc, char **argv)
{
    const double hours = (argc > 1) ? strtod(argv[1], NULL) : 1.0;
    const uint64_t seed = (argc > 2) ? strtoull(argv[2], NULL, 10) : 1U;
    printf("Trailing windows.\n\n");
    const uint32_t alarms = print_table(false, hours, seed);
    printf("\nglr, alarms while nothing changed: %u in %g h.\n\nCentred windows.\n\n",
           (unsigned)alarms, 3.0 * hours);
    (void)print_table(true, hours, seed);
    return 0;
}
