/* davar - the gain of a filter for white noise and drifts at each cluster size, DESIGN (5.16):
 * means over the frequencies of the sampled spectrum. */
#include "filter/spectrum.h"
#include "fit/plan.h"

/* A cluster size above this is beyond the filter: it passes white noise. */
#define SIZE_MOST 4096.0

/* Allan variance of flicker whose spectrum is 1 / angle: 2 ln 2 / pi */
#define FLICKER 0.441271200305303

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

/* The filter of a count: without the sums of blocks. */
static davar_filter_t before_counts(const davar_filter_t *filter)
{
    if (filter->summed <= 1U) {
        return *filter;
    }
    return (davar_filter_t){.cutoff = filter->cutoff / (double)filter->summed,
                            .poles = filter->poles};
}

/* Samples over which the filter spreads a sample of noise: 1 / sum of h^4 for a response of energy
 * sum of h^2 = 1. The spectrum gives the sum of the squared autocorrelation instead, which is two
 * thirds as far above 1 for a long average and as far for one pole: the factor errs on the safe
 * side (5.19). */
static float spread_of(double sum, double squares, uint32_t points)
{
    return (float)(1.0 + 1.5 * (squares * (double)points / squared(sum) - 1.0));
}

/* Variances of a count and of half the difference of two, which rounding must not hide (5.15). */
static void plan_sample(davar_plan_t *plan, const davar_filter_t *filter, uint32_t points)
{
    const davar_filter_t before = before_counts(filter);
    band_t band;
    davar_band_start(&before, &band);
    double zero[3];
    davar_band_spectra(&band, (complex_t){1.0, 0.0}, zero);
    turn_t half = turn_by(SPECTRUM_PI / (2.0 * (double)points * band.decimation));
    turn_t whole = turn_by(SPECTRUM_PI / (2.0 * (double)points));
    double sample = 0.0;
    double step = 0.0;
    for (uint32_t p = 0U; p < points; p++) {
        double s[3];
        davar_band_spectra(&band, half.now, s);
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
    plan->floor = (float)(sample * mean / (12.0 * SPECTRUM_COUNTS * SPECTRUM_COUNTS));
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
    plan->offset[t] =
        (float)(uncertainty * (above - below) / (2.0 * SPECTRUM_LOG_STEP * sums->gain[0]));
}

/* Sizes beyond SIZE_MOST, from `first` on: the filter takes the same from every Allan variance. */
static void plan_beyond(davar_plan_t *plan, int first)
{
    for (int u = first; u < plan->sizes; u++) {
        if (u > 0) {
            const double less =
                (1.0 - (double)plan->gain[u - 1]) * (double)plan->m[u - 1] / (double)plan->m[u];
            plan->gain[u] = (float)(1.0 - less);
        }
        davar_plan_white_row(plan, u);
    }
}

static void plan_frequencies(davar_plan_t *plan, const band_t *band, int count)
{
    const double last = (double)plan->m[plan->sizes - 1U];
    const uint32_t points = davar_band_points((last < SIZE_MOST) ? last : SIZE_MOST, band->filter);
    sums_t sums[DAVAR_TAUS_MAX] = {0};
    double zero[3];
    davar_band_spectra(band, (complex_t){1.0, 0.0}, zero);
    plan_sample(plan, band->filter, points);
    turn_t half = turn_by(SPECTRUM_PI / (2.0 * (double)points * band->decimation));
    turn_t whole = turn_by(SPECTRUM_PI / (2.0 * (double)points));
    for (int t = 0; t < count; t++) {
        sums[t].turn = turn_by((double)plan->m[t] * (SPECTRUM_PI / (2.0 * (double)points)));
    }
    const double mean = 1.0 / (zero[0] * (double)points);
    double sum = 0.0;
    double squares = 0.0;
    for (uint32_t p = 0U; p < points; p++) {
        double s[3];
        davar_band_spectra(band, half.now, s);
        sum += s[0];
        squares += squared(s[0]);
        const double rounded = s[0] / zero[0] + (double)plan->floor;
        const double twice = 2.0 * squared(rounded) / (double)points;
        const double angle = ((double)p + 0.5) * (SPECTRUM_PI / (double)points);
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
    plan->spread = spread_of(sum, squares, points);
    for (int u = 0; u < count; u++) {
        plan_size(plan, u, &sums[u], mean, zero, band->filter->uncertainty);
        for (int t = 0; t <= u; t++) {
            const int pair = plan_pair(t, u);
            plan->covariance[pair] = (float)((double)plan->covariance[pair] /
                                             ((double)plan->gain[t] * (double)plan->gain[u]));
        }
    }
}

DAVAR_RARE void davar_plan_init_filtered(davar_plan_t *plan, const uint32_t *m, uint8_t count,
                                         const davar_filter_t *filter)
{
    band_t band;
    davar_filter_assert(filter);
    if ((filter->poles == 0U) && (filter->averages == 0U)) {
        davar_plan_init_white(plan, m, count);
        return;
    }
    davar_plan_start(plan, m, count);
    plan->declared = true;
    davar_band_start(filter, &band);
    int near = 0;
    while ((near < count) && ((double)plan->m[near] <= SIZE_MOST)) {
        near++;
    }
    plan_frequencies(plan, &band, near);
    plan_beyond(plan, near);
    davar_plan_solve(plan, count);
}
