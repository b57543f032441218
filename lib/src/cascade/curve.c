/* davar - the cascade: sums out, as cluster sizes of a result (11.1). */
#include "cascade/stage.h"
#include "davar/cascade.h"
#include "number/absent.h"
#include "number/ieee.h"
#include "number/real.h"
#include "number/sequence.h"

#include <math.h>

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

/* (1.1) with the differences of (11.1) */
static double deviation_of_hops(const davar_u128_t *sum, const davar_adev_t *tau)
{
    const double m = davar_double_of_u64(tau->m);
    const double divisor =
        davar_scale(davar_scale(m, m), davar_double_of_u64(2U * (uint64_t)tau->differences));
    return davar_root_of_quotient(davar_double_of_u128(*sum), divisor);
}

static void take_cascade_tau(const davar_cascade_t *cascade, uint32_t t, double unit,
                             davar_adev_t *tau)
{
    const davar_u128_t sum = read_generations(cascade, t, &tau->differences);
    tau->m = cascade->config->shortest << t;
    tau->hop = tau->m / (CASCADE_OVERLAP << (t % CASCADE_TAUS));
    tau->adev =
        (tau->differences > 0U) ? davar_scale(deviation_of_hops(&sum, tau), unit) : (double)NAN;
}

bool davar_cascade_append(const davar_cascade_t *cascade, davar_result_t *result)
{
    const davar_cascade_config_t *const config = cascade->config;
    const bool is_float = (cascade->counts_per_unit > 0.0F);
    const double unit =
        is_float ? davar_inverse_of_power(cascade->counts_per_unit) : config->unit_per_count;
    const uint32_t first = result->tau_count;
    bool any = false;
    DAVAR_ASSERT((first + config->tau_count) <= (uint32_t)DAVAR_TAUS_MAX);
    DAVAR_ASSERT((first == 0U) || (result->tau[first - 1U].m < config->shortest));
    result->unit_per_count = is_float ? 0.0 : unit;
    for (uint32_t t = 0U; t < config->tau_count; t++) {
        davar_adev_t *const tau = &result->tau[first + t];
        take_cascade_tau(cascade, t, unit, tau);
        any = any || (tau->differences > 0U);
        result->tau_count++;
    }
    davar_absent_taus(result, first);
    return any;
}
