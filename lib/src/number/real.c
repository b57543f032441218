/* davar - roots, quotients and products in integers. Fixed point "a.b": a bits before the point, b
 * after it. */
#include "number/real.h"

double davar_double_of_u64_by_parts(uint64_t value)
{
    if (value == 0U) {
        return 0.0;
    }
    const uint32_t zeros = davar_leading_zeros(value);
    return davar_double_of_mantissa(value << zeros, 1086U - zeros);
}

#define FRACTION_BITS 52U
#define FRACTION ((UINT64_C(1) << FRACTION_BITS) - 1U)
#define HIDDEN (UINT64_C(1) << FRACTION_BITS)

static inline uint64_t top_64(uint64_t a, uint64_t b)
{
    return davar_multiply_u64(a, b).high;
}

/* The product has 96 bits. */
static inline uint64_t top_64_of_96(uint64_t a, uint32_t b)
{
    return davar_multiply_u32((uint32_t)(a >> 32U), b) + davar_upper_product((uint32_t)a, b);
}

/* --- roots ---------------------------------------------------------------------------------------
 * For m in [1, 4) a polynomial gives r = 1 / sqrt(m) within 2.5 %. Goldschmidt's iteration
 *
 *     s = m r;   u = 3 - s r,  r <- r u / 2,  s <- s u / 2
 *
 * turns a relative error e into 1.5 e^2: 2.5e-2, 9e-4, 1.2e-6, 2e-9 (32 bits end there), 6e-18. The
 * result is the root or just below it, and the remainder decides the rounding. */

/* 3 as 2.30. A little less, so that a value below 1 never reaches 1. */
#define THREE UINT32_C(0xC0000000)
#define BELOW_THREE (THREE - 2U)

typedef struct {
    uint32_t reciprocal; /* 0.32 */
    uint32_t root;       /* 2.30 */
} estimate_t;

static inline uint32_t correction(estimate_t estimate)
{
    return BELOW_THREE - davar_upper_product(estimate.root, estimate.reciprocal);
}

/* m as 2.30; the relative error is below 2e-6. The minimax polynomial is
 * 1.33542 - 0.41067 m + 0.05121 m^2. */
static estimate_t estimate_of(uint32_t m)
{
    const uint32_t slope =
        UINT32_C(1763812533) - (davar_upper_product(m, UINT32_C(219924841)) << 2U);
    const uint32_t reciprocal = (UINT32_C(1433893834) - davar_upper_product(m, slope)) << 2U;
    estimate_t estimate = {reciprocal, davar_upper_product(m, reciprocal)};
    for (unsigned i = 0U; i < 2U; i++) {
        const uint32_t u = correction(estimate);
        estimate.reciprocal = davar_upper_product(estimate.reciprocal, u) << 1U;
        estimate.root = davar_upper_product(estimate.root, u) << 1U;
    }
    return estimate;
}

uint32_t davar_root_of_mantissa_by_integers(uint32_t m)
{
    const estimate_t estimate = estimate_of(m);
    const uint32_t s = davar_upper_product(estimate.root, correction(estimate));
    uint32_t root = (s - 1U) >> 6U;                       /* 9.23, from 3.29 */
    const uint32_t short_of = (m << 16U) - (root * root); /* m - root^2, modulo 2^32 */
    root += (root - short_of) >> 31U;                     /* up if above half a unit */
    return root;
}

/* The mantissa has its top bit set; the exponent is that of a double. */
static double root_of(uint64_t mantissa, uint32_t exponent)
{
    const bool odd = ((exponent & 1U) != 0U);             /* without the bias it is even */
    const uint64_t m = odd ? (mantissa >> 1U) : mantissa; /* in [1, 4) with an even exponent */
    const estimate_t estimate = estimate_of((uint32_t)(m >> 32U));
    const uint32_t reciprocal = davar_upper_product(estimate.reciprocal, correction(estimate))
                                << 1U;
    const uint64_t s = top_64_of_96(m, reciprocal);
    const uint64_t u = ((uint64_t)THREE << 32U) - top_64_of_96(s, reciprocal);
    uint64_t root = (top_64(s, u) - 2U) >> 9U; /* 12.52, from 3.61 */
    const uint64_t short_of = (m << 42U) - (root * root);
    root += (root - short_of) >> 63U;
    const uint64_t half = (uint64_t)((exponent + 0x3FFU) >> 1U) << FRACTION_BITS;
    return davar_double_of_bits(half | (root & FRACTION));
}

double davar_root_by_integers(double value)
{
    uint64_t bits = davar_bits_of_double(value);
    uint32_t exponent = (uint32_t)(bits >> FRACTION_BITS);
    if ((exponent >= 0x7FFU) || (bits == 0U)) { /* a set sign exceeds the exponent of infinity */
        return (value < 0.0) ? (double)NAN : value;
    }
    bits <<= 11U;
    if (exponent == 0U) { /* subnormal: the top bit of the fraction becomes that of a mantissa */
        const uint32_t zeros = davar_leading_zeros(bits);
        bits <<= zeros;
        exponent = 1U - zeros;
    }
    return root_of(bits | (UINT64_C(1) << 63U), exponent);
}

/* --- comparisons ---------------------------------------------------------------------------- */

bool davar_is_between(double low, double value, double high)
{
    return (davar_bits_of_double(low) <= davar_bits_of_double(value)) &&
           (davar_bits_of_double(value) <= davar_bits_of_double(high));
}

/* --- quotients -----------------------------------------------------------------------------------
 * For b in [1, 2) a line gives x = 1 / b within 1/17. Newton's iteration x <- x (2 - b x) turns a
 * relative error e into e^2: 6e-2, 3e-3, 1e-5, 2e-10 (32 bits end there), 5e-20. 2 - b x is the
 * two's complement of b x. */

/* The line is 24/17 - 8/17 b, modulo 1. 8/17 is 0x78787878 / 2^32, but a compiler would replace
 * that factor by shifts and sums, which are slower than a product. */
uint32_t davar_reciprocal_of_mantissa(uint32_t b)
{
    uint32_t x = UINT32_C(1768515945) - (davar_upper_product(b, UINT32_C(0x7878A3D5)) << 1U);
    for (unsigned i = 0U; i < 3U; i++) {
        x = davar_upper_product(x, 0U - davar_upper_product(b, x)) << 1U;
    }
    return x;
}

/* b as 1.63; 1 / b as 0.64 within 2^-60. */
static uint64_t reciprocal_of(uint64_t b)
{
    const uint32_t x = davar_reciprocal_of_mantissa((uint32_t)(b >> 32U));
    return top_64_of_96(0U - top_64_of_96(b, x), x) << 1U;
}

/* The rounded quotient of two 53-bit mantissas, b <= a < 2 b: 2^52 .. 2^53 - 1. It is never half
 * way between two doubles. */
static uint64_t quotient_of_mantissas(uint64_t a, uint64_t b, uint64_t reciprocal)
{
    uint64_t quotient = (top_64(a << 10U, reciprocal) - 4U) >> 10U; /* exact, or one less */
    uint64_t rest = (a << FRACTION_BITS) - (quotient * b);          /* modulo 2^64 */
    if (rest >= b) {
        quotient++;
        rest -= b;
    }
    return quotient + (((2U * rest) > b) ? 1U : 0U);
}

static inline uint64_t mantissa_of(uint64_t bits)
{
    return (bits & FRACTION) | HIDDEN;
}

static inline uint32_t exponent_of(uint64_t bits)
{
    return (uint32_t)(bits >> FRACTION_BITS) & 0x7FFU;
}

static inline bool is_normal(uint32_t exponent)
{
    return (exponent - 1U) < 0x7FEU;
}

double davar_divide_by_integers(double dividend, double divisor)
{
    const uint64_t bits = davar_bits_of_double(dividend);
    const uint64_t by = davar_bits_of_double(divisor);
    const uint64_t b = mantissa_of(by);
    uint64_t a = mantissa_of(bits);
    uint32_t exponent = exponent_of(bits) - exponent_of(by) + 1022U;
    if (a < b) {
        a <<= 1U;
        exponent--;
    }
    if (!is_normal(exponent_of(bits)) || !is_normal(exponent_of(by)) || !is_normal(exponent) ||
        !is_normal(exponent + 2U)) {
        return dividend / divisor; /* 0, infinity, NaN, subnormal or out of range: compiler code */
    }
    const uint64_t sign = (bits ^ by) & (UINT64_C(1) << 63U);
    return davar_double_of_bits(sign | (((uint64_t)exponent << FRACTION_BITS) +
                                        quotient_of_mantissas(a, b, reciprocal_of(b << 11U))));
}

double davar_root_of_quotient_by_integers(double dividend, double divisor)
{
    const uint64_t bits = davar_bits_of_double(dividend);
    const uint64_t by = davar_bits_of_double(divisor);
    const uint64_t b = mantissa_of(by);
    uint64_t a = mantissa_of(bits);
    uint32_t exponent = (uint32_t)(bits >> FRACTION_BITS) - (uint32_t)(by >> FRACTION_BITS) + 1023U;
    if (bits == 0U) {
        return 0.0;
    }
    if (a < b) {
        a <<= 1U;
        exponent--;
    }
    return root_of(quotient_of_mantissas(a, b, reciprocal_of(b << 11U)) << 11U, exponent);
}

/* --- products --------------------------------------------------------------------------------- */

double davar_scale_by_integers(double a, double b)
{
    const uint64_t bits = davar_bits_of_double(a);
    const uint64_t by = davar_bits_of_double(b);
    uint32_t exponent = exponent_of(bits) + exponent_of(by) - 1022U;
    if (bits == 0U) {
        return 0.0;
    }
    const davar_u128_t product =
        davar_multiply_u64(mantissa_of(bits) << 11U, mantissa_of(by) << 11U);
    uint64_t mantissa = product.high;
    uint64_t rest = product.low;
    if ((mantissa >> 63U) == 0U) {
        mantissa = (mantissa << 1U) | (rest >> 63U);
        rest <<= 1U;
        exponent--;
    }
    const uint64_t sign = (bits ^ by) & (UINT64_C(1) << 63U);
    const double size = davar_double_of_mantissa(mantissa | ((rest != 0U) ? 1U : 0U), exponent);
    return davar_double_of_bits(sign | davar_bits_of_double(size));
}

/* --- values as float32, for frames and packets --- */

uint32_t davar_single_bits(double value)
{
    return isnan(value) ? 0x7FC00000U : davar_bits_of_float((float)value);
}

double davar_single_signed(double value)
{
    const double size = fabs(value);
    const double shown = (size < (double)DAVAR_SINGLE_LEAST) ? 0.0 : value;
    return (size <= (double)DAVAR_SINGLE_MOST) ? shown : (double)NAN;
}

double davar_single_magnitude(double value)
{
    return davar_single_signed((value >= 0.0) ? value : (double)NAN);
}

double davar_single_limit(double value)
{
    return (value > (double)DAVAR_SINGLE_MOST) ? (double)INFINITY : davar_single_magnitude(value);
}
