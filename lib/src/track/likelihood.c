/* davar - the likelihood ratio of one variance against two. */
#include "track/likelihood.h"

#include "number/real.h"

void davar_stretch(davar_stretch_t *stretch, const davar_spread_t *sum, uint32_t degrees)
{
    spread_copy(&stretch->sum, sum);
    stretch->degrees = degrees;
    stretch->exponent = spread_exponent(sum);
    const uint32_t mantissa = spread_bits(sum, stretch->exponent);
    stretch->reciprocal = davar_reciprocal_of_mantissa(mantissa);
    stretch->logarithm = INT32_MIN;
}

/* With E_o, E_n the blocks that the parts would have if they were as loud as the whole, and x - 1 - ln x at most (x - 1)^2 / 2
 * above 1, (x - 1)^2 / (2 x) below:  G <= nu/4 (E_o - N_o)^2 (1/P + 1/Q),  P = the blocks of the louder part, Q = E of the
 * other. */
bool davar_likelihood_may_reach(const davar_stretch_t *stretch, const davar_spread_t *older, uint32_t limit)
{
    const uint32_t blocks = stretch->sum.blocks;
    const uint32_t share =
        davar_upper_product(spread_bits(older, stretch->exponent), stretch->reciprocal); /* 31 digits */
    const uint32_t expected = (share >> 10U) * blocks; /* E_o, 21 digits, within 2^-10 */
    const uint32_t there = older->blocks << 21U;
    const bool is_louder = (expected > there);
    const uint32_t excess = is_louder ? (expected - there) : (there - expected);
    const uint32_t size = (excess >> 15U) + 1U; /* 6 digits, of 1023 blocks below 2^16 */
    const uint32_t newer = (blocks << 21U) - (is_louder ? expected : there);
    const uint32_t quiet = is_louder ? newer : expected;
    const uint32_t loud = is_louder ? there : newer;
    const uint32_t p = loud >> 18U; /* 3 digits */
    const uint32_t q = (quiet >> 18U) - (((quiet >> 18U) != 0U) ? 1U : 0U);
    const uint64_t bound = davar_multiply_u32(size * size, ((stretch->degrees * (p + q)) >> 8U) + 1U); /* 15 digits */
    return bound >= (davar_multiply_u32(p * q, limit) << 5U);
}

/* N ln(mean of the whole / mean of this part), 24 digits */
static uint64_t part_of(const davar_stretch_t *stretch, const davar_spread_t *part)
{
    return davar_multiply_i32(stretch->logarithm - spread_logarithm_of_mean(part), (int32_t)part->blocks);
}

int32_t davar_likelihood_gain(davar_stretch_t *stretch, const davar_spread_t *older)
{
    if (stretch->logarithm == INT32_MIN) {
        stretch->logarithm = spread_logarithm_of_mean(&stretch->sum);
    }
    const davar_spread_t newer = spread_between(older, &stretch->sum);
    const uint64_t sum = part_of(stretch, older) + part_of(stretch, &newer); /* not negative, but for rounding */
    return (int32_t)((int64_t)davar_scale_u64(sum, stretch->degrees) >> (24U + 8U + 1U - GAIN_DIGITS));
}
