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
        tau->edf = davar_mixture_edf(model, tau);
        davar_chi_square_interval(tau->edf, &low, &high);
        tau->low = tau->adev * davar_root(low);
        tau->high = tau->adev * davar_root(high);
    }
}

static void write_mixture(const davar_mixture_t *model, double rate_hz, davar_result_t *result)
{
    double unit[DAVAR_COEFFICIENT_COUNT];
    davar_square_units(rate_hz, unit);
    result->noise = DAVAR_NOISE_MIXED;
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

/* Removes the share of rounding from the angle random walk. */
static void take_off_rounding(const davar_mixture_t *model, uint32_t share,
                              davar_coefficient_t *walk)
{
    const double whole = walk->value;
    const double least = model->least[WHITE] / model->a[WHITE];
    const davar_unrounded_t unrounded =
        davar_unrounded(share, (uint32_t)(least * (double)(1U << NOISE_BITS)),
                        scaled_of_double(davar_divide(walk->high, whole)));
    walk->value = whole * scaled_to_double(unrounded.value);
    walk->low = whole * scaled_to_double(unrounded.low);
    walk->high = whole * scaled_to_double(unrounded.high);
}

/* Rounding adds white noise (5.15). The other terms are slow and stay unchanged as long as a sample
 * scatters by half a count for any reason. */
static void write_rounded(const davar_plan_t *plan, const davar_mixture_t *model,
                          davar_result_t *result)
{
    davar_coefficient_t *const walk = &result->coefficient[WHITE];
    double sample = 0.0; /* variance of a sample, rounding included: the model at m = 1 */
    for (int k = 0; k < TERMS; k++) {
        sample += model->a[k];
    }
    const uint32_t share = walk->present
                               ? davar_rounding_share(result, scaled_of_double(model->a[WHITE]))
                               : UINT32_MAX;
    if (davar_rounding_share(result, scaled_of_double(sample)) >= DAVAR_FIT_COARSE) {
        davar_write_coarse(plan, walk->high, result);
    } else if (share >= DAVAR_FIT_COARSE) {
        write_absent(walk, davar_half_a_count_at_least(plan, result, walk->high));
    } else {
        take_off_rounding(model, share, walk);
    }
}

DAVAR_RARE static void fit_mixture(const davar_plan_t *plan, const davar_white_t *white,
                                   double rate_hz, davar_result_t *result)
{
    davar_mixture_t model = {.data = result,
                             .weight = plan->weight,
                             .count = plan->count,
                             .misfit_spread = (double)plan->misfit_spread};
    davar_mixture_fit(&model, scaled_to_double(white->square), white->suspects);
    write_mixture_intervals(&model, result);
    write_mixture(&model, rate_hz, result);
    if (result->unit_per_count > 0.0) {
        write_rounded(plan, &model, result);
    }
}

void davar_fit(davar_plan_t *plan, double rate_hz, davar_result_t *result)
{
    davar_white_t white;
    if (!davar_white_suffices(plan, rate_hz, result, &white)) {
        fit_mixture(plan, &white, rate_hz, result);
    }
}
