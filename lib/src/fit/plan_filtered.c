/* davar - the gain of a filter for white noise and drifts at each cluster size, DESIGN (5.16):
 * means over the frequencies of the sampled spectrum. */
#include "filter/spectrum.h"
#include "fit/plan.h"

/* A cluster size above this is beyond the filter: it passes white noise. */
#define SIZE_MOST 4096.0

/* Allan variance of flicker whose spectrum is 1 / angle: 2 ln 2 / pi */
#define FLICKER 0.441271200305303

/* The frequency axis of the filter as declared, and SPECTRUM_STEP above and below. */
#define AXES 3

/* Means over the frequencies, for one cluster size. */
typedef struct {
    turn_t turn;
    double kernel; /* at this frequency: 2 sin^4(m f) / (m sin^2 f), f half the angle */
    double gain[AXES];
    double flicker; /* kernel S / angle */
    double walk;    /* kernel S / angle^2 */
} sums_t;

static void add_point(sums_t *sums, double m, double sine_2, double angle, const double s[AXES])
{
    const double kernel = 2.0 * squared(squared(sums->turn.now.im)) / (m * sine_2);
    sums->kernel = kernel;
    for (int i = 0; i < AXES; i++) {
        sums->gain[i] += kernel * s[i];
    }
    sums->flicker += kernel * s[0] / angle;
    sums->walk += kernel * s[0] / squared(angle);
    turn_on(&sums->turn);
}

/* Samples over which the filter spreads a sample of noise: 1 / sum of h^4 for a response of energy
 * sum of h^2 = 1. The spectrum gives the sum of the squared autocorrelation instead, which is two
 * thirds as far above 1 for a long average and as far for one pole: the factor errs on the safe
 * side (5.19). */
static float spread_of(double mean, double square)
{
    return (float)(1.0 + 1.5 * (square / squared(mean) - 1.0));
}

/* 4 pi^2 / 12: the exponent of the correlation of successive rounding errors, over the squared step
 * (5.15). */
#define STEP_ROUNDING 3.28986813369645287

/* What rounding must not hide: the variance of a count, and of half the difference of two (5.15). */
static void plan_sample(davar_plan_t *plan, const davar_filter_t *filter)
{
    const bool is_sum = (filter->summed > 1U);
    double sample = filter->count_variance;
    double step = filter->count_step;
    if (!is_sum) {
        davar_filter_scatter(filter, &sample, &step);
    }
    const double by_sample = sample / 3.0;
    const double by_step = step * (25.0 / 6.0);
    const double hides = (by_sample < by_step) ? by_sample : by_step; /* q^2 / 12 over N^2 */
    const double summed = is_sum ? (double)filter->summed : 1.0;
    plan->white.sample = (float)sample;
    plan->white.rounding_variance = summed / 12.0;
    plan->white.hidden = (float)davar_root(summed / (12.0 * hides));
    plan->white.step = (float)(STEP_ROUNDING * step);
    plan->floor = (float)(sample / (12.0 * SPECTRUM_COUNTS * SPECTRUM_COUNTS));
}

static void plan_size(davar_plan_t *plan, int t, const sums_t *sums, double uncertainty)
{
    const double m = (double)plan->m[t];
    plan->gain[t] = (float)sums->gain[0];
    plan->flicker[t] = (float)davar_root(sums->flicker / (FLICKER * m));
    plan->walk[t] = (float)davar_root(sums->walk * 3.0 / squared(m));
    plan->offset[t] = (float)(uncertainty * (sums->gain[1] - sums->gain[2]) /
                              (2.0 * SPECTRUM_LOG_STEP * sums->gain[0]));
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

static void plan_frequencies(davar_plan_t *plan, const davar_filter_t *filter, int count)
{
    static const double stretch[AXES] = {1.0, SPECTRUM_STEP, 1.0 / SPECTRUM_STEP};
    const double last = (double)plan->m[plan->sizes - 1U];
    const uint32_t points = davar_band_points(filter, (last < SIZE_MOST) ? last : SIZE_MOST);
    sums_t sums[DAVAR_TAUS_MAX] = {0};
    band_t band[AXES];
    turn_t whole = turn_by(SPECTRUM_PI / (2.0 * (double)points));
    for (int i = 0; i < AXES; i++) {
        davar_band_start(&band[i], filter, points, stretch[i]);
    }
    for (int t = 0; t < count; t++) {
        sums[t].turn = turn_by((double)plan->m[t] * (SPECTRUM_PI / (2.0 * (double)points)));
    }
    const double share = 1.0 / (double)points;
    double mean = 0.0;
    double square = 0.0;
    for (uint32_t p = 0U; p < points; p++) {
        double s[AXES];
        for (int i = 0; i < AXES; i++) {
            s[i] = davar_band_next(&band[i]) * share;
        }
        mean += s[0];
        square += squared(s[0]) * (double)points;
        const double rounded = s[0] + (double)plan->floor * share;
        const double twice = 2.0 * squared(rounded) * (double)points;
        const double angle = ((double)p + 0.5) * (SPECTRUM_PI / (double)points);
        for (int u = 0; u < count; u++) {
            add_point(&sums[u], (double)plan->m[u], squared(whole.now.im), angle, s);
            for (int t = 0; t <= u; t++) {
                const int pair = plan_pair(t, u);
                plan->covariance[pair] = (float)((double)plan->covariance[pair] +
                                                 twice * sums[u].kernel * sums[t].kernel);
            }
        }
        turn_on(&whole);
    }
    plan->spread = spread_of(mean, square);
    for (int u = 0; u < count; u++) {
        plan_size(plan, u, &sums[u], filter->uncertainty);
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
    davar_filter_assert(filter);
    const bool is_white = davar_filter_passes_all(filter) && (filter->summed <= 1U);
    DAVAR_ASSERT(is_white || DAVAR_FILTERS);
    if (is_white) {
        davar_plan_init_white(plan, m, count);
        return;
    }
    davar_plan_start(plan, m, count);
    plan->white.declared = true;
    int near = 0;
    while ((near < count) && ((double)plan->m[near] <= SIZE_MOST)) {
        near++;
    }
    plan->level = (float)(2.0 * filter->level);
    plan_sample(plan, filter);
    plan_frequencies(plan, filter, near);
    plan_beyond(plan, near);
    davar_plan_solve(plan, count);
}
