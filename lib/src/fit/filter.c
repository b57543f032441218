/* davar - what a filter makes of white noise and drifts at each cluster size, DESIGN (5.16): means
 * over the frequencies of the sampled spectrum. No trigonometric library: angles are turned step by
 * step, in doubles that every target rounds equally. */
#include "davar/law.h"
#include "fit/plan.h"
#include "number/real.h"

/* Frequencies from 0 to half the sample rate, a power of two. */
#define POINTS_LEAST 64U
#define POINTS_MOST 16384U

/* A cluster size above this is beyond the filter: it passes white noise. */
#define SIZE_MOST 4096.0

/* White noise over rounding, in the covariance and in whitening: a sample scatters by six counts. */
#define COUNTS 6.0

/* Step of the cutoff for the derivative of the gains, and its natural logarithm. */
#define STEP 1.05
#define LOG_STEP 0.0487901641694320031

#define PI 3.14159265358979324

/* Allan variance of flicker whose spectrum is 1 / angle: 2 ln 2 / pi */
#define FLICKER 0.441271200305303

typedef struct {
    double re;
    double im;
} complex_t;

static complex_t times(complex_t a, complex_t b)
{
    return (complex_t){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

static double squared(double x)
{
    return x * x;
}

/* e^z for |z| below 16: a series near 0, then squared. */
static complex_t exponential(complex_t z)
{
    const double small = 1.0 / 256.0;
    complex_t sum = {1.0, 0.0};
    for (int k = 8; k >= 1; k--) {
        const complex_t step = {z.re * small / k, z.im * small / k};
        const complex_t product = times(step, sum);
        sum = (complex_t){1.0 + product.re, product.im};
    }
    for (int k = 0; k < 8; k++) {
        sum = times(sum, sum);
    }
    return sum;
}

/* One low-pass: the pole of its sampled autocovariance Re(w z^|lag|). */
typedef struct {
    complex_t z;
    double w; /* w = 1 - i w */
} pole_t;

static double decimation_of(const davar_filter_t *filter)
{
    return (filter->decimation > 1U) ? (double)filter->decimation : 1.0;
}

static pole_t pole_of(const davar_filter_t *filter, double cutoff)
{
    const double angle = 2.0 * PI * cutoff / decimation_of(filter);
    if (filter->poles == 1U) {
        return (pole_t){exponential((complex_t){-angle, 0.0}), 0.0};
    }
    const double part = angle * 0.70710678118654752;
    return (pole_t){exponential((complex_t){-part, part}), 1.0};
}

/* Re(w (1 - z^2) / (1 - 2 z cosine + z^2)) */
static double low_pass(const pole_t *pole, double cosine)
{
    const complex_t z = pole->z;
    const complex_t z2 = times(z, z);
    const complex_t above = {1.0 - z2.re, -z2.im};
    const complex_t under = {1.0 - 2.0 * z.re * cosine + z2.re, z2.im - 2.0 * z.im * cosine};
    const complex_t weighted = times(above, (complex_t){1.0, -pole->w});
    return (weighted.re * under.re + weighted.im * under.im) /
           (squared(under.re) + squared(under.im));
}

/* The filter at three cutoffs: as declared, and STEP above and below. */
typedef struct {
    const davar_filter_t *filter;
    pole_t pole[3];
    double decimation;
    uint32_t aliases;
    complex_t alias; /* half the angle between two aliases */
} band_t;

static void start_band(const davar_filter_t *filter, band_t *band)
{
    band->filter = filter;
    band->decimation = decimation_of(filter);
    band->aliases = (uint32_t)band->decimation;
    band->alias = exponential((complex_t){0.0, PI / band->decimation});
    band->pole[0] = pole_of(filter, filter->cutoff);
    band->pole[1] = pole_of(filter, filter->cutoff * STEP);
    band->pole[2] = pole_of(filter, filter->cutoff / STEP);
}

/* Power gain of the moving averages at half the angle `half`, before decimation. */
static double averaging(const davar_filter_t *filter, complex_t half)
{
    complex_t power = {1.0, 0.0}; /* half^length */
    complex_t square_of = half;
    for (uint32_t n = filter->length; n > 0U; n >>= 1U) {
        power = ((n & 1U) != 0U) ? times(power, square_of) : power;
        square_of = times(square_of, square_of);
    }
    const double under = (double)filter->length * half.im;
    const double ratio = (squared(half.im) > 1e-24) ? squared(power.im / under) : 1.0;
    double gain = 1.0;
    for (uint32_t n = 0U; n < filter->averages; n++) {
        gain *= ratio;
    }
    return gain;
}

/* Power spectra of the samples that the filter makes of white noise, aliases included. `half`: half
 * the angle of the frequency, over the decimation. */
static void spectra(const band_t *band, complex_t half, double s[3])
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
        half = times(half, band->alias);
    }
}

/* The points between two frequencies of the grid; it resolves this many samples. */
static uint32_t points_for(double samples, const davar_filter_t *filter)
{
    double least = samples;
    const double narrow = (filter->poles > 0U) ? (1.0 / filter->cutoff) : 0.0;
    least = (narrow > least) ? narrow : least;
    const double length =
        (filter->averages > 0U) ? ((double)filter->length / decimation_of(filter)) : 0.0;
    least = 4.0 * ((length > least) ? length : least);
    uint32_t points = POINTS_LEAST;
    while ((points < POINTS_MOST) && ((double)points < least)) {
        points *= 2U;
    }
    return points;
}

/* An angle that advances by equal steps, beginning at half a step. */
typedef struct {
    complex_t now;
    complex_t step;
} turn_t;

static turn_t turn_by(double step)
{
    return (turn_t){exponential((complex_t){0.0, 0.5 * step}), exponential((complex_t){0.0, step})};
}

static void turn_on(turn_t *turn)
{
    turn->now = times(turn->now, turn->step);
}

/* Sums over the frequencies, for one cluster size. */
typedef struct {
    turn_t turn;
    double kernel; /* at this frequency: 2 sin^4(m f) / (m sin^2 f), f half the angle */
    double gain[3];
    double flicker; /* kernel S / angle */
    double walk;    /* kernel S / angle^2 */
} sums_t;

static void add_point(sums_t *sums, double m, double sine_2, double angle, const double s[3])
{
    const double kernel = 2.0 * squared(squared(sums->turn.now.im)) / (m * sine_2);
    sums->kernel = kernel;
    for (int i = 0; i < 3; i++) {
        sums->gain[i] += kernel * s[i];
    }
    sums->flicker += kernel * s[0] / angle;
    sums->walk += kernel * s[0] / squared(angle);
    turn_on(&sums->turn);
}

/* What is before the rounding to counts: without the sums that davar_average makes. */
static davar_filter_t before_counts(const davar_filter_t *filter)
{
    if (filter->summed <= 1U) {
        return *filter;
    }
    return (davar_filter_t){.cutoff = filter->cutoff / (double)filter->summed,
                            .poles = filter->poles};
}

/* Variances of a count and of half the difference of two, which rounding must not hide (5.15). */
static void plan_sample(davar_plan_t *plan, const davar_filter_t *filter, uint32_t points)
{
    const davar_filter_t before = before_counts(filter);
    band_t band;
    start_band(&before, &band);
    double zero[3];
    spectra(&band, (complex_t){1.0, 0.0}, zero);
    turn_t half = turn_by(PI / (2.0 * (double)points * band.decimation));
    turn_t whole = turn_by(PI / (2.0 * (double)points));
    double sample = 0.0;
    double step = 0.0;
    for (uint32_t p = 0U; p < points; p++) {
        double s[3];
        spectra(&band, half.now, s);
        sample += s[0];
        step += s[0] * 2.0 * squared(whole.now.im);
        turn_on(&half);
        turn_on(&whole);
    }
    const double mean = 1.0 / (zero[0] * (double)points);
    const double by_sample = sample * mean / 3.0;
    const double by_step = step * mean * (2.0 * 25.0 / 12.0);
    const double hides = (by_sample < by_step) ? by_sample : by_step; /* q^2 / 12 over N^2 */
    const double summed = (filter->summed > 1U) ? (double)filter->summed : 1.0;
    plan->sample = (float)(sample * mean);
    plan->rounding_variance = summed / 12.0;
    plan->hidden = (float)davar_root(summed / (12.0 * hides));
    plan->floor = (float)(sample * mean / (12.0 * COUNTS * COUNTS));
}

static void plan_size(davar_plan_t *plan, int t, const sums_t *sums, double mean,
                      const double zero[3], double uncertainty)
{
    const double m = (double)plan->m[t];
    const double above = sums->gain[1] * (zero[0] / zero[1]);
    const double below = sums->gain[2] * (zero[0] / zero[2]);
    plan->gain[t] = (float)(sums->gain[0] * mean);
    plan->flicker[t] = (float)davar_root(sums->flicker * mean / (FLICKER * m));
    plan->walk[t] = (float)davar_root(sums->walk * mean * 3.0 / squared(m));
    plan->offset[t] = (float)(uncertainty * (above - below) / (2.0 * LOG_STEP * sums->gain[0]));
}

/* Sizes beyond SIZE_MOST, from `first` on: the filter takes the same from every Allan variance. */
static void plan_beyond(davar_plan_t *plan, int first)
{
    for (int u = first; u < plan->sizes; u++) {
        const double m = (double)plan->m[u];
        if (u > 0) {
            const double less = (1.0 - (double)plan->gain[u - 1]) * (double)plan->m[u - 1] / m;
            plan->gain[u] = (float)(1.0 - less);
        }
        for (int t = 0; t <= u; t++) {
            const double m_t = (double)plan->m[t];
            plan->covariance[plan_pair(t, u)] =
                (float)(davar_noise_white_overlap(m_t, m) / (2.0 * m_t * m));
        }
    }
}

static void plan_frequencies(davar_plan_t *plan, const band_t *band, int count)
{
    const double last = (double)plan->m[plan->sizes - 1U];
    const uint32_t points = points_for((last < SIZE_MOST) ? last : SIZE_MOST, band->filter);
    sums_t sums[DAVAR_TAUS_MAX] = {0};
    double zero[3];
    spectra(band, (complex_t){1.0, 0.0}, zero);
    plan_sample(plan, band->filter, points);
    turn_t half = turn_by(PI / (2.0 * (double)points * band->decimation));
    turn_t whole = turn_by(PI / (2.0 * (double)points));
    for (int t = 0; t < count; t++) {
        sums[t].turn = turn_by((double)plan->m[t] * (PI / (2.0 * (double)points)));
    }
    const double mean = 1.0 / (zero[0] * (double)points);
    for (uint32_t p = 0U; p < points; p++) {
        double s[3];
        spectra(band, half.now, s);
        const double rounded = s[0] / zero[0] + (double)plan->floor;
        const double twice = 2.0 * squared(rounded) / (double)points;
        const double angle = ((double)p + 0.5) * (PI / (double)points);
        for (int u = 0; u < count; u++) {
            add_point(&sums[u], (double)plan->m[u], squared(whole.now.im), angle, s);
            for (int t = 0; t <= u; t++) {
                const int pair = plan_pair(t, u);
                plan->covariance[pair] = (float)((double)plan->covariance[pair] +
                                                 twice * sums[u].kernel * sums[t].kernel);
            }
        }
        turn_on(&half);
        turn_on(&whole);
    }
    for (int u = 0; u < count; u++) {
        plan_size(plan, u, &sums[u], mean, zero, band->filter->uncertainty);
        for (int t = 0; t <= u; t++) {
            const int pair = plan_pair(t, u);
            plan->covariance[pair] = (float)((double)plan->covariance[pair] /
                                             ((double)plan->gain[t] * (double)plan->gain[u]));
        }
    }
}

static void assert_filter(const davar_filter_t *filter)
{
    DAVAR_ASSERT(filter->poles <= 2U);
    DAVAR_ASSERT((filter->poles == 0U) || (filter->cutoff >= 0.002));
    DAVAR_ASSERT((filter->poles == 0U) || (filter->cutoff <= (2.0 * decimation_of(filter))));
    DAVAR_ASSERT((filter->uncertainty >= 0.0) && (filter->uncertainty <= 0.5));
    DAVAR_ASSERT((filter->averages == 0U) || (filter->length >= 1U));
    DAVAR_ASSERT((filter->averages == 0U) || (filter->length <= 4096U));
    DAVAR_ASSERT(filter->averages <= 8U);
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
    assert_filter(filter);
    DAVAR_ASSERT((frequency >= 0.0) && (frequency <= 0.5));
    start_band(filter, &band);
    spectra(&band, (complex_t){1.0, 0.0}, zero);
    spectra(&band, exponential((complex_t){0.0, PI * frequency / band.decimation}), s);
    return s[0] / zero[0];
}

DAVAR_RARE void davar_plan_init_filtered(davar_plan_t *plan, const uint32_t *m, uint8_t count,
                                         const davar_filter_t *filter)
{
    band_t band;
    assert_filter(filter);
    davar_plan_start(plan, m, count);
    plan->declared = true;
    start_band(filter, &band);
    int near = 0;
    while ((near < count) && ((double)plan->m[near] <= SIZE_MOST)) {
        near++;
    }
    plan_frequencies(plan, &band, near);
    plan_beyond(plan, near);
    davar_plan_solve(plan, count);
}

/* --- for the laws of the window --------------------------------------------------------------- */

#define WHITENING_ONE 16384.0

/* Lags at which the autocovariance is read, at most; beyond, every n-th one. */
#define LAGS_MOST 256U

static double autocovariance(const band_t *band, uint32_t points, uint32_t lag)
{
    turn_t half = turn_by(PI / (2.0 * (double)points * band->decimation));
    turn_t whole = turn_by((double)lag * (PI / (double)points));
    double sum = 0.0;
    for (uint32_t p = 0U; p < points; p++) {
        double s[3];
        spectra(band, half.now, s);
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
    assert_filter(filter);
    start_band(filter, &band);
    spectra(&band, (complex_t){1.0, 0.0}, zero);
    const uint32_t points = points_for(1.0, filter);
    const double r0 = autocovariance(&band, points, 0U);
    const double r1 = autocovariance(&band, points, 1U);
    const double r2 = autocovariance(&band, points, 2U);
    const double noisy = r0 * (1.0 + (1.0 / (12.0 * squared(COUNTS))));
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
    start_band(filter, &band);
    const uint32_t points = points_for(1.0, filter);
    const uint32_t step = ((points / 2U) > LAGS_MOST) ? ((points / 2U) / LAGS_MOST) : 1U;
    const double r0 = autocovariance(&band, points, 0U);
    double sum = 1.0;
    for (uint32_t lag = step; lag < (points / 2U); lag += step) {
        sum += 2.0 * squared(squared(autocovariance(&band, points, lag) / r0));
    }
    return sum * (double)step;
}

/* The number of standard deviations that a normal variable exceeds with probability `tail`. */
static double normal_quantile(double tail)
{
    const double step = 1.0 / 256.0;
    const double by_root_2_pi = 0.398942280401432678;
    double rest = 0.5 - tail;
    double z = 0.0;
    while (z < 5.5) {
        const double middle = z + (0.5 * step);
        const double part =
            step * by_root_2_pi * exponential((complex_t){-0.5 * squared(middle), 0.0}).re;
        if (part >= rest) {
            return z + (step * rest / part);
        }
        rest -= part;
        z += step;
    }
    return z;
}

/* Of the kurtosis, in standard deviations of ln K at 3; of the contribution, whose distribution has
 * heavier tails (4.3). */
DAVAR_RARE void davar_bound_unstable_rate(davar_config_t *config, double rate,
                                          const davar_filter_t *filter)
{
    const bool by_either = (davar_law_id(config) != 1U) && (davar_law_id(config) != 3U);
    const double length = (double)config->window.shortest;
    const double segment = (double)config->moments.segment;
    DAVAR_ASSERT((rate >= 1e-4) && (rate <= 0.1));
    DAVAR_ASSERT(config->moments.segment < config->window.shortest);
    if (filter != NULL) {
        assert_filter(filter);
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
