/* davar - the plan of a fit: what follows from the cluster sizes and the filter, once, in doubles,
 * DESIGN (5.3) (5.4). White noise and one more term are fitted linearly in the Allan variances, and
 * the variances of that fit are linear in 1 / (number of differences). */
#include "fit/plan.h"

#include "number/real.h"

/* --- the cluster sizes (5.3) (5.4) --- */

/* The window that the weights are made for, in longest sizes. */
#define WINDOW_IN_SIZES 9.0

/* Sizes that are nearly equal make the covariance singular. This share of its diagonal is added. */
#define RIDGE 1e-4

/* Relative to white noise and rounding, an estimate scatters as in counts half as coarse as those of
 * plan->floor, or less (5.15). */
#define FINE_FLOOR 0.25

/* Noise is hidden below this share of what rounding could hide. If it were 1, half a count would be
 * reported where its random fluctuation exceeds it, with a mean 4 % too high (5.15). */
#define NEARLY 0.94

#define PAIRS ((DAVAR_TAUS_MAX * (DAVAR_TAUS_MAX + 1)) / 2)

static double last_of(const davar_plan_t *plan)
{
    return (double)plan->m[plan->white.count - 1U];
}

/* Covariance of y at sizes t <= u for N = 1, in the window that the weights are made for. */
static double covariance_of(const davar_plan_t *plan, int t, int u)
{
    const double effective = WINDOW_IN_SIZES * last_of(plan) + 1.0 - 1.5 * (double)plan->m[t];
    return (double)plan->covariance[plan_pair(t, u)] / effective +
           (double)plan->offset[t] * (double)plan->offset[u];
}

/* Cholesky: covariance = L L'. The diagonal of L is stored as its reciprocal. 0: the covariance is
 * none, because it is approximate above m = 4096 (5.16), and the size gets no weight. */
static void factorise(const davar_plan_t *plan, float l[])
{
    for (int u = 0; u < plan->white.count; u++) {
        for (int t = 0; t <= u; t++) {
            const double whole = covariance_of(plan, t, u);
            double left = whole * ((t == u) ? (1.0 + RIDGE) : 1.0);
            for (int s = 0; s < t; s++) {
                left -= (double)l[plan_pair(s, t)] * (double)l[plan_pair(s, u)];
            }
            if (t == u) {
                l[plan_pair(u, u)] =
                    (left > (RIDGE * whole)) ? (float)(1.0 / davar_root(left)) : 0.0F;
            } else {
                l[plan_pair(t, u)] = (float)(left * (double)l[plan_pair(t, t)]);
            }
        }
    }
}

/* x = (L L')^-1 x */
static void solve_factored(const float l[], int count, double x[])
{
    for (int u = 0; u < count; u++) {
        for (int t = 0; t < u; t++) {
            x[u] -= (double)l[plan_pair(t, u)] * x[t];
        }
        x[u] *= (double)l[plan_pair(u, u)];
    }
    for (int t = count - 1; t >= 0; t--) {
        for (int u = t + 1; u < count; u++) {
            x[t] -= (double)l[plan_pair(t, u)] * x[u];
        }
        x[t] *= (double)l[plan_pair(t, t)];
    }
}

static double product(const double a[], const double b[], int count)
{
    double sum = 0.0;
    for (int t = 0; t < count; t++) {
        sum += a[t] * b[t];
    }
    return sum;
}

/* The shape in y of a term other than white noise. Without a filter it is at most 1, so that all
 * values stay in the range of a float. */
static double shape(const davar_plan_t *plan, int term, int t)
{
    const double m = (double)plan->m[t];
    const double u = m / last_of(plan);
    const double gain = 1.0 / (double)plan->gain[t];
    switch (term) {
    case DAVAR_QUANTIZATION:
        return (double)plan->m[0] / m * gain;
    case DAVAR_BIAS_INSTABILITY:
        return u * gain * (double)plan->flicker[t] * (double)plan->flicker[t];
    case DAVAR_RATE_RANDOM_WALK:
        return u * u * gain * (double)plan->walk[t] * (double)plan->walk[t];
    default:
        return u * u * u * gain;
    }
}

/* A power of two above all sizes; 1 if all values are 0. */
static double scale_of(const double values[], int count)
{
    double largest = 0.0;
    for (int t = 0; t < count; t++) {
        const double size = (values[t] < 0.0) ? -values[t] : values[t];
        largest = (size > largest) ? size : largest;
    }
    return (largest > 0.0)
               ? davar_double_of_bits(((davar_bits_of_double(largest) >> 52U) + 1U) << 52U)
               : 1.0;
}

/* Stores the values as fixed point of 29 bits, in units of scale. */
static void store(const double values[], int count, double scale, int32_t fixed[])
{
    for (int t = 0; t < count; t++) {
        const double value = values[t] * (DAVAR_FIT_FUNCTIONAL_ONE / scale);
        fixed[t] = (int32_t)((value < 0.0) ? (value - 0.5) : (value + 0.5));
    }
}

/* The functional of an amplitude by generalised least squares of y on a constant and one shape
 * (5.4), without its scale. `constant` is the functional of the constant alone. Returns the centre
 * of the shape. One cluster size alone resolves the constant only. */
static double functional_of(const davar_plan_t *plan, const float l[], const double constant[],
                            int term, double functional[])
{
    const int count = plan->white.count;
    double x[DAVAR_TAUS_MAX];
    for (int t = 0; t < count; t++) {
        x[t] = shape(plan, term, t);
    }
    const double centre = product(constant, x, count);
    for (int t = 0; t < count; t++) {
        functional[t] = x[t] - centre;
    }
    solve_factored(l, count, functional);
    const double square = product(functional, x, count);
    const double gain = (square > 0.0) ? (1.0 / square) : 0.0;
    for (int t = 0; t < count; t++) {
        functional[t] *= gain;
    }
    return centre;
}

/* Variance of an amplitude under white noise, N = 1. The covariance of two cluster sizes falls with
 * the number of differences of the shorter one, so the sum over the longer ones is fixed and a
 * window length costs one product per size (5.4). */
static void plan_variance(davar_plan_t *plan, int term, const double functional[], double share)
{
    double variance[DAVAR_TAUS_MAX];
    for (int t = 0; t < plan->white.count; t++) {
        double sum = 0.0;
        for (int u = t; u < plan->white.count; u++) {
            const double twice = (u > t) ? 2.0 : 1.0;
            sum += twice * functional[u] * (double)plan->covariance[plan_pair(t, u)];
        }
        variance[t] = functional[t] * sum * share;
    }
    const double scale = scale_of(variance, plan->white.count);
    store(variance, plan->white.count, scale, plan->variance[term]);
    plan->variance_exponent[term] = (int8_t)((int32_t)(davar_bits_of_double(scale) >> 52U) - 1023);
}

/* Sum of functional / gain: the white noise that rounding of variance 1 looks like. */
static double rounding_in(const davar_plan_t *plan, const double functional[])
{
    double sum = 0.0;
    for (int t = 0; t < plan->white.count; t++) {
        sum += functional[t] / (double)plan->gain[t];
    }
    return sum;
}

/* The largest size of an amplitude that errors of up to 1 in the rounding of each size can have. */
static double rounding_most(const davar_plan_t *plan, const double functional[])
{
    double sum = 0.0;
    for (int t = 0; t < plan->white.count; t++) {
        const double size = (functional[t] < 0.0) ? -functional[t] : functional[t];
        sum += size / (double)plan->gain[t];
    }
    return sum;
}

static double offset_in(const davar_plan_t *plan, const double functional[])
{
    double sum = 0.0;
    for (int t = 0; t < plan->white.count; t++) {
        sum += functional[t] * (double)plan->offset[t];
    }
    return sum;
}

/* One term: its functional, in units of `scale`, and what follows from it. `share`: white noise
 * over white noise and rounding, squared. */
static void plan_amplitude(davar_plan_t *plan, int term, double functional[], double centre,
                           double share)
{
    const double scale = scale_of(functional, plan->white.count);
    const double offset = offset_in(plan, functional) / scale;
    store(functional, plan->white.count, scale, plan->white.functional[term]);
    for (int t = 0; t < plan->white.count; t++) {
        functional[t] /= scale;
    }
    plan_variance(plan, term, functional, share);
    plan->scale[term] = (float)scale;
    plan->white.rounding_most[term] = (float)rounding_most(plan, functional);
    const float per_share = (float)centre * plan->scale[term];
    const float most = (per_share < DAVAR_FIT_CENTRE_MOST) ? per_share : DAVAR_FIT_CENTRE_MOST;
    plan->white.centre[term] = (most > DAVAR_FIT_CENTRE_LEAST) ? most : DAVAR_FIT_CENTRE_LEAST;
    plan->offset_variance[term] = (float)(offset * offset);
}

/* White noise itself: the functional in units of 2^white_bits, at least 1. */
static void plan_white(davar_plan_t *plan, double constant[], double share)
{
    const double scale = scale_of(constant, plan->white.count);
    const uint32_t exponent = (uint32_t)(davar_bits_of_double(scale) >> 52U);
    plan_variance(plan, WHITE, constant, share);
    plan->white.white_bits = (exponent > 1023U) ? (uint8_t)(exponent - 1023U) : 0U;
    store(constant, plan->white.count, (scale > 1.0) ? scale : 1.0, plan->white.functional[WHITE]);
    plan->white.rounding_most[WHITE] = (float)rounding_most(plan, constant);
    const double offset = offset_in(plan, constant);
    const double level = (double)plan->level;
    plan->offset_variance[WHITE] =
        (float)((DAVAR_FIT_AXIS_MARGIN * offset * offset) + (level * level));
    plan->scale[WHITE] = 1.0F;
    plan->white.centre[WHITE] = 0.0F;
}

/* Standard deviation of the misfit. Its variance is twice the sum of the squared correlations. */
static double misfit_spread(const davar_plan_t *plan)
{
    double sum = 0.0;
    for (int u = 0; u < plan->white.count; u++) {
        for (int t = 0; t <= u; t++) {
            const double both = (double)plan->covariance[plan_pair(t, u)];
            const double one = (double)plan->covariance[plan_pair(t, t)];
            const double other = (double)plan->covariance[plan_pair(u, u)];
            sum += ((t < u) ? 4.0 : 2.0) * (both * both) / (one * other);
        }
    }
    return davar_root(sum);
}

/* The part of the uncertain cutoff that moves a size against white noise, and the factors of y. */
static void plan_taus(davar_plan_t *plan, const double constant[])
{
    const double common = offset_in(plan, constant);
    const double level = (double)plan->level;
    for (int t = 0; t < plan->white.count; t++) {
        const double gain = (double)plan->gain[t];
        const double offset = (double)plan->offset[t] - common;
        plan->white.to_white[t] = (float)((double)plan->m[t] / gain);
        plan->doubtful[t] = (float)(0.5 * ((offset * offset) + (level * level)));
        const double inverse = (double)(UINT32_C(1) << DAVAR_FIT_GAIN_BITS) / gain + 0.5;
        plan->white.inverse_gain[t] = (inverse < 4294967295.0) ? (uint32_t)inverse : UINT32_MAX;
    }
}

/* Rounding over white noise from which it hides it (5.15). */
static uint32_t coarse_from(const davar_plan_t *plan)
{
    const double hides =
        (double)plan->white.sample / (3.0 * NEARLY * NEARLY); /* 0.38 without a filter */
    return (uint32_t)(((hides < 2.0) ? hides : 2.0) * (double)(UINT32_C(1) << NOISE_BITS));
}

/* Degrees of freedom per effective difference. */
static void plan_freedom(davar_plan_t *plan)
{
    for (int t = 0; t < plan->sizes; t++) {
        const double rounded = 1.0 + (double)plan->floor / (double)plan->gain[t];
        plan->freedom[t] =
            (float)(2.0 * rounded * rounded / (double)plan->covariance[plan_pair(t, t)]);
    }
}

/* Weights of the fit of a mixture: 1 / m, shared among crowded neighbours. Each is the distance
 * between the geometric means with its neighbours, on the scale of 1 / m. The first entry also
 * represents all shorter sizes, the last one half of all longer ones. After a filter, a size with
 * fewer degrees of freedom counts less (5.6). */
static void plan_weights(davar_plan_t *plan)
{
    const int end = plan->sizes - 1;
    const double first = (double)plan->m[0];
    const double last = (double)plan->m[end];
    const double second = (double)plan->m[(end > 0) ? 1 : 0];
    const double next_to_last = (double)plan->m[(end > 0) ? end - 1 : 0];
    double from = 1.0 / davar_root(first * first * first / second);
    for (int t = 0; t < end; t++) {
        const double to = 1.0 / davar_root((double)plan->m[t] * (double)plan->m[t + 1]);
        plan->weight[t] = (float)(from - to);
        from = to;
    }
    const double beyond = 1.0 / davar_root(last * last * last / next_to_last);
    plan->weight[end] = (float)(from - 0.5 * beyond);
    plan->weight[0] *= (float)(1.0 + 2.35 * (1.0 - 1.0 / (first * first)));
    for (int t = 0; t <= end; t++) {
        const double white = davar_noise_white_weight((double)plan->m[t]);
        plan->weight[t] *= (float)((double)plan->freedom[t] / white);
    }
}

/* Factors from the amplitude of a shape to a[k] of avar = sum a[k] m^(k - 2). */
static void plan_units(davar_plan_t *plan)
{
    const float inverse = (float)(1.0 / last_of(plan));
    plan->unit[DAVAR_QUANTIZATION] = plan->m[0];
    plan->unit[WHITE] = 1.0F;
    plan->unit[DAVAR_BIAS_INSTABILITY] = inverse;
    plan->unit[DAVAR_RATE_RANDOM_WALK] = inverse * inverse;
    plan->unit[DAVAR_RATE_RAMP] = inverse * inverse * inverse;
}

DAVAR_RARE void davar_plan_solve(davar_plan_t *plan, uint8_t count)
{
    float l[PAIRS];
    double constant[DAVAR_TAUS_MAX];
    double functional[DAVAR_TAUS_MAX];
    plan->white.count = count;
    plan->white.window = 0U;
    plan->rate_hz = 0.0;
    factorise(plan, l);
    for (int t = 0; t < count; t++) {
        constant[t] = 1.0;
    }
    solve_factored(l, count, constant);
    double sum = 0.0;
    for (int t = 0; t < count; t++) {
        sum += constant[t];
    }
    for (int t = 0; t < count; t++) {
        constant[t] *= 1.0 / sum;
    }
    const double rounding = rounding_in(plan, constant);
    const double share = 1.0 / (1.0 + FINE_FLOOR * (double)plan->floor * rounding);
    for (int k = 0; k < TERMS; k++) {
        if (k != WHITE) {
            const double centre = functional_of(plan, l, constant, k, functional);
            plan_amplitude(plan, k, functional, centre, share * share);
        }
    }
    plan_taus(plan, constant);
    plan->white.passed = 0U;
    while ((plan->white.passed + 1U < count) &&
           (plan->gain[plan->white.passed] < DAVAR_FIT_PASSED)) {
        plan->white.passed++;
    }
    plan_white(plan, constant, share * share);
    plan->white.rounding = (float)rounding;
    plan->white.coarse = coarse_from(plan);
    plan_units(plan);
    plan_freedom(plan);
    plan_weights(plan);
    plan->misfit_spread = (float)misfit_spread(plan);
    /* The largest sum of edf (y - 1)^2 that is not a misfit (5.9). */
    const double most =
        2.0 * ((double)(count - 1) + DAVAR_FIT_MISFIT * (double)plan->misfit_spread);
    plan->white.misfit_limit = (uint64_t)(most * DAVAR_FIT_MISFIT_ONE);
}

DAVAR_RARE void davar_plan_start(davar_plan_t *plan, const uint32_t *m, uint8_t count)
{
    DAVAR_ASSERT(count >= 1U);
    *plan = (davar_plan_t){.sizes = count,
                           .white.sample = 1.0F,
                           .spread = 1.0F,
                           .white.hidden = 0.5F,
                           .white.rounding_variance = 1.0 / 12.0};
    for (int t = 0; t < count; t++) {
        plan->m[t] = (float)m[t];
        plan->gain[t] = 1.0F;
        plan->flicker[t] = 1.0F;
        plan->walk[t] = 1.0F;
    }
}

DAVAR_RARE void davar_plan_white_row(davar_plan_t *plan, int u)
{
    const double m_u = (double)plan->m[u];
    for (int t = 0; t <= u; t++) {
        const double m_t = (double)plan->m[t];
        plan->covariance[plan_pair(t, u)] =
            (float)(davar_noise_white_overlap(m_t, m_u) / (2.0 * m_t * m_u));
    }
}

DAVAR_RARE static void plan_samples(davar_plan_t *plan, const uint32_t *m, uint8_t count,
                                    bool declared)
{
    DAVAR_ASSERT(declared || DAVAR_FILTERS);
    davar_plan_start(plan, m, count);
    for (int u = 0; u < count; u++) {
        davar_plan_white_row(plan, u);
    }
    davar_plan_solve(plan, count);
    plan->white.declared = declared;
}

DAVAR_RARE void davar_plan_init(davar_plan_t *plan, const uint32_t *m, uint8_t count)
{
    plan_samples(plan, m, count, false);
}

DAVAR_RARE void davar_plan_init_white(davar_plan_t *plan, const uint32_t *m, uint8_t count)
{
    plan_samples(plan, m, count, true);
}
