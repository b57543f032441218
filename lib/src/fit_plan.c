/* davar - what a fit needs and the Allan variances do not change, DESIGN (5.3) to (5.5): for white noise beside one more term
 * the fit is linear in them, and so are its variances in 1 / (number of differences). */
#include "fit_plan.h"

#include "davar/confidence.h"
#include "noise.h"

#include <assert.h>
#include <math.h>

#define TERMS ((int)DAVAR_COEFFICIENT_COUNT)
#define WHITE DAVAR_ANGLE_RANDOM_WALK

/* The shape of a term in y, at most 1 so that nothing leaves the range of a float. */
static double shape(const davar_fit_plan_t *plan, int term, double m)
{
    const double u = m / plan->last;
    switch (term) {
    case DAVAR_QUANTIZATION:
        return plan->first / m;
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

/* Regression of y on a constant and one shape: amplitude = gain * sum w (x - centre) y; the constant itself has
 * centre 0. One cluster size alone shows a constant and nothing else. */
static void plan_regression(davar_fit_plan_t *plan, const uint32_t *m, int term)
{
    double w_sum = 0.0;
    double wx_sum = 0.0;
    for (int t = 0; t < plan->count; t++) {
        w_sum += (double)plan->weight[t];
        wx_sum += (double)plan->weight[t] * shape(plan, term, (double)m[t]);
    }
    plan->centre[term] = (term == WHITE) ? 0.0 : wx_sum / w_sum;
    double square = 0.0;
    for (int t = 0; t < plan->count; t++) {
        const double x = shape(plan, term, (double)m[t]) - plan->centre[term];
        square += (double)plan->weight[t] * x * x;
    }
    plan->gain[term] = ((term == WHITE) || (plan->count > 1U)) ? 1.0 / square : 0.0;
}

static double functional(const davar_fit_plan_t *plan, int term, int t, double m)
{
    return plan->gain[term] * (double)plan->weight[t] * (shape(plan, term, m) - plan->centre[term]);
}

/* Variance of an amplitude under white noise, N = 1, folded so that a window length costs one product per cluster size:
 * the covariance of two cluster sizes falls with the number of differences of the shorter one (5.4). */
static void plan_variance(davar_fit_plan_t *plan, const uint32_t *m, int term)
{
    for (int i = 0; i < plan->count; i++) {
        const double m_i = (double)m[i];
        double sum = 0.0;
        for (int j = i; j < plan->count; j++) {
            const double m_j = (double)m[j];
            const double twice = (j > i) ? 2.0 : 1.0;
            sum += twice * functional(plan, term, j, m_j) * davar_noise_white_overlap(m_i, m_j) / (2.0 * m_i * m_j);
        }
        plan->variance[term][i] = (float)(functional(plan, term, i, m_i) * sum);
    }
}

/* Weights of a white fit: 1 / m, shared among crowded neighbours (the gap between the geometric means with them, on the
 * scale of 1 / m). Within 1 % of the full inverse covariance for octaves and geometric lists from m = 1, without its
 * conditioning. The first entry also stands for all shorter sizes, the last one for half of all longer (5.4). */
static void plan_weights(davar_fit_plan_t *plan, const uint32_t *m)
{
    const int end = plan->count - 1;
    const double second = (double)m[(end > 0) ? 1 : 0];
    const double next_to_last = (double)m[(end > 0) ? end - 1 : 0];
    double from = 1.0 / sqrt(plan->first * plan->first * plan->first / second);
    for (int t = 0; t < end; t++) {
        const double to = 1.0 / sqrt((double)m[t] * (double)m[t + 1]);
        plan->weight[t] = (float)(from - to);
        from = to;
    }
    const double beyond = 1.0 / sqrt(plan->last * plan->last * plan->last / next_to_last);
    plan->weight[end] = (float)(from - 0.5 * beyond);
    plan->weight[0] *= (float)(1.0 + 2.35 * (1.0 - 1.0 / (plan->first * plan->first)));
}

/* Standard deviation of the misfit under white noise: twice the sum of the squared correlations is its variance. */
static double white_misfit_spread(const uint32_t *m, int count)
{
    double sum = 0.0;
    for (int j = 0; j < count; j++) {
        for (int i = 0; i <= j; i++) {
            const double r = davar_noise_correlation(WHITE, (double)m[i], (double)m[j]);
            sum += ((i < j) ? 4.0 : 2.0) * r * r;
        }
    }
    return sqrt(sum);
}

void davar_fit_plan(davar_fit_plan_t *plan, const uint32_t *m, uint8_t count)
{
    assert(count >= 1U);
    plan->count = count;
    plan->window = 0U;
    plan->first = (double)m[0];
    plan->last = (double)m[count - 1U];
    plan->unit[DAVAR_QUANTIZATION] = plan->first;
    plan->unit[WHITE] = 1.0;
    plan->unit[DAVAR_BIAS_INSTABILITY] = 1.0 / plan->last;
    plan->unit[DAVAR_RATE_RANDOM_WALK] = 1.0 / (plan->last * plan->last);
    plan->unit[DAVAR_RATE_RAMP] = 1.0 / (plan->last * plan->last * plan->last);
    plan->misfit_spread = white_misfit_spread(m, count);
    plan_weights(plan, m);
    for (int k = 0; k < TERMS; k++) {
        plan_regression(plan, m, k);
        plan_variance(plan, m, k);
    }
}

static double all_differences(const davar_result_t *result, int t)
{
    return (double)result->window_samples - 2.0 * (double)result->tau[t].m + 1.0;
}

bool davar_fit_is_whole(const davar_result_t *result, int count)
{
    uint32_t lost = result->mirrored_samples;
    for (int t = 0; t < count; t++) {
        lost |= (result->window_samples + 1U - 2U * result->tau[t].m) ^ result->tau[t].differences;
    }
    return lost == 0U;
}

double davar_fit_evidence(const davar_result_t *result)
{
    const double all = (double)result->window_samples;
    return all / (all + 2.0 * (double)result->mirrored_samples);
}

void davar_deviation_interval(double edf, double *low, double *high)
{
    davar_chi_square_interval(edf, low, high);
    *low = sqrt(*low);
    *high = sqrt(*high);
}

static void plan_entry(davar_fit_plan_t *plan, const davar_result_t *result, int t)
{
    const double m = (double)result->tau[t].m;
    const double all = all_differences(result, t);
    const double evidence = davar_fit_evidence(result);
    const double effective = (all + 0.5 * m) * ((double)result->tau[t].differences / all) * evidence;
    const double edf = davar_noise_white_weight(m) * effective;
    double low;
    double high;
    davar_deviation_interval(edf, &low, &high);
    plan->edf[t] = (float)((edf > 1.0) ? edf : 1.0);
    plan->low[t] = (float)low;
    plan->high[t] = (float)high;
    for (int k = 0; k < TERMS; k++) {
        plan->sigma[k] += (double)plan->variance[k][t] / effective;
    }
}

void davar_fit_plan_window(davar_fit_plan_t *plan, const davar_result_t *result)
{
    for (int k = 0; k < TERMS; k++) {
        plan->sigma[k] = 0.0;
    }
    for (int t = 0; t < plan->count; t++) {
        plan_entry(plan, result, t);
    }
    const double of_white = plan->sigma[WHITE];
    davar_chi_square_interval(2.0 / of_white, &plan->white_low, &plan->white_high);
    plan->white_high = sqrt(plan->white_high);
    for (int k = 0; k < TERMS; k++) {
        const double of_term = plan->sigma[k];
        plan->doubt[k] = sqrt(0.5 * (of_white + plan->centre[k] * plan->centre[k] * of_term));
        plan->sigma[k] = ((k == WHITE) || (plan->count > 1U)) ? sqrt(of_term) : (double)INFINITY;
    }
}
