/* davar - an Allan deviation, digit by digit. Private to small. */
#ifndef DAVAR_SMALL_DEVIATION_H
#define DAVAR_SMALL_DEVIATION_H

#include <stdint.h>

/* sqrt(sum / divisor) * unit, each operation correctly rounded, sum and divisor too, without a
 * double of the machine. divisor: 1 to 2^53. In a third of the flash of number/real.c, and in
 * twice its time. */
double davar_deviation_by_digits(uint64_t sum, uint64_t divisor, double unit);

#endif
