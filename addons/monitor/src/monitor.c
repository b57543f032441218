/* davar - compares a result with the table of an error model (9.1) to (9.5). It uses
 * only operations that IEEE 754 rounds correctly, so every target computes the same bits. */
#include "davar/monitor.h"

#include "davar/fit.h"
#include "number/hop.h"
#include "number/real.h"

#define RATIO_LIMIT 1e12 /* of variances; it bounds the loops of cube_root */
#define LIMITS 32U

/* For 1/RATIO_LIMIT <= r <= RATIO_LIMIT: scales r by eights to 1/8 .. 8, then takes four steps of
 * Halley's iteration. */
static double cube_root(double r)
{
    double scale = 1.0;
    while (r > 8.0) {
        r *= 0.125;
        scale *= 2.0;
    }
    while (r < 0.125) {
        r *= 8.0;
        scale *= 0.5;
    }
    double root = 1.0;
    for (uint32_t step = 0U; step < 4U; step++) {
        const double cube = root * root * root;
        root *= (cube + 2.0 * r) / (2.0 * cube + r);
    }
    return scale * root;
}

/* The variance of the cube root of a chi-square over its degrees of freedom. Its mean is 1 minus
 * this (9.1). */
static double scatter_of(double edf)
{
    return 2.0 / (9.0 * edf);
}

/* The cube root of the variance ratio, minus its mean under the model (9.1). */
static double excess_of(double adev, double edf, const davar_model_tau_t *model)
{
    const double ratio = (adev / model->adev_dps) * (adev / model->adev_dps);
    const double bounded = (ratio > 1.0 / RATIO_LIMIT)
                               ? ((ratio < RATIO_LIMIT) ? ratio : RATIO_LIMIT)
                               : 1.0 / RATIO_LIMIT;
    return cube_root(bounded) - 1.0 + scatter_of(edf);
}

/* The part of the variance that comes from the tolerance of the model (9.2). */
static double tolerance_of(const davar_model_tau_t *model)
{
    const double part = (2.0 / 3.0) * model->relative_tolerance;
    return part * part;
}

double davar_deviation(double adev, double edf, const davar_model_tau_t *model)
{
    DAVAR_ASSERT((edf >= 1.0) && (model->adev_dps > 0.0));
    return excess_of(adev, edf, model) / davar_root(scatter_of(edf) + tolerance_of(model));
}

static const davar_model_tau_t *entry_of(const davar_model_tau_t *model, uint8_t count, uint32_t m)
{
    for (uint8_t i = 0U; i < count; i++) {
        if (model[i].m == m) {
            return &model[i];
        }
    }
    return NULL;
}

static davar_monitor_status_t check_entry(const davar_model_tau_t *model, uint8_t i)
{
    const double adev = model[i].adev_dps;
    const double tolerance = model[i].relative_tolerance;
    if (!(adev > 0.0) || !isfinite(adev)) {
        return DAVAR_MONITOR_ERR_ADEV;
    }
    if (!(tolerance >= 0.0) || !isfinite(tolerance)) {
        return DAVAR_MONITOR_ERR_TOLERANCE;
    }
    return (entry_of(model, i, model[i].m) != NULL) ? DAVAR_MONITOR_ERR_TWICE : DAVAR_MONITOR_OK;
}

davar_monitor_status_t davar_monitor_init(davar_monitor_t *monitor, const davar_model_tau_t *model,
                                          uint8_t count, double memory)
{
    DAVAR_ASSERT((monitor != NULL) && (model != NULL));
    davar_monitor_status_t status = (count > 0U) ? DAVAR_MONITOR_OK : DAVAR_MONITOR_ERR_EMPTY;
    for (uint8_t i = 0U; (i < count) && (status == DAVAR_MONITOR_OK); i++) {
        status = check_entry(model, i);
    }
    if ((status == DAVAR_MONITOR_OK) && (!(memory >= 1.0) || !isfinite(memory))) {
        status = DAVAR_MONITOR_ERR_MEMORY;
    }
    if (status == DAVAR_MONITOR_OK) {
        *monitor = (davar_monitor_t){.model = model, .model_count = count, .memory = memory};
    }
    return status;
}

const char *davar_monitor_status_text(davar_monitor_status_t status)
{
    static const char *const text[] = {
        [DAVAR_MONITOR_OK] = "ok",
        [DAVAR_MONITOR_ERR_EMPTY] = "no cluster size in the model",
        [DAVAR_MONITOR_ERR_ADEV] = "an Allan deviation of the model not positive and finite",
        [DAVAR_MONITOR_ERR_TOLERANCE] = "a tolerance of the model negative or not finite",
        [DAVAR_MONITOR_ERR_TWICE] = "a cluster size of the model occurs twice",
        [DAVAR_MONITOR_ERR_MEMORY] = "the mean must extend over at least one window",
    };
    return ((size_t)status < (sizeof text / sizeof text[0])) ? text[status] : "unknown status";
}

/* Samples since the previous result; infinite after a restart of the stream. */
static double step_of(const davar_monitor_t *monitor, const davar_result_t *result)
{
    const bool follows = monitor->started && (result->epoch > monitor->epoch);
    return follows ? (double)(result->epoch - monitor->epoch) : (double)INFINITY;
}

/* Samples that a size looks back over. */
static double span_of(const davar_result_t *result, const davar_adev_t *measured)
{
    return davar_hops(measured) ? davar_hop_span(measured) : (double)result->window_samples;
}

/* Of these, those that the mean does not contain. A size of a cascade may only grow for a long
 * time; its new differences count. If it has fewer than before, it dropped a generation (11.5). */
static double fresh_of(const davar_monitor_tau_t *tau, const davar_adev_t *measured, double span,
                       double step)
{
    if (!(step < span)) {
        return span;
    }
    const bool has_grown = davar_hops(measured) && (measured->differences >= tau->differences);
    return has_grown ? (double)(measured->differences - tau->differences) * (double)measured->m /
                           (double)measured->hops
                     : step;
}

/* Updates the running mean of at most `memory` windows (9.4). A window that contains all that the
 * mean is worth replaces it. */
static void remember(davar_monitor_tau_t *tau, double memory, double span, double fresh,
                     double excess, double edf)
{
    const double most = memory * span;
    const double grown = tau->samples + fresh;
    tau->samples = (grown < most) ? grown : most;
    if (tau->samples > span) {
        const double weight = fresh / tau->samples;
        const double kept = 1.0 - weight;
        tau->excess += weight * (excess - tau->excess);
        tau->variance =
            kept * kept * tau->variance + weight * scatter_of(edf) * (span / tau->samples);
    } else {
        tau->samples = span;
        tau->excess = excess;
        tau->variance = scatter_of(edf);
    }
}

static double mean_deviation(const davar_monitor_tau_t *tau, const davar_model_tau_t *model)
{
    return (tau->samples > 0.0) ? tau->excess / davar_root(tau->variance + tolerance_of(model))
                                : (double)NAN;
}

/* Without a fit that explains the window, edf is the smallest that any noise has. */
static davar_misfit_tau_t misfit_compare(davar_monitor_t *monitor, const davar_result_t *result,
                                         uint8_t t, double step)
{
    const davar_adev_t *measured = &result->tau[t];
    const davar_model_tau_t *model = entry_of(monitor->model, monitor->model_count, measured->m);
    davar_misfit_tau_t found = {DAVAR_TAU_NOT_IN_MODEL, (double)NAN, (double)NAN};
    if (model == NULL) {
        return found;
    }
    if ((measured->differences > 0U) && (measured->adev >= 0.0) && isfinite(measured->adev)) {
        const double edf = (measured->edf >= 1.0) ? measured->edf : davar_edf_least(result, t);
        davar_monitor_tau_t *const tau = &monitor->tau[t];
        const double span = span_of(result, measured);
        found.match = DAVAR_TAU_COMPARED;
        found.deviation = davar_deviation(measured->adev, edf, model);
        remember(tau, monitor->memory, span, fresh_of(tau, measured, span, step),
                 excess_of(measured->adev, edf, model), edf);
        tau->differences = measured->differences;
    } else {
        found.match = DAVAR_TAU_NOT_IN_WINDOW;
    }
    found.mean_deviation = mean_deviation(&monitor->tau[t], model);
    return found;
}

/* Health: the largest |deviation| or |mean_deviation| over the limit that chance exceeds in 0.5 %
 * of windows, the two-sided normal quantile at 0.5 % / compared taus (9.3). At least one is
 * compared. */
static void misfit_judge(davar_misfit_t *misfit)
{
    static const double limits[LIMITS + 1U] = {
        0.0,    2.8070, 3.0233, 3.1440, 3.2272, 3.2905, 3.3415, 3.3840, 3.4205, 3.4524, 3.4808,
        3.5062, 3.5293, 3.5504, 3.5699, 3.5879, 3.6047, 3.6204, 3.6352, 3.6491, 3.6623, 3.6747,
        3.6866, 3.6979, 3.7087, 3.7190, 3.7289, 3.7384, 3.7475, 3.7563, 3.7648, 3.7730, 3.7809};
    const double limit = limits[(misfit->compared < LIMITS) ? misfit->compared : LIMITS];
    misfit->fast = 0.0;
    misfit->slow = 0.0;
    misfit->health = 0.0;
    for (uint8_t t = 0U; t < misfit->tau_count; t++) {
        const davar_misfit_tau_t *tau = &misfit->tau[t];
        if (tau->match == DAVAR_TAU_COMPARED) {
            const double fast = fabs(tau->deviation) / limit;
            const double slow = fabs(tau->mean_deviation) / limit;
            const double most = (fast > slow) ? fast : slow;
            misfit->fast = (fast > misfit->fast) ? fast : misfit->fast;
            misfit->slow = (slow > misfit->slow) ? slow : misfit->slow;
            misfit->worst = (most >= misfit->health) ? t : misfit->worst;
            misfit->health = (most >= misfit->health) ? most : misfit->health;
        }
    }
}

void davar_monitor_update(davar_monitor_t *monitor, const davar_result_t *result,
                          davar_misfit_t *misfit)
{
    DAVAR_ASSERT((monitor != NULL) && (result != NULL) && (misfit != NULL));
    const double step = step_of(monitor, result);
    *misfit = (davar_misfit_t){.health = (double)NAN,
                               .fast = (double)NAN,
                               .slow = (double)NAN,
                               .worst = result->tau_count,
                               .tau_count = result->tau_count};
    for (uint8_t t = 0U; t < result->tau_count; t++) {
        misfit->tau[t] = misfit_compare(monitor, result, t, step);
        if (misfit->tau[t].match == DAVAR_TAU_COMPARED) {
            misfit->compared++;
        }
    }
    if (misfit->compared > 0U) {
        misfit_judge(misfit);
    }
    monitor->epoch = result->epoch;
    monitor->started = true;
}
