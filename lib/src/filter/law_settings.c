/* davar - the settings of the window laws that depend on the filter, DESIGN (4.3) (10.16). */
#include "davar/law.h"
#include "filter/spectrum.h"

/* Laws of davar/law.h with one criterion, and with two that must agree. */
#define LAW_KURTOSIS 1U
#define LAW_AND 3U

#define WHITENING_ONE 16384.0

#define NORMAL_STEP (1.0 / 256.0)

/* Lags at which the autocovariance is read, at most; beyond, every n-th one. */
#define LAGS_MOST 256U

static double autocovariance(const band_t *band, uint32_t points, uint32_t lag)
{
    turn_t half = turn_by(SPECTRUM_PI / (2.0 * (double)points * band->decimation));
    turn_t whole = turn_by((double)lag * (SPECTRUM_PI / (double)points));
    double sum = 0.0;
    for (uint32_t p = 0U; p < points; p++) {
        double s[3];
        davar_band_spectra(band, half.now, s);
        sum += s[0] * whole.now.re;
        turn_on(&half);
        turn_on(&whole);
    }
    return sum / (double)points;
}

static int16_t rounded(double share)
{
    const double scaled = WHITENING_ONE * share;
    return (int16_t)((scaled < 0.0) ? (scaled - 0.5) : (scaled + 0.5));
}

DAVAR_RARE void davar_whiten(davar_config_t *config, const davar_filter_t *filter)
{
    band_t band;
    double zero[3];
    davar_filter_assert(filter);
    davar_band_start(filter, &band);
    davar_band_spectra(&band, (complex_t){1.0, 0.0}, zero);
    const uint32_t points = davar_band_points(1.0, filter);
    const double r0 = autocovariance(&band, points, 0U);
    const double r1 = autocovariance(&band, points, 1U);
    const double r2 = autocovariance(&band, points, 2U);
    const double noisy = r0 * (1.0 + (1.0 / (12.0 * squared(SPECTRUM_COUNTS))));
    const double determinant = squared(noisy) - squared(r1);
    config->glr.whiten_first = rounded(r1 * (noisy - r2) / determinant);
    config->glr.whiten_second = rounded(((noisy * r2) - squared(r1)) / determinant);
    const double first = (double)config->glr.whiten_first / WHITENING_ONE;
    const double second = (double)config->glr.whiten_second / WHITENING_ONE;
    const double rest = r0 * (1.0 + squared(first) + squared(second)) -
                        2.0 * (first * (1.0 - second) * r1 + second * r2);
    config->glr.whiten_level = davar_root(zero[0] / rest);
}

/* Sum of the fourth powers of the autocorrelation over all lags. */
static double fourth_powers(const davar_filter_t *filter)
{
    band_t band;
    davar_band_start(filter, &band);
    const uint32_t points = davar_band_points(1.0, filter);
    const uint32_t step = ((points / 2U) > LAGS_MOST) ? ((points / 2U) / LAGS_MOST) : 1U;
    const double r0 = autocovariance(&band, points, 0U);
    double sum = 1.0;
    for (uint32_t lag = step; lag < (points / 2U); lag += step) {
        sum += 2.0 * squared(squared(autocovariance(&band, points, lag) / r0));
    }
    return sum * (double)step;
}

/* Probability that a normal variable is from z to z + NORMAL_STEP standard deviations. */
static double normal_part(double z)
{
    const double by_root_2_pi = 0.398942280401432678;
    const double middle = z + (0.5 * NORMAL_STEP);
    return NORMAL_STEP * by_root_2_pi *
           davar_exponential((complex_t){-0.5 * squared(middle), 0.0}).re;
}

/* The number of standard deviations that a normal variable exceeds with probability `tail`, from
 * 1e-5 to 0.5. */
static double normal_quantile(double tail)
{
    double rest = 0.5 - tail;
    double z = 0.0;
    double part = normal_part(z);
    while (part < rest) {
        rest -= part;
        z += NORMAL_STEP;
        part = normal_part(z);
    }
    return z + (NORMAL_STEP * rest / part);
}

/* Of the kurtosis, in standard deviations of ln K at 3; of the contribution, whose distribution has
 * heavier tails (4.3). */
DAVAR_RARE void davar_bound_unstable_rate(davar_config_t *config, double rate,
                                          const davar_filter_t *filter)
{
    const uint8_t law = davar_law_id(config);
    const bool by_either = (law != LAW_KURTOSIS) && (law != LAW_AND);
    const double length = (double)config->window.shortest;
    const double segment = (double)config->moments.segment;
    DAVAR_ASSERT((rate >= 1e-4) && (rate <= 0.1));
    DAVAR_ASSERT(config->moments.segment < config->window.shortest);
    if (filter != NULL) {
        davar_filter_assert(filter);
    }
    const double r4 = (filter != NULL) ? fourth_powers(filter) : 1.0;
    const double z = normal_quantile(rate * (by_either ? 0.25 : 0.5));
    const double spread = z * davar_root(24.0 * r4 / length) / 3.0;
    const double slides = davar_root((8.0 / 3.0) * r4 * segment / (length * (length - segment)));
    config->moments.kurtosis_low = 3.0 / (1.0 + spread);
    config->moments.kurtosis_high = (spread < 0.9) ? (3.0 / (1.0 - spread)) : 30.0;
    config->moments.contribution_low = 0.0;
    config->moments.contribution_high = z * (0.98 + 0.065 * (squared(z) - 4.0)) * slides;
}
