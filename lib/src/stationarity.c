/* davar - stationarity decisions without floating point: K = m4 / s^4 is compared with its bounds by cross-multiplying
 * the exact integers n^4 m4 and n^2 s^2, cut to 64-bit mantissas. */
#include "stationarity.h"

#include <math.h>

/* Brings the top bit up; of 128 bits the top 64 are kept. */
static davar_magnitude_t magnitude(uint64_t mantissa, int32_t exponent)
{
    davar_magnitude_t result = {mantissa, 0};
    if (mantissa != 0U) {
        const uint32_t zeros = davar_leading_zeros(mantissa);
        result.mantissa = mantissa << zeros;
        result.exponent = exponent - (int32_t)zeros;
    }
    return result;
}

void davar_magnitude(davar_magnitude_t *result, const davar_u128_t *value, int32_t exponent)
{
    const bool wide = (value->high != 0U);
    const davar_magnitude_t top = magnitude(wide ? value->high : value->low, wide ? (exponent + 64) : exponent);
    const uint32_t zeros = (uint32_t)(exponent + 64 - top.exponent);
    result->mantissa = top.mantissa | ((wide && (zeros > 0U)) ? (value->low >> (64U - zeros)) : 0U);
    result->exponent = top.exponent;
}

/* A finite, non-negative double taken apart: exact, and free of floating-point instructions. */
static davar_magnitude_t magnitude_of_double(const double *value)
{
    const union {
        double value;
        uint64_t bits;
    } number = {*value};
    const uint64_t bits = number.bits;
    const uint64_t fraction = bits & ((UINT64_C(1) << 52U) - 1U);
    const int32_t exponent = (int32_t)((bits >> 52U) & 0x7FFU);
    if (exponent == 0) {
        return magnitude(fraction, -1074);
    }
    return magnitude(fraction | (UINT64_C(1) << 52U), exponent - 1075);
}

static davar_magnitude_t product(davar_magnitude_t a, davar_magnitude_t b)
{
    davar_magnitude_t result = {davar_multiply_u64(a.mantissa, b.mantissa).high, a.exponent + b.exponent + 64};
    if ((result.mantissa >> 63U) == 0U) { /* two top bits multiply to at least 2^126: one shift is enough, or it is 0 */
        result.mantissa <<= 1U;
        result.exponent--;
    }
    return result;
}

static bool greater(davar_magnitude_t a, davar_magnitude_t b)
{
    if ((a.mantissa == 0U) || (b.mantissa == 0U)) {
        return a.mantissa > b.mantissa;
    }
    if (a.exponent != b.exponent) {
        return a.exponent > b.exponent;
    }
    return a.mantissa > b.mantissa;
}

/* |a - b| of magnitudes that differ by less than 2^63, as two kurtoses do; the smaller one loses the bits that fall
 * below the larger one's mantissa. */
static davar_magnitude_t distance(davar_magnitude_t a, davar_magnitude_t b)
{
    const davar_magnitude_t large = greater(a, b) ? a : b;
    const davar_magnitude_t small = greater(a, b) ? b : a;
    const uint32_t shift = (uint32_t)(large.exponent - small.exponent);
    return magnitude(large.mantissa - (small.mantissa >> shift), large.exponent);
}

static bool kurtosis_outside(const davar_config_t *config, const davar_central_t *whole)
{
    const davar_magnitude_t square = product(whole->second, whole->second);
    return greater(whole->fourth, product(magnitude_of_double(&config->kurtosis_high), square)) ||
           greater(product(magnitude_of_double(&config->kurtosis_low), square), whole->fourth);
}

/* S = |K - Km| / K = |x - y| / x with x = m4 s'^4 and y = m4' s^4, all times powers of n that cancel. */
static bool contribution_outside(const davar_config_t *config, const davar_central_t *whole,
                                 const davar_central_t *first)
{
    const davar_magnitude_t x = product(whole->fourth, product(first->second, first->second));
    const davar_magnitude_t y = product(first->fourth, product(whole->second, whole->second));
    const davar_magnitude_t change = distance(x, y);
    return greater(change, product(magnitude_of_double(&config->contribution_high), x)) ||
           greater(product(magnitude_of_double(&config->contribution_low), x), change);
}

bool davar_stationarity_unstable(const davar_config_t *config, const davar_central_t *whole,
                                 const davar_central_t *first)
{
    if (whole->second.mantissa == 0U) {
        return false;
    }
    const bool by_kurtosis = kurtosis_outside(config, whole);
    const bool by_contribution = (first->second.mantissa != 0U) && contribution_outside(config, whole, first);
    switch (config->policy) {
    case DAVAR_POLICY_KURTOSIS:
        return by_kurtosis;
    case DAVAR_POLICY_AND:
        return by_kurtosis && by_contribution;
    case DAVAR_POLICY_FIXED:
    case DAVAR_POLICY_OR:
    default:
        return by_kurtosis || by_contribution;
    }
}

/* 2^exponent for the small exponents that a kurtosis has. */
static double power_of_two(int32_t exponent)
{
    const double power = (double)(UINT64_C(1) << (uint32_t)((exponent < 0) ? -exponent : exponent));
    return (exponent < 0) ? (1.0 / power) : power;
}

double davar_stationarity_kurtosis(const davar_central_t *whole)
{
    if (whole->second.mantissa == 0U) {
        return (double)NAN;
    }
    const double second = (double)whole->second.mantissa;
    const double ratio = ((double)whole->fourth.mantissa / second) / second;
    const int32_t exponent = whole->fourth.exponent - (2 * whole->second.exponent);
    /* The ratio is near 2^-64 and the kurtosis between 1 and n: split the power to stay inside one shift. */
    return (ratio * 18446744073709551616.0) * power_of_two(exponent - 64);
}

double davar_stationarity_contribution(const davar_central_t *whole, const davar_central_t *first)
{
    const double kurtosis = davar_stationarity_kurtosis(whole);
    const double change = kurtosis - davar_stationarity_kurtosis(first);
    return ((change < 0.0) ? -change : change) / kurtosis;
}
