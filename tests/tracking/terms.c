/* davar tests - how well each window law tracks angle random walk, bias instability and rate random
 * walk together: three thirds of 60 000 samples, the noise of the middle one RATIO times as
 * large. docs/TRACKING.md has the table, and what is assumed of the signals of PID-DAVAR.
 *
 *   davar-track-terms [RECORDS [SEED]]     RECORDS of each signal (default 20)
 *   davar-track-terms check                status 1 if too few 95 % intervals contain the truth */
#include "davar/davar.h"
#include "davar/fit.h"
#include "gyro_noise.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RATE_HZ 100.0
#define THIRD 60000U
#define SAMPLES 180000U
#define STRIDE 100U
#define TERMS 3U

/* White noise and flicker are equal at 8 samples, flicker and walk at 128: in a window of 6000
 * samples each term prevails at two or more cluster sizes. */
#define WHITE 20.0
#define FLICKER 10.64
#define WALK 1.083

static const davar_coefficient_kind_t kinds[TERMS] = {
    DAVAR_ANGLE_RANDOM_WALK, DAVAR_BIAS_INSTABILITY, DAVAR_RATE_RANDOM_WALK};
static const char *const terms[TERMS] = {"ARW", "BI", "RRW"};

typedef struct {
    const char *name;
    double ratio[TERMS]; /* of white noise, flicker and walk in the middle stretch */
} signal_t;

static const signal_t signals[] = {
    {"unchanged", {1.0, 1.0, 1.0}}, {"ARW x2", {2.0, 1.0, 1.0}},       {"BI x2", {1.0, 2.0, 1.0}},
    {"RRW x2", {1.0, 1.0, 2.0}},    {"all three x2", {2.0, 2.0, 2.0}},
};
#define SIGNALS (sizeof signals / sizeof signals[0])

typedef struct {
    const char *name;
    const davar_law_t *law;
    uint32_t longest;
    uint32_t shortest;
    uint32_t stride;
} law_t;

static const law_t laws[] = {
    {"A-DAVAR 600", &davar_law_or, 600U, 400U, STRIDE},
    {"A-DAVAR 6000", &davar_law_or, 6000U, 4000U, STRIDE},
    {"fixed 6000", NULL, 6000U, 6000U, STRIDE},
    {"glr 6000", &davar_law_glr_q31, 6000U, 20U, STRIDE},
    {"one per third", NULL, THIRD, THIRD, THIRD},
};
#define LAWS (sizeof laws / sizeof laws[0])
static const law_t separate = {"windows without overlap", NULL, 6000U, 6000U, 6000U};

/* --- signals --- */

/* A stronger flicker is a second one, which begins at 0 and stays where it ends: the level never
 * jumps. */
static void fill(const signal_t *signal, random_t *random, int32_t samples[SAMPLES])
{
    static double sum[SAMPLES];
    static double part[THIRD];
    const double more = sqrt((signal->ratio[1] * signal->ratio[1]) - 1.0);
    double level = 0.0;
    gyro_noise_fill(&(gyro_noise_t){.flicker = FLICKER}, random, sum, SAMPLES);
    for (size_t s = 0U; s < 3U; s++) {
        const bool middle = s == 1U;
        const gyro_noise_t noise = {.white = WHITE * (middle ? signal->ratio[0] : 1.0)};
        const gyro_noise_t slow = {.flicker = middle ? (FLICKER * more) : 0.0,
                                   .walk = WALK * (middle ? signal->ratio[2] : 1.0)};
        double *const here = &sum[s * THIRD];
        gyro_noise_fill(&noise, random, part, THIRD);
        for (size_t i = 0U; i < THIRD; i++) {
            here[i] += part[i];
        }
        gyro_noise_fill(&slow, random, part, THIRD);
        level -= part[0];
        for (size_t i = 0U; i < THIRD; i++) {
            here[i] += part[i] + level;
        }
        level += part[THIRD - 1U];
    }
    for (size_t i = 0U; i < SAMPLES; i++) {
        samples[i] = (int32_t)lround(sum[i]);
    }
}

/* In the units of the coefficients: counts are deg/s. */
static double truth_at(const signal_t *signal, size_t term, uint64_t epoch)
{
    const double unit[TERMS] = {60.0 * WHITE / sqrt(RATE_HZ), 3600.0 * FLICKER,
                                216000.0 * WALK * sqrt(RATE_HZ)};
    return unit[term] * (((epoch / THIRD) == 1U) ? signal->ratio[term] : 1.0);
}

/* --- results --- */

typedef struct {
    double results;
    double present;
    double error; /* sum of |value / truth - 1| of the present ones */
    double whole; /* present, and the window lies in one third */
    double held;  /* of these: the interval contains the truth */
} score_t;

static void judge(score_t scores[TERMS], const signal_t *signal, const davar_result_t *result)
{
    for (size_t t = 0U; t < TERMS; t++) {
        const davar_coefficient_t *const found = &result->coefficient[kinds[t]];
        const double truth = truth_at(signal, t, result->epoch);
        score_t *const score = &scores[t];
        score->results += 1.0;
        if (found->present) {
            const bool whole = ((result->epoch % THIRD) + 1U) >= result->window_samples;
            const bool held = (found->low <= truth) && (truth <= found->high);
            score->present += 1.0;
            score->error += fabs((found->value / truth) - 1.0);
            score->whole += whole ? 1.0 : 0.0;
            score->held += (whole && held) ? 1.0 : 0.0;
        }
    }
}

static davar_t davar;
static davar_plan_t plan;

static void start(const law_t *law)
{
    static davar_config_t config;
    static uint32_t taus[DAVAR_TAUS_MAX];
    static uint64_t memory[131072];
    config = davar_default_config;
    config.rate_hz = RATE_HZ;
    config.unit_per_count = 1.0;
    config.law = law->law;
    config.stride = law->stride;
    config.window.mode = DAVAR_MODE_TRAILING;
    config.window.longest = law->longest;
    config.window.shortest = law->shortest;
    config.window.grow = 1U;
    config.moments.segment = (law->law == &davar_law_or) ? (law->shortest / 4U) : 0U;
    config.taus = taus;
    config.tau_count = davar_taus_octave(law->longest, taus, DAVAR_TAUS_MAX);
    davar_plan_init_white(&plan, taus, config.tau_count);
    if (davar_init_q31(&davar, &config, memory, sizeof memory) != DAVAR_OK) {
        fprintf(stderr, "davar-track-terms: %s: rejected by init\n", law->name);
        exit(1);
    }
}

/* Counts each result in both arrays. */
static void run(const signal_t *signal, const law_t *law, const int32_t samples[SAMPLES],
                score_t scores[TERMS], score_t pooled[TERMS])
{
    static davar_result_t result;
    start(law);
    for (size_t i = 0U; i < SAMPLES; i += STRIDE) {
        davar_push_q31(&davar, &samples[i], STRIDE);
        if (davar_take(&davar, &result) && (result.window_samples >= law->shortest)) {
            davar_fit(&plan, RATE_HZ, &result);
            judge(scores, signal, &result);
            judge(pooled, signal, &result);
        }
    }
}

/* --- tables --- */

typedef score_t table_t[SIGNALS + 1U][LAWS][TERMS]; /* the last row: all signals */

static void measure(table_t table, uint32_t records, uint64_t seed)
{
    static int32_t samples[SAMPLES];
    for (size_t s = 0U; s < SIGNALS; s++) {
        random_t random = random_seeded(seed + s);
        for (uint32_t r = 0U; r < records; r++) {
            fill(&signals[s], &random, samples);
            for (size_t l = 0U; l < LAWS; l++) {
                run(&signals[s], &laws[l], samples, table[s][l], table[SIGNALS][l]);
            }
        }
    }
}

/* Mean error and, in parentheses, the share of results with a value. Last row: the intervals. */
static void print_term(table_t table, size_t term)
{
    printf("\n| %s, %% |", terms[term]);
    for (size_t l = 0U; l < LAWS; l++) {
        printf(" %s |", laws[l].name);
    }
    printf("\n|---|---|---|---|---|---|\n");
    for (size_t s = 0U; s <= SIGNALS; s++) {
        printf("| %s |", (s < SIGNALS) ? signals[s].name : "all signals");
        for (size_t l = 0U; l < LAWS; l++) {
            const score_t *const score = &table[s][l][term];
            printf(" %.1f (%.0f %%) |", 100.0 * score->error / score->present,
                   100.0 * score->present / score->results);
        }
        printf("\n");
    }
    printf("| intervals that contain the truth |");
    for (size_t l = 0U; l < LAWS; l++) {
        const score_t *const score = &table[SIGNALS][l][term];
        printf(" %.1f %% |", 100.0 * score->held / score->whole);
    }
    printf("\n");
}

/* Three standard errors of a share of 95 % in windows that share no sample. */
static int check(void)
{
    static int32_t samples[SAMPLES];
    static score_t one[TERMS];
    static score_t scores[TERMS];
    int status = 0;
    for (size_t s = 0U; s < SIGNALS; s++) {
        random_t random = random_seeded(100U + s);
        fill(&signals[s], &random, samples);
        run(&signals[s], &separate, samples, one, scores);
    }
    for (size_t t = 0U; t < TERMS; t++) {
        const double n = scores[t].whole;
        const double least = (0.95 * n) - (3.0 * sqrt(0.95 * 0.05 * n));
        printf("%s: %.0f windows, %.0f with a value, %.0f intervals contain the truth (at least "
               "%.1f)\n",
               terms[t], scores[t].results, n, scores[t].held, least);
        status = ((n < (0.5 * scores[t].results)) || (scores[t].held < least)) ? 1 : status;
    }
    return status;
}

int main(int argc, char **argv)
{
    static table_t table;
    if ((argc > 1) && (strcmp(argv[1], "check") == 0)) {
        return check();
    }
    const uint32_t records = (argc > 1) ? (uint32_t)strtoul(argv[1], NULL, 10) : 20U;
    measure(table, records, (argc > 2) ? strtoull(argv[2], NULL, 10) : 1U);
    for (size_t t = 0U; t < TERMS; t++) {
        print_term(table, t);
    }
    return 0;
}
