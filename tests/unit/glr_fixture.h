/* davar tests - a detector of changes and its input: blocks of noise, quiet or loud. Every function
 * is inline: each suite uses those that it needs. */
#ifndef DAVAR_TESTS_GLR_FIXTURE_H
#define DAVAR_TESTS_GLR_FIXTURE_H

#include "laws/glr.h"

#include "random.h"
#include "unity.h"

#include <math.h>

#define K_MAX 60U

static const davar_glr_wish_t usual = {100.0, 0.01, 300.0, 6000U, 10U, 2U};
static davar_glr_config_t config;
static const davar_spread_t no_blocks = {0U, 0U, 0U};
static davar_glr_t state;
static davar_glr_event_t event;
static random_t rng;

void setUp(void)
{
    davar_glr_start(&config, &usual);
    davar_glr_reset(&state);
    rng = random_seeded(15U);
}

void tearDown(void) {}

static inline int16_t rounded(double value)
{
    return (int16_t)floor(fmax(-32768.0, fmin(32767.0, value)) + 0.5);
}

static inline void fill(int16_t *sample, double sigma)
{
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(K_MAX, config.block);
    for (uint32_t i = 0U; i < config.block; i++) {
        sample[i] = rounded(sigma * random_gauss(&rng));
    }
}

static inline void push_samples(const int16_t *sample)
{
    int32_t sum = 0;
    uint64_t squares = 0U;
    for (uint32_t i = 0U; i < config.block; i++) {
        sum += sample[i];
        squares += (uint64_t)(sample[i] * (int64_t)sample[i]);
    }
    davar_glr_push_q15(&state, &config, sum, squares, &event);
}

static inline void push_noise(double sigma)
{
    int16_t sample[K_MAX] = {0};
    fill(sample, sigma);
    push_samples(sample);
}

static inline void push_quiet(uint32_t blocks)
{
    for (uint32_t i = 0U; i < blocks; i++) {
        push_noise(20.0);
    }
}

/* Pushes until an alarm; returns the number of blocks, at most `most`. */
static inline uint32_t blocks_to_alarm(double sigma, uint32_t most)
{
    for (uint32_t i = 1U; i <= most; i++) {
        push_noise(sigma);
        if (event.is_alarm) {
            return i;
        }
    }
    return most + 1U;
}

#endif
