/* davar tests - a number for all values that a test has seen: FNV-1a, a word at a time. It is the
 * same on every machine; every NaN counts as the same value. */
#ifndef DAVAR_TESTS_DIGEST_H
#define DAVAR_TESTS_DIGEST_H

#include <math.h>
#include <stdint.h>
#include <string.h>

static uint64_t digest;

static inline void digest_begin(void)
{
    digest = UINT64_C(14695981039346656037);
}

static inline void add(uint64_t value)
{
    digest = (digest ^ value) * UINT64_C(1099511628211);
}

static inline void add_double(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    add(isnan(value) ? 1U : bits);
}

static inline void add_float(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    add(isnan(value) ? 1U : bits);
}

#endif
