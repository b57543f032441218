/* davar-statistics - how often intervals contain the true value, how often alarms are false and how
 * late they come: Monte Carlo with fixed seeds, also for the tables of the documents.
 *
 *   davar-statistics NAME                          as a test: status 1 if a limit is missed
 *   davar-statistics table NAME [TRIALS [SEED]]    with the trials of the documents; also of all
 *                                                  experiments called NAME_...
 *
 * Without arguments it lists the names. */
#include "davar/fit.h"
#include "statistics.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

typedef struct {
    const char *name;
    const experiment_t *experiment;
    uint64_t seed;
    unsigned trials;
    double bad;
    unsigned table_trials;
    size_t long_rows;
} row_t;

static const row_t experiments[] = {
#define EXPERIMENT(name, gear, ...) {#name, &name##_experiment, __VA_ARGS__},
#include "experiments.inc"
};

typedef enum { SHARE, RATE, VALUE } figure_kind_t;

typedef struct {
    const char *name;
    figure_kind_t kind;
    double number;
    double trials; /* of a value: its standard error */
} figure_t;

static figure_t figures[96];
static size_t figure_count;
static unsigned missed;

/* Trials after which a share of `bad` percent is told from one of `good`, with STANDARD_ERRORS on
 * either side of the limit between them. */
static unsigned trials_of(double good, double bad)
{
    const double scatter = sqrt(good * (100.0 - good)) + sqrt(bad * (100.0 - bad));
    return (unsigned)ceil(pow(STANDARD_ERRORS * scatter / (good - bad), 2.0));
}

void require(bool is_met, const char *what)
{
    if (!is_met) {
        fprintf(stderr, "davar-statistics: %s\n", what);
        exit(1);
    }
}

static void add(const char *name, figure_kind_t kind, double number, double trials)
{
    require(figure_count < COUNT_OF(figures), "too many figures in one report");
    figures[figure_count] = (figure_t){name, kind, number, trials};
    figure_count++;
}

void share(const char *name, double hits, double trials)
{
    add(name, SHARE, 100.0 * hits / trials, trials);
}

void rate(const char *name, double events, double stated)
{
    add(name, RATE, events / stated, stated);
}

void value(const char *name, double number, double error)
{
    add(name, VALUE, number, error);
}

static double slack(const figure_t *figure, double limit)
{
    if (!isfinite(limit)) {
        return 0.0;
    }
    switch (figure->kind) {
    case SHARE:
        return STANDARD_ERRORS * sqrt(limit * (100.0 - limit) / figure->trials);
    case RATE:
        return STANDARD_ERRORS * sqrt(limit / figure->trials);
    case VALUE:
    default:
        return STANDARD_ERRORS * figure->trials;
    }
}

static char title[96];

void label(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(title, sizeof title, format, arguments);
    va_end(arguments);
}

/* One limit, such as "N 94:97". */
static void judge(const char *limit)
{
    char name[16];
    char range[32];
    unsigned found = 0U;
    require(sscanf(limit, " %15[^ ] %31[^,]", name, range) == 2, limit);
    char *const colon = strchr(range, ':');
    require(colon != NULL, limit);
    const bool may_lack = name[strlen(name) - 1U] == '?';
    name[strlen(name) - (may_lack ? 1U : 0U)] = '\0';
    const double low = (colon == range) ? -(double)INFINITY : strtod(range, NULL);
    const double high = (colon[1] == '\0') ? (double)INFINITY : strtod(colon + 1, NULL);
    for (size_t i = 0U; i < figure_count; i++) {
        const figure_t *const one = &figures[i];
        if (strcmp(one->name, name) != 0) {
            continue;
        }
        found++;
        const bool good =
            (one->number >= (low - slack(one, low))) && (one->number <= (high + slack(one, high)));
        if (!good && !(may_lack && (one->trials < 30.0))) {
            missed++;
            fprintf(stderr, "%s: %s is %.4g, expected %s\n", title, name, one->number, range);
        }
    }
    require((found > 0U) || may_lack, limit);
}

void report(const char *holds)
{
    const char *before = "";
    printf("| %s |", title);
    for (size_t i = 0U; i < figure_count; i++) {
        if (strcmp(before, figures[i].name) != 0) {
            before = figures[i].name;
            printf(" %s", before);
        }
        printf(" %.4g", figures[i].number);
    }
    printf(" |\n");
    (void)fflush(stdout);
    for (const char *at = holds; (at != NULL) && (*at != '\0');) {
        const char *const comma = strchr(at, ',');
        judge(at);
        at = (comma == NULL) ? NULL : (comma + 1);
    }
    figure_count = 0U;
}

/* ---- the score of windows ---- */

bool contains(double low, double high, double truth)
{
    return !(truth < low) && (truth <= high); /* low: NaN if the term is absent */
}

int ascending(const void *a, const void *b)
{
    const double difference = *(const double *)a - *(const double *)b;
    return (difference > 0.0) - (difference < 0.0);
}

void truth_of(const gyro_noise_t *noise, double truth[])
{
    truth[DAVAR_QUANTIZATION] = noise->quantization;
    truth[DAVAR_ANGLE_RANDOM_WALK] = 60.0 * noise->white;
    truth[DAVAR_BIAS_INSTABILITY] = 3600.0 * noise->flicker;
    truth[DAVAR_RATE_RANDOM_WALK] = 216000.0 * noise->walk;
    truth[DAVAR_RATE_RAMP] = 12960000.0 * noise->ramp;
}

gyro_noise_t noise_of(const char *text)
{
    gyro_noise_t noise = {.white = 0.0};
    double *const terms[] = {&noise.quantization, &noise.white, &noise.flicker,
                             &noise.walk,         &noise.ramp,  &noise.low_pass};
    for (size_t i = 0U; i < COUNT_OF(terms); i++) {
        const char *const at = strchr(text, "QNBKRF"[i]);
        *terms[i] = (at == NULL) ? 0.0 : strtod(at + 1, NULL);
    }
    noise.low_pass = 1.0 - exp(-2.0 * acos(-1.0) * noise.low_pass);
    return noise;
}

const double truth_1[DAVAR_COEFFICIENT_COUNT] = {[DAVAR_ANGLE_RANDOM_WALK] = 60.0};

void observe(const double samples[], uint32_t window)
{
    static double phase[LONGEST + 1U];
    double mean = 0.0;
    for (uint32_t i = 0U; i < window; i++) {
        mean += samples[i] / window;
    }
    phase[0] = 0.0;
    for (uint32_t i = 0U; i < window; i++) {
        phase[i + 1U] = phase[i] + samples[i] - mean;
    }
    for (int t = 0; t < result.tau_count; t++) {
        const uint32_t m = result.tau[t].m;
        double sum = 0.0;
        for (uint32_t i = 0U; i + (2U * m) <= window; i++) {
            const double d = phase[i + (2U * m)] - (2.0 * phase[i + m]) + phase[i];
            sum += d * d;
        }
        result.tau[t].adev = sqrt(sum / (2.0 * m * m * result.tau[t].differences));
    }
}

void expect_window(uint32_t window, const uint32_t m[], uint8_t count)
{
    result = (davar_result_t){.window_samples = window, .tau_count = count};
    for (uint8_t t = 0U; t < count; t++) {
        result.tau[t].m = m[t];
        result.tau[t].differences = window + 1U - (2U * m[t]);
    }
}

void score_add(score_t *score, const davar_result_t *found, const double truth[],
               const double adev[])
{
    const davar_coefficient_t *const arw = &found->coefficient[DAVAR_ANGLE_RANDOM_WALK];
    bool extra = false;
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        const davar_coefficient_t *const c = &found->coefficient[k];
        const bool holds = (!c->present || (truth[k] >= c->low)) && (truth[k] <= c->high);
        score->held[k] += holds ? 1.0 : 0.0;
        score->given[k] += c->present ? 1.0 : 0.0;
        score->within[k] += (c->present && holds) ? 1.0 : 0.0;
        extra = extra || (c->present && !(truth[k] > 0.0));
    }
    score->extra += extra ? 1.0 : 0.0;
    score->withheld += (found->noise == DAVAR_NOISE_FILTERED) ? 1.0 : 0.0;
    if (arw->present) {
        const double error = (arw->value / truth[DAVAR_ANGLE_RANDOM_WALK]) - 1.0;
        score->error[0] += error;
        score->error[1] += error * error;
    }
    if (score->windows < WIDTHS) {
        score->width[(size_t)score->windows] =
            (arw->present && (arw->low > 0.0)) ? (arw->high / arw->low) : (double)INFINITY;
    }
    score->windows += 1.0;
    for (int t = 0; (adev != NULL) && (t < found->tau_count); t++) {
        const davar_adev_t *const tau = &found->tau[t];
        if ((tau->differences > 0U) && isfinite(tau->high)) {
            score->taken[t] += 1.0;
            score->adev[t] += contains(tau->low, tau->high, adev[t]) ? 1.0 : 0.0;
            score->is_long[t] = (9U * tau->m) > found->window_samples;
        }
    }
}

void score_report(const score_t *score, double bound, const char *holds)
{
    static const char *const names[] = {"Q.given", "N.given", "B.given", "K.given", "R.given"};
    static double width[WIDTHS];
    const size_t widths = (size_t)fmin(score->windows, WIDTHS);
    const double given = score->given[DAVAR_ANGLE_RANDOM_WALK];
    const double rms = 100.0 * sqrt(score->error[1] / given);
    for (int t = 0; t < DAVAR_TAUS_MAX; t++) {
        if (score->taken[t] > 0.0) {
            share(score->is_long[t] ? "long" : "ADEV", score->adev[t], score->taken[t]);
        }
    }
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        const bool is_white = (k == (int)DAVAR_ANGLE_RANDOM_WALK);
        share(is_white ? "N" : "others", score->held[k], score->windows);
        share(names[k], score->given[k], score->windows);
    }
    share("N.within", score->within[DAVAR_ANGLE_RANDOM_WALK], given);
    share("extra", score->extra, score->windows);
    share("withheld", score->withheld, score->windows);
    value("bias", 100.0 * score->error[0] / given, rms / sqrt(given));
    value("rms", rms / bound, 0.0);
    for (size_t i = 0U; i < widths; i++) {
        width[i] = score->width[i];
    }
    qsort(width, widths, sizeof width[0], ascending);
    value("width", width[widths / 2U], 0.0);
    report(holds);
}

/* ---- the instance ---- */

davar_config_t config;
davar_t davar;
davar_plan_t plan;
davar_result_t result;
uint64_t memory[131072];

void configure(const davar_law_t *law, uint32_t shortest, uint32_t longest, uint32_t stride)
{
    static uint32_t taus[DAVAR_TAUS_MAX];
    config = davar_default_config;
    config.rate_hz = 1.0;
    config.unit_per_count = 1.0;
    config.law = law;
    config.window.shortest = shortest;
    config.window.longest = longest;
    config.window.grow = 1U;
    config.moments.segment = 0U;
    config.stride = stride;
    config.taus = taus;
    config.tau_count = davar_taus_octave(longest, taus, DAVAR_TAUS_MAX);
}

/* ---- the command line ---- */

static void run(const row_t *one, bool is_table, unsigned trials, const char *seed)
{
    const experiment_t *const experiment = one->experiment;
    const unsigned own = (one->trials > 0U) ? one->trials : trials_of(95.0, one->bad);
    const unsigned of_table = (one->table_trials > 0U) ? one->table_trials : own;
    const unsigned used = (trials > 0U) ? trials : (is_table ? of_table : own);
    const uint64_t first = (seed != NULL) ? strtoull(seed, NULL, 10) : one->seed;
    const char *const rows = experiment->rows;
    printf("%s, %u trials, seed %llu\n", one->name, used, (unsigned long long)first);
    for (size_t i = 0U; i < experiment->count - (is_table ? 0U : one->long_rows); i++) {
        experiment->run(rows + (i * experiment->row_size), used, first);
    }
}

int main(int argc, char **argv)
{
    const bool is_table = (argc > 2) && (strcmp(argv[1], "table") == 0);
    const char *const name = is_table ? argv[2] : ((argc == 2) ? argv[1] : "?");
    const unsigned trials = (argc > 3) ? (unsigned)strtoul(argv[3], NULL, 10) : 0U;
    bool found = false;
    for (size_t i = 0U; i < COUNT_OF(experiments); i++) {
        const size_t length = strlen(name);
        const char end =
            (strncmp(experiments[i].name, name, length) == 0) ? experiments[i].name[length] : '?';
        if ((end == '\0') || (is_table && (end == '_'))) {
            run(&experiments[i], is_table, trials, (argc > 4) ? argv[4] : NULL);
            found = true;
        }
    }
    if (found) {
        return (missed > 0U) ? 1 : 0;
    }
    fputs("usage: davar-statistics NAME | table NAME [TRIALS [SEED]]\nNAME:", stderr);
    for (size_t i = 0U; i < COUNT_OF(experiments); i++) {
        fprintf(stderr, " %s", experiments[i].name);
    }
    fputs("\n", stderr);
    return 2;
}
