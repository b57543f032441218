/* davar tests - without asserts, a push of the wrong number type, or after the end of a record, is
 * rejected and harmless; and a block gives each of its results. Compiled with the library's sources
 * and without asserts, in every build. */
#include "davar/cascade.h"
#include "davar/glr.h"
#include "davar/state.h"
#include "stream_fixture.h"

#include <string.h>

#define SAMPLES 300U
#define SLOT 8192U

#include "cells.h"

static int16_t narrow[SAMPLES];
static int32_t wide[SAMPLES];
static float rates[SAMPLES];
static uint32_t taken;
static double last;

static void make_samples(void)
{
    for (uint32_t i = 0U; i < SAMPLES; i++) {
        narrow[i] = ripple(i);
        wide[i] = narrow[i];
        rates[i] = (float)narrow[i];
    }
}

/* Law glr, whose record has an end. */
static void use_glr(uint32_t type)
{
    config.law = (type == 0U) ? &davar_law_glr_q15 : &davar_law_glr_q31;
    config.moments.segment = 0U;
    config.window.longest = 80U;
}

static davar_status_t start(uint32_t type)
{
    static davar_status_t (*const inits[])(davar_t *, const davar_config_t *, void *, size_t) = {
        davar_init_q15, davar_init_q31, davar_init_f32};
    return inits[type](&davar, &config, memory, sizeof memory);
}

static size_t push_until_result(uint32_t type, size_t from, size_t count)
{
    switch (type) {
    case 0U:
        return davar_push_until_result_q15(&davar, &narrow[from], count);
    case 1U:
        return davar_push_until_result_q31(&davar, &wide[from], count);
    default:
        return davar_push_until_result_f32(&davar, &rates[from], count);
    }
}

static size_t push(uint32_t type)
{
    return push_until_result(type, 0U, 1U);
}

static void push_block(uint32_t type)
{
    switch (type) {
    case 0U:
        davar_push_q15(&davar, narrow, SAMPLES);
        break;
    case 1U:
        davar_push_q31(&davar, wide, SAMPLES);
        break;
    default:
        davar_push_f32(&davar, rates, SAMPLES);
        break;
    }
}

/* Pushes a block and takes every result that it completes. */
static void push_all(uint32_t type)
{
    for (size_t done = 0U; done < SAMPLES;) {
        done += push_until_result(type, done, SAMPLES - done);
        if (davar_take(&davar, &result)) {
            taken++;
            last = result.tau[0].adev;
        }
    }
}

/* Only the counter of missing samples has changed, by `missing`. */
static void assert_only_counted(davar_t as_it_was, uint32_t missing)
{
    as_it_was.health.missing += missing;
    TEST_ASSERT_EQUAL_MEMORY(&as_it_was, &davar, sizeof davar);
}

static void test_a_push_of_another_type_is_rejected_and_counted(void)
{
    static uint64_t before[sizeof memory / sizeof memory[0]];
    make_samples();
    config.full_scale = 100.0;
    for (uint32_t type = 0U; type < 3U; type++) {
        for (uint32_t other = 0U; other < 3U; other++) {
            memset(memory, 0, sizeof memory);
            TEST_ASSERT_EQUAL(DAVAR_OK, start(type));
            const davar_t as_it_was = davar;
            memcpy(before, memory, sizeof before);
            taken = 0U;
            if (other == type) {
                TEST_ASSERT_EQUAL_size_t(1U, push(other));
                continue;
            }
            TEST_ASSERT_EQUAL_size_t(1U, push(other));
            assert_only_counted(as_it_was, 1U);
            push_all(other);
            TEST_ASSERT_EQUAL_UINT32(0U, taken);
            push_block(other);
            assert_only_counted(as_it_was, 1U + (2U * SAMPLES));
            TEST_ASSERT_EQUAL_MEMORY(before, memory, sizeof before);
        }
    }
}

static void test_a_push_of_another_type_to_a_cascade_is_counted(void)
{
    static const davar_cascade_config_t settings = {.rate_hz = 1.0,
                                                    .unit_per_count = 1.0,
                                                    .full_scale = 100.0,
                                                    .shortest = 64U,
                                                    .tau_count = 3U,
                                                    .clusters = 32U};
    davar_cascade_t cascade;
    davar_result_t curve = {0};
    make_samples();
    TEST_ASSERT_EQUAL(DAVAR_CASCADE_OK,
                      davar_cascade_init_q15(&cascade, &settings, memory, sizeof memory));
    davar_cascade_push_q31(&cascade, wide, SAMPLES);
    davar_cascade_push_f32(&cascade, rates, SAMPLES);
    TEST_ASSERT_EQUAL_UINT32(2U * SAMPLES, davar_cascade_health(&cascade).missing);
    davar_cascade_flush(&cascade);
    TEST_ASSERT_FALSE(davar_cascade_append(&cascade, &curve));
    TEST_ASSERT_EQUAL(DAVAR_CASCADE_OK,
                      davar_cascade_init_f32(&cascade, &settings, memory, sizeof memory));
    davar_cascade_push_q15(&cascade, narrow, SAMPLES);
    TEST_ASSERT_EQUAL_UINT32(SAMPLES, davar_cascade_health(&cascade).missing);
}

static void test_a_push_after_the_end_is_rejected_until_the_reset(void)
{
    make_samples();
    config.full_scale = 100.0;
    for (uint32_t type = 0U; type < 3U; type++) {
        use_glr(type);
        TEST_ASSERT_EQUAL(DAVAR_OK, start(type));
        push_all(type);
        TEST_ASSERT_TRUE(davar_flush(&davar));
        const davar_t as_it_was = davar;
        TEST_ASSERT_EQUAL_size_t(1U, push(type));
        davar_gap(&davar, 3U);
        assert_only_counted(as_it_was, 4U);
        davar_reset(&davar);
        TEST_ASSERT_EQUAL_size_t(1U, push(type));
    }
}

/* A state saved after the end of its record is restored at that end: it accepts neither samples nor
 * gaps. */
static void test_after_a_restored_end_nothing_is_accepted(void)
{
    make_samples();
    config.full_scale = 100.0;
    for (uint32_t type = 0U; type < 3U; type++) {
        use_glr(type);
        TEST_ASSERT_EQUAL(DAVAR_OK, start(type));
        push_all(type);
        TEST_ASSERT_TRUE(davar_flush(&davar));
        TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_state_save(&davar, &storage));
        TEST_ASSERT_EQUAL(DAVAR_OK, start(type));
        TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_state_restore(&davar, &storage));
        const davar_t as_it_was = davar;
        for (uint32_t other = 0U; other < 3U; other++) {
            TEST_ASSERT_EQUAL_size_t(1U, push(other));
        }
        davar_gap(&davar, 3U);
        assert_only_counted(as_it_was, 6U);
    }
}

/* The same blocks, of every length, into an instance that is pushed sample by sample and one that
 * is pushed in blocks. */
static void test_a_block_leaves_the_newest_result_and_counts_the_others(void)
{
    static davar_t other;
    static uint64_t more[sizeof memory / sizeof memory[0]];
    static davar_result_t single;
    make_samples();
    for (uint32_t block = 1U; block <= SAMPLES; block += 1U + (block / 3U)) {
        TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
        TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&other, &config, more, sizeof more));
        uint32_t completed = 0U;
        uint32_t found = 0U;
        for (uint32_t from = 0U; from < SAMPLES; from += block) {
            const uint32_t n = (block < (SAMPLES - from)) ? block : (SAMPLES - from);
            bool any = false;
            for (uint32_t i = 0U; i < n; i++) {
                davar_push_q15(&other, &narrow[from + i], 1U);
                const bool is_new = davar_take(&other, &single);
                any = any || is_new;
                completed += is_new ? 1U : 0U;
            }
            davar_push_q15(&davar, &narrow[from], n);
            TEST_ASSERT_EQUAL(any, davar_take(&davar, &result));
            if (any) {
                TEST_ASSERT_EQUAL_UINT64(single.epoch, result.epoch);
                TEST_ASSERT_EQUAL_MEMORY(&single.tau[0].adev, &result.tau[0].adev,
                                         sizeof single.tau[0].adev);
            }
            found += any ? 1U : 0U;
        }
        TEST_ASSERT_EQUAL_UINT32(completed - found, davar_health(&davar).missed);
        TEST_ASSERT_EQUAL_UINT32(0U, davar_health(&davar).missing);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_push_of_another_type_is_rejected_and_counted);
    RUN_TEST(test_a_push_of_another_type_to_a_cascade_is_counted);
    RUN_TEST(test_a_push_after_the_end_is_rejected_until_the_reset);
    RUN_TEST(test_after_a_restored_end_nothing_is_accepted);
    RUN_TEST(test_a_block_leaves_the_newest_result_and_counts_the_others);
    return UNITY_END();
}
