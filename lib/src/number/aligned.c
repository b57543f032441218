#include "number/aligned.h"

#include "number/machine.h"

#define SPARE 4

DAVAR_APART int32_t davar_align(uint32_t mantissa[], const int32_t exponent[], int count)
{
    int32_t common = INT32_MIN;
    for (int t = 0; t < count; t++) {
        common = (exponent[t] > common) ? exponent[t] : common;
    }
    common += SPARE;
    for (int t = 0; t < count; t++) {
        const uint32_t shift = (uint32_t)(common - exponent[t]);
        mantissa[t] = (shift > 31U) ? 0U : (mantissa[t] >> shift);
    }
    return common;
}

uint64_t davar_aligned_sum(const int32_t factor[], const uint32_t mantissa[], int count)
{
    uint64_t sum = 0U; /* modulo 2^64 */
    for (int t = 0; t < count; t++) {
        sum += davar_multiply_i32(factor[t], (int32_t)mantissa[t]);
    }
    return sum & ((sum >> 63U) - 1U);
}
