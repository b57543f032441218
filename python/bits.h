/* davar for Python - how large a whole number is. */
#ifndef BITS_H
#define BITS_H

#include <stdint.h>

/* The number of bits of a value. */
static inline uint32_t bits_of(uint64_t value)
{
    uint32_t bits = 0U;
    while ((bits < 64U) && ((value >> bits) > 0U)) {
        bits++;
    }
    return bits;
}

#endif
