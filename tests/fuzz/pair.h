/* davar tests - two instances of one configuration, of which one is current: a save and a restore
 * change over to the other. Define MEMORY_WORDS, the words of memory of each, before. */
#ifndef DAVAR_TESTS_PAIR_H
#define DAVAR_TESTS_PAIR_H

#define SLOT ((size_t)8 * MEMORY_WORDS)

#include "cells.h"
#include "davar/state.h"
#include "fuzzing.h"

static uint64_t memory[2][MEMORY_WORDS];
static davar_t instances[2];
static unsigned current;

static davar_status_t start(const davar_config_t *config, bool is_q31, unsigned which)
{
    davar_t *const davar = &instances[which];
    memset(memory[which], 0xA5, sizeof memory[which]);
    return is_q31 ? davar_init_q31(davar, config, memory[which], sizeof memory[which])
                  : davar_init_q15(davar, config, memory[which], sizeof memory[which]);
}

static bool start_first(const davar_config_t *config, bool is_q31)
{
    current = 0U;
    memset(cells, 0xFF, sizeof cells);
    return start(config, is_q31, 0U) == DAVAR_OK;
}

static void change_over(const davar_config_t *config, bool is_q31)
{
    REQUIRE(davar_state_save(&instances[current], &storage) == DAVAR_STATE_OK);
    REQUIRE(start(config, is_q31, 1U - current) == DAVAR_OK);
    current = 1U - current;
    REQUIRE(davar_state_restore(&instances[current], &storage) == DAVAR_STATE_OK);
    memset(memory[1U - current], 0x5A, sizeof memory[0]); /* nothing of it may be read */
}

/* Samples up to the next result; returns how many. */
static size_t push_until(bool is_q31, const int32_t *sample, size_t count)
{
    int16_t narrow[256];
    for (size_t i = 0U; !is_q31 && (i < count); i++) {
        narrow[i] = (int16_t)sample[i];
    }
    const size_t done = is_q31 ? davar_push_until_result_q31(&instances[current], sample, count)
                               : davar_push_until_result_q15(&instances[current], narrow, count);
    REQUIRE((done >= 1U) && (done <= count));
    return done;
}

#endif
