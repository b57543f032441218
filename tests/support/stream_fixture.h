/* davar tests - one small instance, a stream for it, and its newest result. Every function is
 * static and inline: each suite uses those that it needs. */
#ifndef DAVAR_TESTS_STREAM_FIXTURE_H
#define DAVAR_TESTS_STREAM_FIXTURE_H

#include "fitted.h"
#include "small_config.h"
#include "unity.h"

#define TAUS 4U

static const uint32_t taus[TAUS] = {1U, 2U, 4U, 8U};
static uint64_t memory[4096];
static davar_config_t config;
static davar_t davar;
static davar_result_t result;

void setUp(void)
{
    config = small_config(taus, TAUS);
}

void tearDown(void) {}

static inline int16_t ripple(uint32_t i)
{
    return (int16_t)(((i * 7919U) % 41U) - 20U);
}

/* Pushes samples from .. to - 1 one by one, takes every result, returns their number. */
static inline uint32_t feed(uint32_t from, uint32_t to)
{
    uint32_t results = 0U;
    for (uint32_t i = from; i < to; i++) {
        const int16_t sample = ripple(i);
        TEST_ASSERT_EQUAL_size_t(1U, davar_push_until_result_q15(&davar, &sample, 1U));
        results += take_fitted(&davar, &result) ? 1U : 0U;
    }
    return results;
}

static inline void start_q15(void)
{
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
}

#endif
