/* davar-sim - centred windows. The record is extended by the mirror images of half a window at both
 * ends:
 *
 *     half - 1 ... 1 0 | 0 1 2 ...                         ... N - 1 | N - 1 ... N - half
 *     ^ position 0       ^ position half: sample 0
 *
 * The window of epoch p with length L is [p + half - L / 2, p + half + L / 2). It is complete when
 * the sample before p + 2 half has come, so the latency is half of the longest window, whatever L
 * is. All integers are exact, as in the library's pipeline of int32 counts, from which the sums
 * come. */
#include "centred/centred.h"

#include "centred/past.h"
#include "davar/content.h"

#include "number/absent.h"
#include "number/q31.inc"
#include "number/quantum.h"

#include "number/q31_moments.inc"

#include <math.h>
#include <stdlib.h>

/* A cluster size. */
typedef struct {
    sum_t sum;            /* of D^2 over the window */
    uint32_t differences; /* spans without a gap in the window */
} cluster_t;

struct centred {
    const davar_config_t *config;
    davar_port_number_t number;
    float counts_per_unit; /* f32: a power of two */
    int32_t highest;       /* counts at or beyond it, or its complement, are saturated */
    /* Rings, at position modulo capacity. The window and a stride more are in them. */
    uint64_t *total; /* sum of the samples before a position, modulo 2^64 */
    uint32_t *run;   /* samples without a gap, up to and including the one at a position */
    uint32_t capacity;
    uint32_t half;     /* of the longest window */
    uint64_t received; /* samples of the record */
    uint64_t count;    /* position of the next sample; 0: the first half window is incomplete */
    bool is_gap;       /* before the next sample */
    bool is_finished;  /* the record has ended */
    uint64_t tail;     /* the window is [tail, head) */
    uint64_t head;
    uint64_t epoch;  /* the next one */
    uint32_t length; /* of its window */
    cluster_t cluster[DAVAR_TAUS_MAX];
    powers_t whole;
    powers_t first; /* without the newest segment */
    bool is_ready;
    bool is_unstable;
    past_t past; /* law fixed */
    davar_health_t health;
};

/* --- memory ----------------------------------------------------------------------------------- */

static int32_t highest_of(const davar_config_t *config, davar_port_number_t number)
{
    const uint32_t usual = (number == DAVAR_PORT_Q15) ? 16U : 24U;
    const uint32_t given = (config->sample_bits == 0U) ? usual : config->sample_bits;
    return (int32_t)((UINT32_C(1) << (given - 1U)) - 1U);
}

centred_t *centred_open(const davar_config_t *config, davar_port_number_t number)
{
    centred_t *const centred = calloc(1U, sizeof *centred);
    if (centred == NULL) {
        return NULL;
    }
    centred->config = config;
    centred->number = number;
    centred->counts_per_unit =
        (number == DAVAR_PORT_F32) ? davar_counts_per_unit(config->full_scale) : 1.0F;
    centred->highest = highest_of(config, number);
    centred->half = config->window.longest / 2U;
    centred->length = config->window.longest;
    centred->epoch = config->stride - 1U;
    centred->capacity = config->window.longest + config->stride + 1U;
    centred->total = calloc(centred->capacity, sizeof *centred->total);
    centred->run = calloc(centred->capacity, sizeof *centred->run);
    if ((centred->total == NULL) || (centred->run == NULL)) {
        centred_close(centred);
        return NULL;
    }
    return centred;
}

void centred_close(centred_t *centred)
{
    if (centred != NULL) {
        free(centred->total);
        free(centred->run);
        free(centred);
    }
}

/* --- the extended record ---------------------------------------------------------------------- */

static uint64_t *total_at(const centred_t *centred, uint64_t position)
{
    return &centred->total[position % centred->capacity];
}

static uint32_t *run_at(const centred_t *centred, uint64_t position)
{
    return &centred->run[position % centred->capacity];
}

static int32_t sample_at(const centred_t *centred, uint64_t position)
{
    return (int32_t)(int64_t)(*total_at(centred, position + 1U) - *total_at(centred, position));
}

/* The difference of the 2 m samples that begin at a position. */
static difference_t difference_at(const centred_t *centred, uint64_t position, uint32_t m)
{
    return (difference_t)(*total_at(centred, position + (2U * (uint64_t)m)) -
                          (2U * *total_at(centred, position + m)) + *total_at(centred, position));
}

/* True if the 2 m samples that begin at a position are in one run. */
static bool is_one_run(const centred_t *centred, uint64_t position, uint32_t m)
{
    const uint32_t span = 2U * m;
    return *run_at(centred, position + span - 1U) >= span;
}

static void append(centred_t *centred, int32_t sample, bool is_gap)
{
    const uint64_t position = centred->count;
    const uint32_t before = is_gap ? 0U : *run_at(centred, position - 1U);
    *total_at(centred, position + 1U) = *total_at(centred, position) + (uint64_t)(int64_t)sample;
    *run_at(centred, position) = (before < UINT32_MAX) ? (before + 1U) : before;
    centred->count++;
}

/* Writes a sample of the first half window and its mirror image. The runs are only marks until all
 * of these samples are there: 0 where a gap is before the position. */
static void append_first(centred_t *centred, int32_t sample, bool is_gap)
{
    const uint64_t after = centred->half + centred->received;
    const uint64_t before = centred->half - centred->received - 1U;
    *total_at(centred, after + 1U) = *total_at(centred, after) + (uint64_t)(int64_t)sample;
    *total_at(centred, before) = *total_at(centred, before + 1U) - (uint64_t)(int64_t)sample;
    *run_at(centred, after) = is_gap ? 0U : 1U;
    *run_at(centred, before + 1U) = is_gap ? 0U : 1U;
}

static void complete_first(centred_t *centred)
{
    *run_at(centred, 0U) = 1U;
    centred->count = 2U * (uint64_t)centred->half;
    for (uint64_t position = 1U; position < centred->count; position++) {
        const uint32_t before = *run_at(centred, position - 1U);
        *run_at(centred, position) = 1U + ((*run_at(centred, position) == 0U) ? 0U : before);
    }
}

/* --- the sums of the window ------------------------------------------------------------------- */

static bool has_moments(const centred_t *centred)
{
    return centred->config->moments.segment > 0U;
}

/* The window takes the sample at its head. */
static void lead(centred_t *centred)
{
    const davar_config_t *const config = centred->config;
    const uint64_t end = centred->head + 1U;
    for (uint8_t t = 0U; t < config->tau_count; t++) {
        const uint32_t m = config->taus[t];
        const uint64_t span = 2U * (uint64_t)m;
        if (((centred->tail + span) <= end) && is_one_run(centred, end - span, m)) {
            sum_add_square(&centred->cluster[t].sum, difference_at(centred, end - span, m));
            centred->cluster[t].differences++;
        }
    }
    if (has_moments(centred)) {
        const uint64_t segment = config->moments.segment;
        powers_add(&centred->whole, sample_at(centred, centred->head));
        if ((end - centred->tail) > segment) {
            powers_add(&centred->first, sample_at(centred, centred->head - segment));
        }
    }
    centred->head = end;
}

/* The window loses the sample at its tail. It is longer than the segment. */
static void trail(centred_t *centred)
{
    const davar_config_t *const config = centred->config;
    const uint64_t begin = centred->tail;
    for (uint8_t t = 0U; t < config->tau_count; t++) {
        const uint32_t m = config->taus[t];
        if (((begin + (2U * (uint64_t)m)) <= centred->head) && is_one_run(centred, begin, m)) {
            sum_subtract_square(&centred->cluster[t].sum, difference_at(centred, begin, m));
            centred->cluster[t].differences--;
        }
    }
    if (has_moments(centred)) {
        powers_remove(&centred->whole, sample_at(centred, begin));
        powers_remove(&centred->first, sample_at(centred, begin));
    }
    centred->tail = begin + 1U;
}

/* --- an epoch --------------------------------------------------------------------------------- */

static uint32_t window_length(const centred_t *centred)
{
    return (uint32_t)(centred->head - centred->tail);
}

static void central_moments(const centred_t *centred, davar_central_t *whole,
                            davar_central_t *first)
{
    const uint32_t length = window_length(centred);
    powers_central(&centred->whole, length, whole);
    powers_central(&centred->first, length - centred->config->moments.segment, first);
}

/* The flag f (3.4). With a fixed window it is for information. */
static bool judge_moments(const centred_t *centred)
{
    static const davar_rule_t rule[] = {RULE_OR, RULE_KURTOSIS, RULE_OR, RULE_AND};
    davar_central_t whole;
    davar_central_t first;
    if (!has_moments(centred)) {
        return false;
    }
    central_moments(centred, &whole, &first);
    return davar_moments_unstable(centred->config, rule[davar_law_id(centred->config)], &whole,
                                  &first);
}

/* Samples of the window that are mirror images. */
static uint32_t mirrored_samples(const centred_t *centred)
{
    const uint64_t end = centred->received + centred->half;
    const uint64_t before = (centred->tail < centred->half) ? (centred->half - centred->tail) : 0U;
    const uint64_t after =
        (centred->is_finished && (centred->head > end)) ? (centred->head - end) : 0U;
    return (uint32_t)(before + after);
}

/* Has a fixed window changed? The mirror images say nothing. */
static bool has_changed(centred_t *centred)
{
    const davar_config_t *const config = centred->config;
    const davar_u128_t *const sum = &centred->cluster[0].sum;
    const bool is_known = (config->taus[0] == 1U) && (mirrored_samples(centred) == 0U);
    return (config->law == NULL) &&
           past_next(&centred->past, config->stride, config->window.longest,
                     is_known ? past_level(sum->high, sum->low) : PAST_UNKNOWN);
}

/* The length of the next window. Neither edge moves backwards. */
static uint32_t next_length(const centred_t *centred)
{
    const davar_config_t *const config = centred->config;
    const uint64_t length = centred->length;
    const uint64_t shrink = (uint64_t)config->window.shrink * config->stride;
    const uint64_t grow = (uint64_t)config->window.grow * config->stride;
    if (config->law == NULL) {
        return config->window.longest;
    }
    if (centred->is_unstable) {
        return (length > (config->window.shortest + shrink)) ? (uint32_t)(length - shrink)
                                                             : config->window.shortest;
    }
    return ((length + grow) < config->window.longest) ? (uint32_t)(length + grow)
                                                      : config->window.longest;
}

/* The sample or image before `count` has come. True if it completes an epoch. */
static bool advance(centred_t *centred)
{
    const uint64_t middle = centred->epoch + centred->half;
    if (centred->count < (middle + centred->half)) {
        return false;
    }
    while (centred->head < (middle + (centred->length / 2U))) {
        lead(centred);
    }
    while (centred->tail < (middle - (centred->length / 2U))) {
        trail(centred);
    }
    const bool has_moved = has_changed(centred);
    centred->is_unstable = judge_moments(centred) || has_moved;
    centred->length = next_length(centred);
    centred->epoch += centred->config->stride;
    centred->is_ready = true;
    return true;
}

/* --- samples in ------------------------------------------------------------------------------- */

/* Limits a count. Counts at either end are saturated. */
static int32_t limited(centred_t *centred, int32_t count)
{
    const int32_t highest = centred->highest;
    if ((count > (-highest - 1)) && (count < highest)) {
        return count;
    }
    davar_count(&centred->health.saturated);
    return (count < 0) ? (-highest - 1) : highest;
}

static int32_t count_of(centred_t *centred, davar_port_samples_t samples, size_t i)
{
    switch (centred->number) {
    case DAVAR_PORT_Q15:
        return limited(centred, samples.q15[i]);
    case DAVAR_PORT_Q31:
        return limited(centred, samples.q31[i]);
    case DAVAR_PORT_F32:
    default:
        return davar_float_to_counts(samples.f32[i], (float)centred->config->full_scale,
                                     centred->counts_per_unit, &centred->health.saturated);
    }
}

/* True if the sample completes an epoch. */
static bool take_in(centred_t *centred, int32_t sample)
{
    const bool is_gap = centred->is_gap && (centred->received > 0U);
    centred->is_gap = false;
    if (centred->count > 0U) {
        append(centred, sample, is_gap);
    } else {
        append_first(centred, sample, is_gap);
    }
    centred->received++;
    if (centred->received == centred->half) {
        complete_first(centred);
    }
    return (centred->count > 0U) && advance(centred);
}

size_t centred_push(centred_t *centred, davar_port_samples_t samples, size_t from, size_t count)
{
    for (size_t i = from; i < count; i++) {
        if (take_in(centred, count_of(centred, samples, i))) {
            return i + 1U - from;
        }
    }
    return count - from;
}

void centred_gap(centred_t *centred, uint32_t missing)
{
    davar_count(&centred->health.gaps);
    davar_count_many(&centred->health.missing, missing);
    centred->is_gap = true;
}

/* The k-th image after the record, at position P + k, is that of position P - 1 - k. A gap before
 * position P - k is between the images k - 1 and k. A gap after the last sample has no place. */
bool centred_flush(centred_t *centred)
{
    const uint64_t end = centred->received + centred->half;
    if (centred->count == 0U) {
        return false;
    }
    centred->is_finished = true;
    while ((centred->count - end) < (centred->half - 1U)) {
        const uint64_t k = centred->count - end;
        const bool is_gap = (k > 0U) && (*run_at(centred, end - k) == 1U);
        append(centred, sample_at(centred, end - 1U - k), is_gap);
        if (advance(centred)) {
            return true;
        }
    }
    return false;
}

/* --- a result out ----------------------------------------------------------------------------- */

/* From the newest run back to the one that contains the tail. */
static uint32_t gaps_inside(const centred_t *centred)
{
    uint32_t gaps = 0U;
    uint64_t end = centred->head;
    while (*run_at(centred, end - 1U) < (end - centred->tail)) {
        end -= *run_at(centred, end - 1U);
        gaps++;
    }
    return gaps;
}

/* The newest equal samples of the window, up to 1024. */
static uint32_t equal_newest(const centred_t *centred)
{
    const int32_t newest = sample_at(centred, centred->head - 1U);
    uint64_t begin = centred->head;
    while ((begin > centred->tail) && ((centred->head - begin) < 1024U) &&
           (sample_at(centred, begin - 1U) == newest)) {
        begin--;
    }
    return (uint32_t)(centred->head - begin);
}

/* (1.1), rounded as in the library's pipelines */
static double deviation_of(const cluster_t *cluster, uint32_t m, double unit_per_count)
{
    if (cluster->differences == 0U) {
        return (double)NAN;
    }
    const uint64_t squares = davar_multiply_u32(2U * m, m);
    const bool is_exact = (squares >> 29U) == 0U; /* the product with at most 2^24 */
    const double divisor =
        is_exact
            ? davar_double_of_u64(davar_scale_u64(squares, cluster->differences))
            : davar_scale(davar_double_of_u64(squares), davar_double_of_u64(cluster->differences));
    return davar_scale(davar_root_of_quotient(sum_to_double(cluster->sum), divisor),
                       unit_per_count);
}

static void fill_taus(const centred_t *centred, davar_result_t *result)
{
    const davar_config_t *const config = centred->config;
    const bool is_float = (centred->number == DAVAR_PORT_F32);
    const double unit =
        is_float ? davar_inverse_of_power(centred->counts_per_unit) : config->unit_per_count;
    result->unit_per_count = is_float ? 0.0 : config->unit_per_count;
    result->tau_count = config->tau_count;
    for (uint8_t t = 0U; t < config->tau_count; t++) {
        const cluster_t *const cluster = &centred->cluster[t];
        result->tau[t] = (davar_adev_t){.m = config->taus[t],
                                        .differences = cluster->differences,
                                        .adev = deviation_of(cluster, config->taus[t], unit)};
    }
    davar_absent_taus(result, 0U);
    davar_absent_coefficients(result);
}

bool centred_take(centred_t *centred, davar_result_t *result)
{
    const double absent = (double)NAN;
    davar_central_t whole;
    davar_central_t first;
    if (!centred->is_ready) {
        return false;
    }
    centred->is_ready = false;
    *result = (davar_result_t){.epoch = centred->epoch - centred->config->stride,
                               .window_samples = window_length(centred),
                               .mirrored_samples = mirrored_samples(centred),
                               .gaps_in_window = gaps_inside(centred),
                               .equal_samples = equal_newest(centred),
                               .unstable = centred->is_unstable,
                               .kurtosis = absent,
                               .contribution = absent,
                               .dispersion = absent};
    if (has_moments(centred)) {
        central_moments(centred, &whole, &first);
        result->kurtosis = davar_kurtosis(&whole);
        result->contribution = davar_contribution(&whole, &first);
    }
    fill_taus(centred, result);
    return true;
}

davar_health_t centred_health(const centred_t *centred)
{
    return centred->health;
}
