/* davar - the spectrum after a filter, DESIGN (5.16). No trigonometric library: angles are turned
 * step by step, in doubles that every target rounds equally. */
#ifndef DAVAR_FILTER_SPECTRUM_H
#define DAVAR_FILTER_SPECTRUM_H

#include "davar/filter.h"
#include "number/real.h"

#define SPECTRUM_PI 3.14159265358979324

/* The covariance and whitening include rounding to counts of a sixth of the scatter of a sample. */
#define SPECTRUM_COUNTS 6.0

/* Step of the cutoff for the derivative of the gains, and its natural logarithm. */
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

/* e^z for |z| below 16: a series near 0, then squared. */
complex_t davar_exponential(complex_t z);

/* Samples of the filter from one that davar gets to the next. */
static inline double filter_decimation(const davar_filter_t *filter)
{
    return (filter->decimation > 1U) ? (double)filter->decimation : 1.0;
}

/* One low-pass: the pole of its sampled autocovariance Re(w z^|lag|). */
typedef struct {
    complex_t z;
    double w; /* w = 1 - i w */
} pole_t;

/* The filter at three cutoffs: as declared, and SPECTRUM_STEP above and below. */
typedef struct {
    const davar_filter_t *filter;
    pole_t pole[3];
    double decimation;
    uint32_t aliases;
    complex_t alias; /* half the angle between two aliases */
} band_t;

/* Prepares a filter, which must stay valid as long as the band. */
void davar_band_start(const davar_filter_t *filter, band_t *band);

/* Power spectra of the samples that the filter makes of white noise, aliases included. `half`: half
 * the angle of the frequency, over the decimation. */
void davar_band_spectra(const band_t *band, complex_t half, double s[3]);

/* The points between two frequencies of the grid; it resolves this many samples. */
uint32_t davar_band_points(double samples, const davar_filter_t *filter);

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

/* Asserts that the fields are in their ranges. */
void davar_filter_assert(const davar_filter_t *filter);

#endif
