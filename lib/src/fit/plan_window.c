/* davar - what a fit needs of the window's length and of the rate, DESIGN (5.5) (1.2): intervals' factors, standard errors, doubts,
 * units. In integers, as the short cut that uses them (5.14). */
#include "fit/noise.h"
#include "fit/plan.h"
#include "number/aligned.h"

/* 2^-bits */
static scaled_t half_to_the(int32_t bits)
{
    const scaled_t scaled = {SCALED_TOP, -31 - bits};
    return scaled;
}

static scaled_t scaled_ratio(uint32_t dividend, uint32_t divisor)
{
    return scaled_times(scaled_of_u32(dividend, 0), scaled_inverse(scaled_of_u32(divisor, 0)));
}

/* --- the rate ---------------------------------------------------------------------------------------------------------- */

/* (1.2): factor * rate^(k - 2), in doubles and correctly rounded: two rates that differ in the last bit give results that differ no
 * more. */
static const double factor[] = {1.0 / 3.0, 3600.0, 3600.0 * 3600.0 * 2.2661800709135971 /* pi / (2 ln 2) */,
                                216000.0 * 216000.0 * 3.0, 12960000.0 * 12960000.0 * 2.0};

/* 1 for a power that is not above 0. */
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
    for (int k = 0; k < TERMS; k++) {
        const double square = davar_scale(factor[k], scaled_to_double(scaled_of_float(plan->unit[k])));
        plan->root[k] = davar_root_of_quotient(davar_scale(square, power_of(rate_hz, k - 2)), power_of(rate_hz, 2 - k));
    }
    plan->rate_hz = rate_hz;
}

/* --- the window (5.5) -------------------------------------------------------------------------------------------- */

uint8_t davar_fit_usable(const davar_result_t *result)
{
    uint8_t count = 0U;
    while ((count < result->tau_count) && (result->tau[count].differences > 0U)) {
        count++;
    }
    return count;
}

/* Policy glr chose this window by what is in it (10.14): it left out most of what it holds to be of one variance, because it was not
 * quite alike; or it has just cut the window, because so few samples were loud or quiet enough. */
static bool is_chosen(const davar_result_t *result)
{
    return result->young || (result->cut_age_samples > (2U * result->window_samples));
}

/* Every difference that the window could hold is there once, at the first `count` cluster sizes, and counts: no gap, no mirror. */
static bool is_whole(const davar_result_t *result, int count)
{
    uint32_t lost = result->mirrored_samples | (is_chosen(result) ? 1U : 0U);
    for (int t = 0; t < count; t++) {
        lost |= (result->window_samples + 1U - 2U * result->tau[t].m) ^ result->tau[t].differences;
    }
    return lost == 0U;
}

scaled_t davar_fit_evidence(const davar_result_t *result)
{
    const scaled_t share =
        scaled_ratio(result->window_samples, result->window_samples + (2U * result->mirrored_samples));
    return is_chosen(result) ? scaled_times(share, scaled_of_u32(7U, -4)) : share;
}

/* How many differences of a window without a gap, and none mirrored, know as much (5.3). */
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

static void plan_tau(davar_plan_t *plan, int t, scaled_t freedom)
{
    const scaled_t edf = at_least_one(freedom);
    scaled_t low;
    scaled_t high;
    davar_chi_square(edf, &low, &high);
    plan->edf[t] = scaled_to_double(edf);
    plan->root_edf[t] = scaled_to_fixed(scaled_root(edf), DAVAR_FIT_ROOT_BITS);
    plan->low[t] = scaled_to_float(scaled_root(low));
    plan->high[t] = scaled_to_float(scaled_root(high));
}

static void plan_white(davar_plan_t *plan, scaled_t variance)
{
    scaled_t low;
    scaled_t high;
    davar_chi_square(at_least_one(scaled_times(half_to_the(-1), scaled_inverse(variance))), &low, &high);
    plan->white_low = scaled_to_fixed(low, NOISE_BITS);
    plan->white_high = scaled_to_float(scaled_root(high));
}

/* Odd, so never 0. Nearly equal cluster sizes, or one alone, show no term: then what (5.4) makes of their variances is 0, or less
 * by its own inaccuracy. */
static uint32_t fixed_sigma(scaled_t sigma)
{
    const uint32_t fixed = scaled_to_fixed(sigma, DAVAR_FIT_SHARE_BITS);
    return (((fixed - 1U) < DAVAR_FIT_SIGMA_MOST) ? fixed : DAVAR_FIT_SIGMA_MOST) | 1U; /* 0: unknown */
}

/* The bound of an absent term: room = sqrt((1 + margin) scale), see (5.11). */
static void plan_term(davar_plan_t *plan, int k, scaled_t of_white, scaled_t variance)
{
    const scaled_t sigma = (variance.mantissa != 0U) ? scaled_root(variance) : variance;
    const scaled_t scale = scaled_of_float(plan->scale[k]);
    const scaled_t margin = scaled_times(scaled_times(scaled_of_double(DAVAR_FIT_BOUND), sigma), scale);
    const scaled_t centre = scaled_of_float(plan->centre[k]);
    const scaled_t of_term = scaled_times(scaled_times(centre, centre), variance);
    const scaled_t half = scaled_times(half_to_the(1), scaled_plus(of_white, of_term));
    plan->sigma[k] = fixed_sigma(sigma);
    plan->room[k] = scaled_to_float(scaled_root(scaled_times(scaled_plus(half_to_the(0), margin), scale)));
    plan->doubt[k] = scaled_to_fixed(scaled_root(half), NOISE_BITS);
}

/* Of an amplitude, from 1 / effective differences, aligned. */
static scaled_t variance_of(const davar_plan_t *plan, int term, const scaled_t inverse[], int32_t exponent)
{
    const uint64_t sum = davar_aligned_sum(plan->variance[term], inverse, plan->count);
    return scaled_of_u64(sum, exponent + plan->variance_exponent[term] - (int32_t)DAVAR_FIT_FUNCTIONAL_BITS);
}

static void plan_window(davar_plan_t *plan, const davar_result_t *result)
{
    const scaled_t evidence = davar_fit_evidence(result);
    scaled_t inverse[DAVAR_TAUS_MAX];
    for (int t = 0; t < plan->count; t++) {
        const scaled_t differences = effective(&result->tau[t], result->window_samples, evidence);
        plan_tau(plan, t, scaled_times(scaled_of_float(plan->freedom[t]), differences));
        inverse[t] = scaled_inverse(differences);
    }
    const int32_t exponent = davar_align(inverse, plan->count);
    const scaled_t of_white = variance_of(plan, WHITE, inverse, exponent);
    plan_white(plan, of_white);
    for (int k = 0; k < TERMS; k++) {
        plan_term(plan, k, of_white, variance_of(plan, k, inverse, exponent));
    }
}

void davar_fit_prepare_window(davar_plan_t *plan, const davar_result_t *result)
{
    const bool whole = is_whole(result, plan->count);
    if ((plan->window != result->window_samples) || !whole) {
        plan_window(plan, result);
        plan->window = whole ? result->window_samples : 0U;
    }
}
