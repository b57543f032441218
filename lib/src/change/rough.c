/* davar - kurtosis and sliding contribution against their bounds, from mantissas of 32 bits. A mantissa is short of the true one
 * by less than 8 of its last bits: by one where it was cut, by one more than its factors together where it is a product. */
#include "change/rough.h"

#include "number/ieee.h"

#define LAST_BITS_UNSURE 64U /* last bits: the errors of two, one of them times a bound below 4 */

/* mantissa * 2^exponent, its top bit set, or 0. */
typedef struct {
    uint32_t mantissa;
    int32_t exponent;
} rough_t;

static inline rough_t rough_of(const davar_magnitude_t *value)
{
    const rough_t rough = {(uint32_t)(value->mantissa >> 32U), value->exponent + 32};
    return rough;
}

/* Of a bound, which is not negative; what is subnormal passes for 0. */
static inline rough_t rough_of_bound(double bound)
{
    const uint64_t bits = davar_bits_of_double(bound);
    const uint32_t exponent = (uint32_t)(bits >> 52U) & 0x7FFU;
    const uint32_t fraction = (uint32_t)(bits >> 21U) & 0x7FFFFFFFU;
    const rough_t rough = {(exponent == 0U) ? 0U : ((UINT32_C(1) << 31U) | fraction), (int32_t)exponent - 1054};
    return rough;
}

static inline rough_t rough_product(rough_t a, rough_t b)
{
    const uint64_t product = davar_multiply_u32(a.mantissa, b.mantissa);
    rough_t rough = {(uint32_t)(product >> 32U), a.exponent + b.exponent + 32};
    if ((rough.mantissa >> 31U) == 0U) {
        rough.mantissa = (uint32_t)(product >> 31U);
        rough.exponent--;
    }
    return rough;
}

/* The sign of a - b, 0 when they are too close to tell. */
static inline int order(uint32_t a, uint32_t b)
{
    if (a > b) {
        return ((a - b) > LAST_BITS_UNSURE) ? 1 : 0;
    }
    return ((b - a) > LAST_BITS_UNSURE) ? -1 : 0;
}

/* over - bound under, its sign. */
static int order_of_ratio(rough_t over, rough_t under, double limit)
{
    const rough_t bound = rough_of_bound(limit);
    if (bound.mantissa == 0U) {
        return 1;
    }
    const rough_t product = rough_product(under, bound);
    const int32_t ahead = over.exponent - product.exponent;
    if ((ahead > 1) || (ahead < -1)) {
        return (ahead > 0) ? 1 : -1;
    }
    return order(over.mantissa >> ((ahead < 0) ? 1U : 0U), product.mantissa >> ((ahead > 0) ? 1U : 0U));
}

/* distance - bound x, its sign; the distance is in units of four of x's last bits. */
static int order_of_distance(uint32_t distance, uint32_t x, double limit)
{
    const rough_t bound = rough_of_bound(limit);
    const uint32_t shift = (uint32_t)(-30 - bound.exponent);
    if (bound.mantissa == 0U) {
        return order(distance, 0U);
    }
    const uint32_t part = (uint32_t)(davar_multiply_u32(x, bound.mantissa) >> 32U);
    return (shift > 31U) ? 0 : order(distance, part >> shift);
}

/* From the signs against the lower and the upper bound. */
static davar_rough_t placed(int low, int high)
{
    if ((low < 0) || (high > 0)) {
        return ROUGH_OUTSIDE;
    }
    return ((low > 0) && (high < 0)) ? ROUGH_INSIDE : ROUGH_UNSURE;
}

davar_rough_t davar_rough_kurtosis(const davar_config_t *config, const davar_central_t *whole)
{
    const rough_t over = rough_of(&whole->fourth);
    const rough_t second = rough_of(&whole->second);
    const rough_t under = rough_product(second, second);
    return placed(order_of_ratio(over, under, config->kurtosis_low),
                  order_of_ratio(over, under, config->kurtosis_high));
}

davar_rough_t davar_rough_contribution(const davar_config_t *config, const davar_central_t *whole,
                                       const davar_central_t *first)
{
    const rough_t second = rough_of(&whole->second);
    const rough_t first_second = rough_of(&first->second);
    const rough_t x = rough_product(rough_product(first_second, first_second), rough_of(&whole->fourth));
    const rough_t y = rough_product(rough_product(second, second), rough_of(&first->fourth));
    const int32_t ahead = y.exponent - x.exponent;
    if ((ahead > 1) || (ahead < -1)) {
        return ROUGH_UNSURE;
    }
    const uint32_t from = x.mantissa >> 2U;
    const uint32_t to = y.mantissa >> (uint32_t)(2 - ahead);
    const uint32_t distance = (from > to) ? (from - to) : (to - from);
    return placed(order_of_distance(distance, x.mantissa, config->contribution_low),
                  order_of_distance(distance, x.mantissa, config->contribution_high));
}
