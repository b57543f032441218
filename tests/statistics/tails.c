/* Noise with light and heavy tails through the library (5.19), in windows of fixed length and in
 * those that a law chooses; and the filter that davar-sim learns from a recording. */
#include "autocovariance.h"
#include "davar/fit.h"
#include "heavy_noise.h"
#include "learning/learn.h"
#include "low_pass.h"
#include "reported.h"
#include "statistics.h"

#include <string.h>

static const shape_t no_filter = {.poles = 0U};
static const shape_t low_pass = {.cutoff = 0.1, .poles = 2U};

static autocovariance_t of_noise;

#define COUNTS 100.0 /* per standard deviation of the noise */

/* Of noise of N = 1 with the autocovariance of_noise. */
static double adev_of(uint32_t m)
{
    double sum = 2.0 * m * of_noise.r[0];
    for (uint32_t k = 1U; (k < 2U * m) && ((int)k < of_noise.count); k++) {
        const double kernel = (k <= m) ? ((2.0 * m) - (3.0 * k)) : ((double)k - (2.0 * m));
        sum += 2.0 * kernel * of_noise.r[k];
    }
    return sqrt(sum / (2.0 * m * m));
}

static void start(const shape_t *filter, double adev[])
{
    config.unit_per_count = 1.0 / COUNTS;
    START(q31);
    plan_shape(&plan, config.taus, config.tau_count, filter);
    autocovariance_of(filter, &of_noise);
    for (int t = 0; t < config.tau_count; t++) {
        adev[t] = adev_of(config.taus[t]);
    }
}

/* The next sample of noise of N = 1; both states of the low-pass get noise of the kind. */
static int32_t next_sample(const noise_kind_t *kind, bool is_filtered, source_t *source,
                           low_pass_t *state)
{
    const double first = kind->next(source);
    if (!is_filtered) {
        return (int32_t)lround(COUNTS * first);
    }
    const double second = kind->next(source);
    return (int32_t)lround(COUNTS *
                           (sqrt(of_noise.r[0]) * low_pass_advance(state, 0.0, first, second)));
}

/* ---- windows of fixed length ---- */

/* By kind: without a filter, and after one, which hides tails without a fourth moment. */
static const char *const tails_hold[NOISE_WHITE_KINDS][2] = {
    {"N 95.5:97.7, ADEV 94.4:97, long? 94:, extra :2.5, bias -1:1",
     "N 95.5:98, ADEV 94:, long? 94:, extra :2.5, bias -2:2"},
    {"N 98.7:, ADEV 94.4:, long? 94.4:, extra :2.5, bias -1:1",
     "N 97.5:, ADEV 94:, long? 94:, extra :2.5, bias -2:2"},
    {"N 97.5:99.5, ADEV 94.8:, long? 94.8:, extra :2.5, bias -1:1",
     "N 94:, ADEV 94:, long? 94:, extra :2.5, bias -2:2"},
    {"N 95.4:98, ADEV 94.8:, long? 94.8:, extra :2.5, bias -2:1",
     "N 93:, ADEV 93:, long? 93:, extra :2.5, bias -2:2"},
    {"N 93.4:96, ADEV 93:, long? 93:, extra :2.5", "N 89:95, ADEV 89:, long? 89:, extra :2.5"},
    {"N 98:, ADEV 96.5:, long? 96.5:, extra :2.5, bias -1:1",
     "N 97.8:, ADEV 96:, long? 96:, extra :2.5, bias -2:2"},
};

static void run_fixed(const noise_kind_t *kind, bool is_filtered, uint32_t window,
                      bool has_kurtosis, unsigned trials, uint64_t seed)
{
    static score_t score;
    const shape_t *const filter = is_filtered ? &low_pass : &no_filter;
    source_t source = source_seeded(seed + window);
    low_pass_t state = low_pass_of(filter, 1.0);
    double adev[DAVAR_TAUS_MAX];
    score = (score_t){0};
    configure(NULL, window, window, window);
    config.moments.segment = has_kurtosis ? 100U : 0U;
    start(filter, adev);
    for (unsigned i = 0U; i < trials; i++) {
        for (uint32_t k = 0U; k < window; k++) {
            const int32_t sample = next_sample(kind, is_filtered, &source, &state);
            davar_push_q31(&davar, &sample, 1U);
        }
        require(davar_take(&davar, &result), "tails: a window without a result");
        davar_fit(&plan, config.rate_hz, &result);
        score_add(&score, &result, truth_1, adev);
    }
    label("%s%s, L %u%s", kind->name, is_filtered ? ", low-pass" : "", (unsigned)window,
          has_kurtosis ? "" : ", no kurtosis");
    score_report(&score, 1.0, tails_hold[kind - noise_kinds][is_filtered ? 1 : 0]);
    if ((window == 600U) && !is_filtered) {
        static const char *const widths[NOISE_WHITE_KINDS] = {
            "width 1.155:1.18", "width 1.155:1.18", "width 1.33:1.41",
            "width 1.33:1.42",  "width 1.9:2.4",    "width 2:2.35"};
        score_report(&score, 1.0, widths[kind - noise_kinds]);
    }
}

static void run_tails(const void *of, unsigned trials, uint64_t seed)
{
    const noise_kind_t *const kind = of;
    run_fixed(kind, false, 300U, true, trials, seed);
    run_fixed(kind, false, 600U, true, trials, seed);
    run_fixed(kind, false, 2000U, true, trials, seed);
    run_fixed(kind, true, 600U, true, trials, seed);
    if (kind->next == noise_gauss) { /* without a kurtosis tails are unknown */
        run_fixed(kind, false, 600U, false, trials, seed);
    }
}

const experiment_t tails_experiment = {noise_kinds, sizeof noise_kinds[0], NOISE_WHITE_KINDS,
                                       run_tails};

/* ---- windows that a law chooses ---- */

typedef struct {
    const char *name;
    const davar_law_t *law;
    bool is_filtered;
    uint32_t shortest;
    uint32_t longest;
    uint32_t segment; /* 0: no moments, so the scatter of the law's blocks counts */
    uint32_t every;   /* samples */
} chosen_t;

static const chosen_t chosen[] = {
    {"glr to 600", &davar_law_glr_q31, false, 20U, 600U, 0U, 600U},
    {"glr to 6000", &davar_law_glr_q31, false, 20U, 6000U, 0U, 6000U},
    {"glr to 600, low-pass", &davar_law_glr_q31, true, 20U, 600U, 0U, 600U},
    {"glr to 6000, low-pass", &davar_law_glr_q31, true, 20U, 6000U, 0U, 6000U},
    {"or", &davar_law_or, false, 400U, 600U, 100U, 1200U},
};

static void run_chosen(const noise_kind_t *kind, const chosen_t *one, unsigned trials,
                       uint64_t seed)
{
    /* by kind: all laws, and law or */
    static const char *const holds[NOISE_WHITE_KINDS] = {
        "N 95.3:97.7, N.given 98:, bias -1.5:1", "N 97.5:", "N 96.5:", "N 95:", "N 94:", "N 98.7:"};
    static score_t score;
    const shape_t *const filter = one->is_filtered ? &low_pass : &no_filter;
    source_t source = source_seeded(seed);
    low_pass_t state = low_pass_of(filter, 1.0);
    double adev[DAVAR_TAUS_MAX];
    davar_glr_report_t reported;
    score = (score_t){0};
    configure(one->law, one->shortest, one->longest, 100U);
    config.tau_count = 7U; /* to 64 samples */
    config.moments.segment = one->segment;
    config.rate_hz = 100.0;
    if (one->law == &davar_law_glr_q31) {
        whiten_shape(&config, filter);
    }
    start(filter, adev);
    for (uint32_t i = 0U; i < (trials + 10U) * one->every; i++) {
        const int32_t sample = next_sample(kind, one->is_filtered, &source, &state);
        davar_push_q31(&davar, &sample, 1U);
        if (((i % one->every) == 0U) && (i >= 10U * one->every) &&
            take_reported(&davar, &result, &reported) && !reported.young) {
            davar_fit(&plan, 1.0, &result);
            score_add(&score, &result, truth_1, adev);
        }
    }
    label("%s, %s", kind->name, one->name);
    share("old", score.windows, trials);
    score_report(&score, 1.0, "old 90:");
    share("N", score.held[DAVAR_ANGLE_RANDOM_WALK], score.windows);
    share("N.given", score.given[DAVAR_ANGLE_RANDOM_WALK], score.windows);
    value("bias", 100.0 * score.error[0] / score.given[DAVAR_ANGLE_RANDOM_WALK], 0.1);
    report(holds[kind - noise_kinds]);
}

static void run_tails_of_laws(const void *of, unsigned trials, uint64_t seed)
{
    for (size_t i = 0U; i < COUNT_OF(chosen); i++) {
        run_chosen(of, &chosen[i], trials, seed);
    }
}

const experiment_t tails_laws_experiment = {noise_kinds, sizeof noise_kinds[0], NOISE_WHITE_KINDS,
                                            run_tails_of_laws};

/* ---- the learned filter ---- */

#define LENGTH 18000U /* samples of a recording: 30 windows of 600 */
#define WINDOWS 30U   /* fresh ones for each recording */
#define WINDOW 600U
#define TAPS 64

typedef struct {
    const char *name;
    bool is_stranger; /* outside the family */
    shape_t filter;
    double after;     /* white noise after the filter, over the scatter of a sample */
    double resonance; /* of two poles: its peak over the plateau */
    double fraction;  /* weight of the previous sample */
} learned_row_t;

static const learned_row_t learned_rows[] = {
    {"white", false, {.poles = 0U}, 0.0, 0.0, 0.0},
    {"1 pole 0.05", false, {.cutoff = 0.05, .poles = 1U}, 0.0, 0.0, 0.0},
    {"1 pole 0.1", false, {.cutoff = 0.1, .poles = 1U}, 0.0, 0.0, 0.0},
    {"1 pole 0.25", false, {.cutoff = 0.25, .poles = 1U}, 0.0, 0.0, 0.0},
    {"1 pole 0.45", false, {.cutoff = 0.45, .poles = 1U}, 0.0, 0.0, 0.0},
    {"2 poles 0.05", false, {.cutoff = 0.05, .poles = 2U}, 0.0, 0.0, 0.0},
    {"2 poles 0.1", false, {.cutoff = 0.1, .poles = 2U}, 0.0, 0.0, 0.0},
    {"2 poles 0.25", false, {.cutoff = 0.25, .poles = 2U}, 0.0, 0.0, 0.0},
    {"2 poles 0.45", false, {.cutoff = 0.45, .poles = 2U}, 0.0, 0.0, 0.0},
    {"CIC 3:4", false, {.averages = 3U, .length = 4U, .decimation = 4U}, 0.0, 0.0, 0.0},
    {"average of 2", false, {.averages = 1U, .length = 2U}, 0.0, 0.0, 0.0},
    {"average of 8", false, {.averages = 1U, .length = 8U}, 0.0, 0.0, 0.0},
    {"1 pole 0.07, noise after", true, {.cutoff = 0.07, .poles = 1U}, 0.15, 0.0, 0.0},
    {"2 poles 0.1, noise after", true, {.cutoff = 0.1, .poles = 2U}, 0.3, 0.0, 0.0},
    {"sample + 0.2 previous", true, {.poles = 0U}, 0.0, 0.0, 0.2},
    {"2 poles + 0.5 previous", true, {.cutoff = 0.2, .poles = 2U}, 0.0, 0.0, 0.5},
    {"sample - 0.4 previous", true, {.poles = 0U}, 0.0, 0.0, -0.4},
    {"resonance of 2", true, {.poles = 0U}, 0.0, 2.0, 0.0},
    {"average of 20", true, {.averages = 1U, .length = 20U}, 0.0, 0.0, 0.0},
};

/* What a recording has beside the noise. */
typedef struct {
    const char *name;
    double flicker; /* over N of a sample */
    double walk;
    bool lines; /* two lines, and motion in a fifth of the recording */
} beside_t;

static const beside_t beside[] = {{"", 0.0, 0.0, false},
                                  {"B 0.3", 0.3, 0.0, false},
                                  {"K 0.05", 0.0, 0.05, false},
                                  {"lines, motion", 0.1, 0.0, true}};

static random_t rng;
static double samples[LENGTH];

static double feedback_of(const learned_row_t *row)
{
    return (row->resonance > 0.0) ? (-(row->resonance - 1.0) / (row->resonance + 1.0)) : 0.0;
}

/* Sum over all lags of the autocovariance. */
static double sum_of(const learned_row_t *row)
{
    autocovariance_of(&row->filter, &of_noise);
    return of_noise.sum * pow((1.0 + row->fraction) / (1.0 - feedback_of(row)), 2.0);
}

/* White noise of N = 1 after the filter, with drifts that pass it. A resonance is x[i] = e[i] + c
 * x[i - 2], whose power peaks at a quarter of the rate. */
static void make_noise(const learned_row_t *row, size_t count, const beside_t *with)
{
    static double fine[(4U * LENGTH) + TAPS];
    static double drift[LENGTH + TAPS];
    double h[TAPS] = {0};
    const shape_t *const filter = &row->filter;
    low_pass_t state = low_pass_of(filter, shape_decimation(filter));
    const size_t taps = (size_t)impulse_response(filter, h);
    const size_t step = (size_t)shape_decimation(filter);
    const double size = 1.0 / sqrt(sum_of(row));
    const double c = feedback_of(row);
    double all = 0.0;
    for (size_t j = 0U; j < taps; j++) {
        all += h[j];
    }
    const gyro_noise_t slow = {.flicker = with->flicker, .walk = with->walk};
    gyro_noise_fill(&slow, &rng, drift, count + TAPS);
    for (size_t i = 0U; i < (step * count) + taps; i++) {
        const double first = random_gauss(&rng);
        fine[i] = low_pass_advance(&state, drift[i / step] / (size * all * (1.0 + row->fraction)),
                                   first, (filter->poles == 2U) ? random_gauss(&rng) : 0.0);
    }
    for (size_t i = 0U; i < count; i++) {
        samples[i] = 0.0;
        for (size_t j = 0U; j < taps; j++) {
            samples[i] += size * h[j] * fine[(i * step) + j];
        }
    }
    for (size_t i = count - 1U; i > 0U; i--) {
        samples[i] += row->fraction * samples[i - 1U];
    }
    for (size_t i = 2U; i < count; i++) {
        samples[i] += c * samples[i - 2U];
    }
}

static double scatter_of_a_sample(const learned_row_t *row)
{
    const random_t now = rng;
    double sum = 0.0;
    make_noise(row, LENGTH, &beside[0]);
    for (size_t i = 0U; i < LENGTH; i++) {
        sum += samples[i] * samples[i] / (double)LENGTH;
    }
    rng = now;
    return sqrt(sum);
}

/* `after`: of white noise after the filter. */
static void finish(size_t count, double after, double unit)
{
    for (size_t i = 0U; (after > 0.0) && (i < count); i++) {
        samples[i] += after * random_gauss(&rng);
    }
    for (size_t i = 0U; (unit > 0.0) && (i < count); i++) {
        samples[i] = round(samples[i] / unit);
    }
}

static void add_lines_and_motion(double scatter)
{
    for (size_t i = 0U; i < LENGTH; i++) {
        const double at = (double)i;
        const bool moves = (i % 5000U) < 1000U;
        samples[i] += scatter * sin(0.9 * at) + 0.5 * scatter * sin(2.3 * at);
        samples[i] +=
            moves ? (30.0 * scatter * sin(0.02 * at) + 5.0 * scatter * sin(0.4 * at)) : 0.0;
    }
}

static learned_t learn_recording(void)
{
    static spectrum_t spectrum;
    require(spectrum_open(&spectrum, LENGTH), "learned: no memory");
    for (size_t i = 0U; i < spectrum_places(&spectrum, LENGTH); i++) {
        spectrum_add(&spectrum, samples + spectrum_place(&spectrum, LENGTH, i));
    }
    const learned_t learned = learn_filter(&spectrum, 1.0 / 12.0);
    spectrum_close(&spectrum);
    return learned;
}

static void score_windows(const learned_row_t *row, const davar_filter_t *filter, double scatter,
                          score_t *score)
{
    uint32_t m[DAVAR_TAUS_MAX];
    const double after = row->after * scatter;
    const double unit = scatter / 10.0;
    const double truth[DAVAR_COEFFICIENT_COUNT] = {[DAVAR_ANGLE_RANDOM_WALK] =
                                                       sqrt(1.0 + (after * after)) * 60.0 / unit};
    expect_window(WINDOW, m, davar_taus_octave(WINDOW, m, DAVAR_TAUS_MAX));
    result.unit_per_count = 1.0;
    davar_plan_init_filtered(&plan, m, result.tau_count, filter);
    for (uint32_t w = 0U; w < WINDOWS; w++) {
        make_noise(row, WINDOW + TAPS, &beside[0]);
        memmove(samples, samples + TAPS, WINDOW * sizeof samples[0]);
        finish(WINDOW, after, unit);
        observe(samples, WINDOW);
        davar_fit(&plan, 1.0, &result);
        score_add(score, &result, truth, NULL);
    }
}

/* A filter is known and its intervals hold, or it stays unknown (5.17). */
static double learn_beside(const learned_row_t *row, const beside_t *with, unsigned trials,
                           uint64_t seed)
{
    static score_t score;
    double known = 0.0;
    double rejected = 0.0;
    score = (score_t){0};
    rng = random_seeded(seed);
    const double scatter = scatter_of_a_sample(row);
    for (unsigned i = 0U; i < trials; i++) {
        make_noise(row, LENGTH, with);
        finish(LENGTH, row->after * scatter, 0.0);
        if (with->lines) {
            add_lines_and_motion(scatter);
        }
        finish(LENGTH, 0.0, scatter / 10.0);
        const learned_t learned = learn_recording();
        rejected += (learned.status == LEARN_MISFIT) ? 1.0 : 0.0;
        if (learn_knows(&learned)) {
            known += 1.0;
            score_windows(row, &learned.filter, scatter, &score);
        }
    }
    const double given = score.given[DAVAR_ANGLE_RANDOM_WALK];
    const double within = score.within[DAVAR_ANGLE_RANDOM_WALK];
    const bool is_common = (2.0 * known) >= trials;
    share("known", known, trials);
    share("rejected", rejected, trials);
    share("N.given", given, score.windows);
    share("N.within", within, given);
    value("wrong", 100.0 * (given - within) / ((double)trials * WINDOWS), 0.0);
    label("%s, %s", row->name, with->name);
    report(is_common ? "N.within 94:, wrong :8" : "wrong :8");
    return rejected;
}

static void run_learned(const void *of, unsigned trials, uint64_t seed)
{
    const learned_row_t *const row = of;
    const double rejected = learn_beside(row, &beside[0], trials, seed);
    if (row->is_stranger) {
        return;
    }
    for (size_t b = 1U; b < COUNT_OF(beside); b++) {
        (void)learn_beside(row, &beside[b], trials, seed);
    }
    share("rejected", rejected, trials);
    label("%s", row->name);
    report("rejected :2");
}

const experiment_t learned_experiment = {ROWS(learned_rows), run_learned};
