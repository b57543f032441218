/* davar - the stationarity test without floating point, and the window law that uses it ([SONG18]).
 * K = m4 / s^4 is compared with its bounds by cross-multiplying n^4 m4 and n^2 s^2, which are exact
 * integers cut to 64-bit mantissas. */
#include "core/song.h"

#include "core/instance.h"
#include "core/window.h"
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

/* --- in 32 bits (3.5) ------------------------------------------------------------------------- */

/* A bound in units of 2^-digits, cut; UINT32_MAX if it is too large. */
static uint32_t rough_bound(double bound, uint32_t digits)
{
    const uint64_t bits = davar_bits_of_double(bound);
    const uint32_t mantissa = (UINT32_C(1) << 31U) | (uint32_t)(bits >> 21U);
    const uint32_t shift = (1054U - digits) - ((uint32_t)(bits >> 52U) & 0x7FFU);
    if (shift < 32U) {
        return mantissa >> shift;
    }
    return ((shift >> 31U) != 0U) ? UINT32_MAX : 0U;
}

DAVAR_RARE void davar_song_bounds(davar_song_bounds_t *bounds, const davar_config_t *config)
{
    bounds->kurtosis.low = rough_bound(config->moments.kurtosis_low, 28U);
    bounds->kurtosis.high = rough_bound(config->moments.kurtosis_high, 28U);
    bounds->contribution.low = rough_bound(config->moments.contribution_low, 32U);
    bounds->contribution.high = rough_bound(config->moments.contribution_high, 32U);
}

/* --- the window law, [SONG18] section 4 (4.1) ------------------------------------------------- */

static uint32_t shorter(const davar_config_t *config, uint32_t length)
{
    const uint32_t step = config->window.shrink * config->stride;
    return (length > (config->window.shortest + step)) ? (length - step) : config->window.shortest;
}

static uint32_t longer(const davar_config_t *config, uint32_t length, bool filling)
{
    if (length == config->window.longest) {
        return length;
    }
    /* The head moves by one per sample; faster growth would move the tail backwards. */
    const bool grows = filling || (config->window.grow > 0U);
    return grows ? smaller(length + config->stride, config->window.longest) : length;
}

DAVAR_APART static bool is_unstable_exactly(const davar_t *davar, davar_song_rule_t rule)
{
    davar_central_t moments[2];
    davar->number->central(davar, moments);
    return davar_song_unstable(davar->config, rule, &moments[0], &moments[1]);
}

/* The first part is evaluated only where the kurtosis of the whole window does not decide. */
static DAVAR_MERGED bool is_unstable(const davar_t *davar, const davar_song_bounds_t *bounds,
                                     const davar_rough_t *whole, davar_song_rule_t rule)
{
    const davar_place_t enough = (rule == SONG_AND) ? ROUGH_INSIDE : ROUGH_OUTSIDE;
    davar_place_t place = davar_rough_kurtosis(bounds, whole);
    if ((place != ROUGH_UNSURE) && (place != enough) && (rule != SONG_KURTOSIS)) {
        davar_rough_t first;
        davar->number->first(davar, &first);
        place = davar_rough_contribution(bounds, whole, &first);
    }
    return (place == ROUGH_UNSURE) ? is_unstable_exactly(davar, rule) : (place == ROUGH_OUTSIDE);
}

/* On a grid the window moves `stride` times as far in one step. O(1), no division. */
static DAVAR_MERGED bool song_judge(davar_t *davar, const davar_song_bounds_t *bounds,
                                    const davar_rough_t *whole, davar_song_rule_t rule)
{
    const davar_config_t *const config = davar->config;
    davar_window_t *const window = &davar->window;
    const bool unstable = (whole != NULL) && is_unstable(davar, bounds, whole, rule);
    window_keep_filling(window, config, unstable);
    window->next_length = unstable ? shorter(config, window->length)
                                   : longer(config, window->length, is_filling(window));
    return unstable;
}

_Static_assert(sizeof(davar_song_bounds_t) <= DAVAR_SONG_BYTES, "DAVAR_SONG_BYTES is too small");

static size_t song_bytes(const davar_config_t *config)
{
    (void)config;
    return sizeof(davar_song_bounds_t);
}

static void song_start(davar_t *davar, void *state, davar_law_start_t why)
{
    (void)why;
    davar_song_bounds(state, davar->config);
}

static bool judge_kurtosis(davar_t *davar, void *state, const davar_rough_t *whole)
{
    return song_judge(davar, state, whole, SONG_KURTOSIS);
}

static bool judge_or(davar_t *davar, void *state, const davar_rough_t *whole)
{
    return song_judge(davar, state, whole, SONG_OR);
}

static bool judge_and(davar_t *davar, void *state, const davar_rough_t *whole)
{
    return song_judge(davar, state, whole, SONG_AND);
}

#define SONG_LAW(number, function)                                                                 \
    {                                                                                              \
        .id = (number), .wants_moments = true, .bytes = song_bytes, .start = song_start,           \
        .judge = (function)                                                                        \
    }

const davar_law_t davar_law_kurtosis = SONG_LAW(1U, judge_kurtosis);
const davar_law_t davar_law_or = SONG_LAW(2U, judge_or);
const davar_law_t davar_law_and = SONG_LAW(3U, judge_and);
