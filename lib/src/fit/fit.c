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

static void write_mixture_intervals(const davar_mixture_t *model, davar_result_t *result)
{
    for (int t = model->first; t < model->end; t++) {
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

/* A term of three standard errors has so many degrees of freedom. A misfit in which it disappears
 * hides it (5.9). */
#define LOST_EDF (2.0 * DAVAR_FIT_THRESHOLD * DAVAR_FIT_THRESHOLD)

static davar_coefficient_t coefficient_of(const davar_mixture_t *model, int term,
                                          const double unit[])
{
    davar_coefficient_t coefficient;
    if (((model->terms >> (unsigned)term) & 1U) != 0U) {
        const double a = model->a[term];
        const double edf = 2.0 * a * a / model->variance[term];
        double low;
        double high;
        davar_chi_square_interval(edf, &low, &high);
        const double value = davar_root(a * unit[term]);
        coefficient = (davar_coefficient_t){
            true, value, davar_root(model->least[term] * unit[term]), value * davar_root(high)};
        if ((model->grow > 1.0) && !(edf > LOST_EDF)) {
            write_absent(&coefficient, coefficient.high);
        }
    } else {
        write_absent(&coefficient, davar_root(davar_mixture_most(model, term) * unit[term]));
    }
    return coefficient;
}

/* The terms from `first` on. */
static void write_terms(const davar_mixture_t *model, int first, double rate_hz,
                        davar_result_t *result)
{
    double unit[DAVAR_COEFFICIENT_COUNT];
    davar_square_units(rate_hz, unit);
    for (int k = first; k < TERMS; k++) {
        result->coefficient[k] = coefficient_of(model, k, unit);
    }
}

/* The part of N^2 that an undeclared filter may have taken: a factor of its upper limit (5.17). */
static double undeclared_factor(const davar_plan_t *plan, const davar_mixture_t *model)
{
    if (plan->white.declared) {
        return 1.0;
    }
    const double sigma = davar_root(model->variance[DAVAR_QUANTIZATION]);
    const double lack = -model->tried[DAVAR_QUANTIZATION];
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
    const double hidden = (double)plan->white.hidden * (double)plan->white.hidden /
                          plan->white.rounding_variance * model->rounding;
    double slow = 0.0; /* variance of a sample by the other terms: the model at m = 1 */
    for (int k = 0; k < TERMS; k++) {
        slow += (k != WHITE) ? model->a[k] : 0.0;
    }
    if (hidden > model->a[WHITE] + (slow / (double)plan->white.sample)) {
        davar_write_coarse(plan, walk->high, result);
    } else if (walk->present && ((hidden > model->a[WHITE]) || !davar_mixture_shows_white(model))) {
        write_absent(walk, walk->high);
    } else if (walk->present) {
        walk->high *= davar_root(undeclared_factor(plan, model));
    }
    if (!walk->present) {
        walk->high = davar_half_a_count_at_least(&plan->white, result, walk->high);
    }
}

static void write_mixture(const davar_mixture_t *model, double rate_hz, davar_result_t *result)
{
    write_mixture_intervals(model, result);
    write_terms(model, DAVAR_QUANTIZATION, rate_hz, result);
    write_white_part(model->plan, model, result);
}

static void fit_window(davar_plan_t *plan, double rate_hz, davar_result_t *result)
{
    davar_white_t white;
    if (davar_white_suffices(plan, rate_hz, result, &white)) {
        return;
    }
    davar_mixture_t model = {.plan = plan, .data = result, .end = plan->white.count};
    davar_mixture_fit(&model, davar_scaled_to_double(white.sum), white.suspects);
    if (davar_mixture_is_filtered(&model) && white.repeats) {
        write_terms(&model, DAVAR_QUANTIZATION, rate_hz, result);
        davar_write_coarse(plan, result->coefficient[WHITE].high, result);
    } else if (davar_mixture_is_filtered(&model)) {
        davar_write_filtered(plan, result);
    } else {
        result->noise = DAVAR_NOISE_MIXED;
        write_mixture(&model, rate_hz, result);
    }
}

/* --- the sizes of a cascade (5.18) --- */

/* The window shows nothing that contradicts the plan, or there is no window. */
static bool is_open(davar_noise_t noise)
{
    return (noise == DAVAR_NOISE_WHITE) || (noise == DAVAR_NOISE_MIXED) ||
           (noise == DAVAR_NOISE_UNKNOWN);
}

/* With fewer sizes, a cascade says less about the slow terms than the window does. */
#define SIZES_LEAST 4

/* Sets the range of sizes that a cascade filled. They are the last ones. */
static void find_cascade(davar_mixture_t *model)
{
    const davar_result_t *const result = model->data;
    const uint8_t sizes = model->plan->sizes;
    model->first = 0;
    model->end = 0;
    for (int t = (result->tau_count < sizes) ? result->tau_count : sizes;
         (t > 0) && davar_hops(&result->tau[t - 1]); t--) {
        if (davar_mixture_has(model, t - 1)) {
            model->end = (model->end > 0) ? model->end : t;
            model->first = t - 1;
        }
    }
}

/* White noise that alone explains the shortest size that is not 0. Returns 0 if
 * all sizes are. */
static double first_white(const davar_mixture_t *model)
{
    for (int t = model->first; t < model->end; t++) {
        const double adev = model->data->tau[t].adev;
        if (adev > 0.0) { /* not NaN */
            return adev * adev * (double)model->plan->m[t] / davar_mixture_white(model, t);
        }
    }
    return 0.0;
}

/* The slow terms, or all if there is no window. White noise stays that of the window: it
 * is newer. */
DAVAR_RARE static void write_cascade(const davar_mixture_t *model, double rate_hz,
                                     davar_result_t *result)
{
    const bool is_white = (model->terms == (1U << (unsigned)WHITE)) && !(model->grow > 1.0);
    if (result->noise == DAVAR_NOISE_UNKNOWN) {
        result->noise = is_white ? DAVAR_NOISE_WHITE : DAVAR_NOISE_MIXED;
        write_mixture(model, rate_hz, result);
        return;
    }
    write_mixture_intervals(model, result);
    if ((model->end - model->first) >= SIZES_LEAST) {
        write_terms(model, DAVAR_BIAS_INSTABILITY, rate_hz, result);
    }
    if (!is_white && (result->noise == DAVAR_NOISE_WHITE)) {
        result->noise = DAVAR_NOISE_MIXED;
    }
}

DAVAR_RARE static void fit_cascade(davar_plan_t *plan, double rate_hz, davar_result_t *result)
{
    const bool alone = (result->noise == DAVAR_NOISE_UNKNOWN);
    davar_mixture_t model = {.plan = plan, .data = result};
    find_cascade(&model);
    const double white = first_white(&model);
    if (!(white > 0.0)) {
        if (alone && (model.end > 0)) {
            davar_write_unlimited(plan, DAVAR_NOISE_CONSTANT, result);
        }
        return;
    }
    davar_plan_rate(plan, rate_hz);
    davar_mixture_fit(&model, white, 0U);
    if (alone && davar_mixture_is_filtered(&model)) {
        davar_write_unlimited(plan, DAVAR_NOISE_FILTERED, result);
    } else {
        write_cascade(&model, rate_hz, result);
    }
}

void davar_fit(davar_plan_t *plan, double rate_hz, davar_result_t *result)
{
    fit_window(plan, rate_hz, result);
    if (is_open(result->noise)) {
        fit_cascade(plan, rate_hz, result);
    }
}

const char *davar_noise_text(davar_noise_t noise)
{
    static const char *const text[] = {
        [DAVAR_NOISE_UNKNOWN] = "not fitted, or a window without differences",
        [DAVAR_NOISE_WHITE] = "white noise",
        [DAVAR_NOISE_MIXED] = "several kinds of noise",
        [DAVAR_NOISE_CONSTANT] = "a constant: noise below one count, or a stuck sensor",
        [DAVAR_NOISE_COARSE] = "noise that rounding to counts hides",
        [DAVAR_NOISE_FILTERED] = "noise after a filter that is not the declared one",
    };
    return ((size_t)noise < (sizeof text / sizeof text[0])) ? text[noise] : "unknown noise";
}
