/* davar - operations on positive numbers that are too long to inline. */
#include "number/scaled.h"

scaled_t davar_scaled_plus(scaled_t a, scaled_t b)
{
    const bool swap = a.exponent < b.exponent;
    const scaled_t large = swap ? b : a;
    const scaled_t small = swap ? a : b;
    const uint32_t shift = (uint32_t)(large.exponent - small.exponent);
    const uint32_t sum =
        large.mantissa + ((shift > 31U) ? 0U : (small.mantissa >> shift)); /* modulo 2^32 */
    const scaled_t within = {sum, large.exponent};
    const scaled_t beyond = {SCALED_TOP | (sum >> 1U), large.exponent + 1};
    return (sum < large.mantissa) ? beyond : within;
}

uint32_t davar_scaled_to_fixed(scaled_t a, int32_t bits)
{
    if (a.exponent >= -bits) {
        return (a.exponent == -bits) ? a.mantissa : UINT32_MAX;
    }
    const uint32_t shift = (uint32_t)(-1 - a.exponent - bits);
    const uint32_t twice = (shift > 31U) ? 0U : (a.mantissa >> shift);
    return (twice >> 1U) + (twice & 1U);
}

scaled_t davar_scaled_root(scaled_t a)
{
    const uint32_t odd = (uint32_t)a.exponent & 1U;
    const uint32_t root = davar_root_of_mantissa((a.mantissa & ~UINT32_C(0xFF)) >> odd);
    return (scaled_t){root << 8U, ((a.exponent - (int32_t)odd) / 2) + (int32_t)odd - 16};
}

double davar_scaled_to_double(scaled_t scaled)
{
    const int32_t exponent = scaled.exponent + (1023 + 31);
    if ((uint32_t)(exponent - 1) >= 0x7FEU) {
        return (exponent <= 0) ? 0.0 : (double)INFINITY;
    }
    const uint32_t upper = ((uint32_t)exponent << 20U) + ((scaled.mantissa << 1U) >> 12U);
    return davar_double_of_bits(((uint64_t)upper << 32U) | (scaled.mantissa << 21U));
}

bool davar_levels_differ(uint32_t one, uint32_t other, uint32_t samples)
{
    return scaled_levels_differ(one, other, samples);
}
