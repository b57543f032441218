/* The detector of changes: how often it alarms without a change, and its delay after one. Noise of
 * known kind through lib/src/laws; 100 Hz and sigma 20 counts. */
#include "davar/filter.h"
#include "filter_cases.h"
#include "filtered_noise.h"
#include "heavy_noise.h"
#include "laws/glr.h"
#include "statistics.h"

#include <stdlib.h>
#include <string.h>

#define RATE_HZ 100U
#define SIGMA 20.0
#define BLOCK 10U

typedef struct {
    davar_glr_t state;
    davar_glr_config_t config;
    davar_glr_event_t event;
    int32_t first; /* coefficients of whitening (10.16) */
    int32_t second;
    int32_t before;
    int32_t earlier;
    bool has_past;
    int32_t sum;
    uint64_t squares;
    uint32_t count;
    /* of a whole record */
    uint64_t samples; /* that it gets */
    double sigma;     /* counts */
    double alarms;
    double cuts;
    double dispersion; /* sum over blocks */
} detector_t;

/* assumed: the filter for whitening, or NULL. */
static void start(detector_t *detector, const shape_t *assumed, double rate_hz, double per_hour,
                  double sigma)
{
    const davar_glr_wish_t wish = {rate_hz, per_hour, 300.0, 6000U, BLOCK, 2U};
    config = davar_default_config;
    memset(detector, 0, sizeof *detector);
    if (assumed != NULL) {
        whiten_shape(&config, assumed);
    }
    davar_glr_start(&detector->config, &wish);
    detector->config.floor =
        davar_glr_floor(BLOCK, config.glr.whiten_first, config.glr.whiten_second);
    davar_glr_reset(&detector->state);
    detector->first = config.glr.whiten_first;
    detector->second = config.glr.whiten_second;
    detector->sigma = sigma;
}

/* A number in counts. True at the end of a block, which has an event. */
static bool push(detector_t *d, double number)
{
    const int32_t sample = (int32_t)fmax(-32768.0, fmin(32767.0, floor(number + 0.5)));
    d->before = d->has_past ? d->before : sample;
    d->earlier = d->has_past ? d->earlier : sample;
    d->has_past = true;
    const int32_t rest =
        sample - (((d->first * d->before) + (d->second * d->earlier) + 8192) >> 14U);
    d->earlier = d->before;
    d->before = sample;
    d->sum += rest;
    d->squares += (uint64_t)((int64_t)rest * rest);
    d->count++;
    if (d->count < d->config.block) {
        return false;
    }
    davar_glr_push_q15(&d->state, &d->config, d->sum, d->squares, &d->event);
    d->sum = 0;
    d->squares = 0U;
    d->count = 0U;
    return true;
}

/* ---- noise of any kind, or after a filter ---- */

static const noise_kind_t *kind; /* NULL: after a filter */
static source_t source;
static filtered_noise_t filtered;

static double next(double size)
{
    return (kind != NULL) ? (size * kind->next(&source)) : filtered_noise_next(&filtered, size);
}

/* The part of a count at which the noise lies. */
static double any_mean(void)
{
    return (kind != NULL) ? 0.0 : random_uniform(&filtered.random);
}

/* Detectors in the same noise. */
static void watch(detector_t detectors[], size_t count)
{
    const double mean = any_mean();
    uint64_t most = 0U;
    for (size_t d = 0U; d < count; d++) {
        most = (detectors[d].samples > most) ? detectors[d].samples : most;
    }
    for (uint64_t i = 0U; i < most; i++) {
        const double now = next(1.0);
        for (size_t d = 0U; d < count; d++) {
            detector_t *const one = &detectors[d];
            if ((i < one->samples) && push(one, mean + (one->sigma * now))) {
                one->alarms += one->event.is_alarm ? 1.0 : 0.0;
                one->cuts += one->event.is_cut ? 1.0 : 0.0;
                one->dispersion += davar_glr_dispersion(&one->state, GLR_TYPICAL) / 4096.0;
            }
        }
    }
}

typedef struct {
    uint32_t count;
    uint32_t quiet;    /* samples before a step */
    uint32_t patience; /* samples after it */
    double per_hour;
    double sigma; /* counts */
} steps_t;

/* Seconds from a step to the alarm: the median, and of nine in ten. */
static double median_delay(const steps_t *steps, const shape_t *assumed, double ratio, double *nine)
{
    static detector_t detector;
    static double delays[800];
    random_t *const random = (kind != NULL) ? &source.random : &filtered.random;
    for (uint32_t t = 0U; t < steps->count; t++) {
        start(&detector, assumed, RATE_HZ, steps->per_hour, steps->sigma);
        const double mean = any_mean();
        const uint32_t quiet = steps->quiet + (uint32_t)(random_next(random) % 5120U);
        for (uint32_t i = 0U; i < quiet; i++) {
            (void)push(&detector, mean + (steps->sigma * next(1.0)));
        }
        uint32_t i = 1U;
        while ((i < steps->patience) &&
               !(push(&detector, mean + (steps->sigma * next(ratio))) && detector.event.is_alarm)) {
            i++;
        }
        delays[t] = (double)i / RATE_HZ;
    }
    qsort(delays, steps->count, sizeof delays[0], ascending);
    *nine = delays[(steps->count * 9U) / 10U];
    return delays[steps->count / 2U];
}

/* ---- noise of every kind ---- */

static double half(source_t *gauss)
{
    return noise_gauss(gauss) * 0.5 / SIGMA;
}

static void start_kind(const char *name, uint64_t seed)
{
    static const noise_kind_t half_kind = {"half", half};
    kind = &half_kind;
    for (size_t i = 0U; i < NOISE_KINDS; i++) {
        kind = (strcmp(name, noise_kinds[i].name) == 0) ? &noise_kinds[i] : kind;
    }
    source = source_seeded(seed);
}

/* A row of the table of rates, in which `trials` are hours. Alarms over the stated ones, at 0.1 and
 * at 1 per hour. Delays at 0.01 per hour: at most 1.3 times the median without the last term of
 * (10.3). */
typedef struct {
    const char *name;
    const char *holds;
    const char *in_time;
} rates_row_t;

static const rates_row_t rates_rows[] = {
    {"gauss", "0.1/h 0.75:1.1, 1/h 0.9:1.25, cuts 11.5:13.5, f 1.02:1.06",
     "x1.5 0.9:1.2, x2 "
     "0.35:0.5"},
    {"laplace", "0.1/h 0.1:0.35, 1/h 0.2:0.38, f 2.9:3.3", "x1.5 2.4:3.17, x2 0.95:1.13"},
    {"student5", "0.1/h 0.3:0.65, 1/h 0.3:0.7, f 3.1:3.6", "x1.5 2.6:3.35, x2 0.95:1.1"},
    {"student3", "0.1/h 0.1:0.35, 1/h 0.05:0.13, f 10:10.8", "x1.5 7.2:10.27, x2 2.5:2.95"},
    {"mixed", "0.1/h 0.1:0.35, 1/h 0.15:0.33, f 11.5:12.7", "x1.5 9.3:13.26, x2 3.5:4.7"},
    {"ar", "0.1/h 0.6:1.05, 1/h 0.7:1.2, f 1.6:1.8", "x1.5 1.5:2.06, x2 0.52:0.68"},
    {"half", "0.1/h :0.4, 1/h :0.5", NULL},
};

static void count_hours(detector_t *detector, double hours, double per_hour)
{
    start(detector, NULL, RATE_HZ, per_hour, SIGMA);
    detector->samples = (uint64_t)(hours * 3600.0 * RATE_HZ);
}

static void run_rates(const void *of, unsigned trials, uint64_t seed)
{
    static const steps_t steps = {800U, 12000U, 100000U, 0.01, SIGMA};
    static detector_t detectors[2];
    const rates_row_t *const row = of;
    double nine;
    count_hours(&detectors[0], trials, 0.1);
    count_hours(&detectors[1], trials, 1.0);
    start_kind(row->name, seed);
    watch(detectors, 2U);
    rate("0.1/h", detectors[0].alarms, 0.1 * trials);
    rate("1/h", detectors[1].alarms, trials);
    value("cuts", detectors[0].cuts / trials, 0.1);
    value("f", detectors[0].dispersion * BLOCK / (double)detectors[0].samples, 0.0);
    label("%s", row->name);
    report(row->holds);
    if (row->in_time != NULL) {
        for (size_t i = 0U; i < 2U; i++) {
            start_kind(row->name, seed + 1U);
            value((i == 0U) ? "x1.5" : "x2",
                  median_delay(&steps, NULL, (i == 0U) ? 1.5 : 2.0, &nine), 0.0);
        }
        report(row->in_time);
    }
}

#define OFTEN 4U /* rows that tools/test runs */
const experiment_t rates_experiment = {rates_rows, sizeof rates_rows[0], OFTEN, run_rates};
const experiment_t rates_other_experiment = {&rates_rows[OFTEN], sizeof rates_rows[0],
                                             COUNT_OF(rates_rows) - OFTEN, run_rates};

/* The kinds with the most alarms, at a low rate. */
static const char *const rare_rows[] = {"student5, student3"};

static void run_rare(const void *of, unsigned trials, uint64_t seed)
{
    static const char *const names[] = {"student5", "student3"};
    static detector_t detector;
    double all = 0.0;
    for (size_t i = 0U; i < COUNT_OF(names); i++) {
        count_hours(&detector, trials, 0.02);
        start_kind(names[i], seed);
        watch(&detector, 1U);
        rate("0.02/h", detector.alarms, 0.02 * trials);
        all += detector.alarms;
    }
    rate("both", all, 0.04 * trials);
    label("%s", *(const char *const *)of);
    report("0.02/h 0.6:1.1, both 0.7:1.05");
}

const experiment_t rates_rare_experiment = {ROWS(rare_rows), run_rare};

/* ---- after a filter, whitened (10.16) ---- */

#define LSB_PER_SIGMA 30.0

typedef struct {
    const char *name;
    double rate_hz;
    double per_hour;
    double hours; /* of 150 at 100 Hz */
    double wrong; /* factor of the assumed cutoff */
} setting_t;

static const setting_t settings[] = {{"100Hz", 100.0, 1.0, 150.0, 1.0},
                                     {"1kHz", 1000.0, 5.0, 20.0, 1.0},
                                     {"8kHz", 8000.0, 20.0, 3.0, 1.0},
                                     {"low", 100.0, 1.0, 150.0, 0.8},
                                     {"high", 100.0, 1.0, 150.0, 1.2}};
#define SETTINGS COUNT_OF(settings)

static void start_filter(const shape_t *filter, uint64_t seed)
{
    kind = NULL;
    filtered_noise_start(&filtered, filter, seed);
}

/* `trials`: hours at 100 Hz. Reports alarms over the stated ones; of `all`: of the first three. */
static void count_whitened(const shape_t *filter, size_t used, unsigned trials, uint64_t seed)
{
    static detector_t detectors[SETTINGS];
    double stated[SETTINGS];
    start_filter(filter, seed);
    for (size_t s = 0U; s < used; s++) {
        const double hours = settings[s].hours * trials / 150.0;
        shape_t assumed = *filter;
        assumed.cutoff *= settings[s].wrong;
        start(&detectors[s], &assumed, settings[s].rate_hz, settings[s].per_hour, LSB_PER_SIGMA);
        stated[s] = hours * settings[s].per_hour;
        detectors[s].samples = (uint64_t)(hours * 3600.0 * settings[s].rate_hz);
    }
    watch(detectors, used);
    for (size_t s = 0U; s < used; s++) {
        rate(settings[s].name, detectors[s].alarms, stated[s]);
    }
    rate("all", detectors[0].alarms + detectors[1].alarms + detectors[2].alarms,
         stated[0] + stated[1] + stated[2]);
}

/* Seconds from a change of 1.5 to the alarm at 100 Hz and one false alarm in 2 h. */
static double step_delay(const shape_t *filter, const shape_t *assumed, uint64_t seed, double *nine)
{
    static const steps_t steps = {200U, 4000U, 6000U, 0.5, LSB_PER_SIGMA};
    start_filter(filter, seed + 1U);
    return median_delay(&steps, assumed, 1.5, nine);
}

static void run_whitened(const void *of, unsigned trials, uint64_t seed)
{
    const case_t *const row = of;
    const size_t used = (row->filter.poles > 0U) ? SETTINGS : 3U;
    double nine[2];
    count_whitened(&row->filter, used, trials, seed);
    label("%s", row->name);
    report("100Hz 0.9:1.25, 1kHz 0.9:1.25, 8kHz 0.9:1.25, all 0.9:1.25, low? 0.9:1.3, "
           "high? 0.9:1.3");
    const double whitened = step_delay(&row->filter, &row->filter, seed, &nine[0]);
    const double plain = step_delay(&row->filter, NULL, seed, &nine[1]);
    value("delay", whitened, 0.0);
    value("nine", nine[0], 0.0);
    value("plain", plain, 0.0);
    value("plain.nine", nine[1], 0.0);
    value("ratio", whitened / plain, 0.0); /* three standard errors of two medians: 0.27 */
    report("delay 0.6:1.2, nine 1:2.1, ratio :1.3");
    for (size_t s = 3U; s < used; s++) {
        shape_t assumed = row->filter;
        assumed.cutoff *= settings[s].wrong;
        value("delay", step_delay(&row->filter, &assumed, seed, nine), 0.0);
        label("%s", settings[s].name);
        report("delay 0.6:1.2");
    }
}

const experiment_t whitened_experiment = {ROWS(cases), run_whitened};

/* Coarse counts: the rate becomes 0. In between, correlation that whitening leaves is hidden from the
 * dispersion: the average of 8 has up to twice the stated alarms. */
typedef struct {
    const char *name;
    const char *holds;
    size_t filter;
} coarse_t;

static const coarse_t coarse_rows[] = {
    {"1 pole 0.05", "10 0.7:1.25, 3 0.4:1.1, 1 :0.1", 1U},
    {"2 poles 0.05", "10 :0.4, 3 :0.1, 1 :0.1", NARROW_CASE},
    {"2 poles 0.1", "10 0.6:1.25, 3 :0.2, 1 :0.1", LESS_NARROW_CASE},
    {"average of 8", "10 0.8:1.5, 3 1.2:2, 1 :0.1", 9U}};

static void run_coarse(const void *of, unsigned trials, uint64_t seed)
{
    static const double sigmas[] = {10.0, 3.0, 1.0, 0.5, 0.3}; /* counts */
    static const char *const names[] = {"10", "3", "1", "0.5", "0.3"};
    static detector_t detectors[COUNT_OF(sigmas)];
    const coarse_t *const row = of;
    const shape_t *const filter = &cases[row->filter].filter;
    start_filter(filter, seed);
    for (size_t s = 0U; s < COUNT_OF(sigmas); s++) {
        start(&detectors[s], filter, RATE_HZ, 1.0, sigmas[s]);
        detectors[s].samples = UINT64_C(360000) * trials;
    }
    watch(detectors, COUNT_OF(sigmas));
    for (size_t s = 0U; s < COUNT_OF(sigmas); s++) {
        rate(names[s], detectors[s].alarms, trials);
    }
    label("%s", row->name);
    report(row->holds);
}

const experiment_t whitened_coarse_experiment = {ROWS(coarse_rows), run_coarse};
