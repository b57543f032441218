/* Noise in counts through the complete library: rounded (5.15), summed by davar_average, and near
 * the ends of a record. */
#include "autocovariance.h"
#include "centred/centred.h"
#include "davar/average.h"
#include "davar/fit.h"
#include "filter_cases.h"
#include "filtered_noise.h"
#include "statistics.h"

#include <string.h>

/* ---- sums of a fast gyro ---- */

static const case_t sums[] = {
    {"white, sum of 8", {SHAPE_SUM(8U)}},
    {"8 kHz to 1 kHz, 250 Hz", {SHAPE_LOW_PASS(250, 1000, 2), SHAPE_SUM(8U)}},
    {"1 kHz to 100 Hz, 41 Hz", {SHAPE_LOW_PASS(41, 100, 2), SHAPE_SUM(10U)}},
    {"1 kHz to 100 Hz, 92 Hz", {SHAPE_LOW_PASS(92, 100, 1), SHAPE_SUM(10U)}},
};

#define SUMS_WINDOW 600U
#define SUMMED_MOST 10U
#define SUM_SIGMAS 4U
static const double sum_sigmas[SUM_SIGMAS] = {30.0, 3.0, 1.0, 0.6}; /* counts, of a fast sample */

static void observe_sums(const double rate[], uint16_t length, double size, double mean,
                         double count)
{
    static double samples[SUMS_WINDOW];
    davar_average_t average;
    uint32_t n = 0U;
    davar_average_init(&average, length);
    for (uint32_t i = 0U; n < SUMS_WINDOW; i++) {
        int32_t sum = 0;
        if (davar_average_push(&average, (int32_t)lround(mean + (size * rate[i])), &sum)) {
            samples[n] = (count / length) * (double)sum;
            n++;
        }
    }
    observe(samples, SUMS_WINDOW);
}

static void run_sums(const void *of, unsigned trials, uint64_t seed)
{
    static filtered_noise_t source;
    static autocovariance_t noise;
    static double rate[SUMS_WINDOW * SUMMED_MOST];
    static score_t scores[SUM_SIGMAS];
    const case_t *const row = of;
    const uint16_t length = row->filter.summed;
    const shape_t fast = {.cutoff = row->filter.cutoff / length, .poles = row->filter.poles};
    shape_t known = row->filter;
    uint32_t m[DAVAR_TAUS_MAX];
    known.uncertainty = 0.0;
    memset(scores, 0, sizeof scores);
    expect_window(SUMS_WINDOW, m, davar_taus_octave(SUMS_WINDOW, m, DAVAR_TAUS_MAX));
    plan_shape(&plan, m, result.tau_count, &known);
    autocovariance_of(&fast, &noise);
    filtered_noise_start(&source, &fast, seed);
    for (unsigned i = 0U; i < trials; i++) {
        const double mean = 100.0 * random_uniform(&source.random);
        for (uint32_t n = 0U; n < (SUMS_WINDOW * length); n++) {
            rate[n] = filtered_noise_next(&source, 1.0);
        }
        for (size_t s = 0U; s < SUM_SIGMAS; s++) {
            const double count = sqrt(length * noise.r[0] / noise.sum) / sum_sigmas[s];
            observe_sums(rate, length, sqrt((double)length / noise.sum) / count, mean, count);
            result.unit_per_count = count / length;
            davar_fit(&plan, 1.0, &result);
            score_add(&scores[s], &result, truth_1, NULL);
        }
    }
    for (size_t s = 0U; s < SUM_SIGMAS; s++) {
        label("%s, sigma %g", row->name, sum_sigmas[s]);
        score_report(&scores[s], 1.0,
                     (sum_sigmas[s] < 3.0) ? "N.within? 95:98.5, bias -1:1"
                                           : "N.given 99:, N.within 95:97.5, bias -1:1, rms :3.6");
    }
}

const experiment_t filtered_sums_experiment = {ROWS(sums), run_sums};

/* ---- noise rounded to counts ---- */

typedef enum { ANYWHERE, ON_A_COUNT, BETWEEN, DRIFTING, WALKING } mean_t;

typedef struct {
    const char *name;
    mean_t mean; /* where it lies between two counts */
    uint32_t window;
} rounding_t;

static const rounding_t rounding[] = {
    {"anywhere", ANYWHERE, 600U},      {"on a count", ON_A_COUNT, 600U},
    {"between two", BETWEEN, 600U},    {"drifting", DRIFTING, 600U},
    {"anywhere", ANYWHERE, LONGEST},   {"on a count", ON_A_COUNT, LONGEST},
    {"between two", BETWEEN, LONGEST}, {"drifting", DRIFTING, LONGEST},
    {"a walk", WALKING, 600U},
};

#define SIGMAS 15U
static const double sigmas[SIGMAS] = {0.0,  0.05, 0.1, 0.2, 0.3, 0.4, 0.45, 0.5,
                                      0.55, 0.6,  0.8, 1.0, 2.0, 5.0, 30.0};

#define ROUNDING_HZ 100.0
#define ROUNDING_UNIT 0.01
#define WALK_STEP 3.0 /* counts */

/* The mean in counts at each sample, and white noise of variance 1. */
static void make_counts(const rounding_t *row, random_t *random, double mean[], double noise[])
{
    const double start = random_uniform(random);
    const double drift =
        (row->mean == DRIFTING) ? (4.0 * random_uniform(random) / row->window) : 0.0;
    const double first[] = {[ANYWHERE] = start,
                            [ON_A_COUNT] = 0.0,
                            [BETWEEN] = 0.5,
                            [DRIFTING] = start,
                            [WALKING] = 0.0};
    const double step = (row->mean == WALKING) ? WALK_STEP : 0.0;
    double walk = first[row->mean];
    for (uint32_t i = 0U; i < row->window; i++) {
        noise[i] = random_gauss(random);
        walk += step * noise[i];
        mean[i] = walk + (drift * i);
    }
}

static const char *rounding_holds(double sigma)
{
    if (sigma < 0.35) {
        return "N 100:, N.given :0";
    }
    if (sigma < 0.45) {
        return "N 95:, N.given :1";
    }
    if (sigma < 0.6) {
        return "N 95:, N.within? 95:";
    }
    return (sigma < 4.0) ? "N 95:, N.given 99:, N.within 95:, bias -1:1"
                         : "N 95:98, N.given 99:, N.within 95:98, bias -1:1";
}

/* Samples `mean` + sigma `noise` of a window through the library and both fits. */
static void score_counts(uint32_t window, const double mean[], const double noise[], double sigma,
                         score_t scores[2])
{
    static int16_t counts[LONGEST];
    const double k = 216000.0 * WALK_STEP * ROUNDING_UNIT * sqrt(ROUNDING_HZ);
    const double truth[DAVAR_COEFFICIENT_COUNT] = {
        [DAVAR_ANGLE_RANDOM_WALK] = 60.0 * sigma * ROUNDING_UNIT / sqrt(ROUNDING_HZ),
        [DAVAR_RATE_RANDOM_WALK] = (sigma < 0.0) ? k : 0.0};
    for (uint32_t i = 0U; i < window; i++) {
        counts[i] = (int16_t)lround(mean[i] + (fmax(sigma, 0.0) * noise[i]));
    }
    davar_reset(&davar);
    davar_push_q15(&davar, counts, window);
    require(davar_take(&davar, &result), "rounding: a window without a result");
    davar_result_t white = result;
    davar_fit(&plan, ROUNDING_HZ, &result);
    score_add(&scores[0], &result, truth, NULL);
    (void)davar_fit_white(&plan, ROUNDING_HZ, &white);
    score_add(&scores[1], &white, truth, NULL);
}

static void run_rounding(const void *of, unsigned trials, uint64_t seed)
{
    static score_t scores[SIGMAS][2];
    static double mean[LONGEST];
    static double noise[LONGEST];
    const rounding_t *const row = of;
    const unsigned windows = (row->window < LONGEST) ? trials : ((trials + 2U) / 3U);
    random_t random = random_seeded(seed);
    const size_t count = (row->mean == WALKING) ? 1U : SIGMAS;
    memset(scores, 0, sizeof scores);
    configure(NULL, row->window, row->window, 1U);
    config.rate_hz = ROUNDING_HZ;
    config.unit_per_count = ROUNDING_UNIT;
    davar_plan_init_white(&plan, config.taus, config.tau_count);
    START(q15);
    for (unsigned i = 0U; i < windows; i++) {
        make_counts(row, &random, mean, noise);
        for (size_t s = 0U; s < count; s++) {
            score_counts(row->window, mean, noise, (row->mean == WALKING) ? -1.0 : sigmas[s],
                         scores[s]);
        }
    }
    for (size_t s = 0U; s < count; s++) {
        label("%s, L %u, sigma %g", row->name, (unsigned)row->window, sigmas[s]);
        score_report(&scores[s][0], 1.0,
                     (row->mean == WALKING) ? "K.given 93:, others 95:"
                                            : rounding_holds(sigmas[s]));
        share("white", scores[s][1].held[DAVAR_ANGLE_RANDOM_WALK], windows);
        report((row->mean == WALKING) ? NULL : "white 95:");
    }
}

const experiment_t rounding_experiment = {ROWS(rounding), run_rounding};

/* ---- near the ends of a record, where a centred window contains part of it twice ---- */

#define RECORD 1000U
#define MIRRORED_TAUS 7U
#define PLACES 7U
#define COUNT 0.001 /* deg/s */

static const uint32_t mirrored_taus[MIRRORED_TAUS] = {1U, 2U, 4U, 8U, 16U, 32U, 64U};
static const uint64_t places[PLACES] = {0U, 50U, 150U, 250U, 300U, 800U, RECORD - 1U};
static const char *const mirrored[] = {"white"};

/* A result waits: is it at one of the places? */
static void score_place(centred_t *centred, score_t scores[PLACES], const double adev[])
{
    require(centred_take(centred, &result), "mirrored: a sample without a result");
    for (unsigned p = 0U; p < PLACES; p++) {
        if (result.epoch == places[p]) {
            davar_fit(&plan, 1.0, &result);
            score_add(&scores[p], &result, truth_1, adev);
        }
    }
}

static void score_record(score_t scores[PLACES], const int16_t *sample, const double adev[])
{
    const davar_port_samples_t samples = {.q15 = sample};
    centred_t *const centred = centred_open(&config, DAVAR_PORT_Q15);
    require(centred != NULL, "mirrored: memory");
    for (size_t n = 0U; n < RECORD;) {
        n += centred_push(centred, samples, n, RECORD);
        score_place(centred, scores, adev);
    }
    while (centred_flush(centred)) {
        score_place(centred, scores, adev);
    }
    centred_close(centred);
}

static void run_mirrored(const void *of, unsigned trials, uint64_t seed)
{
    static score_t scores[PLACES];
    static double noise[RECORD];
    static int16_t sample[RECORD];
    double adev[MIRRORED_TAUS];
    random_t random = random_seeded(seed);
    (void)of;
    memset(scores, 0, sizeof scores);
    configure(NULL, 600U, 600U, 1U);
    config.window = davar_default_config.window;
    config.moments = davar_default_config.moments;
    config.unit_per_count = COUNT;
    config.taus = mirrored_taus;
    config.tau_count = MIRRORED_TAUS;
    davar_plan_init_white(&plan, mirrored_taus, MIRRORED_TAUS);
    for (unsigned t = 0U; t < MIRRORED_TAUS; t++) {
        adev[t] = 1.0 / sqrt((double)mirrored_taus[t]);
    }
    for (unsigned i = 0U; i < trials; i++) {
        gyro_noise_fill(&(gyro_noise_t){.white = 1.0}, &random, noise, RECORD);
        for (unsigned n = 0U; n < RECORD; n++) {
            sample[n] = (int16_t)lround(noise[n] / COUNT);
        }
        score_record(scores, sample, adev);
    }
    for (unsigned p = 0U; p < PLACES; p++) {
        label("epoch %u", (unsigned)places[p]);
        score_report(&scores[p], 1.0,
                     "ADEV 94.4:97, long? 94.4:97, N.given 99:, N.within 95:97, bias -0.7:0.7");
    }
}

const experiment_t mirrored_experiment = {ROWS(mirrored), run_mirrored};
