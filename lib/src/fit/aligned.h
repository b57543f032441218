/* davar - positive numbers brought to one exponent, so that sums with fixed-point factors are sums of integers (5.14). */
#ifndef DAVAR_FIT_ALIGNED_H
#define DAVAR_FIT_ALIGNED_H

#include "number/scaled.h"

/* Brings the numbers to one exponent, which is returned; their mantissas have 28 bits at most, so that 32 products with factors of 29
 * bits fit 62. What is smaller than the largest loses what lies below its last bit. */
int32_t davar_align(scaled_t value[], int count);

/* Sum of factor[t] * value[t], in units of 2^exponent; 0 where it is negative. */
uint64_t davar_aligned_sum(const int32_t factor[], const scaled_t value[], int count);

#endif
