/* davar-sim - Whittle's likelihood of a spectrum for an ARMA model, DESIGN.md: white noise, a flicker
 * and a random walk that pass a filter of N poles and N zeros, and rounding after it. */
#ifndef ARMA_H
#define ARMA_H

#include "davar/filter.h"

#include <stddef.h>

#define ARMA_ORDER_MOST 8U /* poles, and zeros */
#define ARMA_NUMBERS (3U + 2U * ARMA_ORDER_MOST)
#define ARMA_BINS_MOST 512U

/* A mean over neighbouring ordinates. */
typedef struct {
    double angle;
    double power;
    double weight; /* independent ordinates that vary as exponentials */
    double known;  /* power gain of a part that is known */
    double cosine; /* of the angle: arma_turn() */
    double sine;
} arma_bin_t;

typedef struct {
    arma_bin_t bin[ARMA_BINS_MOST];
    size_t count;
    double rounding; /* white noise after the filter */
    bool is_steady;  /* no model has a flicker or a walk */
} arma_data_t;

typedef struct {
    unsigned order;
    bool is_steady; /* no flicker and no walk */
    /* ln of the white noise; flicker and walk over it, at an angle of 1; inverse hyperbolic tangents
     * of the reflection coefficients of poles and of zeros */
    double number[ARMA_NUMBERS];
    double loss;  /* negative log-likelihood */
    double sigma; /* standard error of the first number */
} arma_t;

/* Sets the cosine and the sine of every bin, which a fit needs thousands of times. */
void arma_turn(arma_data_t *data);

/* Finds the most likely model of that many poles and zeros. `fewer`: that of one order less, where a
 * search begins too; not read for order 0. */
void arma_fit(const arma_data_t *data, unsigned order, const arma_t *fewer, arma_t *best);

/* The same model without drifts, fitted again; its loss is infinite if it is not a low-pass. */
arma_t arma_steady(const arma_data_t *data, const arma_t *model);

/* The spectrum of the model at an angle, with rounding, where a known part has this gain. */
double arma_spectrum(const arma_t *model, double angle, double known, double rounding);

/* The coefficients, with a gain of 1 at frequency 0. */
void arma_filter(const arma_t *model, davar_filter_t *filter);

#endif
