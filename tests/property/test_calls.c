/* davar tests - the fuzz target of chained calls on random chains, in every kind of build. A
 * failure aborts and reports the condition. Every bit that the caller sees in the first chains is
 * recorded (see tests/unit/test_recorded.c). */
#include "../fuzz/fuzz_calls.c" /* NOLINT(bugprone-suspicious-include): same chains, in ctest */

#include "unity.h"

#define BYTES_MAX 500U
#define RECORDED 1000U

void setUp(void) {}

void tearDown(void) {}

static void run_chains(uint64_t first, uint32_t chains)
{
    static uint8_t bytes[BYTES_MAX];
    for (uint32_t i = 0U; i < chains; i++) {
        random_t random = random_seeded(first + i);
        const size_t count = 40U + (size_t)(random_next(&random) % (BYTES_MAX - 40U));
        for (size_t k = 0U; k < count; k++) {
            bytes[k] = (uint8_t)(random_next(&random) >> 56U);
        }
        (void)LLVMFuzzerTestOneInput(bytes, count);
    }
}

static void test_every_chain_gives_numbers_in_range_and_counts_losses(void)
{
    run_chains(PROPERTY_FIRST, 4U * PROPERTY_TRIALS);
}

static void test_every_bit_is_as_recorded(void)
{
    digest_begin();
    run_chains(1U, RECORDED);
    TEST_ASSERT_EQUAL_HEX64(UINT64_C(0xEAA715DC790CE9C6), digest);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_every_bit_is_as_recorded);
    RUN_TEST(test_every_chain_gives_numbers_in_range_and_counts_losses);
    return UNITY_END();
}
