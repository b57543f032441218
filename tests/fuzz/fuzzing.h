/* davar tests - shared by the fuzz targets: reading of input bytes, a check that stops the fuzzer,
 * and the range of a value in a frame. */
#ifndef DAVAR_TESTS_FUZZING_H
#define DAVAR_TESTS_FUZZING_H

#include "davar/wire.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

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

/* A value of a frame: 0, absent, or of a magnitude that a sender writes. */
static inline bool is_magnitude(float value)
{
    return isnan(value) || ((value <= 0.0F) && (value >= 0.0F)) ||
           ((value >= DAVAR_WIRE_LEAST) && (value <= DAVAR_WIRE_MOST));
}

#endif
