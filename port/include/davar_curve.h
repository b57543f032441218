/** @file
 * davar - the cluster sizes of a result, for a program that can have a cascade: those of the
 * window, then those of the cascade.
 *
 * A file that calls davar_curve_start links the cascade. */
#ifndef DAVAR_CURVE_H
#define DAVAR_CURVE_H

#include "davar/cascade.h"
#include "davar/fit.h"
#include "davar_port.h"

#ifdef __cplusplus
extern "C" {
#endif

/** What each size of the cascade remembers (davar_cascade_config_t.clusters). */
#define DAVAR_CURVE_CLUSTERS 32U

/** The cluster sizes of a result. */
typedef struct {
    davar_cascade_config_t cascade; /**< tau_count 0: no cascade */
    uint32_t taus[DAVAR_TAUS_MAX];  /**< of the window, then of the cascade */
    uint8_t tau_count;              /**< number of taus, at most DAVAR_TAUS_MAX */
} davar_curve_t;

/** The first octave after the largest size `last` of the window that a cascade can begin with: a
 * multiple of 4, at least 64. 0: every such octave is above 262140. */
static inline uint32_t davar_curve_shortest(uint32_t last)
{
    uint64_t m = 2U * (uint64_t)last;
    while ((m > 0U) && ((m < 64U) || ((m % 4U) != 0U))) {
        m *= 2U;
    }
    return (m <= 262140U) ? (uint32_t)m : 0U;
}

/** Sets the sizes of the window of `config`, which must not point into the curve, and
 * `cascade_taus` of a cascade that continues them. */
static inline void davar_curve_make(davar_curve_t *curve, const davar_config_t *config,
                                    uint8_t cascade_taus)
{
    *curve = (davar_curve_t){
        .cascade = {.rate_hz = config->rate_hz,
                    .unit_per_count = config->unit_per_count,
                    .full_scale = config->full_scale,
                    .shortest = davar_curve_shortest(config->taus[config->tau_count - 1U]),
                    .tau_count = cascade_taus,
                    .clusters = DAVAR_CURVE_CLUSTERS}};
    for (uint8_t t = 0U; t < config->tau_count; t++) {
        curve->taus[curve->tau_count++] = config->taus[t];
    }
    for (uint8_t t = 0U; (t < cascade_taus) && (curve->tau_count < DAVAR_TAUS_MAX); t++) {
        curve->taus[curve->tau_count++] = curve->cascade.shortest << t;
    }
}

/** Bytes of memory for the cascade of one channel; 0 without a cascade. */
static inline size_t davar_curve_bytes(const davar_curve_t *curve, davar_port_number_t number)
{
    /* floats take as much as int32 */
    return (number == DAVAR_PORT_Q15) ? DAVAR_CASCADE_MEMORY(Q15, curve->cascade.tau_count)
                                      : DAVAR_CASCADE_MEMORY(Q31, curve->cascade.tau_count);
}

/** Starts the cascade of one channel, as davar_cascade_init_*. */
static inline davar_cascade_status_t davar_curve_start(const davar_curve_t *curve,
                                                       davar_port_number_t number,
                                                       davar_cascade_t *cascade, void *memory,
                                                       size_t bytes)
{
    switch (number) {
    case DAVAR_PORT_Q15:
        return davar_cascade_init_q15(cascade, &curve->cascade, memory, bytes);
    case DAVAR_PORT_Q31:
        return davar_cascade_init_q31(cascade, &curve->cascade, memory, bytes);
    case DAVAR_PORT_F32:
    default:
        return davar_cascade_init_f32(cascade, &curve->cascade, memory, bytes);
    }
}

/** Prepares the plan of a fit for these sizes. filter null: nothing is known about a filter. */
static inline void davar_curve_plan(const davar_curve_t *curve, davar_plan_t *plan,
                                    const davar_filter_t *filter)
{
    if (filter == NULL) {
        davar_plan_init(plan, curve->taus, curve->tau_count);
    } else {
        davar_plan_init_filtered(plan, curve->taus, curve->tau_count, filter);
    }
}

/** Pushes `count` samples from samples[from] on to the cascade. */
static inline void davar_curve_push(davar_cascade_t *cascade, davar_port_number_t number,
                                    davar_port_samples_t samples, size_t from, size_t count)
{
    switch (number) {
    case DAVAR_PORT_Q15:
        davar_cascade_push_q15(cascade, samples.q15 + from, count);
        break;
    case DAVAR_PORT_Q31:
        davar_cascade_push_q31(cascade, samples.q31 + from, count);
        break;
    case DAVAR_PORT_F32:
    default:
        davar_cascade_push_f32(cascade, samples.f32 + from, count);
        break;
    }
}

#ifdef __cplusplus
}
#endif

#endif
