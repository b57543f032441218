/* davar - degrees of freedom per noise kind and chi-square limits, DESIGN (5.1) (5.2) (5.3) (5.8)
 * (11.6).
 * The constants were fitted to exact values; tests/unit/test_edf.c compares both. */
#include "davar/fit.h"

#include "fit/plan.h"
#include "number/real.h"

DAVAR_APART static double at_least(double floor, double value)
{
    return (value > floor) ? value : floor;
}

DAVAR_APART DAVAR_RARE double davar_noise_white_weight(double m)
{
    return 12.0 * m / (8.0 * m * m + 10.0);
}

DAVAR_RARE double davar_noise_edf(davar_coefficient_kind_t noise, double m, double differences)
{
    const double n = differences;
    double edf;
    switch (noise) {
    case DAVAR_QUANTIZATION: /* correlation 1, -4/6 and 1/6 at lags 0, m and 2 m; 0 elsewhere */
        edf = 36.0 * n * n /
              (36.0 * n + 32.0 * at_least(0.0, n - m) + 2.0 * at_least(0.0, n - 2.0 * m));
        break;
    case DAVAR_ANGLE_RANDOM_WALK:
        edf = davar_noise_white_weight(m) * (n + 0.5 * m);
        break;
    case DAVAR_BIAS_INSTABILITY:
        edf = 1.167 * (n / m + 0.5) * (m * m * m / (m * m * m + 1.0 / 3.0));
        break;
    case DAVAR_RATE_RANDOM_WALK:
    case DAVAR_RATE_RAMP:
    case DAVAR_COEFFICIENT_COUNT:
    default:
        edf = 0.927 * (n / m + 0.36);
        break;
    }
    return at_least(1.0, edf);
}

/* --- differences at hops (11.6) --- */

#define HOP_LAGS 8U /* the table has so many lags per cluster, and ends at two clusters */
#define HOP_BITS 14U
#define HOP_SQUARE_BITS 20U

/* Twice the sum of the squared correlations of flicker from two clusters on, per lag of a cluster:
 * 0.0188. */
#define FLICKER_TAIL UINT64_C(19713)

/* Correlation of two differences whose distance is `lag` eighths of a cluster, as 1.14. */
static int32_t hop_correlation(davar_coefficient_kind_t noise, uint32_t lag)
{
    static const int16_t flicker[2U * HOP_LAGS] = {16384, 15457, 13449, 10813, 7810,  4651,
                                                   1534,  -1316, -3554, -4626, -5008, -4965,
                                                   -4631, -4101, -3457, -2778};
    const int32_t i = (int32_t)lag;
    switch (noise) {
    case DAVAR_QUANTIZATION: /* 1/6 at two clusters: see the sum */
        return (lag == HOP_LAGS) ? -10923 : 0;
    case DAVAR_ANGLE_RANDOM_WALK:
        return (lag < HOP_LAGS) ? (16384 - (3072 * i)) : (1024 * (i - 16));
    case DAVAR_BIAS_INSTABILITY:
        return flicker[lag];
    case DAVAR_RATE_RANDOM_WALK:
    case DAVAR_RATE_RAMP:
    case DAVAR_COEFFICIENT_COUNT:
    default:
        return (lag < HOP_LAGS) ? (16384 + (((24 * i) - 384) * i * i))
                                : (8 * (16 - i) * (16 - i) * (16 - i));
    }
}

/* Twice the squared correlation per pair of differences that are two clusters or more apart, as
 * 0.20. */
static uint64_t hop_tail(davar_coefficient_kind_t noise, uint32_t lags)
{
    if (noise == DAVAR_QUANTIZATION) {
        return UINT64_C(58254); /* 2 / 36, at two clusters only */
    }
    return (noise == DAVAR_BIAS_INSTABILITY) ? (FLICKER_TAIL * lags) : 0U;
}

DAVAR_RARE double davar_hop_edf(davar_coefficient_kind_t noise, uint32_t differences, uint32_t lags)
{
    const uint32_t n = differences;
    const uint32_t end = (n < (2U * lags)) ? n : (2U * lags);
    uint32_t squares = 0U;
    uint32_t moments = 0U; /* each square times its lag; below 2^30 */
    for (uint32_t i = 1U; i < end; i++) {
        const int32_t r = hop_correlation(noise, i * (HOP_LAGS / lags));
        const uint32_t square = (uint32_t)(r * r) >> ((2U * HOP_BITS) - HOP_SQUARE_BITS);
        squares += square;
        moments += i * square;
    }
    const uint64_t pairs = davar_multiply_u32(n, squares) - moments;
    const uint64_t distant = davar_scale_u64(hop_tail(noise, lags), n - end);
    const uint64_t all = ((uint64_t)n << HOP_SQUARE_BITS) + (2U * pairs) + distant;
    return davar_divide(davar_double_of_u64(davar_multiply_u32(n, n) << HOP_SQUARE_BITS),
                        davar_double_of_u64(all));
}

/* --- for every noise --- */

DAVAR_RARE double davar_edf(davar_coefficient_kind_t noise, uint32_t m, uint32_t window)
{
    DAVAR_ASSERT((m >= 1U) && (window / 2U >= m));
    return davar_noise_edf(noise, (double)m, (double)window - 2.0 * (double)m + 1.0);
}

/* The kernel of the long size has three jumps, +1 -2 +1. The triangle of the short one covers each
 * of them, and two at once if the sizes differ by less than 2:1. */
DAVAR_RARE double davar_noise_white_overlap(double m_short, double m_long)
{
    const double shared = at_least(0.0, 2.0 * m_short - m_long);
    return 4.0 * m_short * m_short * m_short + 2.0 * m_short -
           (4.0 / 3.0) * shared * (shared * shared - 1.0);
}

DAVAR_RARE double davar_noise_correlation(davar_coefficient_kind_t noise, double m_short,
                                          double m_long)
{
    const double q = m_long / m_short;
    switch (noise) {
    case DAVAR_QUANTIZATION:
        return (q > 1.0) ? 0.5 : 1.0;
    case DAVAR_ANGLE_RANDOM_WALK:
        return davar_noise_white_overlap(m_short, m_long) /
               (davar_root(davar_noise_white_overlap(m_short, m_short)) *
                davar_root(davar_noise_white_overlap(m_long, m_long)));
    case DAVAR_BIAS_INSTABILITY:
        return 2.7 * davar_root(q) / (q * q + 1.7);
    case DAVAR_RATE_RANDOM_WALK:
    case DAVAR_RATE_RAMP:
    case DAVAR_COEFFICIENT_COUNT:
    default:
        return 1.34 * davar_root(q) / (q + 0.34 / q);
    }
}

/* --- chi-square (5.2): the cube root of chi2_p(edf) / edf is a polynomial in s = edf^-1/2 --- */

/* 1 + 0.924108 s - 0.225576 s^2 + 0.00741269 s^3 + 0.0089802 s^4 - 0.00223456 s^5; no partial sum
 * is negative. */
static uint32_t upper_root(uint32_t s)
{
    const uint32_t fourth = UINT32_C(9642416) - noise_times(s, UINT32_C(2399341));
    const uint32_t second =
        UINT32_C(242210386) - noise_times(s, UINT32_C(7959315) + noise_times(s, fourth));
    return UINT32_C(1073741824) + noise_times(s, UINT32_C(992253409) - noise_times(s, second));
}

uint32_t davar_chi_square_low(uint32_t s)
{
    const uint32_t root = upper_root(s); /* 1 .. 1.72 */
    const uint32_t square = davar_upper_product(root, root);
    const uint32_t cube = davar_upper_product(square, root); /* 6.26 */
    const uint32_t zeros = davar_leading_zeros_32(cube);
    return davar_reciprocal_of_mantissa(cube << zeros) >> (7U - zeros);
}

/* 1 - 0.919928 s - 0.305956 s^2 + 0.606937 s^3 - 1.85701 s^4 + 3.23066 s^5 - 2.13078 s^6 + 0.475463
 * s^7; no partial sum is negative. */
static uint32_t lower_root(uint32_t s)
{
    const uint32_t sixth = UINT32_C(2287907604) - noise_times(s, UINT32_C(510524509));
    const uint32_t fifth = UINT32_C(3468894761) - noise_times(s, sixth);
    const uint32_t fourth = UINT32_C(1993949305) - noise_times(s, fifth);
    const uint32_t third = UINT32_C(651693641) - noise_times(s, fourth);
    const uint32_t first = UINT32_C(987765169) + noise_times(s, UINT32_C(328517754)) -
                           noise_times(noise_times(s, s), third);
    return UINT32_C(1073741824) - noise_times(s, first);
}

void davar_chi_square(scaled_t edf, scaled_t *low, scaled_t *high)
{
    const uint32_t s = davar_scaled_to_fixed(davar_scaled_root(scaled_inverse(edf)), NOISE_BITS);
    const scaled_t root = scaled_inverse(scaled_of_u32(lower_root(s), -NOISE_BITS)); /* 1 .. 10.1 */
    *low = scaled_of_u32(davar_chi_square_low(s), -NOISE_BITS);
    *high = scaled_times(root, scaled_times(root, root));
}

void davar_chi_square_interval(double edf, double *low, double *high)
{
    scaled_t factor[2];
    davar_chi_square(scaled_of_double(at_least(1.0, edf)), &factor[0], &factor[1]);
    *low = davar_scaled_to_double(factor[0]);
    *high = davar_scaled_to_double(factor[1]);
}
