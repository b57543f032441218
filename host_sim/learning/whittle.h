/* davar-sim - Whittle's likelihood of a spectrum for one filter, DESIGN.md: white noise, a flicker
 * and a random walk that pass the filter, and rounding after it. */
#ifndef WHITTLE_H
#define WHITTLE_H

#include "davar/fit.h"
#include "learning/spectrum.h"

/* The window and the line that was removed change the ordinates below this one. */
#define WHITTLE_FIRST 5U

/* Variance of a mean over neighbouring ordinates, over that of independent ones: the window. */
#define WHITTLE_NEIGHBOURS 1.944

#define WHITTLE_TERMS 4U  /* white noise, flicker, random walk; white noise after the filter */
#define WHITTLE_BEHIND 3U /* the last of them, which only a test fits */

#define WHITTLE_LINE_SIGMAS 5.0 /* by which a line exceeds its neighbours */
#define WHITTLE_LEAST 1e-300    /* keeps a model positive */

typedef struct {
    double power[SPECTRUM_ORDINATES];
    bool used[SPECTRUM_ORDINATES];
    double sigma;  /* relative standard error of an ordinate */
    double weight; /* of its loss: neighbours are correlated */
    double rounding;
    size_t terms; /* WHITTLE_TERMS, or WHITTLE_BEHIND without the last */
} whittle_data_t;

typedef struct {
    davar_filter_t filter;
    double part[WHITTLE_TERMS];
    double loss; /* negative log-likelihood */
    double model[SPECTRUM_ORDINATES];
    bool used[SPECTRUM_ORDINATES]; /* the ordinates that it explains */
} whittle_fit_t;

/* Fits the powers of the terms for this filter. */
void whittle_fit(const whittle_data_t *data, const davar_filter_t *filter, whittle_fit_t *fit);

/* The negative log-likelihood of a fit. */
double whittle_loss(const whittle_data_t *data, const whittle_fit_t *fit);

/* The same if lines above the model have a limited effect. */
double whittle_limited_loss(const whittle_data_t *data, const whittle_fit_t *fit);

#endif
