/* davar - what the stages hold, as a verdict and as a result. Reading and computing are apart: what is read may change under
 * the reader's eyes and is read again then, what is computed may take its time. */
#ifndef DAVAR_SRC_COLLECT_H
#define DAVAR_SRC_COLLECT_H

#include "common/sequence.h"
#include "grid/grid_window.h"
#include "number/absent.h"
#include "number/real.h"
#include "pipeline/tracker.h"
#include "track/likelihood.h"

/* Power sums from the window's trailing edge to a record: in `room`. */
static const powers_t *powers_to(powers_t *room, const powers_t *later, const powers_t *earlier)
{
    static const powers_t no_powers = {0};
    davar_read_apart();
    powers_between(room, later, (earlier == NULL) ? &no_powers : earlier);
    return room;
}

static const powers_t *window_whole(powers_t *room, const stages_t *stages)
{
    if (!on_grid(stages)) {
        return &stages->moments.whole;
    }
    const records_t *const records = &stages->grid->records;
    return powers_to(room, records->head_powers, records->tail_powers);
}

/* ... without its newest segment. */
static const powers_t *window_first(powers_t *room, const stages_t *stages)
{
    if (!on_grid(stages)) {
        return &stages->moments.first;
    }
    const records_t *const records = &stages->grid->records;
    return powers_to(room, records->middle_powers, records->tail_powers);
}

/* --- a result --------------------------------------------------------------------------------------------------- */

/* What a result is computed from beside its own integers. */
typedef struct {
    sum_t sum[DAVAR_TAUS_MAX];
    powers_t whole;
    powers_t first;
    uint32_t alarms;     /* of the detector, ever */
    uint32_t dispersion; /* f, GAIN_DIGITS; 0: no detector */
    uint32_t changed;    /* cluster that changed; 0: none did */
    davar_spread_t older;
    davar_spread_t newer;
    int32_t gain;
    bool unstable;
} readings_t;

static uint32_t differences(const davar_gaps_t *gaps, const davar_window_t *window, uint32_t m)
{
    const uint32_t span = 2U * m;
    return (window->length < span) ? 0U : ((window->length - span + 1U) - davar_gaps_spans_lost(gaps, window, m));
}

/* Samples of the window that are mirror images of others in it. */
static uint32_t samples_mirrored(const davar_window_t *window)
{
    const uint32_t in_front = at_start(window) ? (0U - window_tail(window)) : 0U;
    const uint32_t behind = is_finished(window) ? (window_head(window) - window->end) : 0U;
    return in_front + (((int32_t)behind > 0) ? behind : 0U);
}

static uint64_t epoch_of(const stages_t *stages, const davar_config_t *config, const davar_window_t *window)
{
    const uint64_t now = window_now(window) - (is_tracked(stages) ? stages->tracker->left_out : 0U);
    if (tracks_about(config)) { /* so far behind the newest sample when it was complete */
        const uint32_t since = config->stride - window->wait;
        return now - since - half_in_samples(config) - 1U;
    }
    return now - window->lag - (is_centred(config) ? (window->length / 2U) : 1U);
}

static void read_window(const davar_config_t *config, const davar_gaps_t *gaps, const davar_window_t *window,
                        davar_result_t *result)
{
    result->tau_count = config->tau_count;
    result->window_samples = window->length;
    result->mirrored_samples = samples_mirrored(window);
    result->gaps_in_window = davar_gaps_inside(gaps, window);
    for (uint32_t t = 0U; t < config->tau_count; t++) {
        result->tau[t].m = config->taus[t];
        result->tau[t].differences = differences(gaps, window, config->taus[t]);
    }
}

static void read_sums(const stages_t *stages, readings_t *readings)
{
    if (!on_grid(stages)) {
        for (uint32_t t = 0U; t < stages->allan.count; t++) {
            sum_copy(&readings->sum[t], &stages->allan.tau[t].sum);
        }
        return;
    }
    const records_t records = stages->grid->records;
    davar_read_apart();
    for (uint32_t t = 0U; t < stages->allan.count; t++) {
        readings->sum[t] = records_sum(&records, t);
    }
}

/* The stretches in front of the newest change and behind it. */
static void read_change(const tracker_t *tracker, readings_t *readings)
{
    const bool is_single = (tracker->changed <= 1U);
    const davar_glr_t *const detector = is_single ? &tracker->detector : &tracker->clusters->detector;
    readings->changed = tracker->changed;
    readings->gain = tracker->gain;
    spread_copy(&readings->older, &tracker->older);
    readings->newer = spread_between(&detector->alarm.sum, &detector->now.sum);
}

/* What the detector says. */
static void read_tracker(const davar_t *davar, davar_result_t *result, readings_t *readings)
{
    const stages_t *const stages = davar->stages;
    readings->alarms = davar->health.alarms;
    readings->dispersion = 0U;
    readings->changed = 0U;
    result->cut_age_samples = 0U;
    result->young = false;
    if (is_tracked(stages)) {
        result->cut_age_samples = stages->tracker->age;
        result->young = stages->tracker->young;
        readings->dispersion = davar_glr_dispersion(&stages->tracker->detector);
        read_change(stages->tracker, readings);
    }
}

/* Reads everything that a push changes, and computes nothing that can wait: only a stretch as long as this must come
 * without a push now and then. What a push tears may be wrong but must do no harm: what indices and loops depend on is
 * copied first. */
static void read_stages(const davar_t *davar, davar_result_t *result, readings_t *readings)
{
    const davar_window_t window = davar->window;
    const davar_gaps_t gaps = davar->gaps;
    davar_read_apart();
    read_window(davar->config, &gaps, &window, result);
    result->epoch = epoch_of(davar->stages, davar->config, &window);
    read_sums(davar->stages, readings);
    readings->unstable = davar->unstable;
    read_tracker(davar, result, readings);
    if (has_moments(davar->config)) {
        powers_copy(&readings->whole, window_whole(&readings->whole, davar->stages));
        powers_copy(&readings->first, window_first(&readings->first, davar->stages));
    }
}

/* (1.1) */
static double deviation_of(sum_t sum, const davar_adev_t *tau)
{
    const uint64_t squares = davar_multiply_u32(2U * tau->m, tau->m);
    const bool exact = (squares >> 29U) == 0U; /* the product with n <= 2^24 */
    const double divisor = exact ? davar_double_of_u64(davar_scale_u64(squares, tau->differences))
                                 : davar_scale(davar_double_of_u64(squares), davar_double_of_u64(tau->differences));
    return davar_root_of_quotient(sum_to_double(sum), divisor);
}

static void evaluate_taus(const readings_t *readings, double unit_per_count, davar_result_t *result)
{
    for (uint32_t t = 0U; t < result->tau_count; t++) {
        davar_adev_t *const tau = &result->tau[t];
        tau->adev = (double)NAN;
        if (tau->differences > 0U) {
            tau->adev = davar_scale(deviation_of(readings->sum[t], tau), unit_per_count);
        }
    }
}

static void evaluate_stationarity(const davar_config_t *config, const readings_t *readings, davar_result_t *result)
{
    result->unstable = is_adaptive(config) && readings->unstable;
    result->kurtosis = (double)NAN;
    result->contribution = (double)NAN;
    if (has_moments(config)) {
        davar_central_t whole;
        davar_central_t first;
        powers_central(&readings->whole, result->window_samples, &whole);
        powers_central(&readings->first, result->window_samples - config->segment, &first);
        if (!is_adaptive(config)) {
            result->unstable = davar_stationarity_unstable(config, &whole, &first);
        }
        result->kurtosis = davar_stationarity_kurtosis(&whole);
        result->contribution = davar_stationarity_contribution(&whole, &first);
    }
}

/* Of a sum of b (10.1) or of 6 D^2 + m (10.13). NaN where no block is: all were lost in gaps. */
static double level_of(const davar_config_t *config, const davar_spread_t *sum, uint32_t m, double unit_per_count)
{
    const uint32_t rounding = (m == 1U) ? (config->block * (config->block - 1U)) : m;
    const uint32_t unit = (m == 1U) ? rounding : (m * m);
    if (sum->blocks == 0U) {
        return (double)NAN;
    }
    return davar_scale(spread_level(sum, rounding, 12U * unit), unit_per_count);
}

static void evaluate_change(const davar_config_t *config, const readings_t *readings, double unit_per_count,
                            davar_result_t *result)
{
    davar_change_t *const change = &result->change;
    change->m = readings->changed;
    change->older = (double)NAN;
    change->newer = (double)NAN;
    change->gain = (double)NAN;
    if (DAVAR_TRACKING && (readings->changed != 0U)) {
        change->older = level_of(config, &readings->older, readings->changed, unit_per_count);
        change->newer = level_of(config, &readings->newer, readings->changed, unit_per_count);
        change->gain = davar_scale(davar_double_of_u64((uint32_t)readings->gain), 1.0 / (double)(1U << GAIN_DIGITS));
    }
}

static void evaluate(const davar_t *davar, const readings_t *readings, davar_result_t *result)
{
    const davar_config_t *const config = davar->config;
    const double unit_per_count =
        is_float(davar) ? davar_inverse_of_power(davar->counts_per_unit) : config->unit_per_count;
    result->unit_per_count = is_float(davar) ? 0.0 : config->unit_per_count;
    evaluate_taus(readings, unit_per_count, result);
    evaluate_stationarity(config, readings, result);
    result->alarm = (readings->alarms != davar->alarms_seen);
    result->dispersion = (double)NAN;
    if (readings->dispersion != 0U) {
        result->dispersion = (double)readings->dispersion / (double)(1U << GAIN_DIGITS);
    }
    evaluate_change(config, readings, unit_per_count, result);
    davar_absent_taus(result, 0U);
    davar_absent_coefficients(result);
}

#endif
