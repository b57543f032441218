/* davar - the spectrum after a filter. */
#include "filter/spectrum.h"
#include "davar/filter.h"

/* Frequencies from 0 to half the sample rate, a power of two. */
#define POINTS_LEAST 64U
#define POINTS_MOST 16384U

complex_t davar_exponential(complex_t z)
{
    const double small = 1.0 / 256.0;
    complex_t sum = {1.0, 0.0};
    for (int k = 8; k >= 1; k--) {
        const complex_t step = {z.re * small / k, z.im * small / k};
        const complex_t product = complex_times(step, sum);
        sum = (complex_t){1.0 + product.re, product.im};
    }
    for (int k = 0; k < 8; k++) {
        sum = complex_times(sum, sum);
    }
    return sum;
}

static pole_t pole_of(const davar_filter_t *filter, double cutoff)
{
    const double angle = 2.0 * SPECTRUM_PI * cutoff / filter_decimation(filter);
    if (filter->poles == 1U) {
        return (pole_t){davar_exponential((complex_t){-angle, 0.0}), 0.0};
    }
    const double part = angle * 0.70710678118654752;
    return (pole_t){davar_exponential((complex_t){-part, part}), 1.0};
}

/* Re(w (1 - z^2) / (1 - 2 z cosine + z^2)) */
static double low_pass(const pole_t *pole, double cosine)
{
    const complex_t z = pole->z;
    const complex_t z2 = complex_times(z, z);
    const complex_t above = {1.0 - z2.re, -z2.im};
    const complex_t under = {1.0 - 2.0 * z.re * cosine + z2.re, z2.im - 2.0 * z.im * cosine};
    const complex_t weighted = complex_times(above, (complex_t){1.0, -pole->w});
    return (weighted.re * under.re + weighted.im * under.im) /
           (squared(under.re) + squared(under.im));
}

DAVAR_RARE void davar_band_start(const davar_filter_t *filter, band_t *band)
{
    band->filter = filter;
    band->decimation = filter_decimation(filter);
    band->aliases = (uint32_t)band->decimation;
    band->alias = davar_exponential((complex_t){0.0, SPECTRUM_PI / band->decimation});
    band->pole[0] = pole_of(filter, filter->cutoff);
    band->pole[1] = pole_of(filter, filter->cutoff * SPECTRUM_STEP);
    band->pole[2] = pole_of(filter, filter->cutoff / SPECTRUM_STEP);
}

/* Power gain of the moving averages at half the angle `half`, before decimation. */
static double averaging(const davar_filter_t *filter, complex_t half)
{
    complex_t power = {1.0, 0.0}; /* half^length */
    complex_t square_of = half;
    for (uint32_t n = filter->length; n > 0U; n >>= 1U) {
        power = ((n & 1U) != 0U) ? complex_times(power, square_of) : power;
        square_of = complex_times(square_of, square_of);
    }
    const double under = (double)filter->length * half.im;
    const double ratio = (squared(half.im) > 1e-24) ? squared(power.im / under) : 1.0;
    double gain = 1.0;
    for (uint32_t n = 0U; n < filter->averages; n++) {
        gain *= ratio;
    }
    return gain;
}

void davar_band_spectra(const band_t *band, complex_t half, double s[3])
{
    s[0] = 0.0;
    s[1] = 0.0;
    s[2] = 0.0;
    for (uint32_t alias = 0U; alias < band->aliases; alias++) {
        const double gain = (band->filter->averages > 0U) ? averaging(band->filter, half) : 1.0;
        const double cosine = 1.0 - 2.0 * squared(half.im);
        for (int i = 0; i < 3; i++) {
            s[i] += gain * ((band->filter->poles > 0U) ? low_pass(&band->pole[i], cosine) : 1.0);
        }
        half = complex_times(half, band->alias);
    }
}

uint32_t davar_band_points(double samples, const davar_filter_t *filter)
{
    double least = samples;
    const double narrow = (filter->poles > 0U) ? (1.0 / filter->cutoff) : 0.0;
    least = (narrow > least) ? narrow : least;
    const double length =
        (filter->averages > 0U) ? ((double)filter->length / filter_decimation(filter)) : 0.0;
    least = 4.0 * ((length > least) ? length : least);
    uint32_t points = POINTS_LEAST;
    while ((points < POINTS_MOST) && ((double)points < least)) {
        points *= 2U;
    }
    return points;
}

void davar_filter_assert(const davar_filter_t *filter)
{
    DAVAR_ASSERT(filter->poles <= 2U);
    DAVAR_ASSERT((filter->poles == 0U) || (filter->cutoff >= 0.002));
    DAVAR_ASSERT((filter->poles == 0U) || (filter->cutoff <= (2.0 * filter_decimation(filter))));
    DAVAR_ASSERT((filter->uncertainty >= 0.0) && (filter->uncertainty <= 0.5));
    DAVAR_ASSERT((filter->averages == 0U) || (filter->length >= 1U));
    DAVAR_ASSERT((filter->averages == 0U) || (filter->length <= 4096U));
    DAVAR_ASSERT(filter->averages <= 8U);
    DAVAR_ASSERT(((double)filter->averages * (double)filter->length) <=
                 ((double)DAVAR_FILTER_SPAN_MOST * filter_decimation(filter)));
    DAVAR_ASSERT((filter->summed <= 1U) || (filter->averages == 1U));
    DAVAR_ASSERT((filter->summed <= 1U) || (filter->length == filter->summed));
    DAVAR_ASSERT((filter->summed <= 1U) || (filter->decimation == filter->summed));
    (void)filter;
}

DAVAR_RARE double davar_filter_power(const davar_filter_t *filter, double frequency)
{
    band_t band;
    double zero[3];
    double s[3];
    davar_filter_assert(filter);
    DAVAR_ASSERT((frequency >= 0.0) && (frequency <= 0.5));
    davar_band_start(filter, &band);
    davar_band_spectra(&band, (complex_t){1.0, 0.0}, zero);
    davar_band_spectra(
        &band, davar_exponential((complex_t){0.0, SPECTRUM_PI * frequency / band.decimation}), s);
    return s[0] / zero[0];
}
