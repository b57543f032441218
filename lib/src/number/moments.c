/* davar - kurtosis and contribution against their bounds, without floating point ([SONG18]).
 * K = m4 / s^4 is compared with its bounds by cross-multiplying n^4 m4 and n^2 s^2, which are exact
 * integers cut to 64-bit mantissas. */
#include "number/moments.h"

#include "number/real.h"

/* Shifts the top bit into place. */
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

void davar_magnitude_u64(davar_magnitude_t *result, uint64_t value)
{
    *result = magnitude(value, 0);
}

void davar_magnitude(davar_magnitude_t *result, uint64_t low, uint64_t high, int32_t exponent)
{
    const bool wide = (high != 0U);
    const davar_magnitude_t top = magnitude(wide ? high : low, wide ? (exponent + 64) : exponent);
    const uint32_t zeros = (uint32_t)(exponent + 64 - top.exponent);
    result->mantissa = top.mantissa | ((wide && (zeros > 0U)) ? (low >> (64U - zeros)) : 0U);
    result->exponent = top.exponent;
}

/* A finite, non-negative double (-0.0 too) taken apart: exact, and free of floating-point
 * instructions. */
static davar_magnitude_t magnitude_of_double(const double *value)
{
    const uint64_t bits = davar_bits_of_double(*value) << 1U; /* without the sign */
    const int32_t exponent = (int32_t)(uint32_t)(bits >> 53U);
    if (exponent == 0) {
        return magnitude(bits, -1075);
    }
    const davar_magnitude_t normal = {(UINT64_C(1) << 63U) | (bits << 10U), exponent - 1086};
    return normal;
}

/* The product may be one of its factors. */
static void multiply(davar_magnitude_t *product, const davar_magnitude_t *a,
                     const davar_magnitude_t *b)
{
    const uint64_t high = davar_multiply_u64(a->mantissa, b->mantissa).high;
    const uint32_t shift =
        ((high >> 63U) == 0U) ? 1U : 0U; /* the product is at least 2^126, or 0 */
    product->exponent = a->exponent + b->exponent + 64 - (int32_t)shift;
    product->mantissa = high << shift;
}

/* a > b, neither of them 0. */
static bool greater(const davar_magnitude_t *a, const davar_magnitude_t *b)
{
    return (a->exponent == b->exponent) ? (a->mantissa > b->mantissa) : (a->exponent > b->exponent);
}

/* |a - b|, neither of them 0 and their ratio below 2^63, as for two kurtoses. The smaller one loses
 * the bits below the larger one's mantissa. */
static davar_magnitude_t distance(const davar_magnitude_t *a, const davar_magnitude_t *b)
{
    const davar_magnitude_t *const large = greater(a, b) ? a : b;
    const davar_magnitude_t *const small = (large == a) ? b : a;
    const uint32_t shift = (uint32_t)(large->exponent - small->exponent);
    return magnitude(large->mantissa - (small->mantissa >> shift), large->exponent);
}

/* over / under; undefined if under is 0. */
typedef struct {
    davar_magnitude_t over;
    davar_magnitude_t under;
} ratio_t;

/* K = m4 / s^4 (3.1) */
static void kurtosis_of(ratio_t *ratio, const davar_central_t *whole)
{
    ratio->over.mantissa =
        whole->fourth.mantissa; /* a struct copy is a library call on a small core */
    ratio->over.exponent = whole->fourth.exponent;
    multiply(&ratio->under, &whole->second, &whole->second);
}

/* S = |K - Km| / K = |x - y| / x with x = m4 s'^4 and y = m4' s^4; powers of n cancel (3.2). */
static void contribution_of(ratio_t *ratio, const davar_central_t *whole,
                            const davar_central_t *first)
{
    davar_magnitude_t y;
    multiply(&y, &whole->second, &whole->second);
    multiply(&y, &y, &first->fourth);
    multiply(&ratio->under, &first->second, &first->second);
    multiply(&ratio->under, &ratio->under, &whole->fourth);
    ratio->over = distance(&ratio->under, &y);
}

/* The sign of over - limit * under. */
static int against(const ratio_t *ratio, const double *limit)
{
    const davar_magnitude_t bound = magnitude_of_double(limit);
    if ((ratio->over.mantissa == 0U) || (bound.mantissa == 0U)) {
        return ((ratio->over.mantissa != 0U) ? 1 : 0) - ((bound.mantissa != 0U) ? 1 : 0);
    }
    davar_magnitude_t product;
    multiply(&product, &bound, &ratio->under);
    return (greater(&ratio->over, &product) ? 1 : 0) - (greater(&product, &ratio->over) ? 1 : 0);
}

static bool is_outside(const ratio_t *ratio, const double *low, const double *high)
{
    return (against(ratio, high) > 0) || (against(ratio, low) < 0);
}

static bool kurtosis_outside(const davar_config_t *config, const davar_central_t *whole)
{
    ratio_t kurtosis;
    kurtosis_of(&kurtosis, whole);
    return is_outside(&kurtosis, &config->moments.kurtosis_low, &config->moments.kurtosis_high);
}

static bool contribution_outside(const davar_config_t *config, const davar_central_t *whole,
                                 const davar_central_t *first)
{
    ratio_t contribution;
    contribution_of(&contribution, whole, first);
    return is_outside(&contribution, &config->moments.contribution_low,
                      &config->moments.contribution_high);
}

bool davar_moments_unstable(const davar_config_t *config, davar_rule_t rule,
                            const davar_central_t *whole, const davar_central_t *first)
{
    if (whole->second.mantissa == 0U) {
        return false;
    }
    const bool by_kurtosis = kurtosis_outside(config, whole);
    const bool is_enough = (rule == RULE_AND) ? !by_kurtosis : by_kurtosis;
    if (is_enough || (rule == RULE_KURTOSIS)) {
        return by_kurtosis;
    }
    return (first->second.mantissa != 0U) && contribution_outside(config, whole, first);
}

/* The mantissa as a double in [1, 2), cut to its 53 bits. */
static double fraction(const davar_magnitude_t *magnitude)
{
    return davar_double_of_bits((UINT64_C(1023) << 52U) | ((magnitude->mantissa << 1U) >> 12U));
}

/* The ratio is 0 or well inside the range of a double, as for kurtosis and contribution. */
static double quotient(const ratio_t *ratio)
{
    if (ratio->over.mantissa == 0U) {
        return 0.0;
    }
    const uint64_t power = (uint64_t)((int64_t)ratio->over.exponent - ratio->under.exponent) << 52U;
    return davar_double_of_bits(
        davar_bits_of_double(davar_divide(fraction(&ratio->over), fraction(&ratio->under))) +
        power);
}

double davar_kurtosis(const davar_central_t *whole)
{
    if (whole->second.mantissa == 0U) {
        return (double)NAN;
    }
    ratio_t ratio;
    kurtosis_of(&ratio, whole);
    return quotient(&ratio);
}

double davar_contribution(const davar_central_t *whole, const davar_central_t *first)
{
    if ((whole->second.mantissa == 0U) || (first->second.mantissa == 0U)) {
        return (double)NAN;
    }
    ratio_t ratio;
    contribution_of(&ratio, whole, first);
    return quotient(&ratio);
}
