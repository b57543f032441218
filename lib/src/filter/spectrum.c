/* davar - the spectrum after a filter. */
#include "filter/spectrum.h"
#include "davar/filter.h"

/* Frequencies from 0 to half the sample rate, a power of two. */
#define POINTS_LEAST 64U
#define POINTS_MOST 16384U

/* Energy of the response that does not count. */
#define FORGOTTEN 1e-6

/* Least power gain at frequency 0, over the largest that the coefficients allow. */
#define PASSED_LEAST 1e-20

complex_t davar_exponential(complex_t z)
{
    const double small = 1.0 / 256.0;
    complex_t sum = {1.0, 0.0};
    for (int k = 8; k >= 1; k--) {
        const complex_t step = {z.re * small / k, z.im * small / k};
        const complex_t product = complex_times(step, sum);
        sum = (complex_t){1.0 + product.re, product.im};
    }
    for (int k = 0; k < 8; k++) {
        sum = complex_times(sum, sum);
    }
    return sum;
}

/* --- the power gain --- */

uint32_t davar_filter_order(const double c[], uint32_t most)
{
    uint32_t order = most;
    while ((order > 0U) && davar_filter_is_zero(c[order])) {
        order--;
    }
    return order;
}

/* Squared size of sum c[k] z^k; 1 if every c[k] is 0. */
static double polynomial_power(const double c[], uint32_t count, complex_t z)
{
    const uint32_t order = davar_filter_order(c, count - 1U);
    complex_t sum = {c[order], 0.0};
    for (uint32_t k = order; k > 0U; k--) {
        sum = complex_times(sum, z);
        sum.re += c[k - 1U];
    }
    const double power = squared(sum.re) + squared(sum.im);
    return ((order == 0U) && davar_filter_is_zero(c[0])) ? 1.0 : power;
}

/* Power gain of the moving averages at half the angle `half`. */
static double averaging(const davar_filter_t *filter, complex_t half)
{
    complex_t power = {1.0, 0.0}; /* half^length */
    complex_t square_of = half;
    for (uint32_t n = filter->length; n > 0U; n >>= 1U) {
        power = ((n & 1U) != 0U) ? complex_times(power, square_of) : power;
        square_of = complex_times(square_of, square_of);
    }
    const double under = (double)filter->length * half.im;
    const double ratio = (squared(half.im) > 1e-24) ? squared(power.im / under) : 1.0;
    double gain = 1.0;
    for (uint32_t n = 0U; n < filter->averages; n++) {
        gain *= ratio;
    }
    return gain;
}

/* Power gain of the coefficients. */
static double ratio_of(const davar_filter_t *filter, complex_t half)
{
    const complex_t z = complex_times(half, half);
    return polynomial_power(filter->b, DAVAR_FILTER_ZEROS + 1U, z) /
           polynomial_power(filter->a, DAVAR_FILTER_POLES + 1U, z);
}

double davar_filter_gain(const davar_filter_t *filter, complex_t half)
{
    const double gain = ratio_of(filter, half);
    return (filter->averages > 0U) ? (gain * averaging(filter, half)) : gain;
}

static double gain_at_0(const davar_filter_t *filter)
{
    return davar_filter_gain(filter, (complex_t){1.0, 0.0});
}

/* --- the response in time --- */

/* The last samples of a response, the newest first. */
typedef struct {
    double output[DAVAR_FILTER_POLES];
} response_t;

/* Sample n of the response to 1, 0, 0, .. */
static double respond(const davar_filter_t *filter, response_t *past, uint32_t n)
{
    double next = (n <= DAVAR_FILTER_ZEROS) ? filter->b[n] : 0.0;
    for (uint32_t k = DAVAR_FILTER_POLES; k > 0U; k--) {
        next -= filter->a[k] * past->output[k - 1U];
        past->output[k - 1U] = (k > 1U) ? past->output[k - 2U] : next;
    }
    return next;
}

/* Samples, a power of two, in which the coefficients forget a sample: as many again hold less than
 * FORGOTTEN of the energy. 0: unstable, or more than DAVAR_FILTER_SPAN. */
static uint32_t memory_of(const davar_filter_t *filter)
{
    response_t past = {{0.0}};
    double before = 0.0;
    uint32_t n = 0U;
    for (uint32_t memory = 1U; memory <= DAVAR_FILTER_SPAN; memory *= 2U) {
        double energy = 0.0;
        for (; n < (2U * memory); n++) {
            const double h = respond(filter, &past, n);
            (*((n < memory) ? &before : &energy)) += squared(h);
        }
        if ((memory > DAVAR_FILTER_ZEROS) && (energy <= (FORGOTTEN * before))) {
            return memory;
        }
        before += energy;
    }
    return 0U;
}

/* --- the band --- */

uint32_t davar_band_points(const davar_filter_t *filter, double samples)
{
    const double span = (double)filter->averages * (double)filter->length;
    double least = 4.0 * samples;
    least = (least > (4.0 * span)) ? least : (4.0 * span);
    const double memory = 2.0 * (double)memory_of(filter);
    least = (least > memory) ? least : memory;
    uint32_t points = POINTS_LEAST;
    while ((points < POINTS_MOST) && ((double)points < least)) {
        points *= 2U;
    }
    return points;
}

/* Another cutoff stretches the sine of half the angle where the spectrum is that of poles alone, of
 * one pole exactly, and the angle itself where there are as many zeros. The share of the sine. */
static double sine_share(const davar_filter_t *filter)
{
    const double zeros = (double)davar_filter_order(filter->b, DAVAR_FILTER_ZEROS);
    const double poles = (double)davar_filter_order(filter->a, DAVAR_FILTER_POLES);
    return (zeros < poles) ? (1.0 - zeros / poles) : 0.0;
}

DAVAR_RARE void davar_band_start(band_t *band, const davar_filter_t *filter, uint32_t points,
                                 double stretch)
{
    const bool is_exact = !(stretch < 1.0) && !(stretch > 1.0);
    const double step = SPECTRUM_PI / (2.0 * (double)points);
    band->filter = filter;
    band->exact = turn_by(step);
    band->half = turn_by(step / stretch);
    band->sine = 1.0 / stretch;
    band->share = is_exact ? 0.0 : sine_share(filter);
    band->zero = gain_at_0(filter);
}

/* Product of a polynomial at a real z and at 1 / z: its power where the sine is above 1. */
static double power_beyond(const double c[], uint32_t count, double z)
{
    const uint32_t order = davar_filter_order(c, count - 1U);
    double at = 0.0;
    double at_inverse = 0.0;
    for (uint32_t k = 0U; k <= order; k++) {
        at = (at * z) + c[order - k];
        at_inverse = (at_inverse / z) + c[order - k];
    }
    return at * at_inverse;
}

/* Power gain of the coefficients where the sine of half the angle is `sine`. */
static double gain_by_sine(const davar_filter_t *filter, double sine)
{
    const double square = squared(sine);
    if (square <= 1.0) {
        return ratio_of(filter, (complex_t){davar_root(1.0 - square), sine});
    }
    const double cosine = 1.0 - (2.0 * square); /* of the angle, below -1 */
    const double z = cosine + davar_root(squared(cosine) - 1.0);
    const double ratio = power_beyond(filter->b, DAVAR_FILTER_ZEROS + 1U, z) /
                         power_beyond(filter->a, DAVAR_FILTER_POLES + 1U, z);
    return (ratio > 0.0) ? ratio : 0.0; /* a single zero at half the rate changes its sign */
}

double davar_band_next(band_t *band)
{
    const davar_filter_t *const filter = band->filter;
    double gain = ratio_of(filter, band->half.now);
    if (band->share > 0.0) {
        const double by_sine = gain_by_sine(filter, band->sine * band->exact.now.im);
        gain += band->share * (by_sine - gain);
    }
    const double averaged = (filter->averages > 0U) ? averaging(filter, band->exact.now) : 1.0;
    turn_on(&band->half);
    turn_on(&band->exact);
    return gain * averaged / band->zero;
}

DAVAR_RARE void davar_filter_scatter(const davar_filter_t *filter, double *variance, double *step)
{
    const uint32_t points = davar_band_points(filter, 1.0);
    band_t band;
    turn_t half = turn_by(SPECTRUM_PI / (2.0 * (double)points));
    davar_band_start(&band, filter, points, 1.0);
    *variance = 0.0;
    *step = 0.0;
    for (uint32_t p = 0U; p < points; p++) {
        const double share = davar_band_next(&band) / (double)points;
        *variance += share;
        *step += share * 2.0 * squared(half.now.im);
        turn_on(&half);
    }
}

/* --- what is public --- */

bool davar_filter_passes_all(const davar_filter_t *filter)
{
    return (davar_filter_order(filter->b, DAVAR_FILTER_ZEROS) == 0U) &&
           (davar_filter_order(filter->a, DAVAR_FILTER_POLES) == 0U) && (filter->averages == 0U);
}

static bool is_in(double low, double value, double high)
{
    return (value >= low) && (value <= high);
}

/* Sum of the sizes; NaN if one is. */
static double sizes_of(const double c[], uint32_t count)
{
    double sum = 0.0;
    for (uint32_t k = 0U; k < count; k++) {
        sum += (c[k] < 0.0) ? -c[k] : c[k];
    }
    return sum;
}

/* Is the denominator 1 + a[1] z + .., or absent? */
static bool is_denominator(const double a[])
{
    const double sizes = sizes_of(&a[1], DAVAR_FILTER_POLES);
    return (is_in(1.0, a[0], 1.0) && is_in(0.0, sizes, 1e6)) ||
           (is_in(0.0, a[0], 0.0) && is_in(0.0, sizes, 0.0));
}

/* Is the response stable, soon forgotten, and not 0 at frequency 0? */
static bool is_response(const davar_filter_t *filter, double sizes)
{
    const double zero = polynomial_power(filter->b, DAVAR_FILTER_ZEROS + 1U, (complex_t){1.0, 0.0});
    return is_in(1e-9, sizes, 1e9) && (zero > (PASSED_LEAST * squared(sizes))) &&
           (memory_of(filter) > 0U);
}

static bool are_coefficients(const davar_filter_t *filter)
{
    const double sizes = sizes_of(filter->b, DAVAR_FILTER_ZEROS + 1U);
    const bool is_absent =
        is_in(0.0, sizes, 0.0) && (davar_filter_order(filter->a, DAVAR_FILTER_POLES) == 0U);
    return is_denominator(filter->a) && (is_absent || is_response(filter, sizes));
}

/* Counts and averages. */
static bool are_samples(const davar_filter_t *filter)
{
    const uint32_t span = (uint32_t)filter->averages * filter->length;
    const bool is_summed = (filter->summed > 1U);
    return (filter->averages <= 8U) && (span <= DAVAR_FILTER_SPAN) &&
           ((filter->averages == 0U) || (span > 0U)) &&
           (!is_summed || (is_in(1e-9, filter->count_variance, 1e9) &&
                           is_in(0.0, filter->count_step, 2.0 * filter->count_variance)));
}

DAVAR_RARE bool davar_filter_is_valid(const davar_filter_t *filter)
{
    return are_coefficients(filter) && are_samples(filter) &&
           is_in(0.0, filter->uncertainty, 0.5) && is_in(0.0, filter->level, 0.5);
}

void davar_filter_assert(const davar_filter_t *filter)
{
    DAVAR_ASSERT(davar_filter_is_valid(filter));
    (void)filter;
}

DAVAR_RARE double davar_filter_power(const davar_filter_t *filter, double frequency)
{
    davar_filter_assert(filter);
    DAVAR_ASSERT((frequency >= 0.0) && (frequency <= 0.5));
    return davar_filter_gain(filter, davar_exponential((complex_t){0.0, SPECTRUM_PI * frequency})) /
           gain_at_0(filter);
}
