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

/* A deviation need not be known better than to 2^-7. */
#define NEAR_SHIFT 7U

#define WEIGHT_ONE (INT64_C(1) << DAVAR_FIT_FUNCTIONAL_BITS)
#define STOOD_IN_MOST (UINT32_C(1) << 28U) /* as an aligned y */
#define CARRYING_LEAST 3 /* with differences, in a window of a plan from the host */

/* Least amplitude of white noise: enough bits for a root and a reciprocal. */
#define AMPLITUDE_LEAST (UINT64_C(1) << 23U)

/* Of white noise with a standard deviation of 1, 0.5 and 0.375 counts, rounding included, so many
 * equal samples follow each other once in 10^9 samples: log 10^-9 over that of the chance of the
 * likeliest count, which is erf(0.354 / sigma). */
#define SCATTER_BITS 8
static const struct {
    uint16_t scatter; /* in 1 / 256 squared counts */
    uint16_t equal;
} runs[] = {{57U, 104U}, {85U, 56U}, {277U, 32U}};

/* Is the filter known, or known to be absent? */
static bool is_declared(const davar_white_plan_t *plan)
{
    return !DAVAR_FILTERS || plan->declared;
}

/* Can rounding errors repeat, because a filter makes samples alike (5.15)? */
static bool may_repeat(const davar_white_plan_t *plan)
{
    return DAVAR_FILTERS && (davar_bits_of_float(plan->step) != 0U);
}

static uint32_t smaller_of(uint32_t a, uint32_t b)
{
    return (a < b) ? a : b;
}

/* --- the fit --- */

/* The sizes of the plan that have differences. */
static int usable_of(const davar_white_plan_t *plan, const davar_result_t *result)
{
    const int usable = (int)davar_fit_usable(result);
    return (usable < (int)plan->count) ? usable : (int)plan->count;
}

DAVAR_APART DAVAR_RARE scaled_t davar_rounding(const davar_white_plan_t *plan,
                                               const davar_result_t *result)
{
    const scaled_t count = scaled_of_double(result->unit_per_count);
    return scaled_times(scaled_times(count, count), scaled_of_double(plan->rounding_variance));
}

/* Rounding of a sample through the gain. */
static uint32_t rounded_at(const davar_white_plan_t *plan, uint32_t rounding, int t)
{
    const uint64_t part =
        davar_multiply_u32(rounding, plan->inverse_gain[t]) >> DAVAR_FIT_GAIN_BITS;
    return (part < SCALED_TOP) ? (uint32_t)part : SCALED_TOP;
}

/* Reads the deviations, aligns y, whose mantissas had 29 to 32 bits, and takes the rounding off
 * (5.15). False: all are 0. */
static bool read_data(const davar_white_plan_t *plan, const davar_result_t *result,
                      davar_white_t *white)
{
    uint32_t any = 0U;
    for (int t = 0; t < white->usable; t++) {
        const scaled_t adev = scaled_of_double(result->tau[t].adev);
        const scaled_t m = scaled_of_float(plan->to_white[t]);
        const uint32_t square = davar_upper_product(adev.mantissa, adev.mantissa);
        const scaled_t y = {davar_upper_product(square, m.mantissa),
                            (2 * adev.exponent) + m.exponent + 64};
        white->adev[t] = adev;
        white->y[t] = y;
        any |= y.mantissa;
    }
    white->exponent = davar_align(white->y, white->usable);
    white->rounding = davar_rounding(plan, result);
    const uint32_t rounding = davar_scaled_to_fixed(white->rounding, -white->exponent);
    for (int t = 0; t < plan->count; t++) {
        const uint32_t y = (t < white->usable) ? white->y[t].mantissa : 0U;
        const uint32_t rounded = rounded_at(plan, rounding, t);
        white->rounded[t] = rounded;
        white->y[t].mantissa = (y > rounded) ? (y - rounded) : 0U;
    }
    return any != 0U;
}

/* The weight that the first sizes have in white noise; all have 2^29. */
static int64_t weight_of_sizes(const davar_white_plan_t *plan, int sizes)
{
    int64_t sum = 0;
    for (int t = 0; t < sizes; t++) {
        sum += plan->functional[WHITE][t];
    }
    return (int64_t)((uint64_t)sum << plan->white_bits);
}

/* For the sizes without differences, the white noise of the others stands in (5.5). */
static void stand_in(const davar_white_plan_t *plan, davar_white_t *white)
{
    if (white->usable == plan->count) {
        return;
    }
    const int64_t sum = davar_aligned_sum(plan->functional[WHITE], white->y, white->usable);
    const scaled_t found = scaled_of_u64((sum > 0) ? (uint64_t)sum : 0U, (int32_t)plan->white_bits);
    const scaled_t weight = scaled_of_u64((uint64_t)weight_of_sizes(plan, white->usable), 0);
    const uint32_t y = davar_scaled_to_fixed(scaled_quotient(found, weight), 0);
    for (int t = white->usable; t < plan->count; t++) {
        white->y[t].mantissa = (y < STOOD_IN_MOST) ? y : STOOD_IN_MOST;
    }
}

static int64_t amplitude(const davar_white_plan_t *plan, const davar_white_t *white, int term)
{
    return davar_aligned_sum(plan->functional[term], white->y, plan->count);
}

/* Rounding in the estimate of N^2: N^2 scatters with it, although it was taken off. A filter can
 * make its factor negative; it then adds nothing. */
static scaled_t rounding_part(const davar_white_plan_t *plan, const davar_white_t *white)
{
    const uint32_t bits = davar_bits_of_float(plan->rounding);
    const scaled_t none = {0U, SCALED_ZERO};
    return ((bits >> 31U) == 0U) ? scaled_times(white->rounding, scaled_of_float(plan->rounding))
                                 : none;
}

/* By how much rounding may differ from white noise at any size: twice the sum of the correlations
 * of its errors, at most 2 / (e^x - 1), times its variance (5.15). */
static scaled_t rounding_doubt(const davar_white_plan_t *plan, const davar_white_t *white)
{
    const scaled_t none = {0U, SCALED_ZERO};
    if (!may_repeat(plan) || (white->rounding.mantissa == 0U)) {
        return none;
    }
    const scaled_t one = scaled_of_u32(1U, 0);
    const scaled_t x =
        scaled_times(scaled_of_float(plan->step), scaled_quotient(white->square, white->rounding));
    const scaled_t quarter = scaled_times(x, scaled_of_u32(1U, -2));
    const scaled_t third = scaled_times(x, scaled_of_u32(0x55555555U, -32));
    const scaled_t half = scaled_times(x, scaled_of_u32(1U, -1));
    const scaled_t cubic =
        davar_scaled_plus(one, scaled_times(third, davar_scaled_plus(one, quarter)));
    const scaled_t over = scaled_times(x, davar_scaled_plus(one, scaled_times(half, cubic)));
    return scaled_times(white->rounding, scaled_times(scaled_of_u32(2U, 0), scaled_inverse(over)));
}

/* White noise, and the reciprocal for shares. */
static void fit_amplitude(const davar_white_plan_t *plan, davar_white_t *white)
{
    const int64_t found = amplitude(plan, white, WHITE);
    const uint64_t square = (found > (int64_t)AMPLITUDE_LEAST) ? (uint64_t)found : AMPLITUDE_LEAST;
    const int32_t unit = white->exponent - (int32_t)DAVAR_FIT_FUNCTIONAL_BITS;
    white->square = scaled_of_u64(square, unit + (int32_t)plan->white_bits);
    white->doubt = rounding_doubt(plan, white);
    white->sum = davar_scaled_plus(white->square, rounding_part(plan, white));
    const int32_t above = unit + 32 - white->sum.exponent;
    const int32_t spare = 63 - (int32_t)(SUM_SPARE + DAVAR_FIT_SHARE_BITS);
    white->lost = (above > spare) ? (uint32_t)(above - spare) : 0U;
    const int32_t shift = spare + (int32_t)white->lost - above;
    white->inverse_sum = scaled_inverse(white->sum);
    white->inverse =
        davar_scaled_to_fixed(white->inverse_sum, -white->inverse_sum.exponent - shift);
}

/* A sum of products with a functional, over `sum`, in the fixed point of shares; saturates. */
static uint32_t share_of(const davar_white_t *white, uint64_t sum)
{
    const uint32_t share = davar_upper_product((uint32_t)(sum >> SUM_SPARE), white->inverse);
    if (white->lost == 0U) {
        return share;
    }
    return (share <= (UINT32_MAX >> white->lost)) ? (share << white->lost) : UINT32_MAX;
}

/* A part of `sum` as a fraction with so many bits. */
static uint32_t of_sum(const davar_white_t *white, scaled_t part, int32_t bits)
{
    return davar_scaled_to_fixed(scaled_times(part, white->inverse_sum), bits);
}

static uint32_t times_sigma(uint32_t quarters, uint32_t sigma)
{
    return (quarters * sigma) >> 2U; /* sigma is at most 2^26 */
}

/* The share of a term that rounding may look like, because it is not white. */
static uint32_t rounded_share(const davar_white_plan_t *plan, const davar_white_t *white, int term,
                              int32_t bits)
{
    if (!may_repeat(plan) || (white->doubt.mantissa == 0U)) {
        return 0U;
    }
    const scaled_t most = scaled_of_float(plan->rounding_most[term]);
    const uint32_t share = of_sum(white, scaled_times(white->doubt, most), bits);
    return (share < SCALED_TOP) ? share : SCALED_TOP;
}

/* The share of a term from which it is significant. */
static uint32_t significant(const davar_white_plan_t *plan, const davar_white_t *white, int term)
{
    return times_sigma(DAVAR_FIT_THRESHOLD_QUARTERS, plan->sigma[term]) +
           rounded_share(plan, white, term, (int32_t)DAVAR_FIT_SHARE_BITS);
}

/* Does the shortest size scatter by no more than twice the rounding and the noise that it hides?
 * Otherwise N^2 is small because another term lowers it, where a filter makes weights negative. */
static bool is_within_counts(const davar_white_plan_t *plan, const davar_white_t *white)
{
    const uint32_t most = davar_scaled_to_fixed(white->rounding, 1 - white->exponent);
    const uint32_t found = white->y[0].mantissa;
    const uint32_t rounded = white->rounded[0];
    return (found <= rounded) || (noise_times(found - rounded, plan->coarse) <= most);
}

/* The shares of all terms, which of them are significant (5.7), and by how much the short cluster
 * sizes read low (5.17). */
static void fit_shares(const davar_white_plan_t *plan, davar_white_t *white)
{
    white->suspects = 0U;
    white->lack = 0U;
    white->repeats =
        is_within_counts(plan, white) &&
        (rounded_share(plan, white, DAVAR_QUANTIZATION, (int32_t)DAVAR_FIT_SHARE_BITS) >
         times_sigma(DAVAR_FIT_THRESHOLD_QUARTERS, plan->sigma[DAVAR_QUANTIZATION]));
    for (int k = 0; k < TERMS; k++) {
        if (k != WHITE) {
            const int64_t sum = amplitude(plan, white, k);
            const uint32_t share =
                share_of(white, (sum < 0) ? (0U - (uint64_t)sum) : (uint64_t)sum);
            white->share[k] = (sum < 0) ? 0U : share;
            if ((k == DAVAR_QUANTIZATION) && (sum < 0)) {
                white->lack = share;
            }
            if (white->share[k] > significant(plan, white, k)) {
                white->suspects |= 1U << (unsigned)k;
            }
        }
    }
}

/* Do the short cluster sizes read low, as after a filter that the plan does not know? */
static bool lacks(const davar_white_plan_t *plan, const davar_white_t *white)
{
    return white->lack > significant(plan, white, DAVAR_QUANTIZATION);
}

/* |y - N^2| over N^2 and the rounding at this size, with which y scatters (5.15), as a share.
 * `own` is N^2 as a share, and rounding explains `free`. The divisor exceeds `sum` by `more`, in
 * units of y, modulo 2^32. Within `near` of 0, the division changes nothing that matters and is
 * skipped. */
static uint32_t deviation(const davar_white_t *white, int t, uint32_t own, uint32_t free,
                          uint32_t more, uint32_t near)
{
    const uint64_t y = white->y[t].mantissa;
    const uint32_t share = share_of(white, y << DAVAR_FIT_FUNCTIONAL_BITS);
    const uint32_t excess = ((share < SHARE_MOST) ? share : SHARE_MOST) - own; /* modulo 2^32 */
    const uint32_t sign = 0U - (excess >> 31U);
    const uint32_t apart = (excess ^ sign) - sign;
    const uint32_t size = (apart > free) ? (apart - free) : 0U;
    if ((more + near) <= (2U * near)) {
        return size;
    }
    const uint64_t rounded = white->rounded[t];
    const uint32_t whole = own + share_of(white, rounded << DAVAR_FIT_FUNCTIONAL_BITS);
    return davar_scaled_to_fixed(
        scaled_quotient(scaled_of_u32(size | 1U, 0), scaled_of_u32(whole | 1U, 0)),
        (int32_t)DAVAR_FIT_SHARE_BITS);
}

/* Does white noise leave no misfit (5.9)? */
static bool explains(const davar_white_plan_t *plan, const davar_white_t *white)
{
    const uint32_t own = of_sum(white, white->square, (int32_t)DAVAR_FIT_SHARE_BITS);
    const uint32_t sum = davar_scaled_to_fixed(white->sum, -white->exponent);
    const uint32_t rest = davar_scaled_to_fixed(white->square, -white->exponent) - sum;
    const uint32_t doubt = of_sum(white, white->doubt, (int32_t)DAVAR_FIT_SHARE_BITS);
    uint64_t misfit = 0U;
    for (int t = 0; t < white->usable; t++) {
        const uint32_t free = rounded_at(plan, doubt, t);
        const uint32_t size =
            deviation(white, t, own, free, rest + white->rounded[t], sum >> NEAR_SHIFT);
        const uint32_t errors =
            (uint32_t)(davar_multiply_u32(size, plan->root_edf[t]) >> (DAVAR_FIT_SHARE_BITS + 7U));
        misfit += davar_multiply_u32(errors, errors);
        if (misfit > plan->misfit_limit) {
            return false;
        }
    }
    return true;
}

/* --- rounding (5.15) --- */

/* value / under as 2.30, for value < under / 2. */
static uint32_t quotient_of_ones(uint32_t value, uint32_t under)
{
    const uint32_t zeros = davar_leading_zeros_32(under);
    return davar_upper_product(value, davar_reciprocal_of_mantissa(under << zeros)) << (zeros - 1U);
}

/* The largest distance of the variance of rounding from q^2 / 12, for any mean between two counts.
 * `share`: rounding; `noise`: N^2, of which it is at most 0.41 in a sample; both over `sum`. */
static uint32_t rounding_margin(const davar_white_plan_t *plan, const davar_white_t *white,
                                uint32_t share, uint32_t noise)
{
    const scaled_t sample =
        scaled_times(scaled_of_float(plan->sample), scaled_of_u32(noise, -NOISE_BITS));
    const uint32_t ratio = of_sum(white, scaled_quotient(white->rounding, sample), NOISE_BITS);
    const uint32_t square = noise_times(ratio, ratio);
    return noise_times(share, noise_times(square, square)) * 17U / 2U;
}

static scaled_t root_of_share(uint32_t share, uint32_t bits)
{
    return davar_scaled_root(scaled_of_u32(share, -(int32_t)bits));
}

/* A root of white noise as the angle random walk. */
static double in_unit(const davar_white_plan_t *plan, scaled_t root)
{
    return davar_scaled_to_double(scaled_times(root, scaled_of_double(plan->unit)));
}

DAVAR_RARE double davar_half_a_count_at_least(const davar_white_plan_t *plan,
                                              const davar_result_t *result, double limit)
{
    const scaled_t count = scaled_of_double(result->unit_per_count);
    const scaled_t hidden = scaled_times(count, scaled_of_float(plan->hidden));
    const double least = in_unit(plan, hidden);
    return (davar_bits_of_double(limit) < davar_bits_of_double(least)) ? least : limit;
}

/* --- the result --- */

/* edf^-1/2 with heavy tails, at most 1 (5.19); both as 2.30. */
static uint32_t with_tails(const davar_white_plan_t *plan, uint32_t s)
{
    if (plan->white_tails == 0U) {
        return s;
    }
    const uint32_t square = noise_times(s, s);
    return (plan->white_tails < (CENTRE_ONE - square))
               ? davar_scaled_to_fixed(
                     root_of_share(square + plan->white_tails, (uint32_t)NOISE_BITS), NOISE_BITS)
               : CENTRE_ONE;
}

/* Lower limit of N^2 with an unresolved term: the interval must contain the N^2 that the term would
 * leave (5.10). As 2.30. */
static uint32_t doubted(const davar_white_plan_t *plan, uint32_t share, int term)
{
    const scaled_t centre = scaled_of_float(plan->centre[term]); /* 2^-32 to 2^20 per share */
    const uint32_t shift = (uint32_t)((int32_t)DAVAR_FIT_SHARE_BITS - 30 - centre.exponent);
    const uint64_t taken = davar_multiply_u32(centre.mantissa, share) >> shift;
    const uint32_t left = CENTRE_ONE - ((taken < CENTRE_ONE) ? (uint32_t)taken : CENTRE_ONE);
    const uint32_t uncertain = plan->doubt[term];
    if (uncertain >= davar_upper_product(left, (uint32_t)(DAVAR_FIT_NOTHING * FRACTION_32))) {
        return 0U;
    }
    const uint32_t s = quotient_of_ones(uncertain, left);
    return noise_times(left, davar_chi_square_low(DAVAR_LAWS ? with_tails(plan, s) : s));
}

/* Lower limit of N^2 as 2.30. */
static uint32_t least_square(const davar_white_plan_t *plan, const davar_white_t *white)
{
    uint32_t least = plan->white_low;
    for (int k = 0; k < TERMS; k++) {
        if ((k != WHITE) &&
            (white->share[k] > times_sigma(DAVAR_FIT_DOUBT_QUARTERS, plan->sigma[k]))) {
            const uint32_t missed =
                (k > WHITE) ? times_sigma(DAVAR_FIT_MISSED_QUARTERS, plan->sigma[k]) : 0U;
            const uint32_t low = doubted(plan, white->share[k] + missed, k);
            least = (low < least) ? low : least;
        }
    }
    return least;
}

DAVAR_APART static void write_intervals(const davar_plan_t *plan, const davar_white_t *white,
                                        davar_result_t *result)
{
    for (int t = 0; t < white->usable; t++) {
        davar_adev_t *const tau = &result->tau[t];
        tau->edf = plan->edf[t];
        tau->low =
            davar_scaled_to_double(scaled_times(white->adev[t], scaled_of_float(plan->low[t])));
        tau->high = davar_scaled_to_double(
            scaled_times(white->adev[t], scaled_of_float(plan->white.high[t])));
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
    if (plan->white.sigma[term] <= DAVAR_FIT_SIGMA_MOST) {
        const uint32_t sigma = plan->white.sigma[term];
        const uint32_t margin =
            sigma + davar_upper_product(sigma, (uint32_t)((DAVAR_FIT_BOUND - 1.0) * FRACTION_32));
        const scaled_t share = davar_scaled_root(
            scaled_of_u32(white->share[term] + margin, -(int32_t)DAVAR_FIT_SHARE_BITS));
        const scaled_t bound =
            scaled_times(scaled_times(share, scaled_of_float(plan->room[term])), root);
        coefficient->high =
            davar_scaled_to_double(scaled_times(bound, scaled_of_double(plan->root[term])));
    }
}

/* Upper limit of N over N. The filter, which is not declared, may have lowered N^2 by the lack that the
 * window shows and by as much as passes the test (5.17). */
static scaled_t highest(const davar_white_plan_t *plan, const davar_white_t *white)
{
    const scaled_t high = scaled_of_float(plan->white_high);
    const uint32_t passes =
        times_sigma(DAVAR_FIT_THRESHOLD_QUARTERS, plan->sigma[DAVAR_QUANTIZATION]);
    const scaled_t half = scaled_of_u32(white->lack + passes, -1 - (int32_t)DAVAR_FIT_SHARE_BITS);
    const scaled_t centre = scaled_of_float(plan->centre[DAVAR_QUANTIZATION]);
    return davar_scaled_plus(high, scaled_times(high, scaled_times(half, centre)));
}

/* Where N^2 at its lower limit is hidden, N may be 0, because it was selected (5.15). */
static void white_present(const davar_white_plan_t *plan, const davar_white_t *white,
                          davar_coefficient_t *coefficient)
{
    const scaled_t root = davar_scaled_root(white->sum);
    const uint32_t least = least_square(plan, white);
    const scaled_t high =
        is_declared(plan) ? scaled_of_float(plan->white_high) : highest(plan, white);
    const uint32_t share = of_sum(white, rounding_part(plan, white), NOISE_BITS);
    const uint32_t lowest = (least > share) ? (least - share) : 0U;
    const bool is_low =
        noise_times(lowest, plan->coarse) > of_sum(white, white->rounding, NOISE_BITS);
    const uint32_t noise = is_low ? lowest : (CENTRE_ONE - share);
    const uint32_t margin = rounding_margin(plan, white, share, noise);
    const uint32_t off = margin + rounded_share(plan, white, WHITE, NOISE_BITS);
    const uint32_t left = (noise > off) ? (noise - off) : 1U;
    const uint32_t less = (share - margin) >> ((uint32_t)NOISE_BITS - DAVAR_FIT_SHARE_BITS);
    const uint32_t square =
        davar_scaled_to_fixed(scaled_times(high, high), (int32_t)DAVAR_FIT_SHARE_BITS) - less +
        rounded_share(plan, white, WHITE, (int32_t)DAVAR_FIT_SHARE_BITS);
    const double low = in_unit(plan, scaled_times(root, root_of_share(left, (uint32_t)NOISE_BITS)));
    coefficient->present = true;
    coefficient->value = in_unit(plan, davar_scaled_root(white->square));
    coefficient->low = is_low ? low : 0.0;
    coefficient->high =
        in_unit(plan, scaled_times(root, root_of_share(square, DAVAR_FIT_SHARE_BITS)));
}

/* What white noise gives besides the angle random walk. */
static void write_rest(const davar_plan_t *plan, const davar_white_t *white, davar_result_t *result)
{
    const scaled_t root = davar_scaled_root(white->sum);
    write_intervals(plan, white, result);
    for (int k = 0; k < TERMS; k++) {
        if (k != WHITE) {
            white_absent(plan, white, root, k, &result->coefficient[k]);
        }
    }
}

static void write_unlimited_taus(const davar_plan_t *plan, davar_result_t *result)
{
    for (int t = 0; t < result->tau_count; t++) {
        davar_adev_t *const tau = &result->tau[t];
        if (tau->differences > 0U) {
            tau->edf = davar_hops(tau) ? (double)NAN : plan->edf[t];
            tau->low = 0.0;
            tau->high = (double)INFINITY;
        }
    }
}

DAVAR_RARE void davar_write_unlimited(const davar_plan_t *plan, davar_noise_t noise,
                                      davar_result_t *result)
{
    write_unlimited_taus(plan, result);
    davar_absent_coefficients(result);
    result->noise = noise;
}

static void limit_walk(const davar_white_plan_t *plan, double limit, davar_result_t *result)
{
    result->coefficient[WHITE].high = davar_half_a_count_at_least(plan, result, limit);
}

/* Below half a count, the deviations depend on where the mean lies between two counts and do not
 * scatter as chi-square. */
DAVAR_RARE void davar_write_coarse(const davar_plan_t *plan, double limit, davar_result_t *result)
{
    davar_write_unlimited(plan, DAVAR_NOISE_COARSE, result);
    limit_walk(&plan->white, limit, result);
}

/* m avar. */
static scaled_t whole_at(const davar_adev_t *tau)
{
    const scaled_t adev = scaled_of_double(tau->adev);
    return scaled_times(scaled_times(adev, adev), scaled_of_u32(tau->m, 0));
}

/* The first size that its longer neighbour does not exceed has what the filter passes, or the last
 * one. What it still lacks is about what it gained over the size before, of which it takes three
 * times as much (5.17). */
DAVAR_RARE static void limit_filtered(const davar_white_plan_t *plan, int usable,
                                      davar_result_t *result)
{
    scaled_t y[DAVAR_TAUS_MAX];
    int top = 0;
    for (int t = 0; t < usable; t++) {
        y[t] = whole_at(&result->tau[t]);
    }
    const int32_t unit = davar_align(y, usable);
    while ((top + 1 < usable) && (y[top + 1].mantissa > y[top].mantissa)) {
        top++;
    }
    const uint32_t before = (top > 0) ? y[top - 1].mantissa : 0U;
    const scaled_t limit = scaled_of_float(plan->high[top]);
    const scaled_t high =
        scaled_times(scaled_of_u64(y[top].mantissa, unit), scaled_times(limit, limit));
    const scaled_t most =
        davar_scaled_plus(high, scaled_of_u64(3U * (uint64_t)(y[top].mantissa - before), unit));
    limit_walk(plan, in_unit(plan, davar_scaled_root(most)), result);
}

DAVAR_RARE void davar_write_filtered(const davar_plan_t *plan, davar_result_t *result)
{
    davar_write_unlimited(plan, DAVAR_NOISE_FILTERED, result);
    limit_filtered(&plan->white, usable_of(&plan->white, result), result);
}

static void write_nothing(davar_result_t *result)
{
    davar_absent_taus(result, 0U);
    davar_absent_coefficients(result);
}

/* Is there less than half a count? */
static bool is_hidden(const davar_white_plan_t *plan, const davar_white_t *white)
{
    return of_sum(white, white->rounding, NOISE_BITS) >=
           noise_times(of_sum(white, white->square, NOISE_BITS), plan->coarse);
}

/* Are so many rounding errors equal to the one before that they may be a quarter of N^2? */
static bool is_repeated(const davar_white_plan_t *plan, const davar_white_t *white)
{
    return rounded_share(plan, white, WHITE, NOISE_BITS) > (CENTRE_ONE / 4U);
}

static void limit_hidden(const davar_white_plan_t *plan, const davar_white_t *white,
                         davar_result_t *result)
{
    const scaled_t doubt = scaled_times(white->doubt, scaled_of_float(plan->rounding_most[WHITE]));
    const scaled_t most = davar_scaled_root(davar_scaled_plus(white->sum, doubt));
    limit_walk(plan, in_unit(plan, scaled_times(most, scaled_of_float(plan->white_high))), result);
}

/* COARSE: rounding hides the noise. FILTERED: the window shows another filter than the declared one.
 * UNKNOWN: neither. */
static davar_noise_t why_withheld(const davar_white_plan_t *plan, davar_white_t *white)
{
    if (is_hidden(plan, white)) {
        white->suspects = 0U;
        return is_within_counts(plan, white) ? DAVAR_NOISE_COARSE : DAVAR_NOISE_UNKNOWN;
    }
    const bool filtered = lacks(plan, white) && (!is_declared(plan) || (white->suspects == 0U));
    const bool repeated = is_repeated(plan, white) && (white->suspects == 0U);
    if (repeated || (filtered && white->repeats)) {
        return DAVAR_NOISE_COARSE;
    }
    return filtered ? DAVAR_NOISE_FILTERED : DAVAR_NOISE_UNKNOWN;
}

/* The same; writes the limit. */
static davar_noise_t withhold(const davar_white_plan_t *plan, davar_white_t *white,
                              davar_result_t *result)
{
    const davar_noise_t noise = why_withheld(plan, white);
    if (noise == DAVAR_NOISE_COARSE) {
        limit_hidden(plan, white, result);
    } else if (noise == DAVAR_NOISE_FILTERED) {
        limit_filtered(plan, white->usable, result);
    }
    return noise;
}

/* Did the sensor repeat its last sample more often than white noise of this scatter does once in
 * 10^9 samples (5.24)? The scatter is half the mean square of the difference of two of the other
 * samples. */
static bool is_stuck(const davar_result_t *result)
{
    const scaled_t adev = scaled_of_double(result->tau[0].adev);
    const scaled_t count = scaled_of_double(result->unit_per_count);
    uint32_t most = result->window_samples;
    if ((result->tau[0].m != 1U) || (adev.mantissa == 0U) || (count.mantissa == 0U)) {
        return false;
    }
    const uint32_t rest = most - smaller_of(result->equal_samples, most - 1U);
    const scaled_t ratio = scaled_quotient(adev, count);
    const scaled_t share =
        scaled_quotient(scaled_of_u32(result->window_samples, 0), scaled_of_u32(rest, 0));
    const uint32_t scatter =
        davar_scaled_to_fixed(scaled_times(share, scaled_times(ratio, ratio)), SCATTER_BITS);
    for (int i = 0; i < (int)(sizeof runs / sizeof runs[0]); i++) {
        most = (scatter >= runs[i].scatter) ? smaller_of(most, runs[i].equal) : most;
    }
    return result->equal_samples >= most;
}

/* Reads the window. False: its noise is below a count, or the sensor is stuck. */
static bool shows_noise(const davar_white_plan_t *plan, const davar_result_t *result,
                        davar_white_t *white)
{
    return read_data(plan, result, white) && !is_stuck(result);
}

/* What a window that shows noise is, from a y for every size of the plan. Writes the angle random
 * walk, except if it is MIXED. */
static davar_noise_t verdict_of(const davar_white_plan_t *plan, davar_white_t *white,
                                davar_result_t *result)
{
    fit_amplitude(plan, white);
    fit_shares(plan, white);
    const davar_noise_t noise = withhold(plan, white, result);
    if (noise != DAVAR_NOISE_UNKNOWN) {
        return noise;
    }
    if (is_hidden(plan, white) || (white->suspects != 0U) || !explains(plan, white)) {
        return DAVAR_NOISE_MIXED;
    }
    white_present(plan, white, &result->coefficient[WHITE]);
    return DAVAR_NOISE_WHITE;
}

/* davar_white_suffices with a plan that is up to date for the window. */
static bool suffices(davar_plan_t *plan, double rate_hz, davar_result_t *result,
                     davar_white_t *white)
{
    const davar_white_plan_t *const constant = &plan->white;
    davar_noise_t noise = DAVAR_NOISE_CONSTANT; /* differences of 0 limit nothing */
    davar_plan_rate(plan, rate_hz);
    write_nothing(result);
    white->usable = usable_of(constant, result);
    if (shows_noise(constant, result, white)) {
        stand_in(constant, white);
        noise = verdict_of(constant, white, result);
    }
    if (noise == DAVAR_NOISE_WHITE) {
        write_rest(plan, white, result);
    } else if (noise != DAVAR_NOISE_MIXED) {
        write_unlimited_taus(plan, result);
    }
    result->noise = noise;
    return noise != DAVAR_NOISE_MIXED;
}

bool davar_white_suffices(davar_plan_t *plan, double rate_hz, davar_result_t *result,
                          davar_white_t *white)
{
    if (davar_fit_prepare(plan, result) == 0U) {
        write_nothing(result);
        return true;
    }
    return suffices(plan, rate_hz, result, white);
}

/* White noise is at most the whole Allan variance at a size that the filter passes, because other
 * terms only add to it (5.11). */
static void limit_mixed(const davar_white_plan_t *plan, const davar_white_t *white,
                        davar_result_t *result)
{
    const int t = (int)plan->passed;
    if (t < white->usable) {
        const scaled_t high = scaled_times(white->adev[t], scaled_of_float(plan->high[t]));
        const scaled_t most =
            scaled_times(high, davar_scaled_root(scaled_of_float(plan->to_white[t])));
        limit_walk(plan, in_unit(plan, most), result);
    }
}

static bool fit_white(davar_plan_t *plan, double rate_hz, davar_result_t *result)
{
    davar_white_t white;
    if (!suffices(plan, rate_hz, result, &white)) {
        limit_mixed(&plan->white, &white, result);
    }
    return result->noise == DAVAR_NOISE_WHITE;
}

bool davar_fit_white(davar_plan_t *plan, double rate_hz, davar_result_t *result)
{
    if (davar_fit_prepare(plan, result) == 0U) {
        write_nothing(result);
        return false;
    }
    return fit_white(plan, rate_hz, result);
}

/* Are the sizes with differences those of the plan, or do they have enough weight to stand in for
 * the others? */
static bool carries(const davar_white_plan_t *plan, int usable)
{
    if (usable >= (int)plan->count) {
        return usable == (int)plan->count;
    }
    return (usable >= CARRYING_LEAST) && (weight_of_sizes(plan, usable) >= (WEIGHT_ONE / 2));
}

bool davar_fit_white_ready(davar_plan_t *plan, double rate_hz, davar_result_t *result)
{
    if (!carries(&plan->white, (int)davar_fit_usable(result))) {
        write_nothing(result);
        return false;
    }
    davar_fit_prepare_window(plan, result);
    return fit_white(plan, rate_hz, result);
}

bool davar_fit_walk(const davar_white_plan_t *plan, davar_result_t *result)
{
    davar_white_t white;
    davar_noise_t noise = DAVAR_NOISE_CONSTANT;
    DAVAR_ASSERT((davar_fit_usable(result) == plan->count) &&
                 (result->window_samples == plan->window));
    write_nothing(result);
    white.usable = (int)plan->count;
    if (shows_noise(plan, result, &white)) {
        noise = verdict_of(plan, &white, result);
    }
    if (noise == DAVAR_NOISE_MIXED) {
        limit_mixed(plan, &white, result);
    }
    result->noise = noise;
    return noise == DAVAR_NOISE_WHITE;
}
