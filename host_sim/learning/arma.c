/* davar-sim - fits ARMA models to a spectrum by the method of Levenberg and Marquardt with the
 * expected second derivatives (Fisher's scoring). */
#include "learning/arma.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#define FIRST_POLE 3U
#define TURN_MOST 7.0 /* of a reflection coefficient: 1 - 1.7e-6 */
#define STEP 1e-5     /* of a derivative */
#define ROUNDS 60U
#define DAMP_LEAST 1e-9
#define DAMP_MOST 1e9
#define CORNER_MOST 0.3  /* angle from which on a drift is below the white noise */
#define FLAT_BIN 3U      /* up to here a filter is flat: what changes below is a drift, or unseen */
#define UNSEEN_MOST 0.25 /* ln of its gain there */
#define PEAK_MOST 1.6    /* power gain, over that at 0 */
#define CONVERGED 1e-7   /* of the loss */
#define STRANGERS 6U     /* starts anywhere */
#define SEEDS 6U         /* starts at a low-pass */
#define POWER_LEAST 1e-12

/* --- the model --- */

static double square(double x)
{
    return x * x;
}

/* A polynomial whose zeros are within the circle, c[0] = 1. */
static void expand(const double turns[], unsigned order, double c[ARMA_ORDER_MOST + 1U])
{
    memset(c, 0, (ARMA_ORDER_MOST + 1U) * sizeof c[0]);
    c[0] = 1.0;
    for (unsigned n = 1U; n <= order; n++) {
        double before[ARMA_ORDER_MOST + 1U];
        const double reflection = tanh(turns[n - 1U]);
        memcpy(before, c, sizeof before);
        for (unsigned k = 1U; k <= n; k++) {
            c[k] = before[k] + reflection * before[n - k];
        }
    }
}

/* Squared size of a polynomial in e^(-i angle), over that at 0 with `scale` of scale_of(). */
static double size_of(const double c[], unsigned order, double scale, double cosine, double sine)
{
    double re = 0.0;
    double im = 0.0;
    for (unsigned k = order + 1U; k > 0U; k--) {
        const double next = re * cosine - im * sine + c[k - 1U];
        im = re * sine + im * cosine;
        re = next;
    }
    return (square(re) + square(im) + POWER_LEAST) * scale;
}

static double scale_of(const double c[], unsigned order)
{
    double sum = 0.0;
    for (unsigned k = 0U; k <= order; k++) {
        sum += c[k];
    }
    return 1.0 / (square(sum) + POWER_LEAST);
}

typedef struct {
    double b[ARMA_ORDER_MOST + 1U];
    double a[ARMA_ORDER_MOST + 1U];
    unsigned order;
} ratio_t;

static ratio_t ratio_of(const arma_t *model)
{
    ratio_t ratio = {.order = model->order};
    expand(&model->number[FIRST_POLE], model->order, ratio.a);
    expand(&model->number[FIRST_POLE + model->order], model->order, ratio.b);
    return ratio;
}

static double gain_of(const ratio_t *ratio, double cosine, double sine)
{
    const unsigned order = ratio->order;
    return size_of(ratio->b, order, scale_of(ratio->b, order), cosine, sine) /
           size_of(ratio->a, order, scale_of(ratio->a, order), cosine, sine);
}

static double drifts(const arma_t *model, double angle)
{
    return 1.0 + model->number[1] / angle + model->number[2] / square(angle);
}

double arma_spectrum(const arma_t *model, double angle, double known, double rounding)
{
    const ratio_t ratio = ratio_of(model);
    return exp(model->number[0]) * known * gain_of(&ratio, cos(angle), sin(angle)) *
               drifts(model, angle) +
           rounding;
}

void arma_turn(arma_data_t *data)
{
    for (size_t i = 0U; i < data->count; i++) {
        data->bin[i].cosine = cos(data->bin[i].angle);
        data->bin[i].sine = sin(data->bin[i].angle);
    }
}

void arma_filter(const arma_t *model, davar_filter_t *filter)
{
    const ratio_t ratio = ratio_of(model);
    double above = 0.0;
    double under = 0.0;
    *filter = (davar_filter_t){.b = {1.0}, .a = {1.0}};
    for (unsigned k = 0U; k <= model->order; k++) {
        above += ratio.b[k];
        under += ratio.a[k];
    }
    for (unsigned k = 0U; k <= model->order; k++) {
        filter->b[k] = ratio.b[k] * under / above;
        filter->a[k] = ratio.a[k];
    }
}

/* --- the likelihood --- */

/* The model at every bin. */
typedef struct {
    double above[ARMA_BINS_MOST]; /* squared size of the zeros' polynomial */
    double under[ARMA_BINS_MOST]; /* ... and of the poles' */
    double passed[ARMA_BINS_MOST];
    double spectrum[ARMA_BINS_MOST]; /* with rounding */
} curve_t;

static void sizes_of(const arma_data_t *data, const double turns[], unsigned order, double size[])
{
    double c[ARMA_ORDER_MOST + 1U];
    expand(turns, order, c);
    const double scale = scale_of(c, order);
    for (size_t i = 0U; i < data->count; i++) {
        size[i] = size_of(c, order, scale, data->bin[i].cosine, data->bin[i].sine);
    }
}

/* Returns the loss. */
static double evaluate(const arma_data_t *data, const arma_t *model, curve_t *curve)
{
    const double level = exp(model->number[0]);
    double loss = 0.0;
    sizes_of(data, &model->number[FIRST_POLE], model->order, curve->under);
    sizes_of(data, &model->number[FIRST_POLE + model->order], model->order, curve->above);
    for (size_t i = 0U; i < data->count; i++) {
        const arma_bin_t *const bin = &data->bin[i];
        const double gain = curve->above[i] / curve->under[i];
        curve->passed[i] = level * bin->known * gain * drifts(model, bin->angle);
        curve->spectrum[i] = curve->passed[i] + data->rounding;
        const double over = bin->power / curve->spectrum[i];
        loss += bin->weight * (over - 1.0 - log(over));
    }
    return loss;
}

typedef struct {
    double at[ARMA_NUMBERS][ARMA_NUMBERS];
    double right[ARMA_NUMBERS];
} normal_t;

/* Derivatives of the logarithm of the spectrum at each bin. */
typedef double slopes_t[ARMA_BINS_MOST][ARMA_NUMBERS];

static void differentiate(const arma_data_t *data, const arma_t *model, const curve_t *curve,
                          slopes_t slope)
{
    double moved[ARMA_BINS_MOST];
    for (size_t i = 0U; i < data->count; i++) {
        const double angle = data->bin[i].angle;
        slope[i][0] = curve->passed[i] / curve->spectrum[i];
        slope[i][1] = slope[i][0] / (angle * drifts(model, angle));
        slope[i][2] = slope[i][1] / angle;
    }
    for (unsigned k = 0U; k < 2U * model->order; k++) {
        const bool is_pole = (k < model->order);
        arma_t next = *model;
        next.number[FIRST_POLE + k] += STEP;
        sizes_of(data, &next.number[FIRST_POLE + (is_pole ? 0U : model->order)], model->order,
                 moved);
        for (size_t i = 0U; i < data->count; i++) {
            const double grown =
                is_pole ? (curve->under[i] / moved[i]) : (moved[i] / curve->above[i]);
            slope[i][FIRST_POLE + k] = slope[i][0] * (grown - 1.0) / STEP;
        }
    }
}

static void make_normal(const arma_data_t *data, unsigned numbers, const double spectrum[],
                        slopes_t slope, normal_t *normal)
{
    *normal = (normal_t){0};
    for (size_t i = 0U; i < data->count; i++) {
        const double weight = data->bin[i].weight;
        const double excess = weight * (data->bin[i].power / spectrum[i] - 1.0);
        for (unsigned k = 0U; k < numbers; k++) {
            const double weighted = weight * slope[i][k];
            normal->right[k] += slope[i][k] * excess;
            for (unsigned l = 0U; l <= k; l++) {
                normal->at[k][l] += weighted * slope[i][l];
            }
        }
    }
    for (unsigned k = 0U; k < numbers; k++) {
        for (unsigned l = 0U; l < k; l++) {
            normal->at[l][k] = normal->at[k][l];
        }
    }
}

/* A drift that is 0 and would become negative takes no part. */
static void free_drifts(const arma_t *model, unsigned numbers, normal_t *normal)
{
    for (unsigned k = 1U; k < FIRST_POLE; k++) {
        if (model->is_steady || (!(model->number[k] > 0.0) && (normal->right[k] <= 0.0))) {
            for (unsigned l = 0U; l < numbers; l++) {
                normal->at[k][l] = 0.0;
                normal->at[l][k] = 0.0;
            }
            normal->at[k][k] = 1.0;
            normal->right[k] = 0.0;
        }
    }
}

/* Solves for normal->right, by elimination; the matrix is positive definite. False: it is not. */
static bool solve(normal_t *normal, unsigned numbers, double damp)
{
    for (unsigned k = 0U; k < numbers; k++) {
        normal->at[k][k] += damp * normal->at[k][k] + 1e-12;
    }
    for (unsigned p = 0U; p < numbers; p++) {
        if (!(normal->at[p][p] > 0.0)) {
            return false;
        }
        for (unsigned i = 0U; i < numbers; i++) {
            const double multiple = (i != p) ? (normal->at[i][p] / normal->at[p][p]) : 0.0;
            for (unsigned l = 0U; l < numbers; l++) {
                normal->at[i][l] -= multiple * normal->at[p][l];
            }
            normal->right[i] -= multiple * normal->right[p];
        }
    }
    for (unsigned p = 0U; p < numbers; p++) {
        normal->right[p] /= normal->at[p][p];
    }
    return true;
}

static double between(double low, double value, double high)
{
    return fmin(fmax(value, low), high);
}

static void move(const arma_t *from, const double step[], unsigned numbers, arma_t *to)
{
    *to = *from;
    for (unsigned k = 0U; k < numbers; k++) {
        const double limited = between(-2.0, step[k], 2.0);
        to->number[k] += (k == 0U) ? between(-4.0, step[k], 4.0) : limited;
    }
    to->number[1] = between(0.0, to->number[1], CORNER_MOST);
    to->number[2] = between(0.0, to->number[2], square(CORNER_MOST));
    for (unsigned k = FIRST_POLE; k < numbers; k++) {
        to->number[k] = between(-TURN_MOST, to->number[k], TURN_MOST);
    }
}

/* Standard error of ln of the white noise: the root of an element of the inverse. */
static double sigma_of(const normal_t *given, unsigned numbers)
{
    normal_t normal = *given;
    memset(normal.right, 0, sizeof normal.right);
    normal.right[0] = 1.0;
    return (solve(&normal, numbers, 0.0) && (normal.right[0] > 0.0)) ? sqrt(normal.right[0])
                                                                     : HUGE_VAL;
}

static void improve(const arma_data_t *data, arma_t *model)
{
    curve_t curve;
    slopes_t slope;
    const unsigned numbers = FIRST_POLE + (2U * model->order);
    normal_t normal;
    double damp = 1e-3;
    model->loss = evaluate(data, model, &curve);
    for (unsigned round = 0U; (round < ROUNDS) && (damp < DAMP_MOST); round++) {
        differentiate(data, model, &curve, slope);
        make_normal(data, numbers, curve.spectrum, slope, &normal);
        free_drifts(model, numbers, &normal);
        const double before = model->loss;
        bool better = false;
        while (!better && (damp < DAMP_MOST)) {
            normal_t damped = normal;
            arma_t next;
            if (solve(&damped, numbers, damp)) {
                move(model, damped.right, numbers, &next);
                next.loss = evaluate(data, &next, &curve);
                better = (next.loss < before);
                *model = better ? next : *model;
            }
            damp *= better ? 0.2 : 5.0;
        }
        damp = fmax(damp, DAMP_LEAST);
        if (!(before - model->loss > CONVERGED * (1.0 + fabs(before)))) {
            break;
        }
    }
    model->loss = evaluate(data, model, &curve);
    differentiate(data, model, &curve, slope);
    make_normal(data, numbers, curve.spectrum, slope, &normal);
    free_drifts(model, numbers, &normal);
    model->sigma = sigma_of(&normal, numbers);
}

/* --- where a search begins --- */

/* Is the filter flat over the first bins, soon forgotten, and without a resonance, which is a
 * vibration? */
static bool is_low_pass(const arma_data_t *data, const arma_t *model)
{
    const ratio_t ratio = ratio_of(model);
    davar_filter_t filter;
    double most = 0.0;
    arma_filter(model, &filter);
    for (size_t i = 0U; i < data->count; i++) {
        most = fmax(most, gain_of(&ratio, data->bin[i].cosine, data->bin[i].sine));
    }
    const arma_bin_t *const flat = &data->bin[FLAT_BIN];
    return (most < PEAK_MOST) && davar_filter_is_valid(&filter) &&
           (fabs(log(gain_of(&ratio, flat->cosine, flat->sine))) < UNSEEN_MOST);
}

static void try_from(const arma_data_t *data, arma_t *start, arma_t *best)
{
    start->is_steady = data->is_steady;
    improve(data, start);
    if ((start->loss < best->loss) && is_low_pass(data, start)) {
        *best = *start;
    }
}

static double mean_power(const arma_data_t *data)
{
    double sum = 0.0;
    double weights = 0.0;
    for (size_t i = 0U; i < data->count; i++) {
        sum += data->bin[i].weight * data->bin[i].power;
        weights += data->bin[i].weight;
    }
    return sum / weights;
}

/* The same number in every run: 0 to 1. */
static double draw(uint32_t *state)
{
    *state = (*state * 1664525U) + 1013904223U;
    return (double)*state / 4294967296.0;
}

/* The model of one order less, with a pole and a zero that nearly cancel. */
static arma_t extended(const arma_t *fewer, double pole)
{
    arma_t model = *fewer;
    model.is_steady = false;
    const unsigned order = fewer->order + 1U;
    model.order = order;
    for (unsigned k = 0U; k < fewer->order; k++) {
        model.number[FIRST_POLE + order + k] = fewer->number[FIRST_POLE + fewer->order + k];
    }
    model.number[FIRST_POLE + order - 1U] = pole;
    model.number[FIRST_POLE + (2U * order) - 1U] = -pole;
    return model;
}

/* One or two poles as a low-pass has them: a pole p and its conjugate have the reflection
 * coefficients -2 Re p / (1 + |p|^2) and |p|^2. */
static arma_t seeded(unsigned order, double cutoff, double level)
{
    arma_t model = {.order = order, .number = {level}};
    const double angle = 6.283185307179586 * cutoff;
    if (order == 1U) {
        model.number[FIRST_POLE] = atanh(-exp(-angle));
    } else {
        const double part = angle * 0.707106781186547524;
        const double size = exp(-2.0 * part);
        model.number[FIRST_POLE] = atanh(-2.0 * exp(-part) * cos(part) / (1.0 + size));
        model.number[FIRST_POLE + 1U] = atanh(size);
    }
    return model;
}

arma_t arma_steady(const arma_data_t *data, const arma_t *model)
{
    arma_t steady = *model;
    steady.is_steady = true;
    steady.number[1] = 0.0;
    steady.number[2] = 0.0;
    improve(data, &steady);
    steady.loss = is_low_pass(data, &steady) ? steady.loss : HUGE_VAL;
    return steady;
}

void arma_fit(const arma_data_t *data, unsigned order, const arma_t *fewer, arma_t *best)
{
    const double level = log(mean_power(data));
    uint32_t state = 7U + order;
    arma_t start = {.order = order, .number = {level}};
    *best = (arma_t){.loss = HUGE_VAL};
    if (order == 0U) {
        try_from(data, &start, best);
        return;
    }
    const bool has_fewer = (fewer->order + 1U == order); /* otherwise none was a low-pass */
    for (int sign = -1; has_fewer && (sign <= 1); sign += 2) {
        start = extended(fewer, 0.3 * sign);
        try_from(data, &start, best);
    }
    for (unsigned i = 0U; (order <= 2U) && (i < SEEDS); i++) {
        start = seeded(order, 0.4 * pow(0.45, (double)i), level);
        try_from(data, &start, best);
    }
    for (unsigned i = 0U; i < STRANGERS; i++) {
        start = (arma_t){.order = order, .number = {level}};
        for (unsigned k = FIRST_POLE; k < FIRST_POLE + (2U * order); k++) {
            start.number[k] = 2.0 * draw(&state) - 1.0;
        }
        try_from(data, &start, best);
    }
}
