/* davar - the settings of the window laws that depend on the filter, DESIGN (4.3) (10.16). */
#include "davar/content.h"
#include "davar/filter.h"
#include "filter/spectrum.h"

#define WHITENING_ONE 16384.0
#define NORMAL_95 1.96

#define NORMAL_STEP (1.0 / 256.0)

#define BLOCK_MOST 64U /* samples of a block of law glr */

/* Lags at which the autocovariance is read, at most; of more lags, every n-th one. */
#define LAGS_MOST 256U

/* Lags that share the computation of a spectrum. */
#define LAGS_TOGETHER 32U

static int16_t rounded(double share)
{
    const double scaled = WHITENING_ONE * share;
    return (int16_t)((scaled < 0.0) ? (scaled - 0.5) : (scaled + 0.5));
}

/* Autocovariances for white noise of density 1, with this stretch of the frequency axis, at `count`
 * lags: `first`, then every `step`-th. */
static void autocovariances(const davar_filter_t *filter, uint32_t points, double stretch,
                            uint32_t first, uint32_t step, double r[], uint32_t count)
{
    const double by_lag = SPECTRUM_PI / (double)points;
    band_t band;
    turn_t begin = turn_by((double)first * by_lag);
    turn_t ahead = turn_by((double)step * by_lag);
    davar_band_start(&band, filter, points, stretch);
    for (uint32_t i = 0U; i < count; i++) {
        r[i] = 0.0;
    }
    for (uint32_t p = 0U; p < points; p++) {
        double cosine = begin.now.re; /* of the lag times the angle */
        double before = (begin.now.re * ahead.now.re) + (begin.now.im * ahead.now.im);
        const double share = davar_band_next(&band) / (double)points;
        for (uint32_t i = 0U; i < count; i++) {
            const double next = (2.0 * ahead.now.re * cosine) - before;
            r[i] += share * cosine;
            before = cosine;
            cosine = next;
        }
        turn_on(&begin);
        turn_on(&ahead);
    }
}

/* Yule-Walker. */
static void set_weights(davar_config_t *config, const double r[])
{
    const double noisy = r[0] * (1.0 + (1.0 / (12.0 * squared(SPECTRUM_COUNTS))));
    const double determinant = squared(noisy) - squared(r[1]);
    config->glr.whiten_first = rounded(r[1] * (noisy - r[2]) / determinant);
    config->glr.whiten_second = rounded(((noisy * r[2]) - squared(r[1])) / determinant);
}

/* Autocovariance of whitened samples at `lag`. r: of the samples, up to lag + 2 at least. */
static double whitened_at(const double r[], uint32_t lag, double first, double second)
{
    const double by_1 = r[(lag > 0U) ? (lag - 1U) : 1U] + r[lag + 1U];
    const double by_2 = r[(lag > 1U) ? (lag - 2U) : (2U - lag)] + r[lag + 2U];
    const double squares = 1.0 + squared(first) + squared(second);
    return squares * r[lag] - first * (1.0 - second) * by_1 - second * by_2;
}

/* White noise before the filter over whitened samples about the mean of their block. Whitened
 * samples are not quite white, so this is not their variance. */
static double level_of_filter(const davar_config_t *config, const double r[], uint32_t block)
{
    const double first = (double)config->glr.whiten_first / WHITENING_ONE;
    const double second = (double)config->glr.whiten_second / WHITENING_ONE;
    double sum = 0.0;
    for (uint32_t lag = 1U; lag < block; lag++) {
        sum += (double)(block - lag) * whitened_at(r, lag, first, second);
    }
    const double shared = 2.0 * sum / ((double)block * ((double)block - 1.0));
    return davar_root(1.0 / (whitened_at(r, 0U, first, second) - shared));
}

DAVAR_RARE void davar_whiten(davar_config_t *config, const davar_filter_t *filter)
{
    static const double stretch[3] = {1.0, SPECTRUM_STEP, 1.0 / SPECTRUM_STEP};
    double level[3];
    double r[BLOCK_MOST + 2U];
    const uint32_t longer = (config->glr.block > 2U) ? config->glr.block : 2U; /* init rejects it */
    const uint32_t block = (longer < BLOCK_MOST) ? longer : BLOCK_MOST;
    davar_filter_assert(filter);
    const uint32_t points = davar_band_points(filter, 1.0);
    for (int i = 0; i < 3; i++) {
        autocovariances(filter, points, stretch[i], 0U, 1U, r, block + 2U);
        if (i == 0) {
            set_weights(config, r);
        }
        level[i] = level_of_filter(config, r, block);
    }
    const double slope = (level[1] - level[2]) / (2.0 * SPECTRUM_LOG_STEP * level[0]);
    const double of_axis = filter->uncertainty * slope;
    config->glr.whiten_level = level[0];
    config->glr.whiten_tolerance =
        NORMAL_95 * davar_root(squared(of_axis) + squared(filter->level));
}

/* Sum of the fourth powers of the autocorrelation over all lags. */
static double fourth_powers(const davar_filter_t *filter)
{
    const uint32_t points = davar_band_points(filter, 1.0);
    const uint32_t half = points / 2U; /* a power of two, LAGS_TOGETHER at least */
    uint32_t step = 1U;
    while ((half / step) > LAGS_MOST) {
        step *= 2U;
    }
    double r[LAGS_TOGETHER];
    double at_lag_0 = 0.0;
    double sum = 0.0;
    for (uint32_t first = 0U; first < half; first += LAGS_TOGETHER * step) {
        autocovariances(filter, points, 1.0, first, step, r, LAGS_TOGETHER);
        for (uint32_t i = 0U; i < LAGS_TOGETHER; i++) {
            sum += squared(squared(r[i]));
        }
        if (first == 0U) {
            at_lag_0 = squared(squared(r[0]));
        }
    }
    return ((2.0 * sum / at_lag_0) - 1.0) * (double)step;
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
    const davar_law_id_t law = davar_law_id(config);
    const bool by_either = (law != DAVAR_LAW_ID_KURTOSIS) && (law != DAVAR_LAW_ID_AND);
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
