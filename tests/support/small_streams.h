/* davar tests - streams for the small pipeline, which an instance of the complete library gets too.
 * All samples are integers of one generator, so that every machine gets the same. WINDOW: of the
 * instances. */
#ifndef DAVAR_TESTS_SMALL_STREAMS_H
#define DAVAR_TESTS_SMALL_STREAMS_H

#include <stdint.h>

static uint32_t stream_state;

static inline uint32_t random_below(uint32_t most)
{
    stream_state = (stream_state * 1664525U) + 1013904223U;
    return (uint32_t)(((uint64_t)stream_state * most) >> 32U);
}

/* Nearly Gaussian, with a standard deviation of 256. */
static inline int32_t noise(void)
{
    int32_t sum = -6 * 256;
    for (int k = 0; k < 12; k++) {
        sum += (int32_t)random_below(256U);
    }
    return sum;
}

#define STREAMS 11

static struct {
    int32_t walk;
    int32_t last;
    int32_t before[3];
    uint32_t stuck; /* samples until the sensor repeats no longer */
} source;

static inline int32_t filtered(int32_t value)
{
    const int32_t sum = value + source.before[0] + source.before[1] + source.before[2];
    source.before[2] = source.before[1];
    source.before[1] = source.before[0];
    source.before[0] = value;
    return sum;
}

/* White noise of several sizes, coarse and constant noise, noise after a filter, a random walk, a
 * ramp, a tone, a stuck sensor, a saturated one, and noise that changes. */
static inline int32_t sample_of(int stream, uint32_t i)
{
    const int32_t white = noise();
    switch (stream) {
    case 0:
        return white / 8;
    case 1:
        return white / 256;
    case 2:
        return white / 700;
    case 3:
        return filtered(white) / 16;
    case 4:
        source.walk += white / 16;
        return (white + source.walk) / 8;
    case 5:
        return (white / 8) + (int32_t)((i % WINDOW) / 2U);
    case 6:
        return (white / 8) + (((i / 7U) % 2U == 0U) ? 20 : -20);
    case 7:
        source.stuck = (source.stuck > 0U)
                           ? (source.stuck - 1U)
                           : ((random_below(WINDOW) == 0U) ? random_below(2U * WINDOW) : 0U);
        source.last = (source.stuck > 0U) ? source.last : (white / 64);
        return source.last;
    case 8:
        return white * 64;
    case 9:
        return ((i / (3U * WINDOW)) % 2U == 0U) ? (white / 32) : (white / 8);
    default:
        return 5;
    }
}

static inline int16_t clipped(int32_t value)
{
    return (int16_t)((value > INT16_MAX) ? INT16_MAX : ((value < INT16_MIN) ? INT16_MIN : value));
}

#endif
