/* davar - an Allan deviation, digit by digit: a quotient, a root and a product of 53 bits. */
#include "deviation.h"

#include "number/real.h"

#define DIGITS 53
#define DIGITS_BELOW_1 ((UINT64_C(1) << 52U) - 1U)
#define DIGIT_OF_1 (UINT64_C(1) << 52U)
#define EXPONENT_OF_1 1023U
#define PRODUCT_OF_1 ((2U * EXPONENT_OF_1) + 52U + GUARD)
#define GUARD                                                                                      \
    9U /* bits of a product below those that it keeps; the last one: not 0 further below */

/* a / b for b <= a < 2 b, rounded to 53 digits; it is never half way between two. */
DAVAR_APART static uint64_t digits_of_quotient(uint64_t a, uint64_t b)
{
    uint64_t quotient = 0U;
    for (int i = 0; i <= DIGITS; i++) {
        quotient <<= 1U;
        if (a >= b) {
            a -= b;
            quotient++;
        }
        a <<= 1U;
    }
    return (quotient + 1U) >> 1U;
}

/* The root of `square`, 53 or 54 digits, rounded to 53; it is never half way between two. */
DAVAR_APART static uint64_t digits_of_root(uint64_t square)
{
    uint64_t root = 0U;
    uint64_t rest = 0U;
    square <<= 10U;
    for (int i = 0; i <= DIGITS; i++) {
        const uint64_t next = (4U * root) + 1U;
        rest = (4U * rest) | (square >> 62U);
        square <<= 2U;
        root <<= 1U;
        if (rest >= next) {
            rest -= next;
            root++;
        }
    }
    return (root + 1U) >> 1U;
}

/* a b 2^(GUARD - 52), with its last bit set if digits below it are. */
DAVAR_APART static uint64_t digits_of_product(uint64_t a, uint64_t b)
{
    uint64_t product = 0U;
    for (int i = 0; i < DIGITS; i++) {
        product = (product >> 1U) | (product & 1U);
        product += ((a & 1U) != 0U) ? (b << GUARD) : 0U;
        a >>= 1U;
    }
    return product;
}

static uint64_t digits_of(uint64_t bits)
{
    return (bits & DIGITS_BELOW_1) | DIGIT_OF_1;
}

double davar_deviation_by_digits(uint64_t sum, uint64_t divisor, double unit)
{
    const uint64_t bits = davar_bits_of_double(davar_double_of_u64(sum));
    const uint64_t by = davar_bits_of_double(davar_double_of_u64(divisor));
    const uint64_t scale = davar_bits_of_double(unit);
    const uint64_t b = digits_of(by);
    uint64_t a = digits_of(bits);
    uint32_t exponent = EXPONENT_OF_1 + (uint32_t)(bits >> 52U) - (uint32_t)(by >> 52U);
    if (sum == 0U) {
        return 0.0;
    }
    if (a < b) {
        a <<= 1U;
        exponent--;
    }
    const uint64_t square = digits_of_quotient(a, b) << (1U - (exponent & 1U));
    const uint64_t product = digits_of_product(digits_of_root(square), digits_of(scale));
    exponent = ((exponent + EXPONENT_OF_1) / 2U) + (uint32_t)(scale >> 52U) - PRODUCT_OF_1;
    return davar_double_of_bits(davar_bits_of_double(davar_double_of_u64(product)) +
                                ((uint64_t)exponent << 52U));
}
