/* davar tests - the fuzz target of chained calls on random chains, in every kind of build. A
 * failure aborts and reports the condition. */
#include "../fuzz/fuzz_calls.c" /* NOLINT(bugprone-suspicious-include): same chains, in ctest */

#include "unity.h"

#define BYTES_MAX 500U

void setUp(void) {}

void tearDown(void) {}

static void test_every_chain_gives_numbers_in_range_and_counts_losses(void)
{
    static uint8_t bytes[BYTES_MAX];
    for (uint32_t trial = 0U; trial < (4U * PROPERTY_TRIALS); trial++) {
        random_t random = random_seeded(PROPERTY_FIRST + trial);
        const size_t count = 40U + (size_t)(random_next(&random) % (BYTES_MAX - 40U));
        for (size_t i = 0U; i < count; i++) {
            bytes[i] = (uint8_t)(random_next(&random) >> 56U);
        }
        (void)LLVMFuzzerTestOneInput(bytes, count);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_every_chain_gives_numbers_in_range_and_counts_losses);
    return UNITY_END();
}
