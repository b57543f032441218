/* davar - the cascade: sums out, as cluster sizes of a result (11.1), and how strong the noise was
 * that each remembers (11.9). */
#include "compact.h"
#include "davar/cascade.h"
#include "number/absent.h"
#include "number/real.h"
#include "number/sequence.h"
#include "stage.h"

#include <math.h>

#define UNEVEN_BITS 8U
_Static_assert(DAVAR_EVEN == (1U << UNEVEN_BITS), "the unit of davar_adev_t.uneven");

/* A stage as it is at one sample: the sums of its sizes, and what its power needs. */
typedef struct {
    davar_u128_t squares[2U * CASCADE_TAUS];
    uint16_t count[2U * CASCADE_TAUS];
    compact_t power[2U * CASCADE_TAUS];
    compact_t power_squares[2U * CASCADE_TAUS];
    compact_t cluster;
    uint32_t turn; /* of the turns that end a cluster, or SERVE */
    uint32_t earlier;
    uint32_t earlier_before; /* of the stage before */
    davar_u128_t unseen;     /* first stage: of the present cluster */
    uint32_t unseen_count;
} copy_t;

DAVAR_RARE static void copy_stage(const davar_cascade_t *cascade, uint32_t k, copy_t *copy)
{
    const cascade_stage_t *const stage = &((const cascade_stage_t *)cascade->stages)[k];
    copy->earlier = cascade_earlier(cascade, k);
    copy->earlier_before = (k > 0U) ? cascade_earlier(cascade, k - 1U) : 0U;
    copy->cluster = stage->cluster;
    copy->turn = cascade_waits(cascade, k) ? stage->turn : (uint32_t)CASCADE_SERVE;
    for (uint32_t i = 0U; i < (2U * CASCADE_TAUS); i++) {
        davar_u128_copy(&copy->squares[i], &stage->squares[i]);
        copy->count[i] = stage->count[i];
        copy->power[i] = stage->power[i];
        copy->power_squares[i] = stage->power_squares[i];
    }
    if (k == 0U) {
        const uint32_t slot = cascade_slot(cascade, 0U, copy->earlier);
        copy->unseen = cascade_unseen(cascade, &copy->squares[slot]);
        copy->unseen_count = copy->count[slot] - cascade->seen_count;
    }
}

/* Hazard: a push may come between. */
DAVAR_RARE static void read_stage(const davar_cascade_t *cascade, uint32_t k, copy_t *copy)
{
    uint32_t before;
    do {
        before = davar_sequence_read(&cascade->sequence);
        copy_stage(cascade, k, copy);
    } while (davar_sequence_torn(&cascade->sequence, before));
}

/* (1.1) with the differences of (11.1) */
static double deviation_of_hops(const davar_u128_t *sum, const davar_adev_t *tau)
{
    const double m = davar_double_of_u64(tau->m);
    const double divisor =
        davar_scale(davar_scale(m, m), davar_double_of_u64(2U * (uint64_t)tau->differences));
    return davar_root_of_quotient(davar_double_of_u128(*sum), divisor);
}

/* --- the power of the noise (11.9) --- */

/* Power over a time in hops of the first stage. */
typedef struct {
    scaled_t sum;
    uint64_t hops;
} part_t;

/* The present cluster of a stage so far: the part in the stages before, and all of it. */
typedef struct {
    part_t before;
    part_t all;
} present_t;

/* Whole clusters, in hops of the first stage, that the cluster of stage k has received. */
static uint64_t received_hops(const copy_t *copy, uint32_t k)
{
    if (k == 0U) { /* between the turns END and PASS */
        return (copy->cluster != 0U) ? CASCADE_CLUSTER : 0U;
    }
    const uint32_t all = copy->earlier_before / CASCADE_CLUSTER;
    const uint32_t earlier = CASCADE_RATIO * (copy->earlier / CASCADE_CLUSTER);
    const uint64_t clusters = (all - earlier) % (2U * CASCADE_RATIO); /* modulo 2^29 and 2^31 */
    return (clusters * CASCADE_CLUSTER) << (CASCADE_TAUS * (k - 1U));
}

/* From the stage before. If a cluster of that ended since it was read, it counts twice, in the sum
 * and in the time. */
DAVAR_RARE static void next_present(const copy_t *copy, uint32_t k, present_t *present)
{
    if (k == 0U) {
        const scaled_t sum = scaled_of_u128(&copy->unseen);
        present->before = (part_t){{sum.mantissa, sum.exponent - 3}, copy->unseen_count};
    } else {
        present->before = present->all;
    }
    present->all.sum = davar_scaled_plus(present->before.sum, scaled_of_compact(copy->cluster));
    present->all.hops = present->before.hops + received_hops(copy, k);
}

/* 1 / (1 + 2 / edf) of the power of a cluster of stage k in white noise: its edf is 0.9 + 2.78 4^k
 * (11.6). */
DAVAR_RARE static scaled_t steady(uint32_t k)
{
    const uint64_t edf = 90U + (UINT64_C(278) << (CASCADE_TAUS * k));
    return scaled_quotient(scaled_of_u64(edf, 0), scaled_of_u64(edf + 200U, 0));
}

/* Writes the mean power of what a size remembers, 0 if it is unknown, and how unevenly it is
 * spread. */
DAVAR_RARE static void take_power(const davar_cascade_t *cascade, const copy_t *copy,
                                  const present_t *present, uint32_t t, davar_adev_t *tau)
{
    const uint32_t k = t / CASCADE_TAUS;
    const uint32_t size = t % CASCADE_TAUS;
    const uint32_t older = cascade_slot(cascade, size, copy->earlier) ^ 1U;
    const uint32_t generation = (CASCADE_OVERLAP << size) << cascade->shift;
    const bool counted = (copy->turn > ((uint32_t)CASCADE_COUNT + size)) &&
                         (copy->turn < (uint32_t)CASCADE_SERVE); /* the cluster that ends */
    const part_t *const part = counted ? &present->before : &present->all;
    const uint64_t ended =
        ((copy->earlier & (generation - 1U)) / CASCADE_CLUSTER * CASCADE_CLUSTER) +
        (counted ? CASCADE_CLUSTER : 0U) +
        (((copy->count[older] | copy->power[older]) != 0U) ? generation : 0U);
    const uint64_t hops = (ended << (CASCADE_TAUS * k)) + part->hops;
    scaled_t sum = part->sum;
    scaled_t squares = scaled_times(sum, sum);
    for (uint32_t i = 2U * size; i < ((2U * size) + 2U); i++) {
        sum = davar_scaled_plus(sum, scaled_of_compact(copy->power[i]));
        squares = davar_scaled_plus(squares, scaled_of_compact(copy->power_squares[i]));
    }
    tau->power = 0.0F;
    tau->uneven = DAVAR_EVEN;
    if ((tau->differences > 0U) && (sum.mantissa > 0U)) { /* what has a power has hops */
        const scaled_t mean = scaled_quotient(sum, scaled_of_u64(hops, -3));
        const scaled_t spread =
            scaled_times(scaled_quotient(scaled_quotient(squares, sum), mean), steady(k));
        const uint32_t fixed =
            davar_scaled_to_fixed(spread, (int32_t)UNEVEN_BITS - (int32_t)(CASCADE_TAUS * k));
        const uint32_t uneven = (fixed < UINT16_MAX) ? fixed : UINT16_MAX;
        tau->power = scaled_to_float(mean);
        tau->uneven = (uint16_t)((uneven > DAVAR_EVEN) ? uneven : DAVAR_EVEN);
    }
}

/* Powers become ratios to the longest size, which is a mean over the longest time. Sizes of a
 * window, and sizes whose power is unknown, have the ratio 1. */
DAVAR_RARE static void relate_powers(davar_result_t *result, uint32_t first)
{
    float longest = 0.0F;
    for (uint32_t t = first; t < result->tau_count; t++) {
        longest = (result->tau[t].power > 0.0F) ? result->tau[t].power : longest;
    }
    for (uint32_t t = 0U; t < first; t++) {
        result->tau[t].power = 1.0F;
        result->tau[t].uneven = DAVAR_EVEN;
    }
    for (uint32_t t = first; t < result->tau_count; t++) {
        davar_adev_t *const tau = &result->tau[t];
        tau->power = (tau->power > 0.0F)
                         ? scaled_to_float(scaled_quotient(scaled_of_float(tau->power),
                                                           scaled_of_float(longest)))
                         : 1.0F;
    }
}

DAVAR_RARE static void take_cascade_tau(const davar_cascade_t *cascade, const copy_t *copy,
                                        uint32_t t, double unit, davar_adev_t *tau)
{
    const uint32_t first = 2U * (t % CASCADE_TAUS);
    const davar_u128_t squares = davar_u128_add(copy->squares[first], copy->squares[first + 1U]);
    tau->m = cascade->config->shortest << t;
    tau->hops = (uint8_t)(CASCADE_OVERLAP << (t % CASCADE_TAUS));
    tau->differences = (uint32_t)copy->count[first] + copy->count[first + 1U];
    tau->adev =
        (tau->differences > 0U) ? davar_scale(deviation_of_hops(&squares, tau), unit) : (double)NAN;
}

DAVAR_RARE bool davar_cascade_append(const davar_cascade_t *cascade, davar_result_t *result)
{
    const davar_cascade_config_t *const config = cascade->config;
    const bool is_float = (cascade->counts_per_unit > 0.0F);
    const double unit =
        is_float ? davar_inverse_of_power(cascade->counts_per_unit) : config->unit_per_count;
    const uint32_t first = result->tau_count;
    present_t present = {{{0U, SCALED_ZERO}, 0U}, {{0U, SCALED_ZERO}, 0U}};
    bool any = false;
    DAVAR_ASSERT((first + config->tau_count) <= (uint32_t)DAVAR_TAUS_MAX);
    DAVAR_ASSERT((first == 0U) || (result->tau[first - 1U].m < config->shortest));
    result->unit_per_count = is_float ? 0.0 : unit;
    result->tau_count = (uint8_t)(first + config->tau_count);
    for (uint32_t t = 0U; t < config->tau_count; t += CASCADE_TAUS) {
        copy_t copy;
        read_stage(cascade, t / CASCADE_TAUS, &copy);
        next_present(&copy, t / CASCADE_TAUS, &present);
        const uint32_t end = t + CASCADE_TAUS;
        for (uint32_t u = t; (u < end) && (u < config->tau_count); u++) {
            davar_adev_t *const tau = &result->tau[first + u];
            take_cascade_tau(cascade, &copy, u, unit, tau);
            take_power(cascade, &copy, &present, u, tau);
            any = any || (tau->differences > 0U);
        }
    }
    relate_powers(result, first);
    davar_absent_taus(result, first);
    return any;
}
