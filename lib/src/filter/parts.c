/* davar - the coefficients of what data sheets and firmware say is in series, DESIGN (5.20). */
#include "filter/parts.h"
#include "davar/filter.h"
#include "filter/spectrum.h"

#define ROOT_HALF 0.70710678118654752

void davar_filter_forbid(davar_filter_t *filter)
{
    filter->a[0] = -1.0;
}

/* False, and an invalid filter, if a part is out of its range, or after a sum. */
bool davar_filter_may_follow(davar_filter_t *filter, bool is_in_range)
{
    const bool may = is_in_range && !(filter->a[0] < 0.0) && (filter->summed <= 1U);
    if (!may) {
        davar_filter_forbid(filter);
    }
    return may;
}

/* whole *= part, if the product has at most `most` as its order. A whole of zeros is 1. */
static bool multiply_polynomial(double whole[], uint32_t most, const double part[],
                                uint32_t part_order)
{
    const uint32_t order = davar_filter_order(whole, most);
    if ((order + part_order) > most) {
        return false;
    }
    if ((order == 0U) && davar_filter_is_zero(whole[0])) {
        whole[0] = 1.0;
    }
    for (uint32_t i = order + part_order + 1U; i > 0U; i--) {
        const uint32_t at = i - 1U;
        double sum = 0.0;
        for (uint32_t k = 0U; k <= part_order; k++) {
            sum += ((k <= at) && ((at - k) <= order)) ? (part[k] * whole[at - k]) : 0.0;
        }
        whole[at] = sum;
    }
    return true;
}

void davar_filter_append(davar_filter_t *filter, const double b[], uint32_t zeros, const double a[],
                         uint32_t poles)
{
    const double one = 1.0;
    const bool has_b = multiply_polynomial(filter->b, DAVAR_FILTER_ZEROS, b, zeros);
    const bool has_a =
        multiply_polynomial(filter->a, DAVAR_FILTER_POLES, (poles > 0U) ? a : &one, poles);
    if (!has_b || !has_a) {
        davar_filter_forbid(filter);
    }
}

void davar_filter_ba(davar_filter_t *filter, const double *b, unsigned b_count, const double *a,
                     unsigned a_count)
{
    const double one = 1.0;
    const bool has_a = (a_count > 0U);
    const bool counts = (b_count >= 1U) && (b_count <= (DAVAR_FILTER_ZEROS + 1U)) &&
                        (a_count <= (DAVAR_FILTER_POLES + 1U)) &&
                        (!has_a || ((a[0] >= 1.0) && (a[0] <= 1.0)));
    if (davar_filter_may_follow(filter, counts)) {
        davar_filter_append(filter, b, b_count - 1U, has_a ? a : &one, has_a ? (a_count - 1U) : 0U);
    }
}

/* --- an analogue low-pass, sampled --- */

/* The numerator whose autocovariance at the lags 0 and 1 is this. */
static void factor_pair(double at_0, double at_1, double b[2])
{
    const double rest = squared(at_0) - 4.0 * squared(at_1);
    b[0] = davar_root(0.5 * (at_0 + davar_root(rest)));
    b[1] = at_1 / b[0];
}

/* Poles at z and its conjugate, from the autocovariance Re((1 - i) z^lag) of the samples. */
static void sample_two_poles(complex_t z, double b[2], double a[3])
{
    const complex_t z2 = complex_times(z, z);
    const complex_t z3 = complex_times(z2, z);
    const double r[4] = {1.0, z.re + z.im, z2.re + z2.im, z3.re + z3.im};
    a[0] = 1.0;
    a[1] = -2.0 * z.re;
    a[2] = squared(z.re) + squared(z.im);
    double lag[2] = {0.0, 0.0};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            const int apart = i - j;
            const int next = 1 + apart;
            lag[0] += a[i] * a[j] * r[(apart < 0) ? -apart : apart];
            lag[1] += a[i] * a[j] * r[(next < 0) ? -next : next];
        }
    }
    factor_pair(lag[0], lag[1], b);
}

/* By how much more than the cutoff the axis of the sampled spectrum moves: of one pole x coth x, x
 * half its angle, exactly; of two, within 10 % where it matters. */
static double axis_by_cutoff(double cutoff, double angle, unsigned poles)
{
    const double decay = davar_exponential((complex_t){-angle, 0.0}).re;
    const double beyond = (cutoff > 0.3) ? (cutoff - 0.3) : 0.0;
    return (poles == 1U) ? (0.5 * angle * (1.0 + decay) / (1.0 - decay))
                         : (1.0 + 60.0 * squared(beyond));
}

DAVAR_RARE void davar_filter_low_pass(davar_filter_t *filter, double cutoff, unsigned poles,
                                      double uncertainty)
{
    const double angle = 2.0 * SPECTRUM_PI * cutoff;
    const bool is_first = davar_filter_passes_all(filter);
    if (!davar_filter_may_follow(filter, is_first && (cutoff > 0.0) && (cutoff <= 4.0) &&
                                             (poles >= 1U) && (poles <= 2U))) {
        return;
    }
    const double stretched = uncertainty * axis_by_cutoff(cutoff, angle, poles);
    filter->uncertainty = ((uncertainty <= 0.5) && (stretched > 0.5)) ? 0.5 : stretched;
    if (poles == 1U) {
        const double b = 1.0;
        const double a[2] = {1.0, -davar_exponential((complex_t){-angle, 0.0}).re};
        davar_filter_append(filter, &b, 0U, a, 1U);
    } else {
        const double part = angle * ROOT_HALF;
        double b[2];
        double a[3];
        sample_two_poles(davar_exponential((complex_t){-part, part}), b, a);
        davar_filter_append(filter, b, 1U, a, 2U);
    }
}

/* --- digital parts --- */

DAVAR_RARE void davar_filter_biquad(davar_filter_t *filter, double cutoff)
{
    if (!davar_filter_may_follow(filter, (cutoff > 0.0) && (cutoff < 0.5))) {
        return;
    }
    const complex_t half = davar_exponential((complex_t){0.0, SPECTRUM_PI * cutoff});
    const double tangent = half.im / half.re;
    const double square = squared(tangent);
    const double inverse = 1.0 / (1.0 + (2.0 * ROOT_HALF * tangent) + square);
    const double b[3] = {square * inverse, 2.0 * square * inverse, square * inverse};
    const double a[3] = {1.0, 2.0 * (square - 1.0) * inverse,
                         (1.0 - (2.0 * ROOT_HALF * tangent) + square) * inverse};
    davar_filter_append(filter, b, 2U, a, 2U);
}

DAVAR_RARE void davar_filter_pt1(davar_filter_t *filter, double cutoff)
{
    if (!davar_filter_may_follow(filter, (cutoff > 0.0) && (cutoff <= 4.0))) {
        return;
    }
    const double angle = 2.0 * SPECTRUM_PI * cutoff;
    const double k = angle / (1.0 + angle);
    const double a[2] = {1.0, k - 1.0};
    davar_filter_append(filter, &k, 0U, a, 1U);
}

DAVAR_RARE void davar_filter_notch(davar_filter_t *filter, double centre, double q)
{
    if (!davar_filter_may_follow(filter,
                                 (centre > 0.0) && (centre < 0.5) && (q >= 0.1) && (q <= 100.0))) {
        return;
    }
    const complex_t turn = davar_exponential((complex_t){0.0, 2.0 * SPECTRUM_PI * centre});
    const double alpha = turn.im / (2.0 * q);
    const double inverse = 1.0 / (1.0 + alpha);
    const double middle = -2.0 * turn.re * inverse;
    const double b[3] = {inverse, middle, inverse};
    const double a[3] = {1.0, middle, (1.0 - alpha) * inverse};
    davar_filter_append(filter, b, 2U, a, 2U);
}

/* As coefficients, which a later decimation needs. */
static void append_averages(davar_filter_t *filter, unsigned order, unsigned length)
{
    double b[DAVAR_FILTER_ZEROS + 1U];
    for (uint32_t k = 0U; k < length; k++) {
        b[k] = 1.0 / (double)length;
    }
    for (uint32_t i = 0U; i < order; i++) {
        davar_filter_append(filter, b, length - 1U, NULL, 0U);
    }
}

DAVAR_RARE void davar_filter_average(davar_filter_t *filter, unsigned order, unsigned length)
{
    const bool counts =
        (order >= 1U) && (order <= 8U) && (length >= 1U) && (length <= (DAVAR_FILTER_SPAN / order));
    if (!davar_filter_may_follow(filter, counts)) {
        return;
    }
    const uint32_t zeros =
        davar_filter_order(filter->b, DAVAR_FILTER_ZEROS) + (order * (length - 1U));
    if (zeros <= DAVAR_FILTER_ZEROS) {
        append_averages(filter, order, length);
    } else if (filter->averages == 0U) {
        filter->averages = (uint8_t)order;
        filter->length = (uint16_t)length;
    } else {
        davar_filter_forbid(filter);
    }
}
