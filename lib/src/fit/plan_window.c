/* davar - the plan of a window and of a rate, DESIGN (1.2) (5.5): in integers, like the short cut
 * that uses it (5.14). */
#include "fit/plan.h"
#include "number/real.h"

/* --- positive numbers with one exponent (5.14) --- */

#define SPARE 4

int32_t davar_align(scaled_t value[], int count)
{
    int32_t common = INT32_MIN;
    for (int t = 0; t < count; t++) {
        common = (value[t].exponent > common) ? value[t].exponent : common;
    }
    common += SPARE;
    for (int t = 0; t < count; t++) {
        const uint32_t shift = (uint32_t)(common - value[t].exponent);
        value[t].mantissa = (shift > 31U) ? 0U : (value[t].mantissa >> shift);
        value[t].exponent = common;
    }
    return common;
}

int64_t davar_aligned_sum(const int32_t factor[], const scaled_t value[], int count)
{
    uint64_t sum = 0U; /* modulo 2^64 */
    for (int t = 0; t < count; t++) {
        sum += davar_multiply_i32(factor[t], (int32_t)value[t].mantissa);
    }
    return (int64_t)sum;
}

/* 2^-bits */
static scaled_t half_to_the(int32_t bits)
{
    const scaled_t scaled = {SCALED_TOP, -31 - bits};
    return scaled;
}

static scaled_t scaled_ratio(uint32_t dividend, uint32_t divisor)
{
    return scaled_quotient(scaled_of_u32(dividend, 0), scaled_of_u32(divisor, 0));
}

/* --- the rate --- */

/* The units of (1.2) are factor * rate^(k - 2), correctly rounded in doubles: rates that differ in
 * the last bit give results that differ as little. */
static const double factor[] = {1.0 / 3.0, 3600.0,
                                3600.0 * 3600.0 * 2.2661800709135971 /* pi / (2 ln 2) */,
                                216000.0 * 216000.0 * 3.0, 12960000.0 * 12960000.0 * 2.0};

/* rate_hz to the power of 0, 1 or 2; 1 for negative powers. */
static double power_of(double rate_hz, int power)
{
    if (power <= 0) {
        return 1.0;
    }
    return (power == 1) ? rate_hz : davar_scale(rate_hz, rate_hz);
}

void davar_square_units(double rate_hz, double unit[])
{
    for (int k = 0; k < TERMS; k++) {
        unit[k] = davar_scale(factor[k], power_of(rate_hz, k - 2)) / power_of(rate_hz, 2 - k);
    }
}

void davar_plan_rate(davar_plan_t *plan, double rate_hz)
{
    if (davar_bits_of_double(plan->rate_hz) == davar_bits_of_double(rate_hz)) {
        return;
    }
    for (int k = 0; k < TERMS; k++) {
        const double square =
            davar_scale(factor[k], davar_scaled_to_double(scaled_of_float(plan->unit[k])));
        plan->root[k] = davar_root_of_quotient(davar_scale(square, power_of(rate_hz, k - 2)),
                                               power_of(rate_hz, 2 - k));
    }
    plan->white.unit = plan->root[WHITE];
    plan->rate_hz = rate_hz;
}

/* --- the window (5.5) --- */

uint8_t davar_fit_usable(const davar_result_t *result)
{
    uint8_t count = 0U;
    while ((count < result->tau_count) && (result->tau[count].differences > 0U) &&
           !davar_hops(&result->tau[count])) {
        count++;
    }
    return count;
}

/* Does every difference of the first `count` cluster sizes exist once and count fully: no gap, no
 * mirror image? */
static bool is_whole(const davar_result_t *result, int count)
{
    uint32_t lost = result->mirrored_samples | (result->chosen ? 1U : 0U);
    for (int t = 0; t < count; t++) {
        lost |= (result->window_samples + 1U - 2U * result->tau[t].m) ^ result->tau[t].differences;
    }
    return lost == 0U;
}

#define LONGEST (UINT32_C(1) << 31U) /* twice the differences, plus m, fit 32 bits */

scaled_t davar_fit_evidence(const davar_result_t *result)
{
    DAVAR_ASSERT((result->window_samples <= LONGEST) &&
                 (result->mirrored_samples <= (LONGEST - result->window_samples)));
    const scaled_t share = scaled_ratio(result->window_samples,
                                        result->window_samples + (2U * result->mirrored_samples));
    return result->chosen ? scaled_times(share, scaled_of_u32(7U, -4)) : share;
}

/* --- the degrees of freedom of a size, whatever the noise --- */

static double edf_of(const davar_result_t *result, const davar_adev_t *tau,
                     davar_coefficient_kind_t noise)
{
    return davar_hops(tau) ? davar_hop_edf(noise, tau->differences, tau->hops)
                           : davar_edf(noise, tau->m, result->window_samples);
}

DAVAR_RARE double davar_fit_kept(const davar_result_t *result, const davar_adev_t *tau)
{
    if (davar_hops(tau)) {
        return 1.0;
    }
    const double all = (double)(result->window_samples + 1U - (2U * tau->m));
    return (double)tau->differences / all * davar_scaled_to_double(davar_fit_evidence(result));
}

DAVAR_RARE double davar_edf_least(const davar_result_t *result, uint8_t t)
{
    const davar_adev_t *const tau = &result->tau[t];
    DAVAR_ASSERT((t < result->tau_count) && (tau->differences > 0U));
    double least = edf_of(result, tau, DAVAR_QUANTIZATION);
    for (int kind = DAVAR_ANGLE_RANDOM_WALK; kind <= DAVAR_RATE_RANDOM_WALK; kind++) {
        const double edf = edf_of(result, tau, (davar_coefficient_kind_t)kind);
        least = (edf < least) ? edf : least;
    }
    least *= davar_fit_kept(result, tau);
    return (least > 1.0) ? least : 1.0;
}

/* --- heavy tails (5.19) --- */

#define SLOPE 5U                                 /* kappa is k (1 + 5 k standard errors) */
#define EXCESS_BITS 24                           /* excess and kappa as 8.24 */
#define KAPPA_MOST (UINT32_C(80) << EXCESS_BITS) /* tails without a fourth moment have no kappa */
#define SQUARE_BITS 16                           /* its square, and spread */
#define GATE_WHITE 23U /* (1.2 standard errors)^2 times L: 24 (2 + spread) / 3 of variance */
#define GATE_FILTERED 12U
#define BLOCKS_TWO (UINT32_C(2) << EXCESS_BITS)
#define BLOCKS_GATE ((UINT32_C(1) << EXCESS_BITS) / 5U) /* 0.2: above that of Gaussian noise */

#define BITS_OF_1 UINT64_C(0x3FF0000000000000)
#define BITS_OF_INFINITY UINT64_C(0x7FF0000000000000)

/* value - least, at most KAPPA_MOST; 0: not above it, or unknown. */
static uint32_t above(double value, uint32_t least)
{
    const uint64_t bits = davar_bits_of_double(value);
    if ((bits <= BITS_OF_1) || (bits >= BITS_OF_INFINITY)) {
        return 0U;
    }
    const uint32_t whole = davar_scaled_to_fixed(scaled_of_double(value), EXCESS_BITS);
    const uint32_t excess = (whole > (least << EXCESS_BITS)) ? whole - (least << EXCESS_BITS) : 0U;
    return (excess < KAPPA_MOST) ? excess : KAPPA_MOST;
}

/* kappa of the noise before the filter, as 8.24, or 0 if the excess may be chance. A window reads
 * low in heavy tails, because it may hold none of their largest samples, so kappa grows faster than
 * the excess. */
static uint32_t kappa_of_window(const davar_plan_t *plan, const davar_result_t *result)
{
    const uint32_t excess = above(result->kurtosis, 3U);
    const scaled_t spread = scaled_of_float(plan->spread);
    const uint32_t square = davar_upper_product(excess, excess);
    const uint64_t chance =
        davar_multiply_u32(GATE_FILTERED, davar_scaled_to_fixed(spread, SQUARE_BITS)) +
        (GATE_WHITE << SQUARE_BITS);
    if (davar_multiply_u32(square, result->window_samples) <= chance) {
        return 0U;
    }
    const scaled_t error = davar_scaled_root(scaled_ratio(24U, result->window_samples));
    const scaled_t k = scaled_times(scaled_of_u32(excess, -EXCESS_BITS), spread);
    const scaled_t more = scaled_times(scaled_of_u32(SLOPE, 0), scaled_times(k, error));
    return davar_scaled_to_fixed(scaled_times(k, davar_scaled_plus(half_to_the(0), more)),
                                 EXCESS_BITS);
}

/* The same from the scatter of the detector's blocks: the mean square of independent samples
 * scatters by 1 + kappa / 2. It is a scatter of logarithms, to which the largest samples contribute
 * little, so in heavy tails kappa grows with its square. */
static uint32_t kappa_of_blocks(const davar_result_t *result)
{
    const uint32_t excess = above(result->dispersion, 1U);
    const uint32_t slope = (excess > BLOCKS_TWO) ? excess : BLOCKS_TWO;
    const uint64_t kappa = davar_multiply_u32(excess, slope) >> (uint32_t)EXCESS_BITS;
    const uint32_t bounded = (kappa < KAPPA_MOST) ? (uint32_t)kappa : KAPPA_MOST;
    return (excess > BLOCKS_GATE) ? bounded : 0U;
}

/* kappa / 2. Without moments the kurtosis is NaN. */
static float half_kappa_of(const davar_plan_t *plan, const davar_result_t *result)
{
    const bool has_moments = davar_bits_of_double(result->kurtosis) < BITS_OF_INFINITY;
    const uint32_t kappa = has_moments ? kappa_of_window(plan, result) : kappa_of_blocks(result);
    const uint32_t bounded = (kappa < KAPPA_MOST) ? kappa : KAPPA_MOST;
    return (kappa == 0U) ? 0.0F : scaled_to_float(scaled_of_u32(bounded, -1 - EXCESS_BITS));
}

static bool has_tails(const davar_plan_t *plan)
{
    return DAVAR_LAWS && (davar_bits_of_float(plan->half_kappa) != 0U);
}

/* What they add to 1 / edf. `inverse`: 1 / effective differences. */
static scaled_t added_by_tails(const davar_plan_t *plan, scaled_t inverse)
{
    return scaled_times(scaled_of_float(plan->half_kappa), inverse);
}

/* Differences + m / 2 (5.3), reduced for gaps and by the share of new evidence. */
static scaled_t effective(const davar_adev_t *tau, uint32_t window, scaled_t evidence)
{
    const uint32_t all = window + 1U - (2U * tau->m);
    const scaled_t differences = scaled_of_u32((2U * all) + tau->m, -1);
    return scaled_times(scaled_times(differences, scaled_ratio(tau->differences, all)), evidence);
}

static scaled_t at_least_one(scaled_t value)
{
    return (value.exponent < -31) ? half_to_the(0) : value;
}

static void plan_tau(davar_plan_t *plan, int t, scaled_t differences)
{
    scaled_t edf = at_least_one(scaled_times(scaled_of_float(plan->freedom[t]), differences));
    const scaled_t inverse = scaled_inverse(edf);
    scaled_t low;
    scaled_t high;
    if (has_tails(plan)) {
        const scaled_t tails = added_by_tails(plan, scaled_inverse(differences));
        edf = at_least_one(scaled_inverse(davar_scaled_plus(inverse, tails)));
    }
    davar_chi_square(edf, &low, &high);
    const scaled_t doubt = davar_scaled_plus(inverse, scaled_of_float(plan->doubtful[t]));
    plan->edf[t] = davar_scaled_to_double(edf);
    plan->white.root_edf[t] =
        davar_scaled_to_fixed(davar_scaled_root(scaled_inverse(doubt)), DAVAR_FIT_ROOT_BITS);
    plan->low[t] = scaled_to_float(davar_scaled_root(low));
    plan->white.high[t] = scaled_to_float(davar_scaled_root(high));
}

/* Odd, so never 0. One cluster size, or nearly equal ones, resolve no term: (5.4) then gives a
 * variance of 0, or below 0 by its inaccuracy. Such a sigma is unknown and becomes the largest. */
static uint32_t fixed_sigma(scaled_t sigma)
{
    const uint32_t fixed = davar_scaled_to_fixed(sigma, DAVAR_FIT_SHARE_BITS);
    return (((fixed - 1U) < DAVAR_FIT_SIGMA_MOST) ? fixed : DAVAR_FIT_SIGMA_MOST) | 1U;
}

/* One term next to white noise: its sigma, the factor of its upper limit, room = sqrt((1 + margin)
 * scale) (5.11), and the uncertainty that it adds to N^2 (5.10). */
static void plan_term(davar_plan_t *plan, int k, scaled_t of_white, scaled_t variance)
{
    const scaled_t sigma = davar_scaled_root(variance);
    const scaled_t scale = scaled_of_float(plan->scale[k]);
    const scaled_t margin =
        scaled_times(scaled_times(scaled_of_double(DAVAR_FIT_BOUND), sigma), scale);
    const scaled_t centre = scaled_of_float(plan->white.centre[k]);
    const scaled_t of_term = scaled_times(scaled_times(centre, centre), variance);
    const scaled_t half = scaled_times(half_to_the(1), davar_scaled_plus(of_white, of_term));
    plan->white.sigma[k] = fixed_sigma(sigma);
    plan->room[k] = scaled_to_float(
        davar_scaled_root(scaled_times(davar_scaled_plus(half_to_the(0), margin), scale)));
    plan->white.doubt[k] = davar_scaled_to_fixed(davar_scaled_root(half), NOISE_BITS);
}

/* Variance of an amplitude, from aligned values of 1 / effective differences and the uncertainty of
 * the cutoff. */
static scaled_t variance_of(const davar_plan_t *plan, int term, const scaled_t inverse[],
                            int32_t exponent)
{
    const int64_t sum = davar_aligned_sum(plan->variance[term], inverse, plan->white.count);
    const scaled_t variance =
        scaled_of_u64((sum > 0) ? (uint64_t)sum : 0U, exponent + plan->variance_exponent[term] -
                                                          (int32_t)DAVAR_FIT_FUNCTIONAL_BITS);
    return davar_scaled_plus(variance, scaled_of_float(plan->offset_variance[term]));
}

/* Heavy tails scatter all sizes together, in proportion to white noise. So they change the degrees
 * of freedom and nothing else (5.19). */
static void plan_window(davar_plan_t *plan, const davar_result_t *result)
{
    const scaled_t evidence = davar_fit_evidence(result);
    scaled_t inverse[DAVAR_TAUS_MAX];
    scaled_t low;
    scaled_t high;
    const int last = (int)davar_fit_usable(result) - 1; /* stands in for the sizes beyond it */
    for (int t = 0; t < plan->white.count; t++) {
        const davar_adev_t *const tau = &result->tau[(t < last) ? t : last];
        const scaled_t differences = effective(tau, result->window_samples, evidence);
        inverse[t] = scaled_inverse(differences);
        plan_tau(plan, t, differences);
    }
    const int32_t exponent = davar_align(inverse, plan->white.count);
    const scaled_t of_white = variance_of(plan, WHITE, inverse, exponent);
    scaled_t half = scaled_times(half_to_the(1), of_white);
    plan->white.white_tails = 0U;
    if (has_tails(plan)) {
        const scaled_t first = effective(&result->tau[0], result->window_samples, evidence);
        const scaled_t tails = added_by_tails(plan, scaled_inverse(first));
        half = davar_scaled_plus(half, tails);
        plan->white.white_tails = davar_scaled_to_fixed(tails, NOISE_BITS);
    }
    davar_chi_square(at_least_one(scaled_inverse(half)), &low, &high);
    for (int k = 0; k < TERMS; k++) {
        plan_term(plan, k, of_white, variance_of(plan, k, inverse, exponent));
    }
    plan->white.white_low = davar_scaled_to_fixed(low, NOISE_BITS);
    plan->white.white_high = scaled_to_float(davar_scaled_root(high));
}

void davar_fit_prepare_window(davar_plan_t *plan, const davar_result_t *result)
{
    const bool whole = is_whole(result, plan->white.count);
    const float half_kappa = DAVAR_LAWS ? half_kappa_of(plan, result) : 0.0F;
    if ((plan->white.window != result->window_samples) || !whole ||
        (davar_bits_of_float(plan->half_kappa) != davar_bits_of_float(half_kappa))) {
        plan->half_kappa = half_kappa;
        plan_window(plan, result);
        plan->white.window = whole ? result->window_samples : 0U;
    }
}

uint8_t davar_fit_prepare(davar_plan_t *plan, const davar_result_t *result)
{
    const uint8_t usable = davar_fit_usable(result);
    const uint8_t count = (usable < plan->sizes) ? usable : plan->sizes;
    if (count > 0U) {
        if (plan->white.count != count) {
            davar_plan_solve(plan, count);
        }
        davar_fit_prepare_window(plan, result);
    }
    return usable;
}
