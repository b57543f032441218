/* davar - the stationarity test without floating point, and the window law that uses it ([SONG18]).
 * K = m4 / s^4 is compared with its bounds by cross-multiplying n^4 m4 and n^2 s^2, which are exact
 * integers cut to 64-bit mantissas. */
#include "core/song.h"

#include "core/window.h"
#include "number/ieee.h"
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

DAVAR_APART static bool exact_kurtosis_outside(const davar_config_t *config,
                                               const davar_central_t *whole)
{
    ratio_t kurtosis;
    kurtosis_of(&kurtosis, whole);
    return is_outside(&kurtosis, &config->moments.kurtosis_low, &config->moments.kurtosis_high);
}

DAVAR_APART static bool exact_contribution_outside(const davar_config_t *config,
                                                   const davar_central_t *whole,
                                                   const davar_central_t *first)
{
    ratio_t contribution;
    contribution_of(&contribution, whole, first);
    return is_outside(&contribution, &config->moments.contribution_low,
                      &config->moments.contribution_high);
}

static bool kurtosis_outside(const davar_config_t *config, const davar_central_t *whole)
{
    const davar_rough_t rough = davar_rough_kurtosis(config, whole);
    return (rough == ROUGH_UNSURE) ? exact_kurtosis_outside(config, whole)
                                   : (rough == ROUGH_OUTSIDE);
}

static bool contribution_outside(const davar_config_t *config, const davar_central_t *whole,
                                 const davar_central_t *first)
{
    const davar_rough_t rough = davar_rough_contribution(config, whole, first);
    return (rough == ROUGH_UNSURE) ? exact_contribution_outside(config, whole, first)
                                   : (rough == ROUGH_OUTSIDE);
}

bool davar_song_unstable(const davar_config_t *config, davar_song_rule_t rule,
                         const davar_central_t *whole, const davar_central_t *first)
{
    if (whole->second.mantissa == 0U) {
        return false;
    }
    const bool by_kurtosis = kurtosis_outside(config, whole);
    const bool is_enough = (rule == SONG_AND) ? !by_kurtosis : by_kurtosis;
    if (is_enough || (rule == SONG_KURTOSIS)) {
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

double davar_song_kurtosis(const davar_central_t *whole)
{
    if (whole->second.mantissa == 0U) {
        return (double)NAN;
    }
    ratio_t ratio;
    kurtosis_of(&ratio, whole);
    return quotient(&ratio);
}

double davar_song_contribution(const davar_central_t *whole, const davar_central_t *first)
{
    if ((whole->second.mantissa == 0U) || (first->second.mantissa == 0U)) {
        return (double)NAN;
    }
    ratio_t ratio;
    contribution_of(&ratio, whole, first);
    return quotient(&ratio);
}

/* --- in 32 bits ------------------------------------------------------------------------------- */

/* Kurtosis and sliding contribution against their bounds, from mantissas of 32 bits. A mantissa is
 * less than 8 of its last bits below the true one: 1 if it was cut, and for a product the errors of
 * both factors plus 1. */

#define LAST_BITS_UNSURE 64U /* the errors of two mantissas, one of them times a bound below 4 */

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

/* A bound is not negative. Subnormal bounds count as 0. */
static inline rough_t rough_of_bound(double bound)
{
    const uint64_t bits = davar_bits_of_double(bound);
    const uint32_t exponent = (uint32_t)(bits >> 52U) & 0x7FFU;
    const uint32_t fraction = (uint32_t)(bits >> 21U) & 0x7FFFFFFFU;
    const rough_t rough = {(exponent == 0U) ? 0U : ((UINT32_C(1) << 31U) | fraction),
                           (int32_t)exponent - 1054};
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

/* The sign of a - b, or 0 if they are too close. */
static inline int order(uint32_t a, uint32_t b)
{
    if (a > b) {
        return ((a - b) > LAST_BITS_UNSURE) ? 1 : 0;
    }
    return ((b - a) > LAST_BITS_UNSURE) ? -1 : 0;
}

/* The sign of over - limit * under, or 0. */
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
    return order(over.mantissa >> ((ahead < 0) ? 1U : 0U),
                 product.mantissa >> ((ahead > 0) ? 1U : 0U));
}

/* The sign of distance - limit * x, or 0. The distance is in units of four of x's last bits. */
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
    return placed(order_of_ratio(over, under, config->moments.kurtosis_low),
                  order_of_ratio(over, under, config->moments.kurtosis_high));
}

davar_rough_t davar_rough_contribution(const davar_config_t *config, const davar_central_t *whole,
                                       const davar_central_t *first)
{
    const rough_t second = rough_of(&whole->second);
    const rough_t first_second = rough_of(&first->second);
    const rough_t x =
        rough_product(rough_product(first_second, first_second), rough_of(&whole->fourth));
    const rough_t y = rough_product(rough_product(second, second), rough_of(&first->fourth));
    const int32_t ahead = y.exponent - x.exponent;
    if ((ahead > 1) || (ahead < -1)) {
        return ROUGH_UNSURE;
    }
    const uint32_t from = x.mantissa >> 2U;
    const uint32_t to = y.mantissa >> (uint32_t)(2 - ahead);
    const uint32_t distance = (from > to) ? (from - to) : (to - from);
    return placed(order_of_distance(distance, x.mantissa, config->moments.contribution_low),
                  order_of_distance(distance, x.mantissa, config->moments.contribution_high));
}

/* --- the window law, [SONG18] section 4 (4.1) ------------------------------------------------- */

static uint32_t shorter(const davar_config_t *config, uint32_t length)
{
    const uint32_t step = config->window.shrink * config->stride;
    return (length > (config->window.shortest + step)) ? (length - step) : config->window.shortest;
}

static uint32_t longer(const davar_config_t *config, uint32_t length, bool filling)
{
    /* Trailing: the head moves by one per sample; faster growth would move the tail backwards. */
    const uint32_t most = is_centred(config) ? 2U : 1U;
    const uint32_t grow = (filling || (config->window.grow > most)) ? most : config->window.grow;
    return smaller(length + (grow * config->stride), config->window.longest);
}

/* On a grid the window moves `stride` times as far in one step. O(1), no division. */
static bool song_judge(davar_t *davar, const davar_central_t *moments, davar_song_rule_t rule)
{
    const davar_config_t *const config = davar->config;
    davar_window_t *const window = &davar->window;
    const bool unstable =
        (moments != NULL) && davar_song_unstable(config, rule, &moments[0], &moments[1]);
    window_keep_filling(window, config, unstable);
    window->next_length = unstable ? shorter(config, window->length)
                                   : longer(config, window->length, is_filling(window));
    return unstable;
}

static bool judge_kurtosis(davar_t *davar, void *state, const davar_central_t *moments)
{
    (void)state;
    return song_judge(davar, moments, SONG_KURTOSIS);
}

static bool judge_or(davar_t *davar, void *state, const davar_central_t *moments)
{
    (void)state;
    return song_judge(davar, moments, SONG_OR);
}

static bool judge_and(davar_t *davar, void *state, const davar_central_t *moments)
{
    (void)state;
    return song_judge(davar, moments, SONG_AND);
}

const davar_law_t davar_law_kurtosis = {.id = 1U, .wants_moments = true, .judge = judge_kurtosis};
const davar_law_t davar_law_or = {.id = 2U, .wants_moments = true, .judge = judge_or};
const davar_law_t davar_law_and = {.id = 3U, .wants_moments = true, .judge = judge_and};
