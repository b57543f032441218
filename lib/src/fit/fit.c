/* davar - coefficients and intervals, DESIGN (5.3) to (5.11). Most windows hold white noise and nothing else that they could
 * show (fit/white.c); all else goes to fit/mixture.c. */
#include "davar/fit.h"

#include "fit/mixture.h"
#include "fit/plan.h"
#include "fit/white.h"
#include "number/real.h"

static void write_absent(davar_coefficient_t *coefficient, double bound)
{
    *coefficient = (davar_coefficient_t){false, (double)NAN, (double)NAN, bound};
}

/* Upper limit of an absent term. Were the term there, it would scatter too: sigma is raised by what the limit would add
 * to the model's Allan variance where the term is strongest, the share being small * inverse_room (5.11). */
static double bound(double a, double sigma, double inverse_room)
{
    const double margin = DAVAR_FIT_BOUND * sigma;
    const double small = ((a > 0.0) ? a : 0.0) + margin;
    return small + margin * (small * inverse_room);
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
            result->coefficient[k] =
                (davar_coefficient_t){.present = true,
                                      .value = value,
                                      .low = davar_root(model->least[k] * unit[k]),
                                      .high = value * davar_root(high)};
        } else {
            const double sigma = davar_root(model->variance[k]);
            const double square =
                bound(model->beside[k], sigma, 1.0 / davar_mixture_room(model, k));
            write_absent(&result->coefficient[k], davar_root(square * unit[k]));
        }
    }
}

/* Of one sample, rounding included: the Allan variance of the model at m = 1. */
static double variance_of_sample(const davar_mixture_t *model)
{
    double sum = 0.0;
    for (int k = 0; k < TERMS; k++) {
        sum += model->a[k];
    }
    return sum;
}

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

/* Rounding adds to white noise (5.15). It leaves the other terms, which are slow, as they are while a sample scatters by half a count,
 * whatever makes it scatter. */
static void write_rounded(const davar_plan_t *plan, const davar_mixture_t *model,
                          davar_result_t *result)
{
    davar_coefficient_t *const walk = &result->coefficient[WHITE];
    const uint32_t share = walk->present
                               ? davar_rounding_share(result, scaled_of_double(model->a[WHITE]))
                               : UINT32_MAX;
    if (davar_rounding_share(result, scaled_of_double(variance_of_sample(model))) >=
        DAVAR_FIT_COARSE) {
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
