/* davar-sim - learning the filter: Whittle's likelihood of the median spectrum for each filter of a
 * family, with a flicker and a random walk that pass the filter, and rounding after it. */
#include "learning/learn.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define M SPECTRUM_ORDINATES
#define PI 3.14159265358979324

/* The window and the line that was removed change the ordinates below this one. */
#define FIRST 5U

/* Variance of an ordinate of the median spectrum, times the segments: that of the median of
 * exponentials, and of segments that overlap by half. */
#define ORDINATE_VARIANCE 2.2

/* Variance of a mean over neighbouring ordinates, over that of independent ones: the window. */
#define NEIGHBOURS 1.944

#define TERMS 3U    /* white noise, flicker, random walk */
#define ROUNDS 100U /* of the fit of their powers */

#define CUTOFF_LEAST 0.01
#define GRID 24U
#define STEPS 16U /* of the golden section */
#define AVERAGES_MOST 3U
#define LENGTH_MOST 8U

/* In units of log-likelihood: an explanation that is less simple must gain so much. */
#define GAIN 4.0

#define LINE_REACH 15U  /* ordinates on each side that a line is compared with */
#define LINE_SIGMAS 5.0 /* by which it exceeds them */
#define LINE_EXCESS 1.1 /* ... and the model */
#define TRIMS 6U
#define LINES_MOST (M / 4U)

#define BAND 10U
#define TOLERANCE 0.03      /* of the spectrum in a band */
#define MISFIT_NORMAL 3.09  /* one-sided 0.1 % */
#define UNCERTAINTY_LEAST 0.01
#define UNCERTAINTY_MOST 0.5

typedef struct {
    double power[M];
    bool used[M];
    double weight; /* 1 / relative variance of an ordinate */
    double rounding;
} data_t;

typedef struct {
    davar_filter_t filter;
    double part[TERMS];
    double loss; /* negative log-likelihood */
    double model[M];
} fit_t;

static double angle(size_t j)
{
    return 2.0 * PI * (double)(j + 1U) / (double)SPECTRUM_SEGMENT;
}

/* --- the likelihood of one filter --- */

static void evaluate(const data_t *data, double (*shape)[M], fit_t *fit)
{
    fit->loss = 0.0;
    for (size_t j = FIRST; j < M; j++) {
        fit->model[j] = data->rounding;
        for (size_t k = 0; k < TERMS; k++) {
            fit->model[j] += fit->part[k] * shape[k][j];
        }
        if (data->used[j]) {
            const double ratio = data->power[j] / fit->model[j];
            fit->loss += data->weight * (ratio - 1.0 - log(ratio));
        }
    }
}

/* Multiplicative updates keep the powers positive and need no matrix. */
static void improve(const data_t *data, double (*shape)[M], fit_t *fit)
{
    for (size_t k = 0; k < TERMS; k++) {
        double above = 0.0;
        double under = 0.0;
        for (size_t j = FIRST; j < M; j++) {
            if (data->used[j]) {
                const double slope = shape[k][j] / fit->model[j];
                above += slope * data->power[j] / fit->model[j];
                under += slope;
            }
        }
        fit->part[k] *= above / under;
    }
}

/* Fits the powers of the terms behind the filter. */
static void fit_filter(const data_t *data, const davar_filter_t *filter, fit_t *fit)
{
    double shape[TERMS][M];
    double mean = 0.0;
    double passed = 0.0;
    for (size_t j = FIRST; j < M; j++) {
        const double frequency = (double)(j + 1U) / (double)SPECTRUM_SEGMENT;
        shape[0][j] = davar_filter_power(filter, frequency);
        shape[1][j] = shape[0][j] / angle(j);
        shape[2][j] = shape[1][j] / angle(j);
        mean += data->used[j] ? data->power[j] : 0.0;
        passed += data->used[j] ? shape[0][j] : 0.0;
    }
    fit->filter = *filter;
    fit->part[0] = 0.9 * mean / passed;
    fit->part[1] = 0.05 * fit->part[0];
    fit->part[2] = 0.002 * fit->part[0];
    evaluate(data, shape, fit);
    for (size_t round = 0; round < ROUNDS; round++) {
        improve(data, shape, fit);
        evaluate(data, shape, fit);
    }
}

/* --- the family --- */

static void fit_low_pass(const data_t *data, uint8_t poles, double log_cutoff, fit_t *fit)
{
    const davar_filter_t filter = {.cutoff = exp(log_cutoff), .poles = poles};
    fit_filter(data, &filter, fit);
}

static double loss_at(const data_t *data, uint8_t poles, double log_cutoff)
{
    fit_t fit;
    fit_low_pass(data, poles, log_cutoff, &fit);
    return fit.loss;
}

static double grid_at(uint8_t poles, size_t i)
{
    const double most = log((poles == 1U) ? 1.2 : 0.7);
    const double least = log(CUTOFF_LEAST);
    return least + (most - least) * (double)i / (double)(GRID - 1U);
}

/* The minimum between two points of the grid, by golden section. */
static double refine(const data_t *data, uint8_t poles, double low, double high)
{
    const double part = 0.381966011250105152;
    double left = low + part * (high - low);
    double right = high - part * (high - low);
    double loss_left = loss_at(data, poles, left);
    double loss_right = loss_at(data, poles, right);
    for (size_t step = 0; step < STEPS; step++) {
        if (loss_left < loss_right) {
            high = right;
            right = left;
            loss_right = loss_left;
            left = low + part * (high - low);
            loss_left = loss_at(data, poles, left);
        } else {
            low = left;
            left = right;
            loss_left = loss_right;
            right = high - part * (high - low);
            loss_right = loss_at(data, poles, right);
        }
    }
    return 0.5 * (low + high);
}

/* Relative standard error of the cutoff, from the curvature of the likelihood. */
static double uncertainty_of(const data_t *data, const fit_t *best)
{
    const double step = 0.05;
    const double at = log(best->filter.cutoff);
    const double above = loss_at(data, best->filter.poles, at + step);
    const double below = loss_at(data, best->filter.poles, at - step);
    const double curvature = (above + below - 2.0 * best->loss) / (step * step);
    const double sigma = (curvature > 0.0) ? sqrt(NEIGHBOURS / curvature) : UNCERTAINTY_MOST;
    return fmin(fmax(sigma, UNCERTAINTY_LEAST), UNCERTAINTY_MOST);
}

static void search_low_pass(const data_t *data, uint8_t poles, fit_t *best)
{
    size_t nearest = 0;
    double least = HUGE_VAL;
    for (size_t i = 0; i < GRID; i++) {
        const double loss = loss_at(data, poles, grid_at(poles, i));
        nearest = (loss < least) ? i : nearest;
        least = fmin(loss, least);
    }
    const double low = grid_at(poles, (nearest > 0U) ? (nearest - 1U) : 0U);
    const double high = grid_at(poles, (nearest + 1U < GRID) ? (nearest + 1U) : nearest);
    fit_t found;
    fit_low_pass(data, poles, refine(data, poles, low, high), &found);
    if (found.loss < best->loss) {
        *best = found;
    }
}

static void try_averages(const data_t *data, const davar_filter_t *filter, fit_t *best)
{
    fit_t found;
    fit_filter(data, filter, &found);
    if (found.loss < best->loss) {
        *best = found;
    }
}

static void search_averages(const data_t *data, fit_t *best)
{
    for (uint8_t averages = 1U; averages <= AVERAGES_MOST; averages++) {
        for (uint16_t length = 2U; length <= LENGTH_MOST; length++) {
            davar_filter_t filter = {.averages = averages, .length = length, .decimation = 1U};
            try_averages(data, &filter, best);
            filter.decimation = length;
            if (averages > 1U) { /* the mean of blocks is white */
                try_averages(data, &filter, best);
            }
        }
    }
}

/* The simplest explanation: no filter, a low-pass, averages. */
static void search(const data_t *data, fit_t *best)
{
    fit_t averages = {.loss = HUGE_VAL};
    fit_t low_pass = {.loss = HUGE_VAL};
    fit_filter(data, &(davar_filter_t){0}, best);
    search_low_pass(data, 1U, &low_pass);
    search_low_pass(data, 2U, &low_pass);
    search_averages(data, &averages);
    if (averages.loss + GAIN < low_pass.loss) {
        low_pass = averages;
    }
    if (low_pass.loss + GAIN < best->loss) {
        *best = low_pass;
    }
}

/* --- lines --- */

static double median_around(const double power[M], size_t j)
{
    double sorted[2U * LINE_REACH + 1U];
    const size_t last = M - (2U * LINE_REACH) - 1U;
    size_t first = (j > FIRST + LINE_REACH) ? (j - LINE_REACH) : FIRST;
    first = (first < last) ? first : last;
    for (size_t i = 0; i <= 2U * LINE_REACH; i++) {
        size_t at = i;
        for (; (at > 0U) && (sorted[at - 1U] > power[first + i]); at--) {
            sorted[at] = sorted[at - 1U];
        }
        sorted[at] = power[first + i];
    }
    return sorted[LINE_REACH];
}

/* Leaves out an ordinate and those that the window mixes with it. */
static void leave_out(data_t *data, size_t j)
{
    for (size_t i = (j > 2U) ? (j - 2U) : 0U; (i <= j + 2U) && (i < M); i++) {
        data->used[i] = false;
    }
}

/* Lines that stand out from their neighbours. A spectrum that falls has the median of its
 * neighbours in the middle; near its ends only the upper one is without a middle. */
static void leave_lines_out(data_t *data)
{
    const double most = 1.0 + LINE_SIGMAS / sqrt(data->weight);
    for (size_t j = 0; j < M; j++) {
        data->used[j] = (j >= FIRST);
    }
    for (size_t j = FIRST + LINE_REACH; j < M; j++) {
        if (data->power[j] > most * median_around(data->power, j)) {
            leave_out(data, j);
        }
    }
}

/* Wide lines, which exceed the model. False: there are none. */
static bool trim(data_t *data, const fit_t *fit)
{
    const double most = fmax(LINE_EXCESS, 1.0 + (LINE_SIGMAS - 1.0) / sqrt(data->weight));
    data_t before = *data;
    bool any = false;
    for (size_t j = FIRST; j < M; j++) {
        if (before.used[j] && (before.power[j] > most * fit->model[j])) {
            leave_out(data, j);
            any = true;
        }
    }
    return any;
}

static size_t count_used(const data_t *data)
{
    size_t used = 0;
    for (size_t j = FIRST; j < M; j++) {
        used += data->used[j] ? 1U : 0U;
    }
    return used;
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
static bool misfits(const data_t *data, const fit_t *fit)
{
    const double variance = NEIGHBOURS / ((double)BAND * data->weight) + TOLERANCE * TOLERANCE;
    double sum = 0.0;
    double mean = 0.0;
    size_t inside = 0;
    size_t bands = 0;
    for (size_t j = FIRST; j < M; j++) {
        if (data->used[j]) {
            mean += data->power[j] / fit->model[j] / (double)BAND;
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

static learned_t learn(data_t *data)
{
    static const davar_filter_t none = {0};
    fit_t best;
    leave_lines_out(data);
    search(data, &best);
    for (size_t i = 0; (i < TRIMS) && trim(data, &best); i++) {
        if (count_used(data) + LINES_MOST < M - FIRST) {
            return (learned_t){.status = LEARN_MISFIT};
        }
        search(data, &best);
    }
    if (misfits(data, &best)) {
        return (learned_t){.status = LEARN_MISFIT};
    }
    learned_t learned = {.status = LEARN_FOUND, .filter = best.filter};
    if (best.filter.poles > 0U) {
        learned.filter.uncertainty = uncertainty_of(data, &best);
        if (best.filter.cutoff < 1.05 * CUTOFF_LEAST) {
            learned.status = LEARN_MISFIT;
        }
    } else if (best.filter.averages == 0U) {
        learned = (learned_t){.status = LEARN_NONE, .filter = none};
    }
    return learned;
}

learned_t learn_filter(spectrum_t *spectrum, double rounding)
{
    data_t data = {.rounding = rounding};
    const size_t given = spectrum->count;
    const size_t segments = spectrum_median(spectrum, data.power);
    if ((segments == 0U) && (given >= LEARN_SEGMENTS_LEAST)) {
        return (learned_t){.status = LEARN_CONSTANT};
    }
    if (segments < LEARN_SEGMENTS_LEAST) {
        return (learned_t){.status = LEARN_SHORT, .segments = segments};
    }
    data.weight = (double)segments / ORDINATE_VARIANCE;
    learned_t learned = learn(&data);
    learned.segments = segments;
    return learned;
}

bool learn_knows(const learned_t *learned)
{
    return (learned->status == LEARN_FOUND) || (learned->status == LEARN_NONE);
}

static void describe_found(const davar_filter_t *filter, double rate_hz, char *text, size_t size)
{
    if (filter->poles > 0U) {
        const double hz = filter->cutoff * rate_hz;
        (void)snprintf(text, size, "%s-pole low-pass at %.3g Hz (+-%.2g Hz)",
                       (filter->poles == 1U) ? "one" : "two", hz, filter->uncertainty * hz);
    } else {
        (void)snprintf(text, size, "%u %s of %u samples", filter->averages,
                       (filter->decimation > 1U) ? "decimating averages" : "moving averages",
                       filter->length);
    }
}

void learn_describe(const learned_t *learned, double rate_hz, char *text, size_t size)
{
    static const char *const WORDS[] = {
        [LEARN_NOTHING] = "filter unknown",
        [LEARN_FOUND] = "",
        [LEARN_NONE] = "white up to half the sample rate, no filter",
        [LEARN_MISFIT] = "filter unknown: no low-pass of one or two poles and no averages explain "
                         "the spectrum",
        [LEARN_SHORT] = "filter unknown: too few samples at rest",
        [LEARN_CONSTANT] = "filter unknown: the signal does not change",
    };
    if (learned->status == LEARN_FOUND) {
        describe_found(&learned->filter, rate_hz, text, size);
    } else {
        (void)snprintf(text, size, "%s", WORDS[learned->status]);
    }
}

void learn_option(const learned_t *learned, double rate_hz, char *text, size_t size)
{
    const davar_filter_t *const filter = &learned->filter;
    if (!learn_knows(learned)) {
        text[0] = '\0';
    } else if (filter->poles > 0U) {
        (void)snprintf(text, size, "%.4g:%u:%.2g", filter->cutoff * rate_hz, filter->poles,
                       100.0 * filter->uncertainty);
    } else if (filter->averages > 0U) {
        (void)snprintf(text, size, "%s%u:%u", (filter->decimation > 1U) ? "cic" : "average",
                       filter->averages, filter->length);
    } else {
        (void)snprintf(text, size, "none");
    }
}
