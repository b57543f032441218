/* davar - positive numbers brought to one exponent, DESIGN (5.14). */
#include "fit/plan.h"

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

uint64_t davar_aligned_sum(const int32_t factor[], const scaled_t value[], int count)
{
    uint64_t sum = 0U; /* modulo 2^64 */
    for (int t = 0; t < count; t++) {
        sum += davar_multiply_i32(factor[t], (int32_t)value[t].mantissa);
    }
    return sum & ((sum >> 63U) - 1U);
}
