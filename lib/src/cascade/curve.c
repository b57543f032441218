/* davar - the cascade: sums out, Allan deviations with degrees of freedom and intervals (11.6). */
#include "cascade/stage.h"
#include "davar/cascade.h"
#include "davar/fit.h"
#include "number/ieee.h"
#include "number/real.h"
#include "number/scaled.h"
#include "number/sequence.h"

#include <math.h>

#define CASCADE_GROWTH_ONE (1U << CASCADE_GROWTH_BITS)
#define CASCADE_LAGS 8U /* lags per cluster in the correlations below, which end at two clusters */
#define CORRELATION_BITS 14U
#define SQUARE_BITS 20U /* of squared correlations */

/* --- the correlation of two differences (11.6), at a lag in eighths of a cluster, as 1.14 --- */

static int32_t correlation_of_white(uint32_t lag)
{
    return (lag < CASCADE_LAGS) ? (16384 - (3072 * (int32_t)lag)) : (1024 * ((int32_t)lag - 16));
}

static int32_t correlation_of_flicker(uint32_t lag)
{
    static const int16_t table[2U * CASCADE_LAGS] = {16384, 15457, 13449, 10813, 7810,  4651,
                                                     1534,  -1316, -3554, -4626, -5008, -4965,
                                                     -4631, -4101, -3457, -2778};
    return table[lag];
}

/* The sum of its squares from two clusters on, times two, per lag of a cluster. */
#define FLICKER_TAIL UINT64_C(19713) /* 0.0188 */

static int32_t correlation_of_walk(uint32_t lag)
{
    const int32_t i = (int32_t)lag;
    const int32_t rest = 16 - i;
    return (lag < CASCADE_LAGS) ? (16384 + (((24 * i) - 384) * i * i)) : (8 * rest * rest * rest);
}

/* --- the kind of noise ------------------------------------------------------------------------ */

/* A mix of neighbouring kinds: `second` has the share of the later one. */
typedef struct {
    bool is_steep;   /* flicker and walk; otherwise white and flicker */
    uint32_t second; /* in units of 1 / CASCADE_GROWTH_ONE */
} cascade_mix_t;

static cascade_mix_t mix_of(uint32_t growth)
{
    const cascade_mix_t steep = {
        true, ((growth < (2U * CASCADE_GROWTH_ONE)) ? growth : (2U * CASCADE_GROWTH_ONE)) -
                  CASCADE_GROWTH_ONE};
    const cascade_mix_t flat = {
        false, (growth > (CASCADE_GROWTH_ONE / 2U)) ? ((2U * growth) - CASCADE_GROWTH_ONE) : 0U};
    return (growth >= CASCADE_GROWTH_ONE) ? steep : flat;
}

static int32_t correlation_of_mix(cascade_mix_t mix, uint32_t lag)
{
    const int32_t middle = correlation_of_flicker(lag);
    const int32_t first = mix.is_steep ? middle : correlation_of_white(lag);
    const int32_t second = mix.is_steep ? correlation_of_walk(lag) : middle;
    return first + (((second - first) * (int32_t)mix.second) / (int32_t)CASCADE_GROWTH_ONE);
}

static uint64_t flicker_tail(cascade_mix_t mix)
{
    const uint32_t share = mix.is_steep ? (CASCADE_GROWTH_ONE - mix.second) : mix.second;
    return (FLICKER_TAIL * share * share) >> (2U * CASCADE_GROWTH_BITS);
}

/* The growth at size t, from the sizes beside it, and 1.2 times as large: an estimate that scatters
 * should rather leave too few degrees of freedom (11.6). `last`: the largest size with data. */
static uint32_t growth_at(const davar_cascade_result_t *result, uint32_t last, uint32_t t)
{
    const uint32_t above = (t < last) ? (t + 1U) : last;
    const uint32_t high = (above < 2U) ? 2U : above;
    if (high > last) {
        return 2U * CASCADE_GROWTH_ONE;
    }
    const double long_adev = result->tau[high].adev;
    const double short_adev = result->tau[high - 2U].adev;
    if (!(short_adev > 0.0) || !(long_adev > 0.0)) {
        return 2U * CASCADE_GROWTH_ONE;
    }
    const double ratio = davar_divide(long_adev, short_adev);
    const uint32_t growth =
        davar_scaled_to_fixed(scaled_of_double(ratio), (int32_t)CASCADE_GROWTH_BITS);
    return (growth < (2U * CASCADE_GROWTH_ONE)) ? ((growth * 6U) / 5U) : growth;
}

/* --- degrees of freedom and interval ---------------------------------------------------------- */

double davar_cascade_edf(uint32_t growth, uint32_t n, uint32_t lags)
{
    const cascade_mix_t mix = mix_of(growth);
    const uint32_t end = (n < (2U * lags)) ? n : (2U * lags);
    uint32_t squares = 0U;
    uint32_t moments = 0U; /* each square times its lag; below 2^30 */
    for (uint32_t i = 1U; i < end; i++) {
        const int32_t r = correlation_of_mix(mix, i * (CASCADE_LAGS / lags));
        const uint32_t square = (uint32_t)(r * r) >> ((2U * CORRELATION_BITS) - SQUARE_BITS);
        squares += square;
        moments += i * square;
    }
    const uint64_t pairs = davar_multiply_u32(n, squares) - moments;
    const uint64_t distant = davar_scale_u64(flicker_tail(mix) * lags, n - end);
    const uint64_t all = ((uint64_t)n << SQUARE_BITS) + (2U * pairs) + distant;
    return davar_divide(davar_double_of_u64(davar_multiply_u32(n, n) << SQUARE_BITS),
                        davar_double_of_u64(all));
}

static void give_hop_interval(davar_cascade_result_t *result, uint32_t last, uint32_t t)
{
    davar_cascade_tau_t *const tau = &result->tau[t];
    double low;
    double high;
    tau->edf = davar_cascade_edf(growth_at(result, last, t), tau->differences, tau->m / tau->hop);
    davar_chi_square_interval(tau->edf, &low, &high);
    const bool is_zero = !(tau->adev > 0.0);
    tau->low = is_zero ? 0.0 : davar_scale(tau->adev, davar_root(low));
    tau->high = is_zero ? (double)INFINITY : davar_scale(tau->adev, davar_root(high));
}

/* --- a result --------------------------------------------------------------------------------- */

/* The sum of both generations; the number of differences in *count. Hazard: a push may come
 * between. */
static davar_u128_t read_generations(const davar_cascade_t *cascade, uint32_t t, uint32_t *count)
{
    const uint32_t first = 2U * (t % CASCADE_TAUS);
    const cascade_stage_t *const stage =
        &((const cascade_stage_t *)cascade->stages)[t / CASCADE_TAUS];
    davar_u128_t sum[2];
    uint32_t before;
    do {
        before = davar_sequence_read(&cascade->sequence);
        davar_u128_copy(&sum[0], &stage->squares[first]);
        davar_u128_copy(&sum[1], &stage->squares[first + 1U]);
        *count = (uint32_t)stage->count[first] + stage->count[first + 1U];
    } while (davar_sequence_torn(&cascade->sequence, before));
    return davar_u128_add(sum[0], sum[1]);
}

static uint64_t read_hops(const davar_cascade_t *cascade)
{
    uint64_t hops;
    uint32_t before;
    do {
        before = davar_sequence_read(&cascade->sequence);
        hops = cascade->hops;
    } while (davar_sequence_torn(&cascade->sequence, before));
    return davar_scale_u64(hops, cascade->config->shortest / CASCADE_OVERLAP);
}

/* (11.1) */
static double deviation_of_hops(const davar_u128_t *sum, const davar_cascade_tau_t *tau)
{
    const double m = davar_double_of_u64(tau->m);
    const double divisor =
        davar_scale(davar_scale(m, m), davar_double_of_u64(2U * (uint64_t)tau->differences));
    return davar_root_of_quotient(davar_double_of_u128(*sum), divisor);
}

static double cascade_unit(const davar_cascade_t *cascade)
{
    const bool is_float = (cascade->counts_per_unit > 0.0F);
    return is_float ? davar_inverse_of_power(cascade->counts_per_unit)
                    : cascade->config->unit_per_count;
}

static void take_cascade_tau(const davar_cascade_t *cascade, uint32_t t, davar_cascade_tau_t *tau)
{
    const uint32_t turn = t % CASCADE_TAUS;
    const davar_u128_t sum = read_generations(cascade, t, &tau->differences);
    tau->m = cascade->config->shortest << t;
    tau->hop = tau->m / (CASCADE_OVERLAP << turn);
    tau->tau_s = davar_divide(davar_double_of_u64(tau->m), cascade->config->rate_hz);
    tau->clusters = 0U;
    tau->adev = (double)NAN;
    tau->low = (double)NAN;
    tau->high = (double)NAN;
    tau->edf = (double)NAN;
    if (tau->differences > 0U) {
        tau->clusters = 2U + ((tau->differences - 1U) / (CASCADE_OVERLAP << turn));
        tau->adev = davar_scale(deviation_of_hops(&sum, tau), cascade_unit(cascade));
    }
}

bool davar_cascade_take(const davar_cascade_t *cascade, davar_cascade_result_t *result)
{
    bool any = false;
    uint32_t last = 0U;
    result->samples = read_hops(cascade);
    result->tau_count = cascade->config->tau_count;
    for (uint32_t t = 0U; t < result->tau_count; t++) {
        take_cascade_tau(cascade, t, &result->tau[t]);
        if (result->tau[t].differences > 0U) {
            any = true;
            last = t;
        }
    }
    for (uint32_t t = 0U; t <= last; t++) {
        if (result->tau[t].differences > 0U) {
            give_hop_interval(result, last, t);
        }
    }
    return any;
}
