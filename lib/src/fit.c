/* davar - coefficients and intervals, DESIGN (5.3) to (5.11). Most windows hold white noise and nothing else that they could
 * show; for them the fit is a handful of sums over numbers that only the window length changes. All else goes to
 * fit_mixture.c. Units here: tau in samples, y = avar * m, so that white noise is a constant y = N^2. */
#include "davar/fit.h"

#include "fit_mixture.h"
#include "fit_plan.h"
#include "noise.h"

#include <math.h>

#define TERMS ((int)DAVAR_COEFFICIENT_COUNT)
#define WHITE DAVAR_ANGLE_RANDOM_WALK

/* One-sided 95 % point of a Gaussian. */
#define BOUND 1.645

/* A cluster size that does not fit leaves none of the longer ones, gaps or not. */
static uint8_t usable_count(const davar_result_t *result)
{
    uint8_t count = 0U;
    while ((count < result->tau_count) && (result->tau[count].differences > 0U)) {
        count++;
    }
    return count;
}

static void replan(davar_fit_plan_t *plan, const davar_result_t *result, uint8_t count)
{
    uint32_t m[DAVAR_TAUS_MAX] = {0};
    for (int t = 0; t < count; t++) {
        m[t] = result->tau[t].m;
    }
    davar_fit_plan(plan, m, count);
}

static void bring_up_to_date(davar_fit_plan_t *plan, const davar_result_t *result, uint8_t count)
{
    if (plan->count != count) {
        replan(plan, result, count);
    }
    const bool whole = davar_fit_is_whole(result, count);
    if ((plan->window != result->window_samples) || !whole) {
        davar_fit_plan_window(plan, result);
        plan->window = whole ? result->window_samples : 0U;
    }
}

/* Amplitudes of the shapes; the first loop of the two that every window pays for. */
static void fit_white(const davar_fit_plan_t *plan, const davar_result_t *result, double amplitude[])
{
    const double inverse_last = 1.0 / plan->last;
    double sum[DAVAR_COEFFICIENT_COUNT] = {0};
    for (int t = 0; t < plan->count; t++) {
        const davar_adev_t *tau = &result->tau[t];
        const double m = (double)tau->m;
        const double u = m * inverse_last;
        const double weighted = (double)plan->weight[t] * (tau->adev * tau->adev);
        const double y = weighted * m;
        sum[DAVAR_QUANTIZATION] += weighted * plan->first;
        sum[WHITE] += y;
        sum[DAVAR_BIAS_INSTABILITY] += y * u;
        sum[DAVAR_RATE_RANDOM_WALK] += y * u * u;
        sum[DAVAR_RATE_RAMP] += y * u * u * u;
    }
    for (int k = 0; k < TERMS; k++) {
        amplitude[k] = plan->gain[k] * (sum[k] - plan->centre[k] * sum[WHITE]);
    }
}

static double white_misfit(const davar_fit_plan_t *plan, const davar_result_t *result, double white)
{
    const double inverse = 1.0 / white;
    double sum = 0.0;
    for (int t = 0; t < plan->count; t++) {
        const davar_adev_t *tau = &result->tau[t];
        const double excess = tau->adev * tau->adev * (double)tau->m * inverse - 1.0;
        sum += 0.5 * (double)plan->edf[t] * excess * excess;
    }
    return sum;
}

/* The terms that are significant beside white noise, a bit each (5.7). */
static unsigned suspected(const davar_fit_plan_t *plan, const double amplitude[])
{
    unsigned found = 0U;
    for (int k = 0; k < TERMS; k++) {
        if ((k != WHITE) && (amplitude[k] > DAVAR_FIT_THRESHOLD * plan->sigma[k] * amplitude[WHITE])) {
            found |= 1U << (unsigned)k;
        }
    }
    return found;
}

static bool fits_white(const davar_fit_plan_t *plan, const davar_result_t *result, double white)
{
    const double limit = (double)plan->count - 1.0 + DAVAR_FIT_MISFIT * plan->misfit_spread;
    return white_misfit(plan, result, white) <= limit;
}

/* From a[k] of avar = sum a[k] m^(k - 2) to the squares of the coefficients in their units (1.2). */
static void square_units(double tau0_s, double unit[])
{
    const double rate_hz = 1.0 / tau0_s;
    unit[DAVAR_QUANTIZATION] = tau0_s * tau0_s * (1.0 / 3.0);
    unit[WHITE] = 3600.0 * tau0_s;
    unit[DAVAR_BIAS_INSTABILITY] = 3600.0 * 3600.0 * 2.2661800709135971; /* pi / (2 ln 2) */
    unit[DAVAR_RATE_RANDOM_WALK] = 216000.0 * 216000.0 * 3.0 * rate_hz;
    unit[DAVAR_RATE_RAMP] = 12960000.0 * 12960000.0 * 2.0 * rate_hz * rate_hz;
}

/* From squares, a lower limit among them, to the coefficient. */
static void write_present(davar_coefficient_t *coefficient, double square, double low_square, double high)
{
    const double value = sqrt(square);
    *coefficient = (davar_coefficient_t){true, value, sqrt(low_square), value * high};
}

static void write_absent(davar_coefficient_t *coefficient, double bound_square)
{
    *coefficient = (davar_coefficient_t){false, (double)NAN, (double)NAN, sqrt(bound_square)};
}

/* Upper limit of an absent term. Were the term there, it would scatter too: sigma is raised by what the limit would add
 * to the model's Allan variance where the term is strongest, the share being small * inverse_room (5.11). */
static double bound(double a, double sigma, double inverse_room)
{
    const double margin = BOUND * sigma;
    const double small = ((a > 0.0) ? a : 0.0) + margin;
    return small + margin * (small * inverse_room);
}

static void write_white_intervals(const davar_fit_plan_t *plan, davar_result_t *result)
{
    for (int t = 0; t < plan->count; t++) {
        davar_adev_t *tau = &result->tau[t];
        tau->edf = (double)plan->edf[t];
        tau->low = tau->adev * (double)plan->low[t];
        tau->high = tau->adev * (double)plan->high[t];
    }
}

/* Lower limit of N^2 beside an absent term: its interval must hold what the term would leave of it (5.10). */
static double doubted_white(const davar_fit_plan_t *plan, const double amplitude[], int term)
{
    const double left = amplitude[WHITE] - plan->centre[term] * amplitude[term];
    const double uncertain = plan->doubt[term] * amplitude[WHITE];
    return (uncertain >= DAVAR_FIT_NOTHING * left) ? 0.0 : left * davar_chi_square_low(uncertain / left);
}

static double least_white(const davar_fit_plan_t *plan, const double amplitude[])
{
    double least = amplitude[WHITE] * plan->white_low;
    for (int k = 0; k < TERMS; k++) {
        if ((k != WHITE) && (amplitude[k] > DAVAR_FIT_DOUBT * plan->sigma[k] * amplitude[WHITE])) {
            const double low = doubted_white(plan, amplitude, k);
            least = (low < least) ? low : least;
        }
    }
    return least;
}

static void write_white(const davar_fit_plan_t *plan, const double amplitude[], double tau0_s, davar_result_t *result)
{
    const double white = amplitude[WHITE];
    const double inverse_room = 1.0 / white;
    double unit[DAVAR_COEFFICIENT_COUNT];
    square_units(tau0_s, unit);
    for (int k = 0; k < TERMS; k++) {
        write_absent(&result->coefficient[k],
                     bound(amplitude[k], plan->sigma[k] * white, inverse_room) * plan->unit[k] * unit[k]);
    }
    write_present(&result->coefficient[WHITE], white * unit[WHITE], least_white(plan, amplitude) * unit[WHITE],
                  plan->white_high);
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

static void write_mixture(const davar_mixture_t *model, double tau0_s, davar_result_t *result)
{
    double unit[DAVAR_COEFFICIENT_COUNT];
    square_units(tau0_s, unit);
    for (int k = 0; k < TERMS; k++) {
        const double a = model->a[k];
        if (((model->terms >> (unsigned)k) & 1U) != 0U) {
            double low;
            double high;
            davar_deviation_interval(2.0 * a * a / model->variance[k], &low, &high);
            write_present(&result->coefficient[k], a * unit[k], model->least[k] * unit[k], high);
        } else {
            write_absent(&result->coefficient[k],
                         bound(model->beside[k], sqrt(model->variance[k]), 1.0 / davar_mixture_room(model, k)) *
                             unit[k]);
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

static void write_nothing(davar_result_t *result)
{
    for (int k = 0; k < TERMS; k++) {
        write_absent(&result->coefficient[k], (double)INFINITY);
    }
}

/* A constant input: noise below the size of a count, or a sensor that is stuck. Its differences are 0, and that bounds
 * nothing. */
static void write_constant(const davar_fit_plan_t *plan, davar_result_t *result)
{
    write_white_intervals(plan, result);
    for (int t = 0; t < plan->count; t++) {
        result->tau[t].high = (double)INFINITY;
    }
    write_nothing(result);
}

static void fit_mixture(const davar_fit_plan_t *plan, double white, unsigned suspects, double tau0_s,
                        davar_result_t *result)
{
    davar_mixture_t model = {
        .data = result, .weight = plan->weight, .count = plan->count, .misfit_spread = plan->misfit_spread};
    davar_mixture_fit(&model, white, suspects);
    write_mixture_intervals(&model, result);
    write_mixture(&model, tau0_s, result);
}

/* White noise explains all that most windows can show: then the fit ends here. */
static void fit_usable(const davar_fit_plan_t *plan, double tau0_s, davar_result_t *result)
{
    double amplitude[DAVAR_COEFFICIENT_COUNT];
    fit_white(plan, result, amplitude);
    const unsigned suspects = suspected(plan, amplitude);
    if (!(amplitude[WHITE] > 0.0)) {
        write_constant(plan, result);
    } else if ((suspects == 0U) && fits_white(plan, result, amplitude[WHITE])) {
        write_white_intervals(plan, result);
        write_white(plan, amplitude, tau0_s, result);
    } else {
        fit_mixture(plan, amplitude[WHITE], suspects, tau0_s, result);
    }
}

void davar_fit(davar_fit_plan_t *plan, double tau0_s, davar_result_t *result)
{
    const uint8_t count = usable_count(result);
    write_unusable(result, count);
    if (count == 0U) {
        write_nothing(result);
        return;
    }
    bring_up_to_date(plan, result, count);
    fit_usable(plan, tau0_s, result);
}
