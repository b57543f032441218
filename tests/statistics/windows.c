/* Independent windows through the fit: white noise and mixtures (5.12), after filters (5.16, 5.17),
 * in coarse counts (5.15) and near the ends of a record. */
#include "autocovariance.h"
#include "davar/average.h"
#include "davar/fit.h"
#include "filter_cases.h"
#include "filtered_noise.h"
#include "low_pass.h"
#include "statistics.h"

#include <string.h>

static double samples[LONGEST];

/* ---- white noise and mixtures ---- */

typedef struct {
    const char *noise;
    uint32_t window;
    uint32_t last;  /* octaves from 1 to this */
    unsigned steps; /* instead of octaves: geometric steps to `last` */
    const char *holds;
} coverage_t;

#define HOLDS_WHITE "ADEV 94.4:96.5, N 95:97, others 99.6:, extra :2.1, "
#define HOLDS "ADEV 94.4:97, N 94.4:97, "

/* Of cluster sizes above a ninth of the window, intervals may be too wide. Around the threshold of
 * a term, windows mistake one drift for another. White noise far below the rest is hardly resolved,
 * and its statement is then true more often. A ramp scatters less than noise. */
static const coverage_t coverage[] = {
    {"N 1", 50U, 4U, 0U, "ADEV 94.4:96.5, N 95:97.5, others 99.6:, extra :2, bias :4.5"},
    {"N 1", 200U, 16U, 0U, HOLDS_WHITE "bias -1:1.5"},
    {"N 1", 400U, 32U, 0U, HOLDS_WHITE "bias -0.7:0.7"},
    {"N 1", 600U, 64U, 0U, HOLDS_WHITE "bias -0.5:0.5, width 1.15:1.172"},
    {"N 1", 5000U, 512U, 0U, HOLDS_WHITE "bias -0.2:0.2, width 1.04:1.06"},
    {"N 1", 600U, 128U, 0U, HOLDS_WHITE "long 94.4:98, bias -0.5:0.5"},
    {"N 1", 600U, 66U, 31U, HOLDS_WHITE "bias -0.5:0.5"},
    {"N 1", 600U, 66U, 11U, HOLDS_WHITE "bias -0.5:0.5"},
    {"N 1 K 0.005", 600U, 64U, 0U, HOLDS "others 99:, bias -0.5:0.5"},
    {"N 1 K 0.02", 600U, 64U, 0U, HOLDS "others 97:, bias -0.5:1"},
    {"N 1 K 0.05", 600U, 64U, 0U, HOLDS "others 87:, bias -0.5:1.5"},
    {"N 1 K 0.1", 600U, 64U, 0U, HOLDS "others 97:, bias -1:1.5"},
    {"N 1 K 0.3", 600U, 64U, 0U, HOLDS "others 97:, bias -2:2"},
    {"N 1 B 0.05", 600U, 64U, 0U, HOLDS "others 99:, bias -0.5:1"},
    {"N 1 B 0.1", 600U, 64U, 0U, HOLDS "others 98:, bias -0.5:1"},
    {"N 1 B 0.2", 600U, 64U, 0U, HOLDS "others 93.5:, bias -0.5:2"},
    {"N 1 B 0.3", 600U, 64U, 0U, HOLDS "others 88.5:, bias -0.5:2"},
    {"N 1 B 0.5", 600U, 64U, 0U, HOLDS "others 95.5:, bias -1:2"},
    {"N 1 B 1", 600U, 64U, 0U, HOLDS "others 97:, bias -2:2"},
    {"Q 0.1 N 1", 600U, 64U, 0U, HOLDS "others 99.4:, bias -1:1"},
    {"Q 0.2 N 1", 600U, 64U, 0U, HOLDS "others 98:, bias 2:5"},
    {"Q 0.3 N 1", 600U, 64U, 0U, HOLDS "others 91:, bias 5:8"},
    {"Q 0.5 N 1", 600U, 64U, 0U, HOLDS "others 91.5:, bias -1:2"},
    {"Q 1 N 1", 600U, 64U, 0U, "ADEV 94.4:97.5, N 95:98, others 93:, bias -1:2"},
    {"N 1 K 0.02", 5000U, 512U, 0U, "ADEV 94.4:97.5, N 95:97, others 97.5:, bias -0.3:0.3"},
    {"N 1 B 0.1 K 0.01", 5000U, 512U, 0U, HOLDS "others 95.5:, bias -0.3:0.5"},
    {"N 1 K 1", 600U, 64U, 0U, "ADEV 94.4:97.5, N 95:, others 97:"},
    {"K 1", 600U, 64U, 0U, "ADEV 94.4:97, N 99.5:, others 96:, N.given :1.5"},
    {"N 1 R 0.003", 600U, 64U, 0U, "ADEV 94.4:, N 95:97, others 95.5:, bias -0.5:1"},
};

static uint8_t sizes_of(const coverage_t *row, uint32_t m[])
{
    const double steps = (row->steps > 0U) ? row->steps : log2(row->last);
    uint8_t count = 0U;
    for (int i = 0; i <= (int)steps; i++) {
        const uint32_t next = (uint32_t)lround(pow(row->last, i / steps));
        if ((count == 0U) || (next > m[count - 1U])) {
            m[count++] = next;
        }
    }
    return count;
}

static void run_coverage(const void *of, unsigned trials, uint64_t seed)
{
    static score_t score;
    const coverage_t *const row = of;
    const gyro_noise_t noise = noise_of(row->noise);
    uint32_t m[DAVAR_TAUS_MAX] = {0U};
    double truth[DAVAR_COEFFICIENT_COUNT];
    double adev[DAVAR_TAUS_MAX];
    random_t random = random_seeded(seed);
    score = (score_t){0};
    expect_window(row->window, m, sizes_of(row, m));
    davar_plan_init_white(&plan, m, result.tau_count);
    truth_of(&noise, truth);
    for (int t = 0; t < result.tau_count; t++) {
        adev[t] = sqrt(gyro_noise_avar(&noise, m[t]));
    }
    for (unsigned i = 0U; i < trials; i++) {
        gyro_noise_fill(&noise, &random, samples, row->window);
        observe(samples, row->window);
        davar_fit(&plan, 1.0, &result);
        score_add(&score, &result, truth, adev);
    }
    label("%s, L %u, %u taus to %u", row->noise, (unsigned)row->window, result.tau_count,
          (unsigned)row->last);
    score_report(&score, 1.0, row->holds);
}

const experiment_t coverage_experiment = {ROWS(coverage), run_coverage};

/* ---- after a filter ---- */

/* One window is rounded, drifts and is fitted in several ways. */
typedef enum { DECLARED, NARROW, UNDECLARED, WHITE, TOO_HIGH, TOO_LOW } knowledge_t;

typedef struct {
    const char *name;
    const char *holds;
    knowledge_t knowledge;
    double sigma; /* counts */
    int drift;    /* place in drifts[] */
} view_t;

/* Drifts at 8 times the sample rate, made once: they pass the low-pass of each case. */
#define FASTER 8U
#define DRIFT_WINDOW 600U
#define SETTLING 60U
#define DRIFT_LENGTH ((size_t)FASTER * (DRIFT_WINDOW + SETTLING))
#define DRIFTS 500U

static const struct {
    int kind; /* of passed[] */
    double size;
} drifts[] = {{0, 0.0}, {0, 0.1}, {0, 0.3}, {1, 0.02}, {1, 0.05}, {2, 0.001}, {2, 0.003}};

#define UNKNOWN "N.within? 93:"
#define KNOWN "N.given 99.2:, N.within 94.5:98.5, rms :1.25, bias -0.5:1"

/* Rounding errors repeat after a narrow filter, and the doubt widens the interval (5.15). */
#define REPEATED "N.given 99.2:, N.within 94.5:, rms :1.25, bias -0.5:1"

static const view_t views[] = {
    {"declared", KNOWN, DECLARED, 30.0, 0},
    {"declared, sigma 3", KNOWN, DECLARED, 3.0, 0},
    {"declared, narrow, sigma 3", REPEATED, NARROW, 3.0, 0},
    {"not declared", UNKNOWN, UNDECLARED, 30.0, 0},
    {"10 % too high", "N.within 93.5:", TOO_HIGH, 30.0, 0},
    {"10 % too low", "N.within 93.5:", TOO_LOW, 30.0, 0},
    {"white", "N.given 99.2:, N.within 94.5:98", WHITE, 30.0, 0},
    {"sigma 1", "N.within 94.5:, bias -2:2", DECLARED, 1.0, 0},
    {"sigma 0.5", "N.within 94.5:, bias -2:2", DECLARED, 0.5, 0},
    {"B 0.1", "N.within 94.5:, N 94.5:", DECLARED, 30.0, 1},
    {"B 0.3", "N.within 91:, N 91:", DECLARED, 30.0, 2},
    {"K 0.02", "N.within 94.5:, N 94.5:", DECLARED, 30.0, 3},
    {"K 0.05", "N.within 94.5:, N 94.5:", DECLARED, 30.0, 4},
    {"R 0.001", "N.within 94.5:, N 94.5:", DECLARED, 30.0, 5},
    {"R 0.003", "N.within 94.5:, N 94.5:", DECLARED, 30.0, 6},
    {"not declared, B 0.1", UNKNOWN, UNDECLARED, 30.0, 1},
    {"not declared, B 0.3", UNKNOWN, UNDECLARED, 30.0, 2},
    {"not declared, K 0.02", UNKNOWN, UNDECLARED, 30.0, 3},
    {"not declared, K 0.05", UNKNOWN, UNDECLARED, 30.0, 4},
    {"not declared, R 0.001", UNKNOWN, UNDECLARED, 30.0, 5},
    {"not declared, R 0.003", UNKNOWN, UNDECLARED, 30.0, 6},
};
#define VIEWS COUNT_OF(views)

static autocovariance_t of_noise;
static filtered_noise_t source;
static double passed[3][LONGEST];

/* Without a low-pass, a sample is the mean over its time. Moving averages are left out: they would
 * lower short sizes further. */
static void pass_drifts(const shape_t *filter, uint32_t trial)
{
    static float drift[3][DRIFTS][DRIFT_LENGTH]; /* B = 1, K = 1, R = 1 */
    static bool is_made;
    static const gyro_noise_t noise[] = {
        {.flicker = 1.0}, {.walk = 0.35355339059327373}, {.ramp = 1.0 / (double)FASTER}};
    random_t random = random_seeded(952U);
    for (size_t k = 0U; !is_made && (k < 3U); k++) {
        static double rate[DRIFT_LENGTH];
        for (uint32_t i = 0U; i < DRIFTS; i++) {
            gyro_noise_fill(&noise[k], &random, rate, DRIFT_LENGTH);
            for (uint32_t n = 0U; n < DRIFT_LENGTH; n++) {
                drift[k][i][n] = (float)rate[n];
            }
        }
    }
    is_made = true;
    for (size_t k = 0U; k < 3U; k++) {
        low_pass_t low_pass = low_pass_of(filter, (double)FASTER);
        const float *const rate = drift[k][trial % DRIFTS];
        double mean = 0.0;
        low_pass.state[0] = (double)rate[0];
        for (uint32_t n = 0U; n < DRIFT_LENGTH; n++) {
            const uint32_t at = n / FASTER;
            const double now = low_pass_advance(&low_pass, (double)rate[n], 0.0, 0.0);
            mean += now / (double)FASTER;
            if (n % FASTER == FASTER - 1U) {
                if (at >= SETTLING) {
                    passed[k][at - SETTLING] = (filter->poles > 0U) ? now : mean;
                }
                mean = 0.0;
            }
        }
    }
}

/* Root of the Cramer-Rao bound of ln N in percent, with rounding as white noise. */
static double bound(uint32_t window, double count)
{
    double sum = 0.0;
    for (int i = 0; i < 256; i++) {
        double s = of_noise.r[0];
        for (int k = 1; k < of_noise.count; k++) {
            s += 2.0 * of_noise.r[k] * cos(AUTOCOVARIANCE_PI * k * (i + 0.5) / 256.0);
        }
        sum += pow(s / (s + (count * count / 12.0)), 2.0) / 256.0;
    }
    return 100.0 / sqrt(2.0 * window * sum);
}

static bool applies(const view_t *view, const shape_t *filter, uint32_t window, bool is_declared)
{
    const bool is_white = (filter->poles + filter->averages) == 0U;
    const bool is_narrow = (filter->poles == 2U) && (filter->cutoff < 0.06);
    if (!is_declared && (view->knowledge != UNDECLARED)) {
        return false;
    }
    if ((view->sigma < 30.0) && ((view->knowledge == NARROW) != is_narrow)) {
        return false;
    }
    if (view->drift > 0) {
        return (window == DRIFT_WINDOW) && ((view->knowledge == UNDECLARED) || is_narrow);
    }
    if ((view->knowledge == WHITE) || (view->sigma < 2.0)) {
        return is_white;
    }
    if ((view->knowledge == TOO_HIGH) || (view->knowledge == TOO_LOW)) {
        return (filter->poles > 0U) && (window > 300U);
    }
    return true;
}

static void init_plan(davar_plan_t *one, knowledge_t knowledge, const shape_t *filter,
                      const uint32_t m[], uint8_t count)
{
    shape_t declared = *filter;
    if (knowledge == UNDECLARED) {
        davar_plan_init(one, m, count);
    } else if (knowledge == WHITE) {
        davar_plan_init_white(one, m, count);
    } else {
        declared.uncertainty = ((knowledge == TOO_HIGH) || (knowledge == TOO_LOW)) ? 0.1 : 0.0;
        declared.cutoff *= (knowledge == TOO_HIGH) ? 1.1 : ((knowledge == TOO_LOW) ? 0.9 : 1.0);
        plan_shape(one, m, count, &declared);
    }
}

static void run_filtered(const case_t *row, uint32_t window, bool is_declared, unsigned trials,
                         uint64_t seed)
{
    static score_t scores[VIEWS];
    static davar_plan_t plans[VIEWS];
    static double noise[LONGEST];
    bool used[VIEWS];
    uint32_t m[DAVAR_TAUS_MAX];
    filtered_noise_start(&source, &row->filter, seed);
    expect_window(window, m, davar_taus_octave(window, m, DAVAR_TAUS_MAX));
    autocovariance_of(&row->filter, &of_noise);
    for (size_t v = 0U; v < VIEWS; v++) {
        used[v] = applies(&views[v], &row->filter, window, is_declared);
        scores[v] = (score_t){0};
        init_plan(&plans[v], views[v].knowledge, &row->filter, m, result.tau_count);
    }
    for (unsigned i = 0U; i < trials; i++) {
        const double mean = 100.0 * random_uniform(&source.random);
        for (uint32_t n = 0U; n < window; n++) { /* of N = 1 */
            noise[n] = sqrt(of_noise.r[0]) * filtered_noise_next(&source, 1.0);
        }
        if (window == DRIFT_WINDOW) {
            pass_drifts(&row->filter, i);
        }
        for (size_t v = 0U; v < VIEWS; v++) {
            const view_t *const view = &views[v];
            const double count = sqrt(of_noise.r[0]) / view->sigma;
            const double size = drifts[view->drift].size;
            if (!used[v]) {
                continue;
            }
            for (uint32_t n = 0U; n < window; n++) {
                const double drift =
                    (size > 0.0) ? size * passed[drifts[view->drift].kind][n] : 0.0;
                samples[n] = count * round(((noise[n] + drift) / count) + mean);
            }
            observe(samples, window);
            result.unit_per_count = count;
            davar_fit(&plans[v], 1.0, &result);
            score_add(&scores[v], &result, truth_1, NULL);
        }
    }
    for (size_t v = 0U; v < VIEWS; v++) {
        if (used[v]) {
            label("%s, L %u, %s", row->name, (unsigned)window, views[v].name);
            score_report(&scores[v], bound(window, sqrt(of_noise.r[0]) / views[v].sigma),
                         views[v].holds);
        }
    }
}

/* Hard to notice. */
static const case_t wide[] = {
    {"1 pole 0.4", {.cutoff = 0.4, .poles = 1U}},
    {"2 poles 0.4", {.cutoff = 0.4, .poles = 2U}},
};

static void run_three(const case_t *row, bool is_declared, unsigned trials, uint64_t seed)
{
    run_filtered(row, 300U, is_declared, trials, seed);
    run_filtered(row, 600U, is_declared, trials, seed);
    run_filtered(row, 2000U, is_declared, trials, seed);
}

static void run_declared(const void *row, unsigned trials, uint64_t seed)
{
    run_three(row, true, trials, seed);
}

static void run_undeclared(const void *row, unsigned trials, uint64_t seed)
{
    run_three(row, false, trials, seed);
}

const experiment_t filtered_experiment = {ROWS(cases), run_declared};
const experiment_t filtered_undeclared_experiment = {ROWS(wide), run_undeclared};
