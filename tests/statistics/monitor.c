/* False alarms and power of the monitor (9.6): noise with a known Allan variance through the whole
 * library, with and without a cascade; and how often a law calls unchanged noise unstable (4.3). */
#include "davar/monitor.h"
#include "davar/fit.h"

#include "davar/cascade.h"
#include "filter_cases.h"
#include "filtered_noise.h"
#include "statistics.h"

#define WINDOW 600U
#define STRETCH 100U /* windows of one record; the monitor restarts with each */
#define TAUS 7U

/* With a cascade: sizes up to 4096 samples, which remember 41 000 to 74 000 samples. */
#define LONG_TAUS 6U
#define LONG_STRETCH 1000U
#define SAMPLES ((size_t)LONG_STRETCH * WINDOW)

/* The step of a program between davar_take and the monitor. */
typedef enum { FIT_ALL = 0, FIT_WHITE, FIT_NOTHING, FITS } fit_t;

typedef struct {
    const char *truth;
    const char *model; /* NULL: the truth, without tolerance */
    uint32_t stride;
    const char *holds[FITS]; /* NULL: not run */
} monitor_row_t;

#define QUIET "fast 0.25:0.45, slow 0.02:0.7, health :1.05"
#define RARE "fast :0.25, slow :0.3, health :0.5"
#define LOUD "fast 99.5:, slow 99.5:"
static const monitor_row_t monitored[] = {
    {"N 1", NULL, WINDOW, {QUIET, NULL, RARE}},
    {"N 1", NULL, 60U, {QUIET, NULL, NULL}},
    {"N 1 B 0.1", NULL, WINDOW, {QUIET, NULL, NULL}},
    {"N 1 B 0.5", NULL, WINDOW, {QUIET, RARE, NULL}},
    {"N 1 K 0.02", NULL, WINDOW, {QUIET, NULL, NULL}},
    {"N 1 K 0.3", NULL, WINDOW, {QUIET, RARE, RARE}},
    {"Q 1 N 1", NULL, WINDOW, {"fast 0.1:0.22, health :0.5", RARE, RARE}},
    {"N 1.5", "N 1", WINDOW, {LOUD, NULL, LOUD}},
    {"N 1.5 K 0.3", "N 1", WINDOW, {NULL, LOUD, NULL}},
    {"N 1.08", "N 1", WINDOW, {"fast 10:17, slow 90:97", NULL, NULL}},
    {"N 1 K 0.02", "N 1", WINDOW, {"fast 0.5:2, slow 86:95", NULL, NULL}},
    {"N 1.02", "N 1", WINDOW, {"health :0.6", NULL, NULL}},
};

#define QUIET_CASCADE "fast 0.3:0.5, slow :0.5"

/* Results overlap by up to 99 %; the longest sizes of a record are 8 to 15 independent values. */
static const monitor_row_t with_cascade[] = {
    {"N 1", NULL, WINDOW, {QUIET_CASCADE, NULL, "fast :0.1, slow :0.05"}},
    {"N 1 K 0.002", NULL, WINDOW, {QUIET_CASCADE, NULL, NULL}},
    {"N 1 B 0.05", NULL, WINDOW, {QUIET_CASCADE, NULL, NULL}},
};

typedef struct {
    davar_monitor_t monitor;
    davar_model_tau_t table[TAUS + LONG_TAUS];
    double results;
    double fast;
    double slow;
    double health;
} watch_t;

static const uint32_t taus[TAUS + LONG_TAUS] = {1,   2,   4,   8,    16,   32,  64,
                                                128, 256, 512, 1024, 2048, 4096};
static davar_cascade_t cascade;

static void start(const monitor_row_t *row, bool has_cascade, watch_t watches[FITS])
{
    static const davar_cascade_config_t long_config = {.rate_hz = 1.0,
                                                       .full_scale = 65536.0,
                                                       .shortest = 128U,
                                                       .tau_count = LONG_TAUS,
                                                       .clusters = 8U};
    static uint64_t long_memory[DAVAR_CASCADE_MEMORY(F32, LONG_TAUS) / 8U];
    const gyro_noise_t model = noise_of((row->model != NULL) ? row->model : row->truth);
    const double tolerance = (row->model != NULL) ? 0.02 : 0.0;
    const uint8_t count = has_cascade ? (TAUS + LONG_TAUS) : TAUS;
    configure(NULL, WINDOW, WINDOW, row->stride);
    config.full_scale = 65536.0;
    config.moments = davar_default_config.moments;
    config.taus = taus;
    config.tau_count = TAUS;
    START(f32);
    require(davar_cascade_init_f32(&cascade, &long_config, long_memory, sizeof long_memory) ==
                DAVAR_CASCADE_OK,
            "monitor: init of the cascade");
    davar_plan_init_white(&plan, taus, count);
    for (int f = 0; f < (int)FITS; f++) {
        watch_t *const watch = &watches[f];
        for (size_t t = 0; t < count; t++) {
            watch->table[t] =
                (davar_model_tau_t){taus[t], sqrt(gyro_noise_avar(&model, taus[t])), tolerance};
        }
        require(davar_monitor_init(&watch->monitor, watch->table, count, DAVAR_MONITOR_MEMORY) ==
                    DAVAR_MONITOR_OK,
                "monitor: init of the monitor");
    }
}

static void watch_result(watch_t *watch, fit_t fit, bool has_cascade)
{
    static davar_result_t fitted;
    davar_misfit_t misfit;
    fitted = result;
    if (fit == FIT_ALL) {
        davar_fit(&plan, 1.0, &fitted);
    } else if (fit == FIT_WHITE) {
        (void)davar_fit_white(&plan, 1.0, &fitted);
    }
    davar_monitor_update(&watch->monitor, &fitted, &misfit);
    if (has_cascade && (fitted.tau[TAUS + LONG_TAUS - 1U].differences == 0U)) {
        return; /* the record is too short for the longest size */
    }
    require(misfit.compared == (has_cascade ? (TAUS + LONG_TAUS) : TAUS), "monitor: compared");
    watch->results += 1.0;
    watch->fast += (misfit.fast > 1.0) ? 1.0 : 0.0;
    watch->slow += (misfit.slow > 1.0) ? 1.0 : 0.0;
    watch->health += (misfit.health > 1.0) ? 1.0 : 0.0;
}

static void watch_record(const monitor_row_t *row, bool has_cascade, random_t *random,
                         watch_t watches[FITS])
{
    static double rates[SAMPLES];
    static float samples[SAMPLES];
    const gyro_noise_t truth = noise_of(row->truth);
    const size_t length = (size_t)(has_cascade ? LONG_STRETCH : STRETCH) * WINDOW;
    start(row, has_cascade, watches);
    gyro_noise_fill(&truth, random, rates, length);
    for (size_t i = 0; i < length; i++) {
        samples[i] = (float)rates[i];
    }
    for (size_t done = 0; done < length;) {
        const size_t pushed = davar_push_until_result_f32(&davar, samples + done, length - done);
        if (has_cascade) {
            davar_cascade_push_f32(&cascade, samples + done, pushed);
        }
        done += pushed;
        if (!davar_take(&davar, &result)) {
            continue;
        }
        if (has_cascade) {
            (void)davar_cascade_append(&cascade, &result);
        }
        for (int f = 0; f < (int)FITS; f++) {
            if (row->holds[f] != NULL) {
                watch_result(&watches[f], (fit_t)f, has_cascade);
            }
        }
    }
}

/* The slow mean keeps 32 windows together, and so does the health. Overlapping windows scatter as
 * those that do not. */
static void watch_all(const monitor_row_t *row, bool has_cascade, unsigned trials, uint64_t seed)
{
    static const char *const names[FITS] = {"", ", white fit", ", no fit"};
    static watch_t watches[FITS];
    const unsigned windows = (row->model != NULL) ? (trials / 6U) : trials;
    random_t random = random_seeded(seed);
    for (int f = 0; f < (int)FITS; f++) {
        watches[f] = (watch_t){.results = 0.0};
    }
    for (unsigned n = 0U; n < windows; n += has_cascade ? LONG_STRETCH : STRETCH) {
        watch_record(row, has_cascade, &random, watches);
    }
    for (int f = 0; f < (int)FITS; f++) {
        const watch_t *const watch = &watches[f];
        const double slower = watch->results / (has_cascade ? (0.1 * windows) : (windows / 16.0));
        if (row->holds[f] != NULL) {
            const double alike = watch->results / (has_cascade ? (0.4 * windows) : windows);
            share("fast", watch->fast / alike, watch->results / alike);
            share("slow", watch->slow / slower, watch->results / slower);
            share("health", watch->health / slower, watch->results / slower);
            label("%s for %s, stride %u%s", row->truth,
                  (row->model != NULL) ? row->model : "itself", (unsigned)row->stride, names[f]);
            report(row->holds[f]);
        }
    }
}

static void run_monitor(const void *row, unsigned trials, uint64_t seed)
{
    watch_all(row, false, trials, seed);
}

static void run_monitor_cascade(const void *row, unsigned trials, uint64_t seed)
{
    watch_all(row, true, trials, seed);
}

const experiment_t alarms_experiment = {ROWS(monitored), run_monitor};
const experiment_t alarms_cascade_experiment = {ROWS(with_cascade), run_monitor_cascade};

/* ---- unstable windows ---- */

#define UNSTABLE_TRIALS 200U

static filtered_noise_t noise;

static void start_law(const shape_t *filter, const davar_law_t *law, uint32_t shortest,
                      uint32_t longest, double stated)
{
    configure(law, shortest, longest, (shortest == longest) ? longest : 1U);
    config.rate_hz = 100.0;
    config.moments.segment = 100U;
    config.tau_count = 1U;
    if (stated > 0.0) {
        bound_shape(&config, stated, filter);
    }
    START(q31);
}

/* Unstable ones of so many windows. shortest = longest: of windows of this length that do not
 * overlap; else of all windows in the loop. */
static double unstable(const shape_t *filter, const davar_law_t *law, uint32_t shortest,
                       uint32_t longest, double stated, uint32_t windows, uint64_t seed)
{
    uint32_t count = 0U;
    double bad = 0.0;
    start_law(filter, law, shortest, longest, stated);
    filtered_noise_start(&noise, filter, seed + 2U);
    while (count < windows) {
        const int32_t sample = (int32_t)floor((1000.0 * filtered_noise_next(&noise, 1.0)) + 0.5);
        davar_push_q31(&davar, &sample, 1U);
        if (davar_take(&davar, &result) && (result.window_samples >= shortest)) {
            count++;
            bad += result.unstable ? 1.0 : 0.0;
        }
    }
    return bad;
}

/* Steps in white noise after which the law is unstable in a tenth more of 600 samples than
 * before. */
static double noticed(double ratio, double stated, uint64_t seed)
{
    const shape_t none = {.poles = 0U};
    double count = 0.0;
    filtered_noise_start(&noise, &none, seed + 3U);
    for (uint32_t t = 0U; t < UNSTABLE_TRIALS; t++) {
        double bad[2] = {0.0, 0.0};
        start_law(&none, &davar_law_or, 400U, 600U, stated);
        for (uint32_t i = 0U; i < 1800U; i++) {
            const double size = 1000.0 * ((i < 1200U) ? 1.0 : ratio);
            const int32_t sample = (int32_t)floor((size * filtered_noise_next(&noise, 1.0)) + 0.5);
            davar_push_q31(&davar, &sample, 1U);
            if (davar_take(&davar, &result) && (i >= 600U)) {
                bad[(i < 1200U) ? 0U : 1U] += result.unstable ? (1.0 / 600.0) : 0.0;
            }
        }
        count += (bad[1] > (bad[0] + 0.1)) ? 1.0 : 0.0;
    }
    return count;
}

/* The price of a stated rate, and other rates. */
static void run_white(const shape_t *filter, unsigned trials, uint64_t seed)
{
    static const struct {
        double ratio;
        const char *holds;
    } steps[] = {{1.5, "stated 20:40, paper 74:90"},
                 {2.0, "stated 95:, paper 90:"},
                 {2.5, "stated 97:, paper 90:"},
                 {3.0, "stated 97:, paper 90:"}};
    static const struct {
        const char *name;
        const davar_law_t *law;
        const char *holds;
    } laws[] = {{"kurtosis", &davar_law_kurtosis, "10% 7.5:11.5, 3% 2:3.6, 0.3% 0.1:0.4"},
                {"or", &davar_law_or, "10% 7.5:11, 3% 2:3.3, 0.3% 0.1:0.4"},
                {"and", &davar_law_and, "10% :11, 3% :3, 0.3% :0.3"}};
    for (size_t i = 0U; i < COUNT_OF(steps); i++) {
        share("stated", noticed(steps[i].ratio, 0.01, seed), UNSTABLE_TRIALS);
        share("paper", noticed(steps[i].ratio, 0.0, seed), UNSTABLE_TRIALS);
        label("noticed x%.1f", steps[i].ratio);
        report(steps[i].holds);
    }
    for (size_t l = 0U; l < COUNT_OF(laws); l++) {
        share("10%", unstable(filter, laws[l].law, 600U, 600U, 0.1, trials, seed), trials);
        share("3%", unstable(filter, laws[l].law, 600U, 600U, 0.03, trials, seed), trials);
        share("0.3%", unstable(filter, laws[l].law, 600U, 600U, 0.003, trials, seed), trials);
        label("%s", laws[l].name);
        report(laws[l].holds);
    }
}

static void run_unstable(const void *of, unsigned trials, uint64_t seed)
{
    const case_t *const row = of;
    const shape_t *const filter = &row->filter;
    const davar_law_t *const law = &davar_law_or;
    const uint32_t loop = 33U * trials;
    share("400", unstable(filter, law, 400U, 400U, 0.01, trials, seed), trials);
    share("600", unstable(filter, law, 600U, 600U, 0.01, trials, seed), trials);
    share("2000", unstable(filter, law, 2000U, 2000U, 0.01, trials, seed), trials);
    share("paper", unstable(filter, law, 400U, 400U, 0.0, trials, seed), trials);
    value("loop", 100.0 * unstable(filter, law, 400U, 600U, 0.01, loop, seed) / loop, 0.0);
    label("%s", row->name);
    report("400 0.4:0.85, 600 0.6:1.2, 2000 0.8:1.4, paper 18:60, loop :0.5");
    if (row == &cases[WHITE_CASE]) {
        run_white(filter, trials, seed);
    }
}

const experiment_t unstable_experiment = {ROWS(cases), run_unstable};
