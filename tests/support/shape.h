/* davar tests - a filter as a data sheet describes it: what the tests simulate and integrate, and
 * what the library is given. */
#ifndef DAVAR_TESTS_SHAPE_H
#define DAVAR_TESTS_SHAPE_H

#include "davar/filter.h"
#include "davar/fit.h"

#include <stdint.h>

/* An analogue low-pass, then moving averages, then every n-th sample. All zeros: no filter. */
typedef struct {
    double cutoff; /* over the rate of the samples that davar gets */
    double uncertainty;
    uint8_t poles;
    uint8_t averages;
    uint16_t length;     /* samples in each average, before the decimation */
    uint16_t decimation; /* 0, 1, or the length */
    uint16_t summed;     /* the length: the averages are sums of counts */
} shape_t;

#define SHAPE_LOW_PASS(hz, rate_hz, order)                                                         \
    .cutoff = (double)(hz) / (double)(rate_hz), .uncertainty = 0.1, .poles = (order)
#define SHAPE_SUM(n) .averages = 1U, .length = (n), .decimation = (n), .summed = (n)

static inline double shape_decimation(const shape_t *shape)
{
    return (shape->decimation > 1U) ? (double)shape->decimation : 1.0;
}

static inline davar_filter_t filter_of(const shape_t *shape)
{
    davar_filter_t filter = {.b = {0.0}};
    if (shape->poles > 0U) {
        davar_filter_low_pass(&filter, shape->cutoff / shape_decimation(shape), shape->poles,
                              shape->uncertainty);
    }
    if (shape->summed > 1U) {
        davar_filter_sum(&filter, shape->summed);
    } else if (shape->decimation > 1U) {
        davar_filter_cic(&filter, shape->averages, shape->length);
    } else if (shape->averages > 0U) {
        davar_filter_average(&filter, shape->averages, shape->length);
    }
    return filter;
}

static inline void plan_shape(davar_plan_t *to, const uint32_t *m, uint8_t count,
                              const shape_t *shape)
{
    const davar_filter_t filter = filter_of(shape);
    davar_plan_init_filtered(to, m, count, &filter);
}

static inline void whiten_shape(davar_config_t *to, const shape_t *shape)
{
    const davar_filter_t filter = filter_of(shape);
    davar_whiten(to, &filter);
}

static inline void bound_shape(davar_config_t *to, double rate, const shape_t *shape)
{
    const davar_filter_t filter = filter_of(shape);
    davar_bound_unstable_rate(to, rate, &filter);
}

#endif
