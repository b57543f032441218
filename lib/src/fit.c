/* davar - coefficients and intervals, DESIGN (5.3) to (5.11). Most windows hold white noise and nothing else that they could
 * show (fit_white.c); all else goes to fit_mixture.c. */
#include "davar/fit.h"

#include "fit_mixture.h"
#include "fit_plan.h"
#include "fit_white.h"
#include "noise.h"
#include "real.h"

#define TERMS ((int)DAVAR_COEFFICIENT_COUNT)
#define WHITE DAVAR_ANGLE_RANDOM_WALK

/* From a[k] of avar = sum a[k] m^(k - 2) to the squares of the coefficients in their units (1.2). */
DAVAR_APART static void square_units(double rate_hz, double unit[])
{
    const double tau0_s = 1.0 / rate_hz;
    unit[DAVAR_QUANTIZATION] = tau0_s * tau0_s * (1.0 / 3.0);
    unit[WHITE] = 3600.0 * tau0_s;
    unit[DAVAR_BIAS_INSTABILITY] = 3600.0 * 3600.0 * 2.2661800709135971; /* pi / (2 ln 2) */
    unit[DAVAR_RATE_RANDOM_WALK] = 216000.0 * 216000.0 * 3.0 * rate_hz;
    unit[DAVAR_RATE_RAMP] = 12960000.0 * 12960000.0 * 2.0 * rate_hz * rate_hz;
}

/* From roots of amplitudes to the coefficients in their units. */
static void plan_roots(davar_fit_plan_t *plan, double rate_hz)
{
    double unit[DAVAR_COEFFICIENT_COUNT];
    square_units(rate_hz, unit);
    for (int k = 0; k < TERMS; k++) {
        plan->root[k] = davar_root((double)plan->unit[k] * unit[k]);
    }
    plan->rate_hz = rate_hz;
}

/* From squares, a lower limit among them, to the coefficient. */
static void write_present(davar_coefficient_t *coefficient, double square, double low_square, double high)
{
    const double value = davar_root(square);
    *coefficient = (davar_coefficient_t){true, value, davar_root(low_square), value * high};
}

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
        davar_deviation_interval(tau->edf, &low, &high);
        tau->low = tau->adev * low;
        tau->high = tau->adev * high;
    }
}

static void write_mixture(const davar_mixture_t *model, double rate_hz, davar_result_t *result)
{
    double unit[DAVAR_COEFFICIENT_COUNT];
    square_units(rate_hz, unit);
    for (int k = 0; k < TERMS; k++) {
        const double a = model->a[k];
        if (((model->terms >> (unsigned)k) & 1U) != 0U) {
            double low;
            double high;
            davar_deviation_interval(2.0 * a * a / model->variance[k], &low, &high);
            write_present(&result->coefficient[k], a * unit[k], model->least[k] * unit[k], high);
        } else {
            const double sigma = davar_root(model->variance[k]);
            const double square = bound(model->beside[k], sigma, 1.0 / davar_mixture_room(model, k));
            write_absent(&result->coefficient[k], davar_root(square * unit[k]));
        }
    }
}

static void write_unusable(davar_result_t *result, int from)
{
    for (int t = from; t < result->tau_count; t++) {
        result->tau[t].edf = (double)NAN;
        result->tau[t].low = (double)NAN;
        result->tau[t].high = (double)NAN;
    }
}

DAVAR_APART static void write_nothing(davar_result_t *result)
{
    for (int k = 0; k < TERMS; k++) {
        write_absent(&result->coefficient[k], (double)INFINITY);
    }
}

/* A constant input: noise below the size of a count, or a sensor that is stuck. Its differences are 0, and that bounds
 * nothing. */
DAVAR_RARE static void write_constant(const davar_fit_plan_t *plan, davar_result_t *result)
{
    for (int t = 0; t < plan->count; t++) {
        result->tau[t].edf = plan->edf[t];
        result->tau[t].low = 0.0;
        result->tau[t].high = (double)INFINITY;
    }
    write_nothing(result);
}

DAVAR_RARE static void fit_mixture(const davar_fit_plan_t *plan, double white, unsigned suspects, double rate_hz,
                                   davar_result_t *result)
{
    davar_mixture_t model = {
        .data = result, .weight = plan->weight, .count = plan->count, .misfit_spread = (double)plan->misfit_spread};
    davar_mixture_fit(&model, white, suspects);
    write_mixture_intervals(&model, result);
    write_mixture(&model, rate_hz, result);
}

/* White noise explains all that most windows can show: then the fit ends here. */
static void fit_usable(davar_fit_plan_t *plan, const davar_white_t *white, double rate_hz, davar_result_t *result)
{
    if (!white->explains) {
        fit_mixture(plan, scaled_to_double(white->square), white->suspects, rate_hz, result);
        return;
    }
    if (davar_bits_of_double(plan->rate_hz) != davar_bits_of_double(rate_hz)) {
        plan_roots(plan, rate_hz);
    }
    davar_white_write(plan, white, result);
}

void davar_fit_prepared(davar_fit_plan_t *plan, double rate_hz, davar_result_t *result)
{
    davar_white_t white;
    if ((result->tau_count == 0U) || (result->tau[0].differences == 0U)) {
        write_unusable(result, 0);
        write_nothing(result);
        return;
    }
    write_unusable(result, plan->count);
    if (davar_white_fit(plan, result, &white)) {
        fit_usable(plan, &white, rate_hz, result);
    } else {
        write_constant(plan, result);
    }
}

void davar_fit(davar_fit_plan_t *plan, double tau0_s, davar_result_t *result)
{
    davar_fit_prepare(plan, result);
    davar_fit_prepared(plan, 1.0 / tau0_s, result);
}
