/* davar-sim - Whittle's likelihood of a spectrum for one filter. */
#include "learning/whittle.h"
#include "davar/filter.h"

#include <math.h>
#include <string.h>

#define M SPECTRUM_ORDINATES
#define PI 3.14159265358979324
#define ROUNDS 10U /* of the fit of the powers */

static double angle(size_t j)
{
    return 2.0 * PI * (double)(j + 1U) / (double)SPECTRUM_SEGMENT;
}

static double loss_at_ordinate(const whittle_data_t *data, const whittle_fit_t *fit, size_t j)
{
    const double ratio = data->power[j] / fit->model[j];
    return data->weight * (ratio - 1.0 - log(ratio));
}

double whittle_loss(const whittle_data_t *data, const whittle_fit_t *fit)
{
    double loss = 0.0;
    for (size_t j = WHITTLE_FIRST; j < M; j++) {
        loss += data->used[j] ? loss_at_ordinate(data, fit, j) : 0.0;
    }
    return loss;
}

double whittle_limited_loss(const whittle_data_t *data, const whittle_fit_t *fit)
{
    const double most = 0.5 * WHITTLE_LINE_SIGMAS * WHITTLE_LINE_SIGMAS / WHITTLE_NEIGHBOURS;
    double loss = 0.0;
    for (size_t j = WHITTLE_FIRST; j < M; j++) {
        const double one = data->used[j] ? loss_at_ordinate(data, fit, j) : 0.0;
        loss += ((data->power[j] > fit->model[j]) && (one > most)) ? most : one;
    }
    return loss;
}

static void evaluate(const whittle_data_t *data, double (*shape)[M], whittle_fit_t *fit)
{
    for (size_t j = WHITTLE_FIRST; j < M; j++) {
        fit->model[j] = data->rounding + WHITTLE_LEAST;
        for (size_t k = 0; k < data->terms; k++) {
            fit->model[j] += fit->part[k] * shape[k][j];
        }
    }
}

/* The normal equations of weighted least squares. */
typedef struct {
    double at[WHITTLE_TERMS][WHITTLE_TERMS];
    double right[WHITTLE_TERMS];
} normal_t;

static void make_normal(const whittle_data_t *data, double (*shape)[M], const whittle_fit_t *fit,
                        normal_t *normal)
{
    *normal = (normal_t){0};
    for (size_t j = WHITTLE_FIRST; j < M; j++) {
        const double inverse = data->used[j] ? (1.0 / fit->model[j]) : 0.0;
        const double excess = (data->power[j] - data->rounding) * inverse;
        for (size_t k = 0; k < data->terms; k++) {
            const double slope = shape[k][j] * inverse;
            normal->right[k] += slope * excess;
            for (size_t l = 0; l <= k; l++) {
                normal->at[k][l] += slope * shape[l][j] * inverse;
                normal->at[l][k] = normal->at[k][l];
            }
        }
    }
}

/* Solves for the terms that are not 0, by elimination without pivots: the matrix is positive
 * definite. Terms of nearly the same shape leave no pivot; the later one is then 0. */
static void solve(normal_t normal, size_t terms, double part[WHITTLE_TERMS])
{
    for (size_t k = 0; k < terms; k++) {
        const bool on = (part[k] > 0.0) && (normal.at[k][k] > 0.0);
        for (size_t i = 0; i < terms; i++) {
            const double multiple = (on && (i != k)) ? (normal.at[i][k] / normal.at[k][k]) : 0.0;
            for (size_t l = 0; l < terms; l++) {
                normal.at[i][l] -= multiple * normal.at[k][l];
            }
            normal.right[i] -= multiple * normal.right[k];
        }
        if (!on) {
            for (size_t i = 0; i < terms; i++) {
                normal.at[i][k] = 0.0; /* this term takes no part */
            }
        }
    }
    for (size_t k = 0; k < terms; k++) {
        part[k] = ((part[k] > 0.0) && (normal.at[k][k] > 0.0)) ? (normal.right[k] / normal.at[k][k])
                                                               : 0.0;
    }
}

static size_t most_negative(const double part[WHITTLE_TERMS], size_t terms)
{
    size_t worst = 0;
    for (size_t k = 1; k < terms; k++) {
        worst = (part[k] < part[worst]) ? k : worst;
    }
    return worst;
}

/* A step of Fisher's scoring: least squares with the weights of the last model, without terms that
 * become negative. */
static void improve(const whittle_data_t *data, double (*shape)[M], whittle_fit_t *fit)
{
    normal_t normal;
    double sign[WHITTLE_TERMS] = {1.0, 1.0, 1.0, 1.0};
    make_normal(data, shape, fit, &normal);
    for (size_t left = data->terms; left > 0U; left--) {
        double part[WHITTLE_TERMS];
        memcpy(part, sign, sizeof part);
        solve(normal, data->terms, part);
        const size_t worst = most_negative(part, data->terms);
        if (part[worst] >= 0.0) {
            memcpy(fit->part, part, sizeof part);
            return;
        }
        sign[worst] = 0.0;
    }
}

void whittle_fit(const whittle_data_t *data, const davar_filter_t *filter, whittle_fit_t *fit)
{
    double shape[WHITTLE_TERMS][M];
    double mean = 0.0;
    double passed = 0.0;
    for (size_t j = WHITTLE_FIRST; j < M; j++) {
        const double frequency = (double)(j + 1U) / (double)SPECTRUM_SEGMENT;
        shape[0][j] = davar_filter_power(filter, frequency);
        shape[1][j] = shape[0][j] / angle(j);
        shape[2][j] = shape[1][j] / angle(j);
        shape[WHITTLE_BEHIND][j] = 1.0;
        mean += data->used[j] ? data->power[j] : 0.0;
        passed += data->used[j] ? shape[0][j] : 0.0;
    }
    fit->filter = *filter;
    fit->part[0] = 0.9 * mean / passed;
    fit->part[1] = 0.05 * fit->part[0];
    fit->part[2] = 0.002 * fit->part[0];
    fit->part[WHITTLE_BEHIND] = 0.02 * fit->part[0];
    evaluate(data, shape, fit);
    for (size_t round = 0; round < ROUNDS; round++) {
        improve(data, shape, fit);
        evaluate(data, shape, fit);
    }
    fit->loss = whittle_loss(data, fit);
}
