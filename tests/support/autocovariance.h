/* davar tests - the autocovariance of white noise after a filter, from the filter's definition:
 * exponentials of a low-pass, products of the weights of moving averages. */
#ifndef DAVAR_TESTS_AUTOCOVARIANCE_H
#define DAVAR_TESTS_AUTOCOVARIANCE_H

#include "shape.h"

#include <math.h>

#define AUTOCOVARIANCE_LAGS 4096
#define AUTOCOVARIANCE_PI 3.14159265358979324

/* Of the samples, divided by `sum`, the sum over all lags. At `count` lags and above it is 0. `sum`
 * is for a low-pass whose output has variance 1, and moving averages that do not divide. */
typedef struct {
    double r[AUTOCOVARIANCE_LAGS];
    int count;
    double sum;
} autocovariance_t;

/* The low-pass alone, at lags before decimation. */
static inline double low_pass_autocovariance(const shape_t *filter, double lag)
{
    const double size = fabs(lag);
    const double a = 2.0 * AUTOCOVARIANCE_PI * filter->cutoff / shape_decimation(filter) * size;
    if (filter->poles == 0U) {
        return (size > 0.5) ? 0.0 : 1.0;
    }
    if (filter->poles == 1U) {
        return exp(-a);
    }
    const double part = a / sqrt(2.0);
    return exp(-part) * (cos(part) + sin(part));
}

/* Weights of all moving averages together; returns how many. */
static inline int impulse_response(const shape_t *filter, double h[])
{
    int count = 1;
    h[0] = 1.0;
    for (int n = 0; n < filter->averages; n++) {
        const int more = (int)filter->length - 1;
        for (int i = count + more - 1; i >= 0; i--) { /* downwards: it reads entries up to i */
            double sum = 0.0;
            for (int j = (i > more) ? (i - more) : 0; (j <= i) && (j < count); j++) {
                sum += h[j];
            }
            h[i] = sum;
        }
        count += more;
    }
    return count;
}

static inline void autocovariance_of(const shape_t *filter, autocovariance_t *result)
{
    static double h[AUTOCOVARIANCE_LAGS];
    static double product[AUTOCOVARIANCE_LAGS];
    const int taps = impulse_response(filter, h);
    const double step = shape_decimation(filter);
    for (int j = 0; j < taps; j++) {
        product[j] = 0.0;
        for (int i = 0; (i + j) < taps; i++) {
            product[j] += h[i] * h[i + j];
        }
    }
    result->sum = 0.0;
    for (int k = 0; k < AUTOCOVARIANCE_LAGS; k++) {
        double r = 0.0;
        for (int j = 1 - taps; j < taps; j++) {
            r += product[(j < 0) ? -j : j] * low_pass_autocovariance(filter, (step * k) + j);
        }
        result->r[k] = r;
        result->sum += (k > 0) ? (2.0 * r) : r;
        result->count = (fabs(r) > (1e-12 * result->r[0])) ? (k + 1) : result->count;
    }
    for (int k = 0; k < AUTOCOVARIANCE_LAGS; k++) {
        result->r[k] /= result->sum;
    }
}

#endif
