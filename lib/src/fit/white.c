/* davar - the short cut for windows that show white noise only, as most do. The fit is a few sums
 * with factors that only the window length changes, in integers (5.14). Units: tau in samples; y =
 * avar * m, so that white noise is a constant y = N^2; shares are amplitudes over N^2. */
#include "fit/white.h"

#include "fit/plan.h"
#include "number/absent.h"

_Static_assert(DAVAR_TAUS_MAX <= 32, "sums of products with a functional");

/* Such a sum has 62 bits; its upper 32 bits become a share. */
#define SUM_SPARE 30U

#define FRACTION_32 4294967296.0        /* 1.0 as 0.32 */
#define CENTRE_ONE (UINT32_C(1) << 30U) /* 1.0 as 2.30 */
#define SHARE_ONE (UINT32_C(1) << DAVAR_FIT_SHARE_BITS)

/* Largest Allan variance, 64 times the one of white noise: more is a misfit by itself. */
#define SHARE_MOST (SHARE_ONE << 6U)

/* Bound of a signed share, and the least factor of rounding, 2^-16 as the bits of a float. */
#define SHARE_BOUND (UINT32_C(1) << 30U)
#define FACTOR_LEAST ((127U - 16U) << 23U)

/* Least amplitude of white noise: enough bits for a root and a reciprocal. */
#define AMPLITUDE_LEAST (UINT64_C(1) << 23U)

/* --- the fit --- */

/* Reads the deviations and aligns y, whose mantissas had 29 to 32 bits. False: all are 0. */
static bool read_data(const davar_plan_t *plan, const davar_result_t *result, davar_white_t *white)
{
    uint32_t any = 0U;
    for (int t = 0; t < plan->count; t++) {
        const scaled_t adev = scaled_of_double(result->tau[t].adev);
        const scaled_t m = scaled_of_float(plan->to_white[t]);
        const uint32_t square = davar_upper_product(adev.mantissa, adev.mantissa);
        const scaled_t y = {davar_upper_product(square, m.mantissa),
                            (2 * adev.exponent) + m.exponent + 64};
        white->adev[t] = adev;
        white->y[t] = y;
        any |= y.mantissa;
    }
    white->exponent = davar_align(white->y, plan->count);
    return any != 0U;
}

static int64_t amplitude(const davar_plan_t *plan, const davar_white_t *white, int term)
{
    return davar_aligned_sum(plan->functional[term], white->y, plan->count);
}

/* White noise with its rounding, and the reciprocal for shares. */
static void fit_amplitude(const davar_plan_t *plan, davar_white_t *white)
{
    const int64_t found = amplitude(plan, white, WHITE);
    const uint64_t sum = (found > (int64_t)AMPLITUDE_LEAST) ? (uint64_t)found : AMPLITUDE_LEAST;
    const uint32_t zeros = davar_leading_zeros(sum);
    const int32_t above = (int32_t)zeros - (int32_t)plan->white_bits;
    const int32_t spare = 63 - (int32_t)(SUM_SPARE + DAVAR_FIT_SHARE_BITS);
    white->square.mantissa = (uint32_t)((sum << zeros) >> 32U);
    white->square.exponent = white->exponent + 32 - above - (int32_t)DAVAR_FIT_FUNCTIONAL_BITS;
    white->drift = (above > spare) ? (uint32_t)(above - spare) : 0U;
    white->inverse = davar_reciprocal_of_mantissa(white->square.mantissa) >>
                     (uint32_t)(spare + (int32_t)white->drift - above);
}

/* A sum of products with a functional, over N^2, in the fixed point of shares; saturates. */
static uint32_t share_of(const davar_white_t *white, uint64_t sum)
{
    const uint32_t share = davar_upper_product((uint32_t)(sum >> SUM_SPARE), white->inverse);
    if (white->drift == 0U) {
        return share;
    }
    return (share <= (UINT32_MAX >> white->drift)) ? (share << white->drift) : UINT32_MAX;
}

static uint32_t times_sigma(uint32_t quarters, uint32_t sigma)
{
    return (quarters * sigma) >> 2U; /* sigma is at most 2^26 */
}

/* `factor` times the rounding of a sample, as a share: signed, at most SHARE_BOUND in size. A
 * factor below 2^-16 is 0 but for the inaccuracy of the plan. */
static int32_t rounded_share(const davar_white_t *white, float factor)
{
    const uint32_t bits = davar_bits_of_float(factor) & 0x7FFFFFFFU;
    if ((white->rounding.mantissa == 0U) || (bits < FACTOR_LEAST)) {
        return 0;
    }
    const uint32_t share =
        scaled_to_fixed(scaled_times(white->rounding, scaled_of_float(davar_float_of_bits(bits))),
                        (int32_t)DAVAR_FIT_SHARE_BITS);
    const int32_t most = (int32_t)((share < SHARE_BOUND) ? share : SHARE_BOUND);
    return (davar_bits_of_float(factor) == bits) ? most : -most;
}

/* Amplitude of a term over N^2, without rounding, at most 2^31 in size. */
static int32_t signed_share(const davar_plan_t *plan, const davar_white_t *white, int term)
{
    const int64_t sum = amplitude(plan, white, term);
    const uint32_t size = share_of(white, (sum < 0) ? (0U - (uint64_t)sum) : (uint64_t)sum);
    const int32_t most = (int32_t)((size < SHARE_BOUND) ? size : SHARE_BOUND);
    return ((sum < 0) ? -most : most) - rounded_share(white, plan->rounding[term]);
}

/* The shares of all terms, which of them are significant (5.7), and by how much the short cluster
 * sizes read low (5.17). */
static void fit_shares(const davar_plan_t *plan, davar_white_t *white)
{
    white->suspects = 0U;
    white->lack = 0U;
    for (int k = 0; k < TERMS; k++) {
        if (k != WHITE) {
            const int32_t share = signed_share(plan, white, k);
            white->share[k] = (share > 0) ? (uint32_t)share : 0U;
            if ((k == DAVAR_QUANTIZATION) && (share < 0)) {
                white->lack = (uint32_t)-share;
            }
            if (white->share[k] > times_sigma(DAVAR_FIT_THRESHOLD_QUARTERS, plan->sigma[k])) {
                white->suspects |= 1U << (unsigned)k;
            }
        }
    }
}

/* Do the short cluster sizes read low, as behind a filter that the plan does not know? */
static bool lacks(const davar_plan_t *plan, const davar_white_t *white)
{
    return white->lack > times_sigma(DAVAR_FIT_THRESHOLD_QUARTERS, plan->sigma[DAVAR_QUANTIZATION]);
}

/* |y / expected - 1| in standard errors, as 19.13. `more`: expected over N^2, minus 1. */
static uint32_t deviation(const davar_white_t *white, uint32_t y, int32_t more, uint32_t root_edf)
{
    uint32_t share = share_of(white, (uint64_t)y << DAVAR_FIT_FUNCTIONAL_BITS);
    if (more != 0) {
        const uint32_t expected = SHARE_ONE + (uint32_t)more;
        const scaled_t ratio =
            scaled_times(scaled_of_u64(share, 0), scaled_inverse(scaled_of_u32(expected, 0)));
        share = scaled_to_fixed(ratio, (int32_t)DAVAR_FIT_SHARE_BITS);
    }
    const uint32_t ratio = (share < SHARE_MOST) ? share : SHARE_MOST;
    const uint32_t excess = ratio - SHARE_ONE; /* modulo 2^32 */
    const uint32_t sign = 0U - (excess >> 31U);
    return (uint32_t)(davar_multiply_u32((excess ^ sign) - sign, root_edf) >>
                      (DAVAR_FIT_SHARE_BITS + 7U));
}

/* Does white noise leave no misfit (5.9)? */
static bool explains(const davar_plan_t *plan, const davar_white_t *white)
{
    uint64_t misfit = 0U;
    for (int t = 0; t < plan->count; t++) {
        const int32_t more = rounded_share(white, plan->rounded[t]);
        const uint32_t errors = deviation(white, white->y[t].mantissa, more, plan->root_edf[t]);
        misfit += davar_multiply_u32(errors, errors);
        if (misfit > plan->misfit_limit) {
            return false;
        }
    }
    return true;
}

/* --- rounding (5.15) --- */

DAVAR_APART DAVAR_RARE scaled_t davar_rounding(const davar_plan_t *plan,
                                               const davar_result_t *result)
{
    const scaled_t count = scaled_of_double(result->unit_per_count);
    return scaled_times(scaled_times(count, count), scaled_of_double(plan->rounding_variance));
}

/* value / under as 2.30, for value < under / 2. */
static uint32_t quotient_of_ones(uint32_t value, uint32_t under)
{
    const uint32_t zeros = davar_leading_zeros_32(under);
    return davar_upper_product(value, davar_reciprocal_of_mantissa(under << zeros)) << (zeros - 1U);
}

/* The largest distance of the variance of rounding from q^2 / 12, for any mean between two counts
 * and noise of this share. Below plan->coarse, rounding is at most 0.38 of the noise. */
static uint32_t rounding_margin(const davar_plan_t *plan, uint32_t share, uint32_t noise)
{
    const scaled_t ratio =
        scaled_times(scaled_times(scaled_of_u32(share, 0), scaled_inverse(scaled_of_u32(noise, 0))),
                     scaled_of_float(plan->steepness));
    const uint32_t fixed = scaled_to_fixed(ratio, NOISE_BITS);
    const uint32_t square = noise_times(fixed, fixed);
    return noise_times(share, noise_times(square, square)) * 17U / 2U;
}

/* The angle random walk without rounding, over that with it. */
typedef struct {
    scaled_t value;
    scaled_t low;
    scaled_t high;
} unrounded_t;

static scaled_t root_of_share(uint32_t share)
{
    return scaled_root(scaled_of_u32(share, -NOISE_BITS));
}

/* Takes off the `share` of rounding. `rounding`: variance of rounding of a sample over the
 * variance, below plan->coarse; `least`: lower limit of the variance over the variance; all as
 * 2.30. `high`: upper limit of its root. */
DAVAR_RARE static unrounded_t unrounded(const davar_plan_t *plan, uint32_t share, uint32_t rounding,
                                        uint32_t least, scaled_t high)
{
    const bool is_low = noise_times(least, plan->coarse) > rounding; /* so least > share */
    const uint32_t noise = is_low ? (least - share) : (CENTRE_ONE - share);
    const uint32_t margin = (share > 0U) ? rounding_margin(plan, share, noise) : 0U;
    unrounded_t without = {{SCALED_TOP, -31}, {0U, SCALED_ZERO}, high}; /* 1, 0, high */
    if (is_low) {
        without.low = root_of_share((noise > margin) ? (noise - margin) : 1U);
    }
    if (share > 0U) {
        const uint32_t square =
            scaled_to_fixed(scaled_times(high, high), (int32_t)DAVAR_FIT_SHARE_BITS);
        const uint32_t less = (share - margin) >> ((uint32_t)NOISE_BITS - DAVAR_FIT_SHARE_BITS);
        without.value = root_of_share(CENTRE_ONE - share);
        without.high = scaled_root(scaled_of_u32(square - less, -(int32_t)DAVAR_FIT_SHARE_BITS));
    }
    return without;
}

/* Where rounding lowers the estimate, because the functional of a filter has negative factors. Its
 * share may be several times the estimate. */
DAVAR_RARE static unrounded_t raised(scaled_t share, uint32_t least, scaled_t high)
{
    const scaled_t one = {SCALED_TOP, -31};
    const scaled_t root = scaled_root(scaled_plus(one, share));
    return (unrounded_t){root, scaled_times(root, root_of_share(least | 1U)),
                         scaled_times(root, high)};
}

/* A root of an amplitude as the coefficient of a term, in its unit. */
static double in_unit(const davar_plan_t *plan, int term, scaled_t root)
{
    return scaled_to_double(scaled_times(root, scaled_of_double(plan->root[term])));
}

DAVAR_RARE double davar_half_a_count_at_least(const davar_plan_t *plan,
                                              const davar_result_t *result, double limit)
{
    const scaled_t count = scaled_of_double(result->unit_per_count);
    const scaled_t hidden = scaled_times(count, scaled_of_float(plan->hidden));
    const double least = in_unit(plan, WHITE, hidden);
    return (davar_bits_of_double(limit) < davar_bits_of_double(least)) ? least : limit;
}

/* --- the result --- */

/* Lower limit of N^2 with an unresolved term: the interval must contain the N^2 that the term would
 * leave (5.10). As 2.30. */
static uint32_t doubted(const davar_plan_t *plan, uint32_t share, int term)
{
    const scaled_t centre = scaled_of_float(plan->centre[term]); /* 2^-32 to 2^20 per share */
    const uint32_t shift = (uint32_t)((int32_t)DAVAR_FIT_SHARE_BITS - 30 - centre.exponent);
    const uint64_t taken = davar_multiply_u32(centre.mantissa, share) >> shift;
    const uint32_t left = CENTRE_ONE - ((taken < CENTRE_ONE) ? (uint32_t)taken : CENTRE_ONE);
    const uint32_t uncertain = plan->doubt[term];
    if (uncertain >= davar_upper_product(left, (uint32_t)(DAVAR_FIT_NOTHING * FRACTION_32))) {
        return 0U;
    }
    return noise_times(left, davar_chi_square_low(quotient_of_ones(uncertain, left)));
}

/* Lower limit of N^2 as 2.30. */
static uint32_t least_square(const davar_plan_t *plan, const davar_white_t *white)
{
    uint32_t least = plan->white_low;
    for (int k = 0; k < TERMS; k++) {
        if ((k != WHITE) &&
            (white->share[k] > times_sigma(DAVAR_FIT_DOUBT_QUARTERS, plan->sigma[k]))) {
            const uint32_t larger = (k > WHITE) ? times_sigma(6U, plan->sigma[k]) : 0U;
            const uint32_t low = doubted(plan, white->share[k] + larger, k);
            least = (low < least) ? low : least;
        }
    }
    return least;
}

static void write_intervals(const davar_plan_t *plan, const davar_white_t *white,
                            davar_result_t *result)
{
    for (int t = 0; t < plan->count; t++) {
        davar_adev_t *const tau = &result->tau[t];
        tau->edf = plan->edf[t];
        tau->low = scaled_to_double(scaled_times(white->adev[t], scaled_of_float(plan->low[t])));
        tau->high = scaled_to_double(scaled_times(white->adev[t], scaled_of_float(plan->high[t])));
    }
}

/* The upper limit of an absent term is sqrt((share + margin)(1 + margin)) N (5.11). */
static void white_absent(const davar_plan_t *plan, const davar_white_t *white, scaled_t root,
                         int term, davar_coefficient_t *coefficient)
{
    coefficient->present = false;
    coefficient->value = (double)NAN;
    coefficient->low = (double)NAN;
    coefficient->high = (double)INFINITY;
    if (plan->sigma[term] <= DAVAR_FIT_SIGMA_MOST) {
        const uint32_t sigma = plan->sigma[term];
        const uint32_t margin =
            sigma + davar_upper_product(sigma, (uint32_t)((DAVAR_FIT_BOUND - 1.0) * FRACTION_32));
        const scaled_t share =
            scaled_root(scaled_of_u32(white->share[term] + margin, -(int32_t)DAVAR_FIT_SHARE_BITS));
        const scaled_t bound =
            scaled_times(scaled_times(share, scaled_of_float(plan->room[term])), root);
        coefficient->high = in_unit(plan, term, bound);
    }
}

/* An undeclared filter may have lowered the estimate by the lack that the window shows (5.17). */
static scaled_t with_lack(const davar_plan_t *plan, const davar_white_t *white, scaled_t high)
{
    if (plan->declared || (white->lack == 0U)) {
        return high;
    }
    const scaled_t half_lack = scaled_of_u32(white->lack, -1 - (int32_t)DAVAR_FIT_SHARE_BITS);
    const scaled_t centre = scaled_of_float(plan->centre[DAVAR_QUANTIZATION]);
    return scaled_plus(high, scaled_times(high, scaled_times(half_lack, centre)));
}

static void white_present(const davar_plan_t *plan, const davar_white_t *white, scaled_t root,
                          davar_coefficient_t *coefficient)
{
    const scaled_t whole = scaled_times(root, scaled_of_double(plan->root[WHITE]));
    const uint32_t factor = davar_bits_of_float(plan->rounding[WHITE]);
    const uint32_t size = factor & 0x7FFFFFFFU;
    const scaled_t rounded =
        scaled_times(white->rounding, scaled_of_float(davar_float_of_bits(size)));
    const uint32_t share = scaled_to_fixed(rounded, NOISE_BITS);
    const uint32_t least = least_square(plan, white);
    const scaled_t high = with_lack(plan, white, scaled_of_float(plan->white_high));
    const unrounded_t without =
        (factor == size)
            ? unrounded(plan, share, scaled_to_fixed(white->rounding, NOISE_BITS), least, high)
            : raised(rounded, least, high);
    coefficient->present = true;
    coefficient->value =
        scaled_to_double((share == 0U) ? whole : scaled_times(whole, without.value));
    coefficient->low = scaled_to_double(scaled_times(whole, without.low));
    coefficient->high = scaled_to_double(scaled_times(whole, without.high));
}

static void write_white(const davar_plan_t *plan, const davar_white_t *white,
                        davar_result_t *result)
{
    const scaled_t root = scaled_root(white->square);
    write_intervals(plan, white, result);
    result->noise = DAVAR_NOISE_WHITE;
    for (int k = 0; k < TERMS; k++) {
        if (k != WHITE) {
            white_absent(plan, white, root, k, &result->coefficient[k]);
        } else {
            white_present(plan, white, root, &result->coefficient[k]);
        }
    }
}

DAVAR_RARE void davar_write_unlimited(const davar_plan_t *plan, davar_noise_t noise,
                                      davar_result_t *result)
{
    for (int t = 0; t < plan->count; t++) {
        result->tau[t].edf = plan->edf[t];
        result->tau[t].low = 0.0;
        result->tau[t].high = (double)INFINITY;
    }
    davar_absent_coefficients(result);
    result->noise = noise;
}

/* Below half a count, the deviations depend on where the mean lies between two counts and do not
 * scatter as chi-square. */
DAVAR_RARE void davar_write_coarse(const davar_plan_t *plan, double limit, davar_result_t *result)
{
    davar_write_unlimited(plan, DAVAR_NOISE_COARSE, result);
    result->coefficient[WHITE].high = davar_half_a_count_at_least(plan, result, limit);
}

static void write_nothing(davar_result_t *result)
{
    davar_absent_taus(result, 0U);
    davar_absent_coefficients(result);
}

/* Does the shortest size scatter by no more than twice the rounding and the noise that it hides?
 * Otherwise N^2 is small because another term lowers it, where a filter makes weights negative. */
DAVAR_RARE static bool is_within_counts(const davar_plan_t *plan, const davar_result_t *result,
                                        const davar_white_t *white)
{
    const scaled_t count = scaled_of_double(result->unit_per_count);
    const scaled_t hidden = scaled_times(count, scaled_of_float(plan->hidden));
    const scaled_t noise =
        scaled_times(scaled_times(hidden, hidden), scaled_of_float(plan->gain[0]));
    const scaled_t most = scaled_plus(noise, davar_rounding(plan, result));
    const scaled_t found =
        scaled_times(scaled_times(white->adev[0], white->adev[0]), scaled_of_float(plan->m[0]));
    return scaled_to_fixed(scaled_times(found, scaled_inverse(most)), NOISE_BITS) <=
           (2U * CENTRE_ONE);
}

/* davar_white_suffices with a plan that is up to date. */
static bool suffices(davar_plan_t *plan, double rate_hz, davar_result_t *result,
                     davar_white_t *white)
{
    davar_absent_taus(result, plan->count);
    if (!read_data(plan, result, white)) {
        /* Noise below a count, or a stuck sensor: differences of 0 limit nothing. */
        davar_write_unlimited(plan, DAVAR_NOISE_CONSTANT, result);
        return true;
    }
    fit_amplitude(plan, white);
    if (davar_bits_of_double(plan->rate_hz) != davar_bits_of_double(rate_hz)) {
        davar_plan_rate(plan, rate_hz);
    }
    white->rounding = scaled_times(davar_rounding(plan, result), scaled_inverse(white->square));
    if (scaled_to_fixed(white->rounding, NOISE_BITS) >= plan->coarse) {
        white->suspects = 0U;
        white->explains = false;
        if (!is_within_counts(plan, result, white)) {
            return false;
        }
        const scaled_t high =
            scaled_times(scaled_root(white->square), scaled_of_float(plan->white_high));
        davar_write_coarse(plan, in_unit(plan, WHITE, high), result);
        return true;
    }
    fit_shares(plan, white);
    white->lacks = lacks(plan, white);
    if (white->lacks && (!plan->declared || (white->suspects == 0U))) {
        davar_write_unlimited(plan, DAVAR_NOISE_FILTERED, result);
        return true;
    }
    white->explains = (white->suspects == 0U) && explains(plan, white);
    if (white->explains) {
        write_white(plan, white, result);
    }
    return white->explains;
}

bool davar_white_suffices(davar_plan_t *plan, double rate_hz, davar_result_t *result,
                          davar_white_t *white)
{
    if (davar_fit_usable(result) == 0U) {
        write_nothing(result);
        return true;
    }
    davar_fit_prepare(plan, result);
    return suffices(plan, rate_hz, result, white);
}

/* White noise is at most the whole Allan variance at a size that the filter passes, because other
 * terms only add to it (5.11). */
static void write_beside(const davar_plan_t *plan, const davar_white_t *white,
                         davar_result_t *result)
{
    int t = 0;
    while ((t < (plan->count - 1)) &&
           (davar_bits_of_float(plan->gain[t]) < davar_bits_of_float(DAVAR_FIT_PASSED))) {
        t++;
    }
    write_intervals(plan, white, result);
    davar_absent_coefficients(result);
    const scaled_t most = scaled_times(scaled_of_double(result->tau[t].high),
                                       scaled_root(scaled_of_float(plan->to_white[t])));
    result->coefficient[WHITE].high =
        davar_half_a_count_at_least(plan, result, in_unit(plan, WHITE, most));
    davar_absent_taus(result, 0U); /* the intervals held for white noise only */
    result->noise = DAVAR_NOISE_MIXED;
}

/* Fits nothing if the plan has another number of cluster sizes than the window supports. */
static bool fit_white(davar_plan_t *plan, double rate_hz, davar_result_t *result, uint8_t usable)
{
    davar_white_t white;
    if ((usable == 0U) || (usable != plan->count)) {
        write_nothing(result);
    } else if (!suffices(plan, rate_hz, result, &white)) {
        write_beside(plan, &white, result);
    }
    return result->noise == DAVAR_NOISE_WHITE;
}

bool davar_fit_white(davar_plan_t *plan, double rate_hz, davar_result_t *result)
{
    const uint8_t usable = davar_fit_usable(result);
    davar_fit_prepare(plan, result);
    return fit_white(plan, rate_hz, result, usable);
}

bool davar_fit_white_ready(davar_plan_t *plan, double rate_hz, davar_result_t *result)
{
    const uint8_t usable = davar_fit_usable(result);
    if (usable == plan->count) {
        davar_fit_prepare_window(plan, result);
    }
    return fit_white(plan, rate_hz, result, usable);
}
