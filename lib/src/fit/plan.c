/* davar - what a fit needs of the cluster sizes alone, DESIGN (5.3) (5.4): for white noise beside one more term the fit is linear in
 * the Allan variances, and so are its variances in 1 / (number of differences). In doubles, once. */
#include "fit/plan.h"

#include "fit/noise.h"
#include "number/real.h"

static double last_of(const davar_plan_t *plan)
{
    return (double)plan->m[plan->count - 1U];
}

/* The shape of a term in y, at most 1 so that nothing leaves the range of a float. */
static double shape(const davar_plan_t *plan, int term, int t)
{
    const double m = (double)plan->m[t];
    const double u = m / last_of(plan);
    switch (term) {
    case DAVAR_QUANTIZATION:
        return (double)plan->m[0] / m;
    case DAVAR_ANGLE_RANDOM_WALK:
        return 1.0;
    case DAVAR_BIAS_INSTABILITY:
        return u;
    case DAVAR_RATE_RANDOM_WALK:
        return u * u;
    default:
        return u * u * u;
    }
}

/* The power of two above a positive number. */
static double power_above(double value)
{
    return davar_double_of_bits(((davar_bits_of_double(value) >> 52U) + 1U) << 52U);
}

static int32_t rounded(double value)
{
    return (int32_t)((value < 0.0) ? (value - 0.5) : (value + 0.5));
}

/* A power of two above all of them, 1 where all are 0. */
static double scale_of(const double values[], int count)
{
    double largest = 0.0;
    for (int t = 0; t < count; t++) {
        const double size = (values[t] < 0.0) ? -values[t] : values[t];
        largest = (size > largest) ? size : largest;
    }
    return (largest > 0.0) ? power_above(largest) : 1.0;
}

/* As fixed point of 29 bits, in units of scale. */
static void store(const double values[], int count, double scale, int32_t fixed[])
{
    for (int t = 0; t < count; t++) {
        fixed[t] = rounded(values[t] * (DAVAR_FIT_FUNCTIONAL_ONE / scale));
    }
}

/* Regression of y on a constant and one shape: amplitude = sum functional y, functional = gain * w (x - centre); the constant
 * itself has centre 0. One cluster size alone shows a constant and nothing else. */
static void plan_regression(davar_plan_t *plan, int term)
{
    double w_sum = 0.0;
    double wx_sum = 0.0;
    for (int t = 0; t < plan->count; t++) {
        w_sum += (double)plan->weight[t];
        wx_sum += (double)plan->weight[t] * shape(plan, term, t);
    }
    const double centre = (term == WHITE) ? 0.0 : wx_sum / w_sum;
    double square = 0.0;
    for (int t = 0; t < plan->count; t++) {
        const double x = shape(plan, term, t) - centre;
        square += (double)plan->weight[t] * x * x;
    }
    const double gain = ((term == WHITE) || (plan->count > 1U)) ? 1.0 / square : 0.0;
    double functional[DAVAR_TAUS_MAX];
    for (int t = 0; t < plan->count; t++) {
        functional[t] = gain * (double)plan->weight[t] * (shape(plan, term, t) - centre);
    }
    const double scale = (term == WHITE) ? 1.0 : scale_of(functional, plan->count); /* the sum of white noise's is 1 */
    store(functional, plan->count, scale, plan->functional[term]);
    plan->scale[term] = (float)scale;
    const float per_share = (float)centre * plan->scale[term];
    plan->centre[term] = (per_share < DAVAR_FIT_CENTRE_MOST) ? per_share : DAVAR_FIT_CENTRE_MOST;
}

/* Variance of an amplitude under white noise, N = 1, folded so that a window length costs one product per cluster size:
 * the covariance of two cluster sizes falls with the number of differences of the shorter one (5.4). */
static void plan_variance(davar_plan_t *plan, int term)
{
    const double one = 1.0 / DAVAR_FIT_FUNCTIONAL_ONE;
    double variance[DAVAR_TAUS_MAX];
    for (int i = 0; i < plan->count; i++) {
        const double m_i = (double)plan->m[i];
        double sum = 0.0;
        for (int j = i; j < plan->count; j++) {
            const double m_j = (double)plan->m[j];
            const double twice = (j > i) ? 2.0 : 1.0;
            const double functional = (double)plan->functional[term][j] * one;
            sum += twice * functional * davar_noise_white_overlap(m_i, m_j) / (2.0 * m_i * m_j);
        }
        variance[i] = (double)plan->functional[term][i] * one * sum;
    }
    const double scale = scale_of(variance, plan->count);
    store(variance, plan->count, scale, plan->variance[term]);
    plan->variance_exponent[term] = (int8_t)((int32_t)(davar_bits_of_double(scale) >> 52U) - 1023);
}

/* Weights of a white fit: 1 / m, shared among crowded neighbours (the gap between the geometric means with them, on the
 * scale of 1 / m). Within 1 % of the full inverse covariance for octaves and geometric lists from m = 1, without its
 * conditioning. The first entry also stands for all shorter sizes, the last one for half of all longer (5.4). */
static void plan_weights(davar_plan_t *plan)
{
    const int end = plan->count - 1;
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
}

/* Standard deviation of the misfit under white noise: twice the sum of the squared correlations is its variance. */
static double white_misfit_spread(const davar_plan_t *plan)
{
    double sum = 0.0;
    for (int j = 0; j < plan->count; j++) {
        for (int i = 0; i <= j; i++) {
            const double both = davar_noise_white_overlap((double)plan->m[i], (double)plan->m[j]);
            const double one = davar_noise_white_overlap((double)plan->m[i], (double)plan->m[i]);
            const double other = davar_noise_white_overlap((double)plan->m[j], (double)plan->m[j]);
            sum += ((i < j) ? 4.0 : 2.0) * (both * both) / (one * other);
        }
    }
    return davar_root(sum);
}

/* The largest sum of edf (y - 1)^2 that is no misfit (5.9). */
static uint64_t misfit_limit(const davar_plan_t *plan)
{
    const double most = 2.0 * ((double)(plan->count - 1) + DAVAR_FIT_MISFIT * (double)plan->misfit_spread);
    return (uint64_t)(most * DAVAR_FIT_MISFIT_ONE);
}

/* What turns the amplitude of a shape into a[k] of avar = sum a[k] m^(k - 2). */
static void plan_units(davar_plan_t *plan)
{
    const float inverse = (float)(1.0 / last_of(plan));
    plan->unit[DAVAR_QUANTIZATION] = plan->m[0];
    plan->unit[WHITE] = 1.0F;
    plan->unit[DAVAR_BIAS_INSTABILITY] = inverse;
    plan->unit[DAVAR_RATE_RANDOM_WALK] = inverse * inverse;
    plan->unit[DAVAR_RATE_RAMP] = inverse * inverse * inverse;
}

DAVAR_RARE void davar_plan_init(davar_plan_t *plan, const uint32_t *m, uint8_t count)
{
    DAVAR_ASSERT(count >= 1U);
    plan->count = count;
    plan->window = 0U;
    plan->rate_hz = 0.0;
    for (int t = 0; t < count; t++) {
        plan->m[t] = (float)m[t];
        plan->freedom[t] = (float)davar_noise_white_weight((double)m[t]);
    }
    plan_units(plan);
    plan_weights(plan);
    plan->misfit_spread = (float)white_misfit_spread(plan);
    plan->misfit_limit = misfit_limit(plan);
    for (int k = 0; k < TERMS; k++) {
        plan_regression(plan, k);
        plan_variance(plan, k);
    }
}

DAVAR_RARE static void replan(davar_plan_t *plan, const davar_result_t *result, uint8_t count)
{
    uint32_t m[DAVAR_TAUS_MAX] = {0};
    for (int t = 0; t < count; t++) {
        m[t] = result->tau[t].m;
    }
    davar_plan_init(plan, m, count);
}

void davar_fit_prepare(davar_plan_t *plan, const davar_result_t *result)
{
    const uint8_t count = davar_fit_usable(result);
    if (count == 0U) {
        return;
    }
    if (plan->count != count) {
        replan(plan, result, count);
    }
    davar_fit_prepare_window(plan, result);
}
