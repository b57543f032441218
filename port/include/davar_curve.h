/** @file
 * davar - the cluster sizes of a result, for programs with an option --longest-tau: those of the
 * window, then those of a cascade.
 *
 * A file that calls davar_curve_start links the cascade. */
#ifndef DAVAR_CURVE_H
#define DAVAR_CURVE_H

#include "davar/cascade.h"
#include "davar_port.h"

#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/** What each size of the cascade remembers (davar_cascade_config_t.clusters). */
#define DAVAR_CURVE_CLUSTERS 32U

/** A rate that follows from time stamps differs in its last digits from the nominal one. A size
 * that is longer by this factor is not too long. */
#define DAVAR_CURVE_REACHES (1.0 + 1e-6)

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

/** The largest number of sizes of a cascade in addition to the window's; 0: no cascade fits. */
static inline uint8_t davar_curve_most(const davar_config_t *config, davar_port_number_t number)
{
    uint8_t most = 0U;
    for (uint8_t n = 1U; (config->tau_count + n) <= DAVAR_TAUS_MAX; n++) {
        davar_curve_t curve;
        davar_cascade_t probe;
        uint64_t no_memory[1] = {0U};
        davar_curve_make(&curve, config, n); /* init checks the memory after everything else */
        if (davar_curve_start(&curve, number, &probe, no_memory, 0U) !=
            DAVAR_CASCADE_ERR_MEMORY_SIZE) {
            break;
        }
        most = n;
    }
    return most;
}

/** Sets the sizes of the window and every octave of a cascade up to longest_s seconds.
 * @return False, with the reason for a user in `why`, if the cascade would have no size, or more
 * than it can have. */
static inline bool davar_curve_reach(davar_curve_t *curve, const davar_config_t *config,
                                     davar_port_number_t number, double longest_s, char *why,
                                     size_t size)
{
    davar_curve_make(curve, config, 0U);
    const uint32_t last = config->taus[config->tau_count - 1U];
    const double first_s = (double)curve->cascade.shortest / config->rate_hz;
    const uint8_t most = davar_curve_most(config, number);
    uint8_t count = 0U;
    double next_s = first_s;
    while ((count <= most) && (next_s <= longest_s * DAVAR_CURVE_REACHES)) {
        next_s *= 2.0;
        count++;
    }
    if ((most == 0U) && (config->tau_count == DAVAR_TAUS_MAX)) {
        (void)snprintf(why, size, "at most %d cluster sizes of the window expected, found %u",
                       DAVAR_TAUS_MAX - 1, config->tau_count);
    } else if (most == 0U) {
        (void)snprintf(why, size,
                       "a largest cluster size of the window up to 131070 samples expected, found "
                       "%u",
                       (unsigned)last);
    } else if ((count == 0U) || (count > most)) {
        double beyond_s = first_s;
        for (uint8_t n = 0U; n < most; n++) {
            beyond_s *= 2.0;
        }
        (void)snprintf(why, size,
                       "from %.9g s to less than %.9g s expected at %.9g Hz after a window with "
                       "cluster sizes up to %u samples, found %.9g s",
                       first_s, beyond_s, config->rate_hz, (unsigned)last, longest_s);
    } else {
        davar_curve_make(curve, config, count);
        return true;
    }
    return false;
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
