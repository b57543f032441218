/* Intervals in windows that a law chooses while the noise changes: of the angle random walk (10.14,
 * 10.15), of three terms together, and of the level since the last alarm (10.18). */
#include "davar/fit.h"
#include "heavy_noise.h"
#include "low_pass.h"
#include "reported.h"
#include "statistics.h"

#include <string.h>

static davar_glr_report_t reported;

/* ---- by the time since a step ---- */

#define SIGMA 20.0
#define BINS 6U

typedef enum { SINCE_CUT, SINCE } when_t;

typedef struct {
    const char *name;
    const char *holds;
    double ratio;
    when_t time; /* to the step; SINCE_CUT: of windows cut since */
    double rate_hz;
    uint32_t stride;
    uint64_t stretch; /* samples between two steps; `trials` of them */
    unsigned part;    /* of the trials */
    uint64_t seed;
    uint32_t until[BINS]; /* samples */
} tracked_t;

#define SINCE_STEP                                                                                 \
    10U, 6000U, 1U, 11U,                                                                           \
    {                                                                                              \
        50U, 100U, 200U, 500U, 1500U, 6000U                                                        \
    }
/* 1 kHz; the stretch is no multiple of a stride */
#define STRIDE(samples)                                                                            \
    samples, 6007U, 3U, 23U,                                                                       \
    {                                                                                              \
        1000U, 2000U, 3000U, 5000U, 6007U, 6007U                                                   \
    }
#define HELD "first 95:, held 94.8:97.1, found "

/* Figures: `held` by the intervals at each time, at which most windows have been cut or are not
 * young; `first` in the first second; `few` at other times; `found`: cut from 2 s to 5 s; `late`:
 * young results from 5 s on. A bin has strongly correlated results: its standard error is 0.7. */
static const tracked_t tracked[] = {
    {"none", "held 95.4:97.2, first 96.5:97.6, found 100:", 1.0, SINCE_CUT, 100.0, SINCE_STEP},
    {"x1.25", "held 94.8:97, found 70:85", 1.25, SINCE_CUT, 100.0, SINCE_STEP},
    {"x1.5", HELD "98:", 1.5, SINCE_CUT, 100.0, SINCE_STEP},
    {"x2", HELD "99.5:", 2.0, SINCE_CUT, 100.0, SINCE_STEP},
    {"x3", HELD "99.5:", 3.0, SINCE_CUT, 100.0, SINCE_STEP},
    {"stride 7", "held 94.5:97, late :1", 2.0, SINCE, 1000.0, STRIDE(7U)},
    {"stride 10", "held 94.5:97, late :1", 2.0, SINCE, 1000.0, STRIDE(10U)},
    {"stride 33", "held 94.5:97, late :1", 2.0, SINCE, 1000.0, STRIDE(33U)},
    {"stride 100", "held 94.5:97, late :1", 2.0, SINCE, 1000.0, STRIDE(100U)},
    {"stride 250", "held 94.5:97, late :1", 2.0, SINCE, 1000.0, STRIDE(250U)},
    {"stride 500", "held 94.5:97, late :1", 2.0, SINCE, 1000.0, STRIDE(500U)},
    {"stride 1000", "held 94.5:97, late :1", 2.0, SINCE, 1000.0, STRIDE(1000U)},
};

/* Results at this time, of them cut since (or young), with an interval, and held by it. */
typedef struct {
    double all;
    double marked;
    double offered;
    double held;
} bin_t;

static void start_tracked(const tracked_t *row)
{
    configure(&davar_law_glr_q15, 20U, 6000U, row->stride);
    config.rate_hz = row->rate_hz;
    config.window.gaps_max = 64U;
    config.tau_count = 9U; /* to 256 samples */
    davar_plan_init_white(&plan, config.taus, config.tau_count);
    START(q15);
}

static double sigma_at(const tracked_t *row, uint64_t i)
{
    return (((i / row->stretch) % 2U) == 0U) ? SIGMA : (SIGMA * row->ratio);
}

static void judge_tracked(const tracked_t *row, bin_t bins[BINS])
{
    const double sigma = sigma_at(row, result.epoch);
    const double truth = 60.0 * sqrt(((sigma * sigma) + (1.0 / 12.0)) / row->rate_hz);
    const uint64_t since = result.epoch % row->stretch;
    const bool is_cut = (row->ratio <= 1.0) || (reported.cut_age_samples <= (since + 30U));
    bin_t *bin = bins;
    while (since >= row->until[bin - bins]) {
        bin++;
    }
    (void)davar_fit_white(&plan, row->rate_hz, &result);
    const davar_coefficient_t *const arw = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
    const bool is_held = arw->present && contains(arw->low, arw->high, truth);
    bin->all += 1.0;
    bin->marked += ((row->time == SINCE_CUT) ? is_cut : reported.young) ? 1.0 : 0.0;
    if ((row->time != SINCE_CUT) || is_cut) {
        bin->offered += arw->present ? 1.0 : 0.0;
        bin->held += is_held ? 1.0 : 0.0;
    }
}

static void report_tracked(const tracked_t *row, const bin_t bins[BINS])
{
    for (uint32_t b = 0U; (b < BINS) && (bins[b].all > 0.0); b++) {
        const bool is_first = (row->time == SINCE_CUT) && (row->until[b] <= 100U);
        const double share_marked = bins[b].marked / bins[b].all;
        const bool counts =
            (row->time == SINCE) ? (b > 0U) : ((row->time == SINCE_CUT) == (share_marked >= 0.5));
        value(counts ? (is_first ? "first" : "held") : "few",
              100.0 * bins[b].held / bins[b].offered, 0.7);
        value("marked", 100.0 * share_marked, 0.0);
    }
    value("found", 100.0 * bins[3].marked / bins[3].all, 0.0);
    value("offered", 100.0 * bins[3].offered / bins[3].all, 0.0);
    value("late", 100.0 * bins[4].marked / bins[4].all, 0.0);
    label("%s", row->name);
    report(row->holds);
}

static void run_tracked(const void *of, unsigned trials, uint64_t seed)
{
    const tracked_t *const row = of;
    bin_t bins[BINS] = {{0.0, 0.0, 0.0, 0.0}};
    random_t random = random_seeded(row->seed + seed);
    start_tracked(row);
    for (uint64_t i = 0U; i < (trials / row->part) * row->stretch; i++) {
        const int16_t sample = (int16_t)lround(sigma_at(row, i) * random_gauss(&random));
        davar_push_q15(&davar, &sample, 1U);
        if (take_reported(&davar, &result, &reported) && (result.epoch >= row->stretch)) {
            judge_tracked(row, bins);
        }
    }
    report_tracked(row, bins);
}

const experiment_t tracked_experiment = {ROWS(tracked), run_tracked};

/* ---- three terms ---- */

/* Three thirds of 60 000 samples, the noise of the middle one RATIO times as large. docs/TRACKING.md
 * has the table, and what is assumed of the signals of PID-DAVAR. White noise and flicker are equal
 * at 8 samples, flicker and walk at 128: in a window of 6000 samples each term prevails at two or
 * more cluster sizes. */
#define RATE_HZ 100.0
#define THIRD 60000U
#define RECORD 180000U
#define TERMS 3U
#define WHITE 20.0
#define FLICKER 10.64
#define WALK 1.083

static const davar_coefficient_kind_t kinds[TERMS] = {
    DAVAR_ANGLE_RANDOM_WALK, DAVAR_BIAS_INSTABILITY, DAVAR_RATE_RANDOM_WALK};

typedef struct {
    const char *name;
    double ratio[TERMS]; /* of white noise, flicker and walk in the middle stretch */
} signal_t;

static const signal_t signals[] = {
    {"unchanged", {1.0, 1.0, 1.0}}, {"ARW x2", {2.0, 1.0, 1.0}},       {"BI x2", {1.0, 2.0, 1.0}},
    {"RRW x2", {1.0, 1.0, 2.0}},    {"all three x2", {2.0, 2.0, 2.0}},
};
#define SIGNALS COUNT_OF(signals)

typedef struct {
    const char *name;
    const davar_law_t *law;
    uint32_t longest;
    uint32_t shortest;
    uint32_t stride;
    const char *holds; /* of all signals; errors in percent */
} law_t;

/* The last one has windows that share no sample. */
static const law_t laws[] = {
    {"A-DAVAR 600", &davar_law_or, 600U, 400U, 100U, "ARW.error 4.2:5.8, BI.error 12:15.5"},
    {"A-DAVAR 6000", &davar_law_or, 6000U, 4000U, 100U, "ARW.error 1.9:2.8, BI.error 5.5:7.5"},
    {"fixed 6000", NULL, 6000U, 6000U, 100U, "ARW.error 2:3, BI.error 5.5:7.5"},
    {"glr 6000", &davar_law_glr_q31, 6000U, 20U, 100U, "ARW.error 2.4:3.2, BI.error 7:9.5"},
    {"one per third", NULL, THIRD, THIRD, THIRD, "ARW.error 0.2:0.8, BI.error 1:3"},
    {"no overlap", NULL, 6000U, 6000U, 6000U,
     "ARW.held 93:95, BI.held 95:97, RRW.held 96.5:99.7, ARW.error 1.2:2"},
};
#define LAWS COUNT_OF(laws)

typedef struct {
    double results;
    double present;
    double error; /* sum of |value / truth - 1| of the present ones */
    double whole; /* present, and the window lies in one third */
    double held;  /* of these: the interval contains the truth */
} term_t;

/* A stronger flicker is a second one, which begins at 0 and stays where it ends: the level never
 * jumps. */
static void fill_record(const signal_t *signal, random_t *random, int32_t samples[RECORD])
{
    static double sum[RECORD];
    static double part[THIRD];
    const double more = sqrt((signal->ratio[1] * signal->ratio[1]) - 1.0);
    double level = 0.0;
    gyro_noise_fill(&(gyro_noise_t){.flicker = FLICKER}, random, sum, RECORD);
    for (size_t s = 0U; s < 3U; s++) {
        const bool middle = s == 1U;
        const gyro_noise_t white = {.white = WHITE * (middle ? signal->ratio[0] : 1.0)};
        const gyro_noise_t slow = {.flicker = middle ? (FLICKER * more) : 0.0,
                                   .walk = WALK * (middle ? signal->ratio[2] : 1.0)};
        double *const here = &sum[s * THIRD];
        gyro_noise_fill(&white, random, part, THIRD);
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
    for (size_t i = 0U; i < RECORD; i++) {
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

static void judge_terms(term_t terms[TERMS], const signal_t *signal)
{
    for (size_t t = 0U; t < TERMS; t++) {
        const davar_coefficient_t *const found = &result.coefficient[kinds[t]];
        const double truth = truth_at(signal, t, result.epoch);
        term_t *const term = &terms[t];
        term->results += 1.0;
        if (found->present) {
            const bool whole = ((result.epoch % THIRD) + 1U) >= result.window_samples;
            term->present += 1.0;
            term->error += fabs((found->value / truth) - 1.0);
            term->whole += whole ? 1.0 : 0.0;
            term->held += (whole && contains(found->low, found->high, truth)) ? 1.0 : 0.0;
        }
    }
}

static void run_law(const signal_t *signal, const law_t *law, const int32_t samples[RECORD],
                    term_t terms[TERMS], term_t pooled[TERMS])
{
    configure(law->law, law->shortest, law->longest, law->stride);
    config.rate_hz = RATE_HZ;
    config.moments.segment = (law->law == &davar_law_or) ? (law->shortest / 4U) : 0U;
    davar_plan_init_white(&plan, config.taus, config.tau_count);
    START(q31);
    for (size_t i = 0U; i < RECORD; i += 100U) {
        davar_push_q31(&davar, &samples[i], 100U);
        if (davar_take(&davar, &result) && (result.window_samples >= law->shortest)) {
            davar_fit(&plan, RATE_HZ, &result);
            judge_terms(terms, signal);
            judge_terms(pooled, signal);
        }
    }
}

static void report_terms(const char *signal, const law_t *law, const term_t terms[TERMS],
                         const char *holds)
{
    static const char *const names[TERMS][3] = {{"ARW.error", "ARW.given", "ARW.held"},
                                                {"BI.error", "BI.given", "BI.held"},
                                                {"RRW.error", "RRW.given", "RRW.held"}};
    for (size_t t = 0U; t < TERMS; t++) {
        value(names[t][0], 100.0 * terms[t].error / terms[t].present, 0.0);
        value(names[t][1], 100.0 * terms[t].present / terms[t].results, 0.0);
        share(names[t][2], terms[t].held, terms[t].whole);
    }
    label("%s, %s", signal, law->name);
    report(holds);
}

static const char *const terms_rows[] = {"signals"};

static void run_terms(const void *of, unsigned trials, uint64_t seed)
{
    static int32_t samples[RECORD];
    static term_t terms[SIGNALS + 1U][LAWS][TERMS]; /* the last row: all signals */
    (void)of;
    memset(terms, 0, sizeof terms);
    for (size_t s = 0U; s < SIGNALS; s++) {
        random_t random = random_seeded(seed + s);
        for (unsigned r = 0U; r < trials; r++) {
            fill_record(&signals[s], &random, samples);
            for (size_t l = 0U; l < LAWS; l++) {
                run_law(&signals[s], &laws[l], samples, terms[s][l], terms[SIGNALS][l]);
            }
        }
    }
    for (size_t s = 0U; s <= SIGNALS; s++) {
        for (size_t l = 0U; l < LAWS; l++) {
            const bool is_all = (s == SIGNALS);
            report_terms(is_all ? "all signals" : signals[s].name, &laws[l], terms[s][l],
                         is_all ? laws[l].holds : NULL);
        }
    }
}

const experiment_t terms_experiment = {ROWS(terms_rows), run_terms};

/* ---- the level since the last alarm ---- */

#define SECOND 100U /* samples; a result each */
#define MINUTE (60U * SECOND)

/* A record: its noise, and how its level changes. */
typedef struct {
    const char *name;
    const char *holds;
    double (*next)(source_t *source);
    const shape_t *filter; /* declared */
    double counts;         /* per standard deviation of the noise before it */
    uint32_t minutes;
    double step;        /* the level goes up by it and down every four minutes */
    double rise;        /* of the level in an hour */
    uint32_t gap_every; /* samples from one gap to the next; 0: none */
} steady_t;

#define WITHHELD "present :1"
#define QUIET "present 97:, contained 96:, 10min "
#define TAILED "present 92:, contained 96:, 10min "
static const shape_t plain = {.poles = 0U};
static const shape_t one_pole = {.cutoff = 0.1, .poles = 1U};
static const shape_t two_poles = {.cutoff = 0.1, .poles = 2U};
static const shape_t narrow = {.cutoff = 0.05, .poles = 2U};

/* An hour each, days in the tables; of heavy tails the minutes in which the dispersion is learned. */
static const steady_t steady[] = {
    {"gauss", QUIET "1.0205:1.024", noise_gauss, &plain, 100.0, 60U, 0.0, 0.0, 0U},
    {"uniform", QUIET "1.0195:1.023", noise_uniform, &plain, 100.0, 60U, 0.0, 0.0, 0U},
    {"laplace", TAILED "1.037:1.045", noise_laplace, &plain, 100.0, 60U, 0.0, 0.0, 0U},
    {"student5", TAILED "1.045:1.057", noise_student5, &plain, 100.0, 60U, 0.0, 0.0, 0U},
    {"student4", "contained 95:, present :15", noise_student4, &plain, 100.0, 25U, 0.0, 0.0, 0U},
    {"student3", WITHHELD, noise_student3, &plain, 100.0, 25U, 0.0, 0.0, 0U},
    {"mixed", WITHHELD, noise_mixed, &plain, 100.0, 25U, 0.0, 0.0, 0U},
    {"rare10", WITHHELD, noise_rare10, &plain, 100.0, 25U, 0.0, 0.0, 0U},
    {"rare20", "contained 95:, present :1.5", noise_rare20, &plain, 100.0, 25U, 0.0, 0.0, 0U},
    {"one pole at 0.1", QUIET "1.0205:1.024", noise_gauss, &one_pole, 100.0, 60U, 0.0, 0.0, 0U},
    {"one pole at 0.1, 5 counts", QUIET "1.042:1.05", noise_gauss, &one_pole, 5.0, 60U, 0.0, 0.0,
     0U},
    {"two poles at 0.1", QUIET "1.0205:1.024", noise_gauss, &two_poles, 100.0, 60U, 0.0, 0.0, 0U},
    {"two poles at 0.05, 1000 counts", QUIET "1.021:1.0255", noise_gauss, &narrow, 1000.0, 60U, 0.0,
     0.0, 0U},
    {"two poles at 0.05, 50 counts", QUIET "1.034:1.04", noise_gauss, &narrow, 50.0, 60U, 0.0, 0.0,
     0U},
    {"two poles at 0.05, 15 counts", QUIET "1.2:1.235", noise_gauss, &narrow, 15.0, 60U, 0.0, 0.0,
     0U},
    {"5 counts", QUIET "1.0205:1.024", noise_gauss, &plain, 5.0, 60U, 0.0, 0.0, 0U},
    {"0.75 counts", QUIET "1.025:1.029", noise_gauss, &plain, 0.75, 60U, 0.0, 0.0, 0U},
};

/* What a record showed, at each result from the first with an interval on. */
typedef struct {
    double results;
    double missed;   /* intervals without the true level */
    double worst;    /* largest distance of the level from its interval, relative */
    double width[2]; /* high over low after 10 min and at the end; 0: none was shown */
    double restarts; /* without an alarm */
    double alarms;
} shown_t;

static void start_steady(const steady_t *row)
{
    configure(&davar_law_glr_q15, 20U, 6000U, SECOND);
    config.rate_hz = RATE_HZ;
    config.unit_per_count = 1.0 / row->counts;
    config.tau_count = 3U;
    if (row->filter->poles > 0U) {
        whiten_shape(&config, row->filter);
    }
    START(q15);
    plan_shape(&plan, config.taus, 3U, row->filter);
}

static void note(shown_t *shown, double truth, uint64_t before, uint32_t second)
{
    const davar_steady_t *const now = &reported.steady;
    shown->alarms += reported.alarm ? 1.0 : 0.0;
    shown->restarts += (!reported.alarm && (now->samples < before)) ? 1.0 : 0.0;
    if (now->samples == 0U) {
        require(isnan(now->low) && isnan(now->high) && isnan(now->level), "steady: not withheld");
        return;
    }
    require((now->low <= now->level) && (now->level <= now->high), "steady: level outside");
    shown->results += 1.0;
    shown->missed += contains(now->low, now->high, truth) ? 0.0 : 1.0;
    shown->worst = fmax(shown->worst, fmax(now->low / truth, truth / now->high) - 1.0);
    shown->width[(second <= 600U) ? 0 : 1] = now->high / now->low;
}

static double level_at(const steady_t *row, uint32_t sample)
{
    const bool is_up = ((sample / (4U * MINUTE)) % 2U) != 0U;
    return 1.0 + (is_up ? row->step : 0.0) + (row->rise * sample / (60.0 * MINUTE));
}

static shown_t show(const steady_t *row, uint32_t samples, uint64_t seed)
{
    source_t source = source_seeded(seed);
    low_pass_t state = low_pass_of(row->filter, 1.0);
    shown_t shown = {.results = 0.0};
    uint64_t before = 0U;
    start_steady(row);
    const double gain = sqrt((double)plan.white.sample);
    for (uint32_t i = 0U; i < samples; i++) {
        const double level = level_at(row, i);
        double x = level * row->next(&source);
        if (row->filter->poles > 0U) {
            x = gain * low_pass_advance(&state, 0.0, x, level * row->next(&source));
        }
        const double counts = floor((row->counts * x) + 0.5);
        const int16_t sample = (int16_t)fmax(-32768.0, fmin(32767.0, counts));
        davar_push_q15(&davar, &sample, 1U);
        if ((row->gap_every > 0U) && ((i % row->gap_every) == 0U)) {
            davar_gap(&davar, 1U);
        }
        if (take_reported(&davar, &result, &reported)) {
            note(&shown, level, before, (i + 1U) / SECOND);
            before = reported.steady.samples;
        }
    }
    return shown;
}

static void report_steady(const steady_t *row, uint32_t minutes, unsigned trials, uint64_t seed)
{
    shown_t all = {.results = 0.0};
    double contained = 0.0;
    double with[2] = {0.0};
    const double hours = trials * minutes / 60.0;
    for (unsigned run = 0U; run < trials; run++) {
        const shown_t shown = show(row, minutes * MINUTE, seed + run);
        contained += (shown.missed > 0.0) ? 0.0 : 1.0;
        all.results += shown.results;
        all.missed += shown.missed;
        all.alarms += shown.alarms;
        all.restarts += shown.restarts;
        all.worst = fmax(all.worst, shown.worst);
        for (int i = 0; i < 2; i++) {
            all.width[i] += shown.width[i];
            with[i] += (shown.width[i] > 0.0) ? 1.0 : 0.0;
        }
    }
    value("present", 100.0 * all.results / (3600.0 * hours), 0.0);
    share("contained", contained, trials);
    value("10min", all.width[0] / with[0], 0.0);
    value("end", all.width[1] / with[1], 0.0);
    value("missed", 100.0 * all.missed / all.results, 0.0);
    value("farthest", 100.0 * all.worst, 0.0);
    value("alarms", all.alarms / hours, 0.0);
    value("restarts", all.restarts / hours, 0.0);
    label("%s", row->name);
    report(row->holds);
}

static void run_steady(const void *of, unsigned trials, uint64_t seed)
{
    const steady_t *const row = of;
    report_steady(row, row->minutes, (row->minutes < 60U) ? (5U * trials / 2U) : trials, seed);
}

static void run_days(const void *of, unsigned trials, uint64_t seed)
{
    const steady_t *const row = of;
    const bool is_short = row->minutes < 60U;
    report_steady(row, is_short ? row->minutes : (24U * 60U), is_short ? (10U * trials) : trials,
                  seed);
}

const experiment_t steady_experiment = {ROWS(steady), run_steady};
const experiment_t steady_days_experiment = {ROWS(steady), run_days};

/* ---- noise that changes ---- */

/* `missed`: until the alarm. In slowly rising noise new sections begin without one. The gaps of one
 * sample are in half a block before each place where the parts are compared. */
static const steady_t changing[] = {
    {"x1.25", "missed 1.5:3, restarts :0.2", noise_gauss, &plain, 100.0, 360U, 0.25, 0.0, 0U},
    {"x1.5", "missed 0.5:1.2, restarts :0.2", noise_gauss, &plain, 100.0, 360U, 0.5, 0.0, 0U},
    {"x2", "missed 0.18:0.7, restarts :0.2", noise_gauss, &plain, 100.0, 360U, 1.0, 0.0, 0U},
    {"x3", "missed 0.13:0.5, restarts :0.2", noise_gauss, &plain, 100.0, 360U, 2.0, 0.0, 0U},
    {"+10 % per hour", "farthest :3.6, restarts 1.2:2.2", noise_gauss, &plain, 100.0, 360U, 0.0,
     0.1, 0U},
    {"+10 % per hour, with gaps", "farthest :3.6, restarts 1.2:2.2", noise_gauss, &plain, 100.0,
     360U, 0.0, 0.1, 635U},
};

const experiment_t steady_changing_experiment = {ROWS(changing), run_steady};
