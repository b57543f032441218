/* Whole recordings through a window and a cascade: the intervals of the cascade's sizes (11.8), the
 * fit of the curve (5.18), and how long a gyro must rest until it resolves B and K. */
#include "davar/cascade.h"
#include "davar/fit.h"
#include "shape.h"
#include "statistics.h"

#include <string.h>

static davar_cascade_t cascade;
static uint64_t cascade_memory[DAVAR_CASCADE_MEMORY(Q31, DAVAR_CASCADE_TAUS_MAX) / 8U];

/* ---- sizes of a cascade ---- */

/* The cascade reads a recording at its hops only. A hop of 16 samples is therefore one sample of
 * the noise, pushed 16 times. Its Allan variance at m samples is that of the noise at m / 16. */
#define HOP 16U
#define HOPS_MAX 4096U
#define HOP_COUNTS 1048576.0 /* per unit of the noise */

typedef struct {
    const char *noise;
    uint32_t hops; /* of a recording, at most: it ends anywhere in its last quarter */
    uint16_t clusters;
    uint8_t tau_count;
    uint32_t gap_every; /* hops; 0: none */
    const char *holds;
} cascade_row_t;

#define TIGHT "ADEV 94.3:96.3, long? 94.3:98"
#define SAFE "ADEV 94.3:98" /* differences beside gaps are less correlated than edf assumes */

/* 4 clusters and more, all of them remembered, or the beginning forgotten by all but the longest
 * size. `long`: fewer than ten clusters, which scatter less than the chi-square of their degrees of
 * freedom in white noise. */
static const cascade_row_t cascades[] = {
    {"N 1", 1000U, 2048U, 6U, 0U, TIGHT},
    {"B 1", 1000U, 2048U, 6U, 0U, TIGHT},
    {"K 1", 1000U, 2048U, 6U, 0U, TIGHT},
    {"N 1 B 0.1 K 0.005", 1000U, 2048U, 6U, 0U, TIGHT},
    {"N 1", 180U, 32U, 4U, 0U, TIGHT},
    {"B 1", 180U, 32U, 4U, 0U, TIGHT},
    {"K 1", 180U, 32U, 4U, 0U, "ADEV 94:96.3, long 94:98"},
    {"N 1", 4096U, 8U, 8U, 0U, TIGHT},
    {"B 1", 4096U, 8U, 8U, 0U, TIGHT},
    {"K 1", 4096U, 8U, 8U, 0U, TIGHT},
    {"N 1", 4096U, 32U, 8U, 0U, TIGHT},
    {"B 1", 4096U, 32U, 8U, 0U, TIGHT},
    {"K 1", 4096U, 32U, 8U, 0U, TIGHT},
    {"N 1", 2000U, 2048U, 5U, 200U, SAFE},
    {"B 1", 2000U, 2048U, 5U, 200U, SAFE},
    {"K 1", 2000U, 2048U, 5U, 200U, SAFE},
};

static void push_hops(const cascade_row_t *row, random_t *random, const double rate[],
                      uint32_t hops)
{
    int32_t block[HOP];
    for (uint32_t i = 0U; i < hops; i++) {
        if ((row->gap_every > 0U) && ((random_next(random) % row->gap_every) == 0U)) {
            davar_cascade_gap(&cascade, 1U);
        }
        for (uint32_t k = 0U; k < HOP; k++) {
            block[k] = (int32_t)lround(HOP_COUNTS * rate[i]);
        }
        davar_cascade_push_q31(&cascade, block, HOP);
    }
    davar_cascade_flush(&cascade);
}

static void run_cascade(const void *of, unsigned trials, uint64_t seed)
{
    static davar_cascade_config_t settings; /* the cascade keeps its address */
    static score_t score;
    static double rate[HOPS_MAX];
    const cascade_row_t *const row = of;
    const gyro_noise_t noise = noise_of(row->noise);
    double adev[DAVAR_CASCADE_TAUS_MAX];
    double clusters[DAVAR_CASCADE_TAUS_MAX] = {0.0};
    double truth[DAVAR_COEFFICIENT_COUNT] = {0.0};
    uint32_t sizes[DAVAR_CASCADE_TAUS_MAX];
    random_t random = random_seeded(seed);
    settings = (davar_cascade_config_t){.rate_hz = 1.0,
                                        .unit_per_count = 1.0 / HOP_COUNTS,
                                        .shortest = 4U * HOP,
                                        .tau_count = row->tau_count,
                                        .clusters = row->clusters};
    for (uint32_t t = 0U; t < row->tau_count; t++) {
        sizes[t] = settings.shortest << t;
        adev[t] = sqrt(gyro_noise_avar(&noise, 4U << t));
    }
    score = (score_t){0};
    davar_plan_init_white(&plan, sizes, row->tau_count);
    for (unsigned i = 0U; i < trials; i++) {
        const uint32_t hops = row->hops - (uint32_t)(random_next(&random) % (row->hops / 4U));
        gyro_noise_fill(&noise, &random, rate, hops);
        require(davar_cascade_init_q31(&cascade, &settings, cascade_memory,
                                       sizeof cascade_memory) == DAVAR_CASCADE_OK,
                "cascade: init");
        push_hops(row, &random, rate, hops);
        result = (davar_result_t){0};
        require(davar_cascade_append(&cascade, &result), "cascade: append");
        davar_fit(&plan, settings.rate_hz, &result);
        score_add(&score, &result, truth, adev);
        for (uint32_t t = 0U; t < row->tau_count; t++) {
            const davar_adev_t *const tau = &result.tau[t];
            clusters[t] += (tau->differences > 0U)
                               ? (2.0 + (((double)tau->differences - 1.0) / (double)tau->hops))
                               : 0.0;
        }
    }
    for (uint32_t t = 0U; t < row->tau_count; t++) {
        score.is_long[t] = clusters[t] < (10.0 * score.taken[t]);
    }
    label("%s, %u hops, C %u%s", row->noise, (unsigned)row->hops, row->clusters,
          (row->gap_every > 0U) ? ", gaps" : "");
    score_report(&score, 1.0, row->holds);
}

const experiment_t cascade_experiment = {ROWS(cascades), run_cascade};

/* ---- the curve of window and cascade ---- */

#define WINDOW 300U
#define SHORT_TAUS 6U
#define LONG_TAUS 10U
#define TAUS (SHORT_TAUS + LONG_TAUS)
#define SAMPLES_MAX 65536U
#define CUTOFF 0.05
#define CURVE_COUNTS 4096.0 /* per unit of the noise */

typedef enum { IS_WHITE, UNDECLARED, ONE_POLE, PLANS } declared_t;

typedef struct {
    const char *name;
    const char *noise;
    uint32_t samples;   /* of a recording */
    uint32_t gap_every; /* samples; 0: none */
    bool short_window;  /* only two of its sizes have differences */
    declared_t declared;
    const char *holds;
} curve_t;

static const uint32_t curve_taus[TAUS] = {1U,   2U,   4U,    8U,    16U,   32U,   64U,    128U,
                                          256U, 512U, 1024U, 2048U, 4096U, 8192U, 16384U, 32768U};

static double constant(double at)
{
    (void)at;
    return 1.0;
}

static double louder(double at)
{
    return (at < 0.98) ? 1.0 : 1.5;
}

static double quieter(double at)
{
    return (at < 0.6) ? 1.0 : 0.3;
}

static double burst(double at)
{
    return ((at > 0.5) && (at < 0.51)) ? 10.0 : 1.0;
}

static double swell(double at)
{
    return exp(0.7 * sin(25.0 * at));
}

#define CURVE "ADEV 94.3:97.5, long 94.3:98, N 95:, N.given 99.5:, withheld :0.5, others "
#define LEVEL "N 95:98.3, others 94:, extra "
#define B_LEVEL "N 95:98.7, others 93:, B.given 94:"

/* The angle random walk is that of the window, whatever the cascade remembers; other levels of white
 * noise before are no drift (11.9). Near the threshold, some recordings take one drift for another.
 * A ramp scatters less than noise. */
static const curve_t curves[] = {
    {"white", "N 1", 16384U, 0U, false, IS_WHITE, CURVE "98.5:, extra :2, bias -1:1"},
    {"white, undeclared", "N 1", 8192U, 0U, false, UNDECLARED, CURVE "98.5:"},
    {"white, short window", "N 1", 8192U, 0U, true, IS_WHITE, CURVE "98.5:"},
    {"white, gaps", "N 1", 16384U, 2000U, false, IS_WHITE, CURVE "98.5:"},
    {"B 0.07", "N 1 B 0.07", 55000U, 0U, false, UNDECLARED, CURVE "96:, B.given 95:"},
    {"B 0.2", "N 1 B 0.2", 16384U, 0U, false, IS_WHITE, CURVE "95:, B.given 94:"},
    {"K 0.01", "N 1 K 0.01", 16384U, 0U, false, IS_WHITE, CURVE "92.5:, K.given 89:"},
    {"B 0.05, K 0.001", "N 1 B 0.05 K 0.001", 65536U, 0U, false, IS_WHITE, CURVE "92.5:"},
    {"R 1e-5", "N 1 R 1e-5", 16384U, 0U, false, IS_WHITE,
     "ADEV 94.3:, long 94.3:, N 95:, N.given 99.5:, withheld :0.5, others 96:"},
    {"Q 1", "Q 1 N 1", 8192U, 0U, false, IS_WHITE, CURVE "93.5:, Q.given 99.5:"},
    {"1 pole 0.05", "N 1 F 0.05", 16384U, 0U, false, ONE_POLE, CURVE "98:"},
    {"1 pole 0.05, undeclared", "N 1 F 0.05", 8192U, 0U, false, UNDECLARED, "withheld 99.5:"},
};

/* Of white noise at a part of the recording. */
typedef struct {
    const char *name;
    double (*level)(double at);
    const char *holds[2]; /* without and with flicker */
} level_t;

static const level_t same = {"", constant, {NULL, NULL}};
static const level_t levels[] = {
    {"x 1.5, ", louder, {LEVEL ":2.5", B_LEVEL}},
    {"x 0.3, ", quieter, {LEVEL ":3", B_LEVEL}},
    {"burst x 10, ", burst, {LEVEL ":6", B_LEVEL}}, /* a limit of (11.9) */
    {"swell, ", swell, {LEVEL ":3", B_LEVEL}},
};
static const curve_t changing[] = {
    {"white", "N 1", 27600U, 0U, false, IS_WHITE, NULL},
    {"B 0.2", "N 1 B 0.2", 27600U, 0U, false, IS_WHITE, NULL},
};

static void observe_curve(const curve_t *row, const level_t *level, const double white[],
                          const double rest[], random_t *random)
{
    davar_reset(&davar);
    davar_cascade_reset(&cascade);
    for (uint32_t i = 0U; i < row->samples; i++) {
        const double size = level->level((double)i / row->samples);
        const int32_t count = (int32_t)lround(CURVE_COUNTS * (rest[i] + (size * white[i])));
        if ((row->gap_every > 0U) && ((random_next(random) % row->gap_every) == 0U)) {
            davar_gap(&davar, 1U);
            davar_cascade_gap(&cascade, 1U);
        }
        davar_push_q31(&davar, &count, 1U);
        davar_cascade_push_q31(&cascade, &count, 1U);
    }
    require(davar_take(&davar, &result), "curve: no window");
    for (uint32_t t = 2U; (t < SHORT_TAUS) && row->short_window; t++) {
        result.tau[t].differences = 0U;
        result.tau[t].adev = (double)NAN;
    }
    require(davar_cascade_append(&cascade, &result), "curve: append");
}

/* Of white noise in the last window. */
static double level_of_window(const curve_t *row, const level_t *level)
{
    double sum = 0.0;
    for (uint32_t i = row->samples - WINDOW; i < row->samples; i++) {
        const double now = level->level((double)i / row->samples);
        sum += now * now;
    }
    return sqrt(sum / WINDOW);
}

static davar_plan_t curve_plan[PLANS];

static void start_curve(void)
{
    static const davar_cascade_config_t cascade_config = {.rate_hz = 1.0,
                                                          .unit_per_count = 1.0 / CURVE_COUNTS,
                                                          .shortest = 64U,
                                                          .tau_count = LONG_TAUS,
                                                          .clusters = 32U};
    const shape_t filter = {.cutoff = CUTOFF, .poles = 1U};
    davar_plan_init_white(&curve_plan[IS_WHITE], curve_taus, TAUS);
    davar_plan_init(&curve_plan[UNDECLARED], curve_taus, TAUS);
    plan_shape(&curve_plan[ONE_POLE], curve_taus, TAUS, &filter);
    configure(NULL, WINDOW, WINDOW, WINDOW);
    config.unit_per_count = 1.0 / CURVE_COUNTS;
    config.taus = curve_taus;
    config.tau_count = SHORT_TAUS;
    START(q31);
    require(davar_cascade_init_q31(&cascade, &cascade_config, cascade_memory,
                                   sizeof cascade_memory) == DAVAR_CASCADE_OK,
            "curve: init of the cascade");
}

/* Of each level one score, from the same noise. */
static void score_curves(const curve_t *row, const level_t *of, size_t count, score_t scores[],
                         random_t *random)
{
    static double white[SAMPLES_MAX];
    static double rest[SAMPLES_MAX];
    const bool changes = (of != &same);
    const gyro_noise_t noise = noise_of(row->noise);
    const gyro_noise_t only = {.white = noise.white};
    gyro_noise_t other = noise;
    if (changes) {
        other.white = 0.0;
        gyro_noise_fill(&only, random, white, row->samples);
    }
    gyro_noise_fill(&other, random, rest, row->samples);
    for (size_t l = 0U; l < count; l++) {
        const double now = level_of_window(row, &of[l]);
        double truth[DAVAR_COEFFICIENT_COUNT];
        double adev[TAUS];
        truth_of(&noise, truth);
        truth[DAVAR_ANGLE_RANDOM_WALK] *= now;
        for (uint32_t t = 0U; t < TAUS; t++) {
            const double size = (t < SHORT_TAUS) ? now : 1.0;
            adev[t] = sqrt(gyro_noise_avar(&noise, curve_taus[t])) * size;
        }
        observe_curve(row, &of[l], white, rest, random);
        davar_fit(&curve_plan[row->declared], 1.0, &result);
        score_add(&scores[l], &result, truth, changes ? NULL : adev);
    }
}

static void run_at(const curve_t *row, const level_t *of, size_t count, unsigned trials,
                   uint64_t seed)
{
    static score_t scores[COUNT_OF(levels)];
    random_t random = random_seeded(seed);
    start_curve();
    memset(scores, 0, sizeof scores);
    for (unsigned i = 0U; i < trials; i++) {
        score_curves(row, of, count, scores, &random);
    }
    for (size_t l = 0U; l < count; l++) {
        label("%s%s", of[l].name, row->name);
        score_report(&scores[l], 1.0,
                     (row->holds != NULL) ? row->holds : of[l].holds[row - changing]);
    }
}

static void run_curve(const void *row, unsigned trials, uint64_t seed)
{
    run_at(row, &same, 1U, trials, seed);
}

static void run_levels(const void *row, unsigned trials, uint64_t seed)
{
    run_at(row, levels, COUNT_OF(levels), trials, seed);
}

const experiment_t curve_experiment = {ROWS(curves), run_curve};
const experiment_t curve_levels_experiment = {ROWS(changing), run_levels};

/* ---- the time until B and K are resolved ---- */

#define RATE_HZ 100.0
#define LSB (250.0 / 32768.0) /* deg/s */
#define MINUTE 6000U          /* samples; a window, and from one result to the next */
#define SECOND 100U
#define FIRST_TAUS 7U
#define DAY_TAUS 17U /* up to a day */

/* Gauss-Markov processes of one variance, a factor of four apart in time, add up to flicker; from
 * 1 s to 186 days. Shorter ones are below the white noise. */
#define MARKOV_COUNT 13
#define MARKOV_FIRST_S 1.0

/* Data sheets give N and the in-run bias stability, not K. */
typedef struct {
    const char *name;
    const char *holds;
    double n;          /* deg/sqrt(h) */
    double b;          /* deg/h */
    double k;          /* deg/h/sqrt(h) */
    unsigned most_min; /* length of a recording */
} gyro_t;

static const gyro_t gyros[] = {
    {"ADIS16470", "half 5:8, nine 13:32, holds 94:", 0.34, 8.0, 0.0, 100U},
    {"ADIS16488A", "half 6:10, nine 20:50, holds 94:", 0.26, 5.1, 0.0, 100U},
    {"ADIS16505-1", "half 6:10, nine 20:50, holds 94:", 0.13, 2.3, 0.0, 100U},
    {"0.3 and 5", "half 8:13, nine 25:50, holds 94:", 0.3, 5.0, 0.0, 100U},
    {"ADIS16405", "half 13:20, nine 50:79, holds 94:", 2.0, 25.0, 0.0, 200U},
    {"ADIS16495-1", "half 25:40, nine 63:126, holds 94:", 0.09, 0.8, 0.0, 400U},
    {"any", "half 100:158, nine 398:720, holds 94:", 0.3, 5.0, 20.0, 800U},
    {"any", "holds 94:", 0.3, 5.0, 10.0, 2000U},
    {"any", "holds 94:", 0.3, 5.0, 5.0, 4000U},
    {"BMI088", "holds 94:", 0.84, 2.0, 0.0, 2600U},
    {"STIM300", "holds 94:", 0.15, 0.3, 0.0, 2600U},
};

typedef struct {
    random_t random;
    double markov[MARKOV_COUNT];
    double memory[MARKOV_COUNT]; /* of a second */
    double sigma;                /* of each process, in counts */
    double white;                /* of a sample */
    double step;                 /* of the walk in a second */
    double walk;
} rest_t;

static rest_t start_rest(const gyro_t *gyro, uint64_t seed)
{
    rest_t rest = {.random = random_seeded(seed),
                   .sigma = gyro->b / 3600.0 * sqrt(2.0 * log(2.0) / acos(-1.0)) / LSB,
                   .white = gyro->n / 60.0 * sqrt(RATE_HZ) / LSB,
                   .step = gyro->k / 3600.0 / 60.0 / LSB};
    for (int i = 0; i < MARKOV_COUNT; i++) {
        rest.memory[i] = exp(-1.0 / (MARKOV_FIRST_S * pow(4.0, i)));
        rest.markov[i] = rest.sigma * random_gauss(&rest.random);
    }
    return rest;
}

/* The slow terms keep their value for a second. The white noise is not quite Gaussian, which does
 * not affect B and K. */
static void fill_second(rest_t *rest, int16_t *counts)
{
    double slow = rest->walk;
    for (int i = 0; i < MARKOV_COUNT; i++) {
        const double new = sqrt(1.0 - rest->memory[i] * rest->memory[i]);
        rest->markov[i] =
            rest->memory[i] * rest->markov[i] + rest->sigma * new *random_bell(&rest->random);
        slow += rest->markov[i];
    }
    rest->walk += rest->step * random_gauss(&rest->random);
    for (uint32_t i = 0U; i < SECOND; i++) {
        const double above = slow + rest->white * random_bell(&rest->random) + 32768.5;
        counts[i] = (int16_t)((int32_t)above - 32768);
    }
}

/* Times at which the fit is tested: ten per decade, in minutes, up to three days. */
#define CHECKS 31U
static const unsigned check_min[CHECKS] = {4U,    5U,    6U,    8U,    10U,   13U,   16U,  20U,
                                           25U,   32U,   40U,   50U,   63U,   79U,   100U, 126U,
                                           158U,  200U,  251U,  316U,  398U,  501U,  631U, 794U,
                                           1000U, 1259U, 1585U, 1995U, 2512U, 3162U, 3981U};

/* Recordings that resolve the term, and whose statement is true, at each of these times. */
static double resolved[CHECKS];
static double true_in[CHECKS];

static void watch(const gyro_t *gyro, uint64_t seed)
{
    const davar_coefficient_kind_t kind =
        (gyro->k > 0.0) ? DAVAR_RATE_RANDOM_WALK : DAVAR_BIAS_INSTABILITY;
    const double truth = (gyro->k > 0.0) ? gyro->k : gyro->b;
    rest_t rest = start_rest(gyro, seed);
    int16_t counts[SECOND];
    unsigned minute = 0U;
    davar_reset(&davar);
    davar_cascade_reset(&cascade);
    for (unsigned i = 0U; (i < CHECKS) && (check_min[i] <= gyro->most_min); i++) {
        for (; minute < check_min[i]; minute++) {
            const bool in_window = (minute + 1U == check_min[i]); /* which has only this minute */
            for (uint32_t s = 0U; s < 60U; s++) {
                fill_second(&rest, counts);
                davar_push_q15(&davar, counts, in_window ? SECOND : 0U);
                davar_cascade_push_q15(&cascade, counts, SECOND);
            }
        }
        require(davar_take(&davar, &result) && davar_cascade_append(&cascade, &result),
                "resolved: no result");
        davar_fit(&plan, RATE_HZ, &result);
        const davar_coefficient_t *const found = &result.coefficient[kind];
        const bool holds = (truth <= found->high) && (!found->present || (truth >= found->low));
        resolved[i] += found->present ? 1.0 : 0.0;
        true_in[i] += holds ? 1.0 : 0.0;
    }
}

/* The first time at which so many recordings resolve the term, in minutes. */
static double time_of(double recordings)
{
    for (unsigned i = 0U; i < CHECKS; i++) {
        if (resolved[i] >= recordings) {
            return check_min[i];
        }
    }
    return (double)INFINITY;
}

static void run_resolved(const void *of, unsigned trials, uint64_t seed)
{
    static const davar_cascade_config_t long_config = {.rate_hz = RATE_HZ,
                                                       .unit_per_count = LSB,
                                                       .shortest = 128U,
                                                       .tau_count = DAY_TAUS,
                                                       .clusters = 32U};
    static uint32_t sizes[FIRST_TAUS + DAY_TAUS];
    static davar_plan_t fresh;
    const gyro_t *const gyro = of;
    memset(resolved, 0, sizeof resolved);
    memset(true_in, 0, sizeof true_in);
    for (uint32_t t = 0U; t < COUNT_OF(sizes); t++) {
        sizes[t] = 1U << t;
    }
    configure(NULL, MINUTE, MINUTE, MINUTE);
    config.rate_hz = RATE_HZ;
    config.unit_per_count = LSB;
    config.taus = sizes;
    config.tau_count = FIRST_TAUS;
    davar_plan_init_white(&fresh, sizes, COUNT_OF(sizes));
    START(q15);
    require(davar_cascade_init_q15(&cascade, &long_config, cascade_memory, sizeof cascade_memory) ==
                DAVAR_CASCADE_OK,
            "resolved: init of the cascade");
    for (unsigned n = 0U; n < trials; n++) {
        plan = fresh;
        watch(gyro, seed + n);
    }
    const unsigned half = trials / 2U;
    const unsigned nine = (trials * 9U) / 10U;
    value("half", time_of(half), 0.0);
    value("nine", time_of(nine), 0.0);
    for (unsigned i = 0U; (i < CHECKS) && (check_min[i] <= gyro->most_min); i++) {
        share("holds", true_in[i], trials);
    }
    label("%s, N %.2g, B %.2g, K %.2g", gyro->name, gyro->n, gyro->b, gyro->k);
    report(gyro->holds);
}

const experiment_t resolved_experiment = {ROWS(gyros), run_resolved};
