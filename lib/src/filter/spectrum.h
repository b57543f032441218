/* davar - the spectrum after a filter, DESIGN (5.16). No trigonometric library: angles are turned
 * step by step, in doubles that every target rounds equally. */
#ifndef DAVAR_FILTER_SPECTRUM_H
#define DAVAR_FILTER_SPECTRUM_H

#include "davar/filter.h"
#include "number/real.h"

#define SPECTRUM_PI 3.14159265358979324

/* The covariance and whitening include rounding to counts of a sixth of the scatter of a sample. */
#define SPECTRUM_COUNTS 6.0

/* Step of the frequency axis for the derivative of the gains, and its natural logarithm. */
#define SPECTRUM_STEP 1.05
#define SPECTRUM_LOG_STEP 0.0487901641694320031

typedef struct {
    double re;
    double im;
} complex_t;

static inline complex_t complex_times(complex_t a, complex_t b)
{
    return (complex_t){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

static inline double squared(double x)
{
    return x * x;
}

/* e^z for |z| below 32: a series near 0, then squared. */
complex_t davar_exponential(complex_t z);

static inline bool davar_filter_is_zero(double c)
{
    return (c <= 0.0) && (c >= 0.0);
}

/* Index of the last coefficient that is not 0; 0 if there is none. */
uint32_t davar_filter_order(const double c[], uint32_t most);

/* An angle that advances by equal steps, beginning at half a step. */
typedef struct {
    complex_t now;
    complex_t step;
} turn_t;

static inline turn_t turn_by(double step)
{
    return (turn_t){davar_exponential((complex_t){0.0, 0.5 * step}),
                    davar_exponential((complex_t){0.0, step})};
}

static inline void turn_on(turn_t *turn)
{
    turn->now = complex_times(turn->now, turn->step);
}

/* The power spectrum at equal steps of the frequency, over that at 0. */
typedef struct {
    const davar_filter_t *filter;
    turn_t half;  /* half the angle, stretched */
    turn_t exact; /* ... not stretched, as for the averages */
    double sine;  /* by which its sine is stretched */
    double share; /* of the spectrum with the stretched sine */
    double zero;
} band_t;

/* Begins at half of the first of `points` steps up to half the sample rate. `stretch`: factor of
 * the frequency axis of the coefficients. The filter must stay valid as long as the band. */
void davar_band_start(band_t *band, const davar_filter_t *filter, uint32_t points, double stretch);

/* The spectrum at this frequency. Moves on to the next. */
double davar_band_next(band_t *band);

/* The steps up to half the sample rate that resolve this many samples, and the filter. */
uint32_t davar_band_points(const davar_filter_t *filter, double samples);

/* Power gain of the coefficients and averages at half the angle, not over that at 0. */
double davar_filter_gain(const davar_filter_t *filter, complex_t half);

/* Is a sample a sample of the noise? */
bool davar_filter_passes_all(const davar_filter_t *filter);

/* Means over the frequencies, for white noise of density 1: the variance of a sample, and half the
 * mean square of the difference of two successive ones. */
void davar_filter_scatter(const davar_filter_t *filter, double *variance, double *step);

/* Asserts that the filter is valid. */
void davar_filter_assert(const davar_filter_t *filter);

#endif
