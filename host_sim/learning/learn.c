/* davar-sim - learning the filter: the ARMA model that explains the median spectrum with the fewest
 * numbers, and how well it knows the white noise before the filter. */
#include "learning/learn.h"
#include "learning/arma.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define PI 3.14159265358979324

/* The window and the line that was removed change the ordinates below this one. */
#define FIRST 2U

/* Variance of an ordinate of the median spectrum, times the segments: that of the median of
 * exponentials, and of segments that overlap by half. */
#define ORDINATE_VARIANCE 2.2

/* Variance of a mean over neighbouring ordinates, over that of independent ones: the window. */
#define NEIGHBOURS 1.944

#define BIN_SHARE 16U /* a bin of the fit holds so large a part of its ordinate's number, */
#define BIN_MOST 6U   /* and no more ordinates than this: a zero at half the rate is narrow */

/* Orders that are tried after the best one. */
#define PATIENCE 2U

/* The widest low-passes that a claim of no filter must exclude: they change N by 3 %. */
#define WIDE_1_POLE 0.6
#define WIDE_2_POLES 0.5
#define EXCLUDED 2.0 /* two standard errors, as log-likelihood */

/* Moving averages that are tried, in series and samples of each, and what their number costs in
 * log-likelihood. */
#define AVERAGES_MOST 3U
#define LENGTH_MOST 64U
#define LOG_LENGTHS 5.0

/* Of ln of the white noise: a model that leaves more open describes a drift. */
#define APART_MOST 0.5

#define LEVEL_MOST 0.1 /* standard uncertainty of ARW that is worth declaring */

#define LINE_REACH 17U /* a line is compared with this part of the spectrum on each side */
#define REACH_MOST (SPECTRUM_MOST / LINE_REACH)
#define LINE_SIGMAS 5.0 /* by which it exceeds its neighbours */
#define LINE_EXCESS 1.1 /* ... and the model */
#define TRIMS 6U

#define BAND 10U
#define TOLERANCE 0.02     /* of the spectrum in a band */
#define MISFIT_NORMAL 3.09 /* one-sided 0.1 % */

typedef struct {
    double power[SPECTRUM_MOST];
    bool used[SPECTRUM_MOST];
    size_t ordinates;
    double sigma;         /* relative standard error of an ordinate */
    double weight;        /* independent ordinates for each */
    double rounding;      /* variance */
    davar_filter_t known; /* before which the models are; all zeros: none */
} data_t;

static double angle_of(const data_t *data, size_t j)
{
    return PI * (double)(j + 1U) / (double)(data->ordinates + 1U);
}

static double model_at(const data_t *data, const arma_t *model, size_t j)
{
    const double angle = angle_of(data, j);
    const double known = davar_filter_power(&data->known, angle / (2.0 * PI));
    return arma_spectrum(model, angle, known, data->rounding);
}

/* --- lines --- */

static double median_around(const data_t *data, size_t j)
{
    double sorted[2U * REACH_MOST + 1U] = {0};
    const size_t reach = data->ordinates / LINE_REACH;
    const size_t last = data->ordinates - (2U * reach) - 1U;
    size_t first = (j > FIRST + reach) ? (j - reach) : FIRST;
    first = (first < last) ? first : last;
    for (size_t i = 0; i <= 2U * reach; i++) {
        size_t at = i;
        for (; (at > 0U) && (sorted[at - 1U] > data->power[first + i]); at--) {
            sorted[at] = sorted[at - 1U];
        }
        sorted[at] = data->power[first + i];
    }
    return sorted[reach];
}

/* Leaves out an ordinate and those that the window mixes with it. */
static void leave_out(data_t *data, size_t j)
{
    for (size_t i = (j > 2U) ? (j - 2U) : 0U; (i <= j + 2U) && (i < data->ordinates); i++) {
        data->used[i] = false;
    }
}

/* Lines that stand out from their neighbours. A spectrum that falls has the median of its
 * neighbours in the middle; near its ends only the upper one is without a middle. */
static void leave_lines_out(data_t *data)
{
    const double most = 1.0 + LINE_SIGMAS * data->sigma;
    for (size_t j = 0; j < data->ordinates; j++) {
        data->used[j] = (j >= FIRST);
    }
    for (size_t j = FIRST + (data->ordinates / LINE_REACH); j < data->ordinates; j++) {
        if (data->power[j] > most * median_around(data, j)) {
            leave_out(data, j);
        }
    }
}

/* Wide lines, which exceed the model. False: there are none. */
static bool trim(data_t *data, const arma_t *model)
{
    const double most = fmax(LINE_EXCESS, 1.0 + (LINE_SIGMAS - 1.0) * data->sigma);
    const data_t before = *data;
    bool any = false;
    for (size_t j = FIRST; j < data->ordinates; j++) {
        if (before.used[j] && (before.power[j] > most * model_at(data, model, j))) {
            leave_out(data, j);
            any = true;
        }
    }
    return any;
}

static size_t count_used(const data_t *data)
{
    size_t used = 0;
    for (size_t j = FIRST; j < data->ordinates; j++) {
        used += data->used[j] ? 1U : 0U;
    }
    return used;
}

/* --- the models --- */

/* Means over neighbours: the fit needs no more, and is faster. */
static void fill_bins(const data_t *data, arma_data_t *bins)
{
    bins->count = 0U;
    bins->rounding = data->rounding;
    bins->is_steady = false;
    for (size_t j = FIRST; j < data->ordinates;) {
        const size_t more = j / BIN_SHARE;
        const size_t end = j + ((more < BIN_MOST) ? (more + 1U) : BIN_MOST);
        arma_bin_t bin = {.known = 1.0};
        double inside = 0.0;
        for (; (j < end) && (j < data->ordinates); j++) {
            if (data->used[j]) {
                bin.angle += angle_of(data, j);
                bin.power += data->power[j];
                inside += 1.0;
            }
        }
        if ((inside > 0.0) && (bins->count < ARMA_BINS_MOST)) {
            bin.angle /= inside;
            bin.power = fmax(bin.power / inside, 1e-300);
            bin.weight = inside * data->weight;
            bins->bin[bins->count] = bin;
            bins->count++;
        }
    }
    arma_turn(bins);
}

/* Bayes' criterion, in units of log-likelihood. */
static double criterion(const arma_data_t *bins, const arma_t *model)
{
    double independent = 0.0;
    for (size_t i = 0U; i < bins->count; i++) {
        independent += bins->bin[i].weight;
    }
    return model->loss + 0.5 * (1.0 + 2.0 * model->order) * log(fmax(independent, 1.0));
}

typedef struct {
    arma_t model[ARMA_ORDER_MOST + 1U];
    double criterion[ARMA_ORDER_MOST + 1U];
    arma_t drifting[ARMA_ORDER_MOST + 1U]; /* with the drifts, although they may gain little */
    unsigned count;                        /* orders that were tried */
    unsigned best;
} models_t;

static void fit_models(const arma_data_t *bins, models_t *models)
{
    models->count = 0U;
    models->best = 0U;
    for (unsigned p = 0U; (p <= ARMA_ORDER_MOST) && (p <= models->best + PATIENCE); p++) {
        arma_fit(bins, p, (p > 0U) ? &models->model[p - 1U] : NULL, &models->model[p]);
        models->drifting[p] = models->model[p];
        if ((models->model[p].loss < HUGE_VAL) && !bins->is_steady) {
            const arma_t steady = arma_steady(bins, &models->model[p]);
            const bool is_better = steady.loss < models->model[p].loss + EXCLUDED;
            models->model[p] = is_better ? steady : models->model[p];
        }
        models->criterion[p] = criterion(bins, &models->model[p]);
        models->best = (models->criterion[p] < models->criterion[models->best]) ? p : models->best;
        models->count = p + 1U;
    }
}

/* Akaike's criterion, in units of log-likelihood. */
static double akaike(const arma_t *model)
{
    const unsigned drifts = (model->number[1] > 0.0 ? 1U : 0U) + (model->number[2] > 0.0 ? 1U : 0U);
    return model->loss + (double)(2U * model->order + drifts);
}

/* Relative standard uncertainty of the angle random walk, half that of the white noise: the mean
 * over all models, with the weights that Akaike's criterion gives them, because the one with the
 * fewest numbers may be too simple. */
static double level_of(const models_t *models)
{
    const arma_t *const best = &models->model[models->best];
    double sum = 0.0;
    double weights = 0.0;
    for (unsigned i = 0U; i < 2U * models->count; i++) {
        const arma_t *const model =
            (i % 2U == 0U) ? &models->model[i / 2U] : &models->drifting[i / 2U];
        const double weight = exp(akaike(best) - akaike(model));
        const double apart = fmin(fabs(model->number[0] - best->number[0]), APART_MOST);
        const double sigma = fmin(model->sigma, APART_MOST);
        sum += weight * (sigma * sigma + apart * apart);
        weights += weight;
    }
    return 0.5 * sqrt(sum / weights);
}

/* The loss with a filter that is given. */
static double loss_after(const arma_data_t *bins, const davar_filter_t *filter, arma_t *model)
{
    arma_data_t passed = *bins;
    for (size_t i = 0U; i < bins->count; i++) {
        passed.bin[i].known *= davar_filter_power(filter, bins->bin[i].angle / (2.0 * PI));
    }
    arma_fit(&passed, 0U, NULL, model);
    return criterion(bins, model);
}

void learn_choose(const arma_data_t *bins, learn_choice_t *choice)
{
    models_t models;
    fit_models(bins, &models);
    const double least = models.criterion[models.best];
    *choice = (learn_choice_t){.model = models.model[models.best], .criterion = least};
    if (choice->model.order > 0U) {
        arma_filter(&choice->model, &choice->filter);
        choice->filter.level = fmin(level_of(&models), 0.5);
    }
    /* Moving averages have more zeros than a model: the best of them alone. */
    for (unsigned order = 1U; order <= AVERAGES_MOST; order++) {
        for (unsigned length = 2U; length <= LENGTH_MOST; length++) {
            davar_filter_t filter = {.b = {0.0}};
            arma_t model;
            davar_filter_average(&filter, order, length);
            const double found = loss_after(bins, &filter, &model) + LOG_LENGTHS;
            if (found < choice->criterion) {
                *choice = (learn_choice_t){filter, order, length, model, found};
            }
        }
    }
}

/* --- the misfit --- */

/* Upper 0.1 % of chi-square, after Wilson and Hilferty. */
static double chi_square_most(double freedom)
{
    const double part = 2.0 / (9.0 * freedom);
    const double root = 1.0 - part + MISFIT_NORMAL * sqrt(part);
    return freedom * root * root * root;
}

/* Does the mean over any bands differ from the model by more than chance and the tolerance? */
static bool misfits(const data_t *data, const arma_t *model)
{
    const double variance = 1.0 / ((double)BAND * data->weight) + TOLERANCE * TOLERANCE;
    double sum = 0.0;
    double mean = 0.0;
    size_t inside = 0;
    size_t bands = 0;
    for (size_t j = FIRST; j < data->ordinates; j++) {
        if (data->used[j]) {
            mean += data->power[j] / model_at(data, model, j) / (double)BAND;
            inside++;
        }
        if (inside == BAND) {
            sum += (mean - 1.0) * (mean - 1.0) / variance;
            bands++;
            mean = 0.0;
            inside = 0;
        }
    }
    return sum > chi_square_most((double)bands);
}

/* --- what is learned --- */

/* Does the spectrum exclude every filter that matters? */
static bool is_white(const data_t *data, const arma_t *white)
{
    arma_data_t bins;
    davar_filter_t narrow[2] = {{.b = {0.0}}, {.b = {0.0}}};
    bool excluded = true;
    fill_bins(data, &bins);
    davar_filter_low_pass(&narrow[0], WIDE_1_POLE, 1U, 0.0);
    davar_filter_low_pass(&narrow[1], WIDE_2_POLES, 2U, 0.0);
    for (int i = 0; i < 2; i++) {
        arma_t model;
        (void)loss_after(&bins, &narrow[i], &model);
        excluded = excluded && (model.loss > white->loss + EXCLUDED);
    }
    return excluded;
}

static learned_t judge(const data_t *data, const learn_choice_t *choice)
{
    learned_t learned = {.status = LEARN_FOUND,
                         .filter = choice->filter,
                         .averages = choice->averages,
                         .length = choice->length};
    const bool is_filtered = (choice->averages > 0U) || (choice->model.order > 0U);
    if (misfits(data, &choice->model)) {
        learned.status = LEARN_MISFIT;
    } else if (!is_filtered) {
        learned.status = is_white(data, &choice->model) ? LEARN_NONE : LEARN_WIDE;
    } else if (learned.filter.level > LEVEL_MOST) {
        learned.status = LEARN_VAGUE;
    } else {
        /* found */
    }
    return learned;
}

/* Fits, and leaves out what exceeds the fit, as a wide line does, until nothing does. */
static learned_t learn(data_t *data)
{
    learn_choice_t choice;
    leave_lines_out(data);
    for (size_t i = 0; i <= TRIMS; i++) {
        arma_data_t bins;
        if (3U * count_used(data) < 2U * data->ordinates) {
            return (learned_t){.status = LEARN_MISFIT};
        }
        fill_bins(data, &bins);
        learn_choose(&bins, &choice);
        data->known = (choice.averages > 0U) ? choice.filter : (davar_filter_t){.b = {0.0}};
        if ((i == TRIMS) || !trim(data, &choice.model)) {
            break;
        }
    }
    return judge(data, &choice);
}

learned_t learn_filter(spectrum_t *spectrum, double rounding)
{
    const size_t given = spectrum->count;
    data_t data = {.ordinates = spectrum->ordinates, .rounding = rounding};
    const size_t segments = spectrum_median(spectrum, data.power);
    learned_t learned = {.status = LEARN_SHORT};
    if ((segments == 0U) && (given >= LEARN_SEGMENTS_LEAST)) {
        learned.status = LEARN_CONSTANT;
    } else if (segments >= LEARN_SEGMENTS_LEAST) {
        data.sigma = sqrt(ORDINATE_VARIANCE / (double)segments);
        data.weight = 1.0 / (NEIGHBOURS * data.sigma * data.sigma);
        learned = learn(&data);
    }
    learned.segments = segments;
    learned.segment = spectrum->segment;
    return learned;
}

bool learn_knows(const learned_t *learned)
{
    return (learned->status == LEARN_FOUND) || (learned->status == LEARN_NONE);
}

/* --- in words --- */

/* The frequency over the rate from which on the power is below half; 0.5: none. */
static double half_power(const davar_filter_t *filter)
{
    double frequency = 0.0;
    while ((frequency < 0.5) && (davar_filter_power(filter, fmin(frequency, 0.5)) > 0.5)) {
        frequency += 0.0005;
    }
    return frequency;
}

void learn_describe(const learned_t *learned, double rate_hz, char text[LEARN_TEXT])
{
    static const char *const WORDS[] = {
        [LEARN_NOTHING] = "filter unknown",
        [LEARN_FOUND] = "",
        [LEARN_NONE] = "white up to half the sample rate, no filter",
        [LEARN_VAGUE] = "filter unknown: the spectrum leaves open how much noise there is before "
                        "it; record longer at rest",
        [LEARN_WIDE] = "filter unknown: the recording is white but too short to exclude a wide "
                       "low-pass",
        [LEARN_MISFIT] = "filter unknown: no filter of up to 8 poles explains the spectrum, for "
                         "example of vibration, or of a narrow filter in coarse counts",
        [LEARN_SHORT] = "filter unknown: it needs 4352 samples at rest without gaps",
        [LEARN_CONSTANT] = "filter unknown: the signal does not change",
    };
    if (learned->status != LEARN_FOUND) {
        (void)snprintf(text, LEARN_TEXT, "%s", WORDS[learned->status]);
        return;
    }
    if (learned->averages > 0U) {
        (void)snprintf(text, LEARN_TEXT, "%u moving averages of %u samples", learned->averages,
                       learned->length);
        return;
    }
    const double half = half_power(&learned->filter);
    const double percent = 100.0 * learned->filter.level;
    if (half < 0.5) {
        (void)snprintf(text, LEARN_TEXT, "a filter with -3 dB at %.3g Hz (ARW known to %.2g %%)",
                       half * rate_hz, percent);
    } else {
        (void)snprintf(text, LEARN_TEXT,
                       "a filter that passes half the rate (ARW known to %.2g %%)", percent);
    }
}

/* Appends to the text. */
static void append(char text[LEARN_TEXT], const char *format, ...)
{
    const size_t used = strlen(text);
    va_list values;
    va_start(values, format);
    (void)vsnprintf(text + used, LEARN_TEXT - used, format, values);
    va_end(values);
}

static void append_list(char text[LEARN_TEXT], const double c[], unsigned first, unsigned last)
{
    for (unsigned k = first; k <= last; k++) {
        append(text, "%s%.17g", (k > first) ? "," : ":", c[k]);
    }
}

void learn_option(const learned_t *learned, char text[LEARN_TEXT])
{
    const davar_filter_t *const filter = &learned->filter;
    unsigned order = ARMA_ORDER_MOST;
    text[0] = '\0';
    if (learned->status == LEARN_NONE) {
        append(text, "none");
    } else if (learned->averages > 0U) {
        append(text, "average%u:%u", learned->averages, learned->length);
    } else if (learned->status == LEARN_FOUND) {
        while ((order > 1U) && !(fabs(filter->a[order]) + fabs(filter->b[order]) > 0.0)) {
            order--;
        }
        append(text, "ba");
        append_list(text, filter->b, 0U, order);
        append_list(text, filter->a, 1U, order);
        append(text, ":%.2g", 100.0 * filter->level);
    }
}
