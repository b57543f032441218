/* davar - coefficients and intervals, DESIGN (5.3) to (5.11). Most windows show white noise only
 * and are fitted by fit/white.c; the others need fit/mixture.c. */
#include "davar/fit.h"

#include "fit/mixture.h"
#include "fit/plan.h"
#include "fit/white.h"
#include "number/real.h"

static void write_absent(davar_coefficient_t *coefficient, double bound)
{
    *coefficient = (davar_coefficient_t){false, (double)NAN, (double)NAN, bound};
}

/* Upper limit of an absent term (5.11). A present term would scatter too, so sigma grows by the
 * share that the limit would have of the model's Allan variance where the term is strongest. */
static double bound(const davar_mixture_t *model, int term)
{
    const double margin = DAVAR_FIT_BOUND * davar_root(model->variance[term]);
    const double a = model->beside[term];
    const double small = ((a > 0.0) ? a : 0.0) + margin;
    return small + margin * (small * (1.0 / davar_mixture_room(model, term)));
}

static void write_mixture_intervals(const davar_mixture_t *model, davar_result_t *result)
{
    for (int t = 0; t < model->count; t++) {
        davar_adev_t *tau = &result->tau[t];
        double low;
        double high;
        if (!davar_mixture_has(model, t)) {
            continue;
        }
        tau->edf = davar_mixture_edf(model, t);
        davar_chi_square_interval(tau->edf, &low, &high);
        tau->low = tau->adev * davar_root(low);
        tau->high = tau->adev * davar_root(high);
    }
}

static void write_mixture(const davar_mixture_t *model, double rate_hz, davar_result_t *result)
{
    double unit[DAVAR_COEFFICIENT_COUNT];
    davar_square_units(rate_hz, unit);
    const bool white =
        model->curve && (model->terms == (1U << (unsigned)WHITE)) && !(model->grow > 1.0);
    result->noise = white ? DAVAR_NOISE_WHITE : DAVAR_NOISE_MIXED;
    for (int k = 0; k < TERMS; k++) {
        const double a = model->a[k];
        if (((model->terms >> (unsigned)k) & 1U) != 0U) {
            double low;
            double high;
            davar_chi_square_interval(2.0 * a * a / model->variance[k], &low, &high);
            const double value = davar_root(a * unit[k]);
            result->coefficient[k] = (davar_coefficient_t){
                true, value, davar_root(model->least[k] * unit[k]), value * davar_root(high)};
        } else {
            write_absent(&result->coefficient[k], davar_root(bound(model, k) * unit[k]));
        }
    }
}

/* The part of N^2 that an undeclared filter may have taken: a factor of its upper limit (5.17). */
static double undeclared_factor(const davar_plan_t *plan, const davar_mixture_t *model)
{
    if (plan->declared) {
        return 1.0;
    }
    const double sigma = davar_root(model->variance[DAVAR_QUANTIZATION]);
    const double lack = -model->beside[DAVAR_QUANTIZATION];
    return 1.0 + (((lack > 0.0) ? lack : 0.0) + DAVAR_FIT_THRESHOLD * sigma) / model->a[WHITE] /
                     (double)plan->m[0];
}

/* Where the scatter of a sample is below half a count, and where the angle random walk cannot be
 * distinguished from the rest (5.15) (5.16). Rounding adds white noise; the other terms are slow
 * and stay as long as a sample scatters by half a count for any reason. */
static void write_white_part(const davar_plan_t *plan, const davar_mixture_t *model,
                             davar_result_t *result)
{
    davar_coefficient_t *const walk = &result->coefficient[WHITE];
    const double hidden =
        (double)plan->hidden * (double)plan->hidden / plan->rounding_variance * model->rounding;
    double slow = 0.0; /* variance of a sample by the other terms: the model at m = 1 */
    for (int k = 0; k < TERMS; k++) {
        slow += (k != WHITE) ? model->a[k] : 0.0;
    }
    if (hidden > model->a[WHITE] + (slow / (double)plan->sample)) {
        davar_write_coarse(plan, walk->high, result);
    } else if (walk->present && ((hidden > model->a[WHITE]) || !davar_mixture_shows_white(model))) {
        write_absent(walk, walk->high);
    } else if (walk->present) {
        walk->high *= davar_root(undeclared_factor(plan, model));
    }
    if (!walk->present) {
        walk->high = davar_half_a_count_at_least(plan, result, walk->high);
    }
}

DAVAR_RARE static void fit_mixture(davar_mixture_t *model, double white, unsigned suspects,
                                   double rate_hz, davar_result_t *result)
{
    const davar_plan_t *const plan = model->plan;
    model->data = result;
    model->rounding = scaled_to_double(davar_rounding(plan, result));
    davar_mixture_fit(model, white, suspects);
    if (davar_mixture_is_filtered(model)) {
        davar_write_unlimited(plan, DAVAR_NOISE_FILTERED, result);
        return;
    }
    write_mixture_intervals(model, result);
    write_mixture(model, rate_hz, result);
    write_white_part(plan, model, result);
}

/* Number of sizes up to the last one that a cascade filled; 0 without a cascade. */
static int curve_count(const davar_plan_t *plan, const davar_result_t *result)
{
    int count = 0;
    for (int t = 0; (t < result->tau_count) && (t < plan->sizes); t++) {
        if (davar_fit_hops(&result->tau[t]) && (result->tau[t].differences > 0U)) {
            count = t + 1;
        }
    }
    return count;
}

/* Where the fit of a curve starts: white noise that explains the shortest size that is not 0. 0: all
 * are 0. */
static double first_white(const davar_plan_t *plan, const davar_result_t *result, int count)
{
    for (int t = 0; t < count; t++) {
        const davar_adev_t *const tau = &result->tau[t];
        if ((tau->differences > 0U) && (tau->adev > 0.0)) {
            return tau->adev * tau->adev * (double)plan->m[t] / (double)plan->gain[t];
        }
    }
    return 0.0;
}

/* The window shows nothing that contradicts the plan, or there is no window (5.18). */
static bool is_open(davar_noise_t noise)
{
    return (noise == DAVAR_NOISE_WHITE) || (noise == DAVAR_NOISE_MIXED) ||
           (noise == DAVAR_NOISE_UNKNOWN);
}

static void fit_window(davar_plan_t *plan, double rate_hz, davar_result_t *result)
{
    davar_white_t white;
    if (!davar_white_suffices(plan, rate_hz, result, &white)) {
        davar_mixture_t model = {.plan = plan, .count = plan->count};
        fit_mixture(&model, scaled_to_double(white.sum), white.suspects, rate_hz, result);
    }
}

/* All sizes together, those of the window and of the cascade (5.18). */
DAVAR_RARE static void fit_curve(davar_plan_t *plan, int count, double rate_hz,
                                 davar_result_t *result)
{
    const double white = first_white(plan, result, count);
    if (white > 0.0) {
        davar_mixture_t model = {.plan = plan, .count = count, .curve = true};
        davar_plan_rate(plan, rate_hz);
        fit_mixture(&model, white, 0U, rate_hz, result);
    } else {
        davar_write_unlimited(plan, DAVAR_NOISE_CONSTANT, result);
    }
}

void davar_fit(davar_plan_t *plan, double rate_hz, davar_result_t *result)
{
    const int count = curve_count(plan, result);
    fit_window(plan, rate_hz, result);
    if ((count > 0) && is_open(result->noise)) {
        fit_curve(plan, count, rate_hz, result);
    }
}
