/* davar - coefficients and intervals, DESIGN (5.3) to (5.11). Most windows hold white noise and nothing else that they could
 * show; for them the fit is a handful of sums over numbers that only the window length changes. All else goes to
 * fit_mixture.c. Units here: tau in samples, y = avar * m, so that white noise is a constant y = N^2. */
#include "davar/fit.h"

#include "fit_mixture.h"
#include "fit_plan.h"
#include "noise.h"
#include "real.h"

#define TERMS ((int)DAVAR_COEFFICIENT_COUNT)
#define WHITE DAVAR_ANGLE_RANDOM_WALK

/* One-sided 95 % point of a Gaussian. */
#define BOUND 1.645

/* adev and y = adev^2 m of the usable cluster sizes, in units of a power of two near the largest adev: of no extreme size, so
 * that a float holds them. */
typedef struct {
    uint64_t exponent; /* of the unit, as a double has it */
    float adev[DAVAR_TAUS_MAX];
    float y[DAVAR_TAUS_MAX];
} relative_t;

#define EXPONENT (UINT64_C(0x7FF) << 52U)
#define ONE (UINT64_C(1023) << 52U) /* 1.0 */

/* value >= 0 over 2^(exponent - 1023): exact, and no more than an integer's subtraction. */
static float over_power(double value, uint64_t exponent)
{
    const uint64_t bits = davar_bits_of_double(value);
    const bool vanishes = (bits == 0U) || ((bits + ONE) <= exponent);
    return vanishes ? 0.0F : (float)davar_double_of_bits((bits + ONE) - exponent);
}

static double times_power(float value, uint64_t exponent)
{
    const uint64_t bits = davar_bits_of_double((double)value);
    return (bits == 0U) ? 0.0 : davar_double_of_bits((bits - ONE) + exponent);
}

/* False: all are 0. */
static bool relate(const davar_fit_plan_t *plan, const davar_result_t *result, relative_t *relative)
{
    uint64_t largest = 0U; /* positive doubles have the order of their bits */
    for (int t = 0; t < plan->count; t++) {
        const uint64_t bits = davar_bits_of_double(result->tau[t].adev);
        largest = (bits > largest) ? bits : largest;
    }
    relative->exponent = largest & EXPONENT;
    for (int t = 0; t < plan->count; t++) {
        relative->adev[t] = over_power(result->tau[t].adev, relative->exponent);
        relative->y[t] = relative->adev[t] * relative->adev[t] * plan->m[t];
    }
    return relative->exponent != 0U;
}

/* Amplitudes of the shapes. */
static void fit_white(const davar_fit_plan_t *plan, const float y[], float amplitude[])
{
    for (int k = 0; k < TERMS; k++) {
        float sum = 0.0F;
        for (int t = 0; t < plan->count; t++) {
            sum += plan->functional[k][t] * y[t];
        }
        amplitude[k] = sum;
    }
}

static bool fits_white(const davar_fit_plan_t *plan, const float y[], float inverse_white)
{
    float misfit = 0.0F;
    for (int t = 0; t < plan->count; t++) {
        const float excess = y[t] * inverse_white - 1.0F;
        misfit += plan->edf[t] * excess * excess;
    }
    return 0.5F * misfit <= (float)(plan->count - 1) + (float)DAVAR_FIT_MISFIT * plan->misfit_spread;
}

/* The terms that are significant beside white noise, a bit each (5.7); from here on amplitudes are shares of that noise. */
static unsigned suspected(const davar_fit_plan_t *plan, const float share[])
{
    unsigned found = 0U;
    for (int k = 0; k < TERMS; k++) {
        if ((k != WHITE) && (share[k] > (float)DAVAR_FIT_THRESHOLD * plan->sigma[k])) {
            found |= 1U << (unsigned)k;
        }
    }
    return found;
}

/* From a[k] of avar = sum a[k] m^(k - 2) to the squares of the coefficients in their units (1.2). */
static void square_units(double rate_hz, double unit[])
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
    const double margin = BOUND * sigma;
    const double small = ((a > 0.0) ? a : 0.0) + margin;
    return small + margin * (small * inverse_room);
}

/* ... as a share of white noise. */
static float white_bound(float share, float sigma)
{
    const float margin = (float)BOUND * sigma;
    const float small = ((share > 0.0F) ? share : 0.0F) + margin;
    return small + margin * small;
}

static void write_white_intervals(const davar_fit_plan_t *plan, const relative_t *relative, davar_result_t *result)
{
    for (int t = 0; t < plan->count; t++) {
        davar_adev_t *tau = &result->tau[t];
        tau->edf = (double)plan->edf[t];
        tau->low = times_power(relative->adev[t] * plan->low[t], relative->exponent);
        tau->high = times_power(relative->adev[t] * plan->high[t], relative->exponent);
    }
}

/* Lower limit of N^2 beside an absent term: its interval must hold what the term would leave of it (5.10). */
static float doubted_white(const davar_fit_plan_t *plan, const float share[], int term)
{
    const float left = 1.0F - plan->centre[term] * share[term];
    const float uncertain = plan->doubt[term];
    return (uncertain >= (float)DAVAR_FIT_NOTHING * left) ? 0.0F : left * davar_chi_square_low(uncertain / left);
}

static float least_white(const davar_fit_plan_t *plan, const float share[])
{
    float least = plan->white_low;
    for (int k = 0; k < TERMS; k++) {
        if ((k != WHITE) && (share[k] > (float)DAVAR_FIT_DOUBT * plan->sigma[k])) {
            const float low = doubted_white(plan, share, k);
            least = (low < least) ? low : least;
        }
    }
    return least;
}

/* root: of N^2, in the units of adev. */
static void write_white(const davar_fit_plan_t *plan, const float share[], double root, davar_result_t *result)
{
    for (int k = 0; k < TERMS; k++) {
        const double high = (double)davar_rootf(white_bound(share[k], plan->sigma[k]));
        write_absent(&result->coefficient[k], root * high * plan->root[k]);
    }
    const double value = root * plan->root[WHITE];
    const double low = (double)davar_rootf(least_white(plan, share));
    result->coefficient[WHITE] = (davar_coefficient_t){true, value, value * low, value * (double)plan->white_high};
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
    for (int t = 0; t < plan->count; t++) {
        result->tau[t].edf = (double)plan->edf[t];
        result->tau[t].low = 0.0;
        result->tau[t].high = (double)INFINITY;
    }
    write_nothing(result);
}

static void fit_mixture(const davar_fit_plan_t *plan, double white, unsigned suspects, double rate_hz,
                        davar_result_t *result)
{
    davar_mixture_t model = {
        .data = result, .weight = plan->weight, .count = plan->count, .misfit_spread = (double)plan->misfit_spread};
    davar_mixture_fit(&model, white, suspects);
    write_mixture_intervals(&model, result);
    write_mixture(&model, rate_hz, result);
}

/* White noise explains all that most windows can show: then the fit ends here. */
static void fit_usable(davar_fit_plan_t *plan, const relative_t *relative, double rate_hz, davar_result_t *result)
{
    float share[DAVAR_COEFFICIENT_COUNT];
    fit_white(plan, relative->y, share);
    const float white = share[WHITE];
    const float inverse = 1.0F / white;
    for (int k = 0; k < TERMS; k++) {
        share[k] *= inverse;
    }
    const double root = times_power(davar_rootf(white), relative->exponent);
    const unsigned suspects = suspected(plan, share);
    if ((suspects != 0U) || !fits_white(plan, relative->y, inverse)) {
        fit_mixture(plan, root * root, suspects, rate_hz, result);
        return;
    }
    if (davar_bits_of_double(plan->rate_hz) != davar_bits_of_double(rate_hz)) {
        plan_roots(plan, rate_hz);
    }
    write_white_intervals(plan, relative, result);
    write_white(plan, share, root, result);
}

void davar_fit_prepared(davar_fit_plan_t *plan, double rate_hz, davar_result_t *result)
{
    relative_t relative;
    if ((result->tau_count == 0U) || (result->tau[0].differences == 0U)) {
        write_unusable(result, 0);
        write_nothing(result);
        return;
    }
    write_unusable(result, plan->count);
    if (relate(plan, result, &relative)) {
        fit_usable(plan, &relative, rate_hz, result);
    } else {
        write_constant(plan, result);
    }
}

void davar_fit(davar_fit_plan_t *plan, double tau0_s, davar_result_t *result)
{
    davar_fit_prepare(plan, result);
    davar_fit_prepared(plan, 1.0 / tau0_s, result);
}
