/* davar - what a fit needs and the Allan variances do not change, DESIGN (5.3) to (5.5): for white noise beside one more term
 * the fit is linear in them, and so are its variances in 1 / (number of differences). */
#include "fit/plan.h"

#include "davar/confidence.h"
#include "fit/noise.h"
#include "number/real.h"

/* The largest float that 32 bits hold. */
#define LARGEST_FIXED 4294967040.0F

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

/* Stores a functional as fixed point of 29 bits, in units of a power of two above its largest value; that of white noise, whose
 * sum is 1, as it is. */
static void store_functional(davar_plan_t *plan, int term, const double functional[])
{
    double largest = 0.0;
    for (int t = 0; t < plan->count; t++) {
        const double size = (functional[t] < 0.0) ? -functional[t] : functional[t];
        largest = (size > largest) ? size : largest;
    }
    const double scale = ((term == WHITE) || (plan->count == 1U)) ? 1.0 : power_above(largest);
    for (int t = 0; t < plan->count; t++) {
        plan->functional[term][t] = rounded(functional[t] * (DAVAR_FIT_FUNCTIONAL_ONE / scale));
    }
    plan->scale[term] = (float)scale;
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
    store_functional(plan, term, functional);
    const float per_share = (float)centre * plan->scale[term];
    plan->centre[term] = (per_share < DAVAR_FIT_CENTRE_MOST) ? per_share : DAVAR_FIT_CENTRE_MOST;
}

/* Variance of an amplitude under white noise, N = 1, folded so that a window length costs one product per cluster size:
 * the covariance of two cluster sizes falls with the number of differences of the shorter one (5.4). */
static void plan_variance(davar_plan_t *plan, int term)
{
    const double one = 1.0 / DAVAR_FIT_FUNCTIONAL_ONE;
    for (int i = 0; i < plan->count; i++) {
        const double m_i = (double)plan->m[i];
        double sum = 0.0;
        for (int j = i; j < plan->count; j++) {
            const double m_j = (double)plan->m[j];
            const double twice = (j > i) ? 2.0 : 1.0;
            const double functional = (double)plan->functional[term][j] * one;
            sum += twice * functional * davar_noise_white_overlap(m_i, m_j) / (2.0 * m_i * m_j);
        }
        plan->variance[term][i] = (float)((double)plan->functional[term][i] * one * sum);
    }
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
            const double r = davar_noise_correlation(WHITE, (double)plan->m[i], (double)plan->m[j]);
            sum += ((i < j) ? 4.0 : 2.0) * r * r;
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

/* --- the rate ---------------------------------------------------------------------------------------------------------- */

/* (1.2) */
void davar_square_units(double rate_hz, double unit[])
{
    const double tau0_s = 1.0 / rate_hz;
    unit[DAVAR_QUANTIZATION] = tau0_s * tau0_s * (1.0 / 3.0);
    unit[WHITE] = 3600.0 * tau0_s;
    unit[DAVAR_BIAS_INSTABILITY] = 3600.0 * 3600.0 * 2.2661800709135971; /* pi / (2 ln 2) */
    unit[DAVAR_RATE_RANDOM_WALK] = 216000.0 * 216000.0 * 3.0 * rate_hz;
    unit[DAVAR_RATE_RAMP] = 12960000.0 * 12960000.0 * 2.0 * rate_hz * rate_hz;
}

/* From roots of amplitudes to the coefficients in their units. */
void davar_plan_rate(davar_plan_t *plan, double rate_hz)
{
    double unit[DAVAR_COEFFICIENT_COUNT];
    davar_square_units(rate_hz, unit);
    for (int k = 0; k < TERMS; k++) {
        plan->root[k] = davar_root((double)plan->unit[k] * unit[k]);
    }
    plan->rate_hz = rate_hz;
}

/* --- the window (5.5) -------------------------------------------------------------------------------------------- */

uint8_t davar_fit_usable(const davar_result_t *result)
{
    uint8_t count = 0U;
    while ((count < result->tau_count) && (result->tau[count].differences > 0U)) {
        count++;
    }
    return count;
}

/* Policy glr chose this window by what is in it (10.14): it left out most of what it holds to be of one variance, because it was not
 * quite alike; or it has just cut the window, because so few samples were loud or quiet enough. */
static bool is_chosen(const davar_result_t *result)
{
    return result->young || (result->cut_age_samples > (2U * result->window_samples));
}

/* Every difference that the window could hold is there once, at the first `count` cluster sizes, and counts: no gap, no mirror. */
static bool is_whole(const davar_result_t *result, int count)
{
    uint32_t lost = result->mirrored_samples | (is_chosen(result) ? 1U : 0U);
    for (int t = 0; t < count; t++) {
        lost |= (result->window_samples + 1U - 2U * result->tau[t].m) ^ result->tau[t].differences;
    }
    return lost == 0U;
}

double davar_fit_evidence(const davar_result_t *result)
{
    const double all = (double)result->window_samples;
    const double share = is_chosen(result) ? 0.4375 : 1.0;
    return share * all / (all + 2.0 * (double)result->mirrored_samples);
}

void davar_deviation_interval(double edf, double *low, double *high)
{
    davar_chi_square_interval(edf, low, high);
    *low = davar_root(*low);
    *high = davar_root(*high);
}

/* As fixed point, to the nearest; what it cannot hold is as much as it can. */
static uint32_t fixed(float value, float one, float most)
{
    const float scaled = value * one + 0.5F;
    return (uint32_t)((scaled < most) ? scaled : most);
}

static void plan_entry(davar_plan_t *plan, const davar_result_t *result, float evidence, int t, float variance[])
{
    const float all = (float)(result->window_samples + 1U - 2U * result->tau[t].m);
    const float differences = (float)result->tau[t].differences;
    const float effective = (all + 0.5F * plan->m[t]) * (differences / all) * evidence;
    const float inverse = 1.0F / effective;
    const float freedom = plan->freedom[t] * effective;
    const float edf = (freedom > 1.0F) ? freedom : 1.0F;
    double low;
    double high;
    davar_deviation_interval((double)edf, &low, &high);
    plan->edf[t] = (double)edf;
    plan->root_edf[t] = fixed(davar_rootf(edf), DAVAR_FIT_ROOT_ONE, LARGEST_FIXED);
    plan->low[t] = (float)low;
    plan->high[t] = (float)high;
    for (int k = 0; k < TERMS; k++) {
        variance[k] += plan->variance[k][t] * inverse;
    }
}

static void plan_white(davar_plan_t *plan, float variance)
{
    double low;
    double high;
    davar_chi_square_interval(2.0 / (double)variance, &low, &high);
    plan->white_low = fixed((float)low, NOISE_ONE, LARGEST_FIXED);
    plan->white_high = davar_rootf((float)high);
}

/* Odd, so never 0. Nearly equal cluster sizes, or one alone, show no term: then what (5.4) makes of their variances is 0, or less
 * by its own inaccuracy. */
static uint32_t fixed_sigma(float sigma, float variance)
{
    const float most = (float)DAVAR_FIT_SIGMA_MOST;
    return ((variance > 0.0F) ? fixed(sigma, DAVAR_FIT_SHARE_ONE, most) : DAVAR_FIT_SIGMA_MOST) | 1U;
}

/* The bound of an absent term: room = sqrt((1 + margin) scale), see (5.11). */
static void plan_term(davar_plan_t *plan, int k, float of_white, float variance)
{
    const float positive = (variance > 0.0F) ? variance : 0.0F;
    const float sigma = davar_rootf(positive);
    const float margin = (float)DAVAR_FIT_BOUND * sigma * plan->scale[k];
    const float of_term = plan->centre[k] * plan->centre[k] * positive;
    plan->sigma[k] = fixed_sigma(sigma, variance);
    plan->room[k] = davar_rootf((1.0F + margin) * plan->scale[k]);
    plan->doubt[k] = fixed(davar_rootf(0.5F * (of_white + of_term)), NOISE_ONE, LARGEST_FIXED);
}

static void plan_window(davar_plan_t *plan, const davar_result_t *result)
{
    const float evidence = (float)davar_fit_evidence(result);
    float variance[DAVAR_COEFFICIENT_COUNT] = {0.0F};
    for (int t = 0; t < plan->count; t++) {
        plan_entry(plan, result, evidence, t, variance);
    }
    plan_white(plan, variance[WHITE]);
    for (int k = 0; k < TERMS; k++) {
        plan_term(plan, k, variance[WHITE], variance[k]);
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
