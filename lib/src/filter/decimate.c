/* davar - every n-th sample of a filter is a filter again, DESIGN (5.21) (5.22): poles to the power
 * of n, and the numerator of the same autocovariance. */
#include "filter/parts.h"
#include "filter/spectrum.h"

/* Frequencies of the spectrum whose autocovariance is read: twice the lags that can be there. */
#define CIRCLE (2U * (DAVAR_FILTER_ZEROS + 1U))

#define ZEROS 15U /* after decimation, at most */

#define ROUNDS 1000U /* rows of a factor; a zero of size r is wrong by r^2000 */

/* --- poles --- */

/* Sums of the n-th powers of the poles, for n = step, 2 step, .. */
static void sum_powers(const double a[], uint32_t poles, uint32_t step, double sums[])
{
    double past[DAVAR_FILTER_POLES + 1U] = {0.0}; /* past[k]: of n - k */
    for (uint32_t n = 1U; n <= (poles * step); n++) {
        double sum = (n <= poles) ? (-(double)n * a[n]) : 0.0;
        for (uint32_t k = poles; k > 0U; k--) {
            past[k] = past[k - 1U];
        }
        for (uint32_t k = 1U; (k <= poles) && (k < n); k++) {
            sum -= a[k] * past[k];
        }
        past[0] = sum;
        if ((n % step) == 0U) {
            sums[n / step] = sum;
        }
    }
}

/* Replaces every pole by its power, after Newton's identities. */
static void raise_poles(double a[], uint32_t poles, uint32_t power)
{
    double sums[DAVAR_FILTER_POLES + 1U] = {0.0};
    sum_powers(a, poles, power, sums);
    for (uint32_t j = 1U; j <= poles; j++) {
        double sum = sums[j];
        for (uint32_t k = 1U; k < j; k++) {
            sum += a[k] * sums[j - k];
        }
        a[j] = -sum / (double)j;
    }
}

/* --- the numerator --- */

/* Autocovariance of the numerator after decimation, at lags 0 to `zeros`: the spectrum of the
 * aliases over that of the new poles, around the circle. */
static void fold(const davar_filter_t *before, const davar_filter_t *poles, uint32_t step,
                 uint32_t zeros, double lag[])
{
    const double angle = SPECTRUM_PI / (double)CIRCLE; /* half of a step around the circle */
    for (uint32_t j = 0U; j <= zeros; j++) {
        lag[j] = 0.0;
    }
    for (uint32_t i = 0U; i < CIRCLE; i++) {
        const double half = angle * (double)i;
        double sum = 0.0;
        for (uint32_t alias = 0U; alias < step; alias++) {
            const double at = (half + (SPECTRUM_PI * (double)alias)) / (double)step;
            sum += davar_filter_gain(before, davar_exponential((complex_t){0.0, at}));
        }
        /* poles alone: the gain is 1 over theirs */
        const complex_t here = davar_exponential((complex_t){0.0, half});
        const double share = sum / davar_filter_gain(poles, here) / (double)CIRCLE;
        const complex_t turn = complex_times(here, here);
        complex_t now = {1.0, 0.0};
        for (uint32_t j = 0U; j <= zeros; j++) {
            lag[j] += share * now.re;
            now = complex_times(now, turn);
        }
    }
}

/* The numerator of an autocovariance whose zeros are within the circle: the rows of the Cholesky
 * factor of its matrix converge to it, after Bauer 1955. */
static void factor_lags(const double lag[], uint32_t zeros, double b[])
{
    double row[ZEROS + 1U][ZEROS + 1U] = {{0.0}}; /* of place n modulo their number, from the end */
    const uint32_t rows = zeros + 1U;
    for (uint32_t n = 0U; n < ROUNDS; n++) {
        double *const now = row[n % rows];
        for (uint32_t k = (n < zeros) ? n : zeros; k > 0U; k--) {
            const double *const before = row[(n - k) % rows];
            double sum = lag[k];
            for (uint32_t j = k + 1U; j <= zeros; j++) {
                sum -= now[j] * before[j - k];
            }
            now[k] = sum / before[0];
        }
        double rest = lag[0];
        for (uint32_t j = 1U; j <= zeros; j++) {
            rest -= now[j] * now[j];
        }
        now[0] = davar_root(rest);
        for (uint32_t k = 0U; k <= zeros; k++) {
            b[k] = now[k];
        }
    }
}

/* --- decimation --- */

/* Moving averages without the limit of their length, then every length-th sample. */
static void decimate(davar_filter_t *filter, uint32_t order, uint32_t length)
{
    double lag[ZEROS + 1U];
    double b[ZEROS + 1U];
    davar_filter_t before = *filter;
    davar_filter_t poles = {.b = {1.0}};
    const uint32_t pole_count = davar_filter_order(filter->a, DAVAR_FILTER_POLES);
    const uint32_t span = davar_filter_order(filter->b, DAVAR_FILTER_ZEROS) +
                          (order * (length - 1U)) + (pole_count * (length - 1U));
    const uint32_t zeros = span / length;
    if ((filter->averages > 0U) || (zeros > ZEROS)) {
        davar_filter_forbid(filter);
        return;
    }
    before.averages = (uint8_t)order;
    before.length = (uint16_t)length;
    for (uint32_t k = 0U; k <= pole_count; k++) {
        poles.a[k] = filter->a[k];
    }
    raise_poles(poles.a, pole_count, length);
    fold(&before, &poles, length, zeros, lag);
    factor_lags(lag, zeros, b);
    const davar_filter_t after = {.uncertainty = filter->uncertainty, .level = filter->level};
    *filter = after;
    davar_filter_append(filter, b, zeros, poles.a, pole_count);
}

DAVAR_RARE void davar_filter_cic(davar_filter_t *filter, unsigned order, unsigned length)
{
    if (davar_filter_may_follow(filter, (order >= 1U) && (order <= 8U) && (length >= 1U) &&
                                            (length <= 4096U)) &&
        (length > 1U)) {
        decimate(filter, order, length);
    }
}

DAVAR_RARE void davar_filter_sum(davar_filter_t *filter, unsigned length)
{
    if (davar_filter_may_follow(filter, (length >= 1U) && (length <= 4096U)) && (length > 1U)) {
        double variance;
        double step;
        davar_filter_scatter(filter, &variance, &step);
        decimate(filter, 1U, length);
        filter->count_variance = variance;
        filter->count_step = step;
        filter->summed = (uint16_t)length;
    }
}
