/* davar tests - a fuzz target on random bytes, in every kind of build. A failure aborts and reports
 * the condition. RECORDED_DIGEST is the digest of what the library returns for the first inputs; see
 * tests/unit/test_recorded.c. Include it after the target. */
#ifndef DAVAR_TESTS_CHAINS_H
#define DAVAR_TESTS_CHAINS_H

#include "digest.h"
#include "random.h"
#include "unity.h"

#define BYTES_MAX 500U

void setUp(void) {}

void tearDown(void) {}

/* Any byte, or one that is likely to become a limit or the value next to it. */
static uint8_t any_byte(random_t *random, bool at_limits)
{
    static const uint8_t limits[] = {0U, 1U, 0x7FU, 0x80U, 0xFEU, 0xFFU};
    const uint64_t drawn = random_next(random);
    const bool is_limit = at_limits && ((drawn % 4U) == 0U);
    return is_limit ? limits[(drawn >> 32U) % sizeof limits] : (uint8_t)(drawn >> 56U);
}

/* Every second input has many bytes at limits. */
static void run_inputs(uint64_t first, uint32_t inputs)
{
    static uint8_t bytes[BYTES_MAX];
    for (uint32_t i = 0U; i < inputs; i++) {
        random_t random = random_seeded(first + i);
        const size_t count = 40U + (size_t)(random_next(&random) % (BYTES_MAX - 40U));
        for (size_t k = 0U; k < count; k++) {
            bytes[k] = any_byte(&random, (i % 2U) == 1U);
        }
        (void)LLVMFuzzerTestOneInput(bytes, count);
    }
}

static void test_every_bit_is_as_recorded(void)
{
    digest_begin();
    run_inputs(1U, RECORDED_INPUTS);
    TEST_ASSERT_EQUAL_HEX64(RECORDED_DIGEST, digest);
}

static void test_other_inputs_keep_the_conditions(void)
{
    run_inputs(PROPERTY_FIRST + RECORDED_INPUTS, PROPERTY_TRIALS);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_every_bit_is_as_recorded);
    RUN_TEST(test_other_inputs_keep_the_conditions);
    return UNITY_END();
}

#endif
