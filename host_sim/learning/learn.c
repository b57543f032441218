/* davar-sim - learning the filter: the most likely one of a family for the median spectrum, and
 * whether others explain it as well. */
#include "learning/learn.h"
#include "davar/filter.h"
#include "learning/whittle.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define M SPECTRUM_ORDINATES

/* Variance of an ordinate of the median spectrum, times the segments: that of the median of
 * exponentials, and of segments that overlap by half. */
#define ORDINATE_VARIANCE 2.2

#define CUTOFF_LEAST 0.01
#define GRID 24U
#define STEPS 16U /* of the golden section */
#define AVERAGES_MOST 3U
#define LENGTH_MOST 8U

/* In units of log-likelihood: an explanation that is less simple must gain so much. */
#define GAIN 4.0

/* The widest low-passes that a claim of no filter must exclude: they change N by 3 %. */
#define WIDE_1_POLE 0.6
#define WIDE_2_POLES 0.5
#define EXCLUDED 2.0 /* two standard errors, as log-likelihood */

/* Another explanation counts if it changes the white noise, N^2, by this. */
#define PLATEAU 0.05

#define LINE_REACH ((size_t)15) /* ordinates on each side that a line is compared with */
#define LINE_EXCESS 1.1         /* ... and the model */
#define TRIMS 6U
#define LINES_MOST (M / 3U)

#define BAND 10U
#define TOLERANCE 0.02     /* of the spectrum in a band */
#define MISFIT_NORMAL 3.09 /* one-sided 0.1 % */
#define REACH_STEP 0.02    /* so the least uncertainty is 1 % */
#define REACH_MOST 1.02
#define UNCERTAINTY_MOST 0.5

/* From the simplest on. */
typedef enum { NO_FILTER = 0, ONE_POLE, TWO_POLES, AVERAGES, FAMILIES } family_t;

/* --- the family --- */

static void fit_low_pass(const whittle_data_t *data, uint8_t poles, double log_cutoff,
                         whittle_fit_t *fit)
{
    const davar_filter_t filter = {.cutoff = exp(log_cutoff), .poles = poles};
    whittle_fit(data, &filter, fit);
}

static double loss_at(const whittle_data_t *data, uint8_t poles, double log_cutoff)
{
    whittle_fit_t fit;
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
static double refine(const whittle_data_t *data, uint8_t poles, double low, double high)
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

static void search_low_pass(const whittle_data_t *data, uint8_t poles, whittle_fit_t *best)
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
    whittle_fit_t found;
    fit_low_pass(data, poles, refine(data, poles, low, high), &found);
    if (found.loss < best->loss) {
        *best = found;
    }
}

static void try_averages(const whittle_data_t *data, const davar_filter_t *filter,
                         whittle_fit_t *best)
{
    whittle_fit_t found;
    whittle_fit(data, filter, &found);
    if (found.loss < best->loss) {
        *best = found;
    }
}

static void search_averages(const whittle_data_t *data, whittle_fit_t *best)
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

static void search(const whittle_data_t *data, family_t family, whittle_fit_t *best)
{
    switch (family) {
    case ONE_POLE:
        search_low_pass(data, 1U, best);
        break;
    case TWO_POLES:
        search_low_pass(data, 2U, best);
        break;
    case AVERAGES:
        search_averages(data, best);
        break;
    case NO_FILTER:
    case FAMILIES:
    default:
        whittle_fit(data, &(davar_filter_t){0}, best);
        break;
    }
}

/* --- lines --- */

static double median_around(const double power[M], size_t j)
{
    double sorted[2U * LINE_REACH + 1U] = {0};
    const size_t last = M - (2U * LINE_REACH) - 1U;
    size_t first = (j > WHITTLE_FIRST + LINE_REACH) ? (j - LINE_REACH) : WHITTLE_FIRST;
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
static void leave_out(whittle_data_t *data, size_t j)
{
    for (size_t i = (j > 2U) ? (j - 2U) : 0U; (i <= j + 2U) && (i < M); i++) {
        data->used[i] = false;
    }
}

/* Lines that stand out from their neighbours. A spectrum that falls has the median of its
 * neighbours in the middle; near its ends only the upper one is without a middle. */
static void leave_lines_out(whittle_data_t *data)
{
    const double most = 1.0 + WHITTLE_LINE_SIGMAS * data->sigma;
    for (size_t j = 0; j < M; j++) {
        data->used[j] = (j >= WHITTLE_FIRST);
    }
    for (size_t j = WHITTLE_FIRST + LINE_REACH; j < M; j++) {
        if (data->power[j] > most * median_around(data->power, j)) {
            leave_out(data, j);
        }
    }
}

/* Wide lines, which exceed the model. False: there are none. */
static bool trim(whittle_data_t *data, const whittle_fit_t *fit)
{
    const double most = fmax(LINE_EXCESS, 1.0 + (WHITTLE_LINE_SIGMAS - 1.0) * data->sigma);
    const whittle_data_t before = *data;
    bool any = false;
    for (size_t j = WHITTLE_FIRST; j < M; j++) {
        if (before.used[j] && (before.power[j] > most * fit->model[j])) {
            leave_out(data, j);
            any = true;
        }
    }
    return any;
}

static size_t count_used(const whittle_data_t *data)
{
    size_t used = 0;
    for (size_t j = WHITTLE_FIRST; j < M; j++) {
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
static bool misfits(const whittle_data_t *data, const whittle_fit_t *fit)
{
    const double variance = 1.0 / ((double)BAND * data->weight) + TOLERANCE * TOLERANCE;
    double sum = 0.0;
    double mean = 0.0;
    size_t inside = 0;
    size_t bands = 0;
    for (size_t j = WHITTLE_FIRST; j < M; j++) {
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

/* Does noise after the filter change what the spectrum says about the white noise before it? */
static bool is_hidden(const whittle_data_t *data, const whittle_fit_t *best)
{
    whittle_data_t with = *data;
    whittle_fit_t fit = {.loss = HUGE_VAL};
    with.terms = WHITTLE_TERMS;
    if (best->filter.poles > 0U) {
        search_low_pass(&with, best->filter.poles, &fit);
    } else {
        whittle_fit(&with, &best->filter, &fit);
    }
    const double plateau = fit.part[0] + fit.part[WHITTLE_BEHIND];
    return (fit.loss + EXCLUDED < best->loss) &&
           (fabs(plateau - best->part[0]) > PLATEAU * best->part[0]);
}

/* Does the spectrum exclude every filter that matters? */
static bool is_white(const whittle_data_t *data, const whittle_fit_t *white)
{
    return (loss_at(data, 1U, log(WIDE_1_POLE)) > white->loss + EXCLUDED) &&
           (loss_at(data, 2U, log(WIDE_2_POLES)) > white->loss + EXCLUDED);
}

static learn_status_t judge(const whittle_data_t *data, const whittle_fit_t *best)
{
    const bool low_pass = (best->filter.poles > 0U);
    if (misfits(data, best) || (low_pass && (best->filter.cutoff < 1.05 * CUTOFF_LEAST))) {
        return LEARN_MISFIT;
    }
    if (!low_pass && (best->filter.averages == 0U)) {
        return is_white(data, best) ? LEARN_NONE : LEARN_WIDE;
    }
    return is_hidden(data, best) ? LEARN_BEHIND : LEARN_FOUND;
}

/* Fits a family, and leaves out what exceeds the fit, as a wide line does, until nothing does. What
 * exceeds costs as much as if it just did not. If too much is left out, the loss is infinite. */
static void explain(const whittle_data_t *given, family_t family, whittle_fit_t *best)
{
    whittle_data_t data = *given;
    *best = (whittle_fit_t){.loss = HUGE_VAL};
    search(&data, family, best);
    for (size_t i = 0; (i < TRIMS) && trim(&data, best); i++) {
        *best = (whittle_fit_t){.loss = HUGE_VAL};
        search(&data, family, best);
    }
    const bool enough = (count_used(&data) + LINES_MOST >= M - WHITTLE_FIRST);
    memcpy(best->used, data.used, sizeof best->used);
    best->loss = enough ? whittle_limited_loss(given, best) : HUGE_VAL;
}

/* The simplest family that explains the spectrum: a less simple one must gain so much. */
static family_t choose(const whittle_fit_t fits[FAMILIES])
{
    const family_t low_pass = (fits[TWO_POLES].loss < fits[ONE_POLE].loss) ? TWO_POLES : ONE_POLE;
    family_t chosen = NO_FILTER;
    if (fits[low_pass].loss + GAIN < fits[chosen].loss) {
        chosen = low_pass;
    }
    return (fits[AVERAGES].loss + GAIN < fits[chosen].loss) ? AVERAGES : chosen;
}

/* The largest difference, in logarithms, between the white noise before this filter and before
 * another one that explains the spectrum about as well. */
static double spread_of(const whittle_fit_t fits[FAMILIES], family_t chosen)
{
    double spread = 0.0;
    for (family_t other = ONE_POLE; other < FAMILIES; other++) {
        if (fits[other].loss < fits[chosen].loss + GAIN) {
            spread = fmax(spread, fabs(log(fits[other].part[0] / fits[chosen].part[0])));
        }
    }
    return spread;
}

/* How far the cutoff can move, in logarithms and half of it for a standard error, before the loss
 * grows by that of two standard errors. The flatter side counts: where a drift takes no part, the
 * other one is steep. */
static double reach(const whittle_data_t *data, const whittle_fit_t *best, double step)
{
    const double from = log(best->filter.cutoff);
    double distance = 0.0;
    do {
        distance += fabs(step);
    } while ((distance < REACH_MOST) &&
             (loss_at(data, best->filter.poles, from + copysign(distance, step)) <
              best->loss + EXCLUDED));
    return 0.5 * distance;
}

/* Relative standard error of the cutoff. It moves the white noise at least by `spread`. */
static double uncertainty_of(const whittle_data_t *data, const whittle_fit_t *best, double spread)
{
    const double sigma = fmax(reach(data, best, REACH_STEP), reach(data, best, -REACH_STEP));
    whittle_fit_t other;
    fit_low_pass(data, best->filter.poles, log(best->filter.cutoff) + sigma, &other);
    const double moved = fabs(log(other.part[0] / best->part[0]));
    return sigma * fmax(1.0, spread / fmax(moved, 0.1 * spread + WHITTLE_LEAST));
}

static learned_t learn(whittle_data_t *data)
{
    whittle_fit_t fits[FAMILIES];
    leave_lines_out(data);
    for (family_t family = NO_FILTER; family < FAMILIES; family++) {
        explain(data, family, &fits[family]);
    }
    const family_t chosen = choose(fits);
    whittle_fit_t *best = &fits[chosen];
    if (!isfinite(best->loss)) {
        return (learned_t){.status = LEARN_MISFIT};
    }
    const double spread = spread_of(fits, chosen);
    if (spread > PLATEAU) {
        return (learned_t){.status = LEARN_VAGUE};
    }
    memcpy(data->used, best->used, sizeof data->used);
    best->loss = whittle_loss(data, best);
    learned_t learned = {.status = judge(data, best), .filter = best->filter};
    if (best->filter.poles > 0U) {
        learned.filter.uncertainty = uncertainty_of(data, best, spread);
    }
    if ((learned.status == LEARN_FOUND) && (learned.filter.uncertainty > UNCERTAINTY_MOST)) {
        learned.status = LEARN_VAGUE;
    }
    return learned;
}

learned_t learn_filter(spectrum_t *spectrum, double rounding)
{
    whittle_data_t data = {.rounding = rounding, .terms = WHITTLE_BEHIND};
    const size_t given = spectrum->count;
    const size_t segments = spectrum_median(spectrum, data.power);
    if ((segments == 0U) && (given >= LEARN_SEGMENTS_LEAST)) {
        return (learned_t){.status = LEARN_CONSTANT};
    }
    if (segments < LEARN_SEGMENTS_LEAST) {
        return (learned_t){.status = LEARN_SHORT, .segments = segments};
    }
    data.sigma = sqrt(ORDINATE_VARIANCE / (double)segments);
    data.weight = 1.0 / (WHITTLE_NEIGHBOURS * data.sigma * data.sigma);
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
        [LEARN_VAGUE] = "filter unknown: several explain the spectrum equally well",
        [LEARN_WIDE] = "filter unknown: the recording is white but too short to exclude a wide "
                       "low-pass",
        [LEARN_BEHIND] = "filter unknown: white noise after the filter hides it",
        [LEARN_MISFIT] = "filter unknown: no low-pass of one or two poles and no averages explain "
                         "the spectrum",
        [LEARN_SHORT] = "filter unknown: it needs 4352 samples at rest without gaps",
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
