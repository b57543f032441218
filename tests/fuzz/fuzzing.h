/* davar tests - shared by the fuzz targets: reading of input bytes, a check that stops the fuzzer,
 * and what holds for every number that a caller gets. */
#ifndef DAVAR_TESTS_FUZZING_H
#define DAVAR_TESTS_FUZZING_H

#include "davar/can.h"
#include "davar/davar.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Called by libFuzzer with every input. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define REQUIRE(condition)                                                                         \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "%s:%d: not so: %s\n", __FILE__, __LINE__, #condition);                \
            abort();                                                                               \
        }                                                                                          \
    } while (0)

typedef struct {
    const uint8_t *next;
    const uint8_t *end;
} bytes_t;

/* The next byte; 0 after the last. */
static inline uint8_t byte(bytes_t *bytes)
{
    return (bytes->next < bytes->end) ? *bytes->next++ : 0U;
}

/* A number of low .. high (at most 256 apart) from the next byte. */
static inline uint32_t between(bytes_t *bytes, uint32_t low, uint32_t high)
{
    return low + ((uint32_t)byte(bytes) % (high - low + 1U));
}

/* The next `count` bytes, the highest first. */
static inline uint64_t word(bytes_t *bytes, unsigned count)
{
    uint64_t value = 0U;
    for (unsigned i = 0U; i < count; i++) {
        value = (value << 8U) | byte(bytes);
    }
    return value;
}

/* The same bits. */
static inline bool is_same(double one, double other)
{
    uint64_t bits[2];
    memcpy(&bits[0], &one, sizeof one);
    memcpy(&bits[1], &other, sizeof other);
    return bits[0] == bits[1];
}

/* The types of samples. */
typedef enum { Q15 = 0, Q31, F32 } type_t;

/* A value of a frame: 0, absent, or of a magnitude that a sender writes. */
static inline bool is_magnitude(float value)
{
    return isnan(value) || ((value <= 0.0F) && (value >= 0.0F)) ||
           ((value >= DAVAR_CAN_LEAST) && (value <= DAVAR_CAN_MOST));
}

static inline bool is_number(double value)
{
    return isfinite(value) && (value >= 0.0);
}

/* A deviation is a number within its interval, or absent with it. */
static inline void check_deviation(const davar_adev_t *tau)
{
    REQUIRE((tau->differences > 0U) ? is_number(tau->adev)
                                    : (isnan(tau->adev) && isnan(tau->low) && isnan(tau->high)));
    REQUIRE(isnan(tau->edf) || ((tau->edf >= 1.0) && isfinite(tau->edf)));
    REQUIRE(isnan(tau->low) == isnan(tau->high));
    REQUIRE(isnan(tau->low) ||
            ((tau->low >= 0.0) && (tau->low <= tau->adev) && (tau->high >= tau->adev)));
}

/* A coefficient is a number within its interval, or absent with at most an upper limit. */
static inline void check_coefficient(const davar_coefficient_t *coefficient)
{
    const bool is_given = is_number(coefficient->value) && (coefficient->low >= 0.0) &&
                          (coefficient->low <= coefficient->value) &&
                          (coefficient->high >= coefficient->value);
    const bool is_absent =
        isnan(coefficient->value) && isnan(coefficient->low) && (coefficient->high >= 0.0);
    REQUIRE(coefficient->present ? is_given : is_absent);
}

#endif
