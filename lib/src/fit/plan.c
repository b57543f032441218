/* davar - the plan of a fit: values that depend on the cluster sizes, the window length and the
 * rate alone, DESIGN (1.2) (5.3) to (5.5). White noise and one more term are fitted linearly in the
 * Allan variances, and the variances of that fit are linear in 1 / (number of differences). Cluster
 * sizes and rate are planned once, in doubles. The window is planned in integers, like the short
 * cut that uses it (5.14). */
#include "fit/plan.h"

#include "number/real.h"

/* --- positive numbers with one exponent (5.14) --- */

#define SPARE 4

int32_t davar_align(scaled_t value[], int count)
{
    int32_t common = INT32_MIN;
    for (int t = 0; t < count; t++) {
        common = (value[t].exponent > common) ? value[t].exponent : common;
    }
    common += SPARE;
    for (int t = 0; t < count; t++) {
        const uint32_t shift = (uint32_t)(common - value[t].exponent);
        value[t].mantissa = (shift > 31U) ? 0U : (value[t].mantissa >> shift);
        value[t].exponent = common;
    }
    return common;
}

uint64_t davar_aligned_sum(const int32_t factor[], const scaled_t value[], int count)
{
    uint64_t sum = 0U; /* modulo 2^64 */
    for (int t = 0; t < count; t++) {
        sum += davar_multiply_i32(factor[t], (int32_t)value[t].mantissa);
    }
    return sum & ((sum >> 63U) - 1U);
}

/* --- the cluster sizes (5.3) (5.4) --- */

static double last_of(const davar_plan_t *plan)
{
    return (double)plan->m[plan->count - 1U];
}

/* The shape of a term in y. It is at most 1, so that all values stay in the range of a float. */
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

/* Regression of y on a constant and one shape (5.4): amplitude = sum functional y, functional =
 * gain * w (x - centre). The constant itself has centre 0. One cluster size alone resolves the
 * constant only. */
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
    /* The functional of white noise adds up to 1. */
    const double scale = (term == WHITE) ? 1.0 : scale_of(functional, plan->count);
    store(functional, plan->count, scale, plan->functional[term]);
    plan->scale[term] = (float)scale;
    const float per_share = (float)centre * plan->scale[term];
    plan->centre[term] = (per_share < DAVAR_FIT_CENTRE_MOST) ? per_share : DAVAR_FIT_CENTRE_MOST;
}

/* Variance of an amplitude under white noise, N = 1. The covariance of two cluster sizes falls with
 * the number of differences of the shorter one, so the sum over the longer ones is fixed and a
 * window length costs one product per size (5.4). */
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

/* Weights of a white fit: 1 / m, shared among crowded neighbours. Each is the distance between the
 * geometric means with its neighbours, on the scale of 1 / m. The first entry also represents all
 * shorter sizes, the last one half of all longer ones (5.4). */
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

/* Standard deviation of the misfit under white noise. Its variance is twice the sum of the squared
 * correlations. */
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
    /* The largest sum of edf (y - 1)^2 that is not a misfit (5.9). */
    const double most =
        2.0 * ((double)(plan->count - 1) + DAVAR_FIT_MISFIT * (double)plan->misfit_spread);
    plan->misfit_limit = (uint64_t)(most * DAVAR_FIT_MISFIT_ONE);
    for (int k = 0; k < TERMS; k++) {
        plan_regression(plan, k);
        plan_variance(plan, k);
    }
}

/* 2^-bits */
static scaled_t half_to_the(int32_t bits)
{
    const scaled_t scaled = {SCALED_TOP, -31 - bits};
    return scaled;
}

static scaled_t scaled_ratio(uint32_t dividend, uint32_t divisor)
{
    return scaled_times(scaled_of_u32(dividend, 0), scaled_inverse(scaled_of_u32(divisor, 0)));
}

/* --- the rate --- */

/* The units of (1.2) are factor * rate^(k - 2), correctly rounded in doubles: rates that differ in
 * the last bit give results that differ as little. */
static const double factor[] = {1.0 / 3.0, 3600.0,
                                3600.0 * 3600.0 * 2.2661800709135971 /* pi / (2 ln 2) */,
                                216000.0 * 216000.0 * 3.0, 12960000.0 * 12960000.0 * 2.0};

/* rate_hz to the power of 0, 1 or 2; 1 for negative powers. */
static double power_of(double rate_hz, int power)
{
    if (power <= 0) {
        return 1.0;
    }
    return (power == 1) ? rate_hz : davar_scale(rate_hz, rate_hz);
}

void davar_square_units(double rate_hz, double unit[])
{
    for (int k = 0; k < TERMS; k++) {
        unit[k] = davar_scale(factor[k], power_of(rate_hz, k - 2)) / power_of(rate_hz, 2 - k);
    }
}

void davar_plan_rate(davar_plan_t *plan, double rate_hz)
{
    for (int k = 0; k < TERMS; k++) {
        const double square =
            davar_scale(factor[k], scaled_to_double(scaled_of_float(plan->unit[k])));
        plan->root[k] = davar_root_of_quotient(davar_scale(square, power_of(rate_hz, k - 2)),
                                               power_of(rate_hz, 2 - k));
    }
    plan->rate_hz = rate_hz;
}

/* --- the window (5.5) --- */

uint8_t davar_fit_usable(const davar_result_t *result)
{
    uint8_t count = 0U;
    while ((count < result->tau_count) && (result->tau[count].differences > 0U)) {
        count++;
    }
    return count;
}

/* Law glr chose this window by its data (10.14): it has just cut the window, or it omitted more
 * than half of the samples since the cut, because they were not quite alike. */
static bool is_chosen(const davar_result_t *result)
{
    return result->young || (result->cut_age_samples > (2U * result->window_samples));
}

/* Does every difference of the first `count` cluster sizes exist once and count fully: no gap, no
 * mirror image? */
static bool is_whole(const davar_result_t *result, int count)
{
    uint32_t lost = result->mirrored_samples | (is_chosen(result) ? 1U : 0U);
    for (int t = 0; t < count; t++) {
        lost |= (result->window_samples + 1U - 2U * result->tau[t].m) ^ result->tau[t].differences;
    }
    return lost == 0U;
}

scaled_t davar_fit_evidence(const davar_result_t *result)
{
    const scaled_t share = scaled_ratio(result->window_samples,
                                        result->window_samples + (2U * result->mirrored_samples));
    return is_chosen(result) ? scaled_times(share, scaled_of_u32(7U, -4)) : share;
}

/* Differences + m / 2 (5.3), reduced for gaps and by the share of new evidence. */
static scaled_t effective(const davar_adev_t *tau, uint32_t window, scaled_t evidence)
{
    const uint32_t all = window + 1U - (2U * tau->m);
    const scaled_t differences = scaled_of_u32((2U * all) + tau->m, -1);
    return scaled_times(scaled_times(differences, scaled_ratio(tau->differences, all)), evidence);
}

static scaled_t at_least_one(scaled_t value)
{
    return (value.exponent < -31) ? half_to_the(0) : value;
}

static void plan_tau(davar_plan_t *plan, int t, scaled_t freedom)
{
    const scaled_t edf = at_least_one(freedom);
    scaled_t low;
    scaled_t high;
    davar_chi_square(edf, &low, &high);
    plan->edf[t] = scaled_to_double(edf);
    plan->root_edf[t] = scaled_to_fixed(scaled_root(edf), DAVAR_FIT_ROOT_BITS);
    plan->low[t] = scaled_to_float(scaled_root(low));
    plan->high[t] = scaled_to_float(scaled_root(high));
}

/* Odd, so never 0. One cluster size, or nearly equal ones, resolve no term: (5.4) then gives a
 * variance of 0, or below 0 by its inaccuracy. Such a sigma is unknown and becomes the largest. */
static uint32_t fixed_sigma(scaled_t sigma)
{
    const uint32_t fixed = scaled_to_fixed(sigma, DAVAR_FIT_SHARE_BITS);
    return (((fixed - 1U) < DAVAR_FIT_SIGMA_MOST) ? fixed : DAVAR_FIT_SIGMA_MOST) | 1U;
}

/* One term next to white noise: its sigma, the factor of its upper limit, room = sqrt((1 + margin)
 * scale) (5.11), and the uncertainty that it adds to N^2 (5.10). */
static void plan_term(davar_plan_t *plan, int k, scaled_t of_white, scaled_t variance)
{
    const scaled_t sigma = (variance.mantissa != 0U) ? scaled_root(variance) : variance;
    const scaled_t scale = scaled_of_float(plan->scale[k]);
    const scaled_t margin =
        scaled_times(scaled_times(scaled_of_double(DAVAR_FIT_BOUND), sigma), scale);
    const scaled_t centre = scaled_of_float(plan->centre[k]);
    const scaled_t of_term = scaled_times(scaled_times(centre, centre), variance);
    const scaled_t half = scaled_times(half_to_the(1), scaled_plus(of_white, of_term));
    plan->sigma[k] = fixed_sigma(sigma);
    plan->room[k] =
        scaled_to_float(scaled_root(scaled_times(scaled_plus(half_to_the(0), margin), scale)));
    plan->doubt[k] = scaled_to_fixed(scaled_root(half), NOISE_BITS);
}

/* Variance of an amplitude, from aligned values of 1 / effective differences. */
static scaled_t variance_of(const davar_plan_t *plan, int term, const scaled_t inverse[],
                            int32_t exponent)
{
    const uint64_t sum = davar_aligned_sum(plan->variance[term], inverse, plan->count);
    return scaled_of_u64(sum, exponent + plan->variance_exponent[term] -
                                  (int32_t)DAVAR_FIT_FUNCTIONAL_BITS);
}

static void plan_window(davar_plan_t *plan, const davar_result_t *result)
{
    const scaled_t evidence = davar_fit_evidence(result);
    scaled_t inverse[DAVAR_TAUS_MAX];
    scaled_t low;
    scaled_t high;
    for (int t = 0; t < plan->count; t++) {
        const scaled_t differences = effective(&result->tau[t], result->window_samples, evidence);
        plan_tau(plan, t, scaled_times(scaled_of_float(plan->freedom[t]), differences));
        inverse[t] = scaled_inverse(differences);
    }
    const int32_t exponent = davar_align(inverse, plan->count);
    const scaled_t of_white = variance_of(plan, WHITE, inverse, exponent);
    davar_chi_square(at_least_one(scaled_times(half_to_the(-1), scaled_inverse(of_white))), &low,
                     &high);
    plan->white_low = scaled_to_fixed(low, NOISE_BITS);
    plan->white_high = scaled_to_float(scaled_root(high));
    for (int k = 0; k < TERMS; k++) {
        plan_term(plan, k, of_white, variance_of(plan, k, inverse, exponent));
    }
}

void davar_fit_prepare_window(davar_plan_t *plan, const davar_result_t *result)
{
    const bool whole = is_whole(result, plan->count);
    if ((plan->window != result->window_samples) || !whole) {
        plan_window(plan, result);
        plan->window = whole ? result->window_samples : 0U;
    }
}

/* Apart from the function below, which then needs little stack. */
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
