/* davar tests - two instances, one of which continues as the other, and the storage between them:
 * two slots in RAM that can lose power. The suites of state and storage use all of it. */
#ifndef DAVAR_TESTS_STATE_FIXTURE_H
#define DAVAR_TESTS_STATE_FIXTURE_H

#include "davar/state.h"
#include "small_config.h"
#include "unity.h"

#include <string.h>

#define SLOT 8192U

static const uint32_t taus[4] = {1U, 2U, 5U, 8U};
static uint64_t memory[2][1024];
static davar_config_t config;
static davar_t original;
static davar_t restored;

/* Two slots in RAM. The power fails after `budget` written bytes, or after `reads` reads. */
static unsigned char cells[2U * SLOT];
static size_t budget;
static size_t reads;

static bool read_cells(void *context, size_t offset, void *data, size_t bytes)
{
    (void)context;
    memcpy(data, &cells[offset], bytes);
    reads -= (reads > 0U) ? 1U : 0U;
    return reads > 0U;
}

static bool write_cells(void *context, size_t offset, const void *data, size_t bytes)
{
    (void)context;
    const size_t done = (bytes < budget) ? bytes : budget;
    memcpy(&cells[offset], data, done);
    budget -= done;
    return done == bytes;
}

static davar_storage_t storage;

void setUp(void)
{
    storage = (davar_storage_t){read_cells, write_cells, NULL, SLOT};
    memset(cells, 0xFF, sizeof cells);
    budget = SIZE_MAX;
    reads = SIZE_MAX;
    config = small_config(taus, 4U);
}

void tearDown(void) {}

typedef enum { Q15, Q31, F32 } type_t;

static void init(type_t type, davar_t *davar, unsigned which)
{
    static davar_status_t (*const inits[])(davar_t *, const davar_config_t *, void *, size_t) = {
        davar_init_q15, davar_init_q31, davar_init_f32};
    memset(memory[which], 0xA5, sizeof memory[which]);
    TEST_ASSERT_EQUAL(DAVAR_OK, inits[type](davar, &config, memory[which], sizeof memory[which]));
}

/* One sample of a noise that is at times four times as large, with occasional gaps. True: a result
 * was taken. */
static bool step(type_t type, davar_t *davar, uint32_t n, davar_result_t *result)
{
    const int32_t value = (int32_t)(((n * 2654435761U) >> 20U) % 101U) - 50;
    const int32_t sample = ((n / 97U) % 2U == 0U) ? value : (4 * value);
    const int16_t narrow = (int16_t)sample;
    const float rate = 0.3F * (float)sample;
    if ((n % 61U) == 60U) {
        davar_gap(davar, 2U);
    }
    if (type == Q15) {
        davar_push_q15(davar, &narrow, 1U);
    } else if (type == Q31) {
        davar_push_q31(davar, &sample, 1U);
    } else {
        davar_push_f32(davar, &rate, 1U);
    }
    memset(result, 0, sizeof *result);
    return davar_take(davar, result); /* the fit is a pure function of it */
}

/* Epoch of the next result from the state in the storage. */
static uint64_t restored_epoch(void)
{
    davar_result_t result;
    init(Q15, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_state_restore(&restored, &storage));
    TEST_ASSERT_TRUE(step(Q15, &restored, 0U, &result));
    return result.epoch;
}

static void feed(uint32_t from, uint32_t to)
{
    davar_result_t result;
    for (uint32_t n = from; n < to; n++) {
        (void)step(Q15, &original, n, &result);
    }
}

#endif
