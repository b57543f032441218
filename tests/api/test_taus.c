/* davar tests - the series of cluster sizes. */
#include "davar/davar.h"
#include "unity.h"

static uint32_t taus[DAVAR_TAUS_MAX];

void setUp(void) {}
void tearDown(void) {}

static void test_octaves_stop_at_a_ninth_of_the_window(void)
{
    TEST_ASSERT_EQUAL_UINT8(0U, davar_taus_octave(1U, taus, DAVAR_TAUS_MAX));
    TEST_ASSERT_EQUAL_UINT8(1U, davar_taus_octave(2U, taus, DAVAR_TAUS_MAX));
    TEST_ASSERT_EQUAL_UINT8(7U, davar_taus_octave(600U, taus, DAVAR_TAUS_MAX));
    TEST_ASSERT_EQUAL_UINT32(64U, taus[6]);
    TEST_ASSERT_EQUAL_UINT8(6U, davar_taus_octave(575U, taus, DAVAR_TAUS_MAX));
    TEST_ASSERT_EQUAL_UINT8(3U, davar_taus_octave(600U, taus, 3U));
}

static void test_the_geometric_series_is_distinct_and_ends_at_a_ninth_of_the_window(void)
{
    TEST_ASSERT_EQUAL_UINT8(0U, davar_taus_geometric(1U, 5U, taus, DAVAR_TAUS_MAX));
    TEST_ASSERT_EQUAL_UINT8(0U, davar_taus_geometric(600U, 0U, taus, DAVAR_TAUS_MAX));
    for (uint32_t window = 2U; window < 20000U; window += 1U + (window / 7U)) {
        for (uint8_t wanted = 1U; wanted <= DAVAR_TAUS_MAX; wanted++) {
            const uint8_t count = davar_taus_geometric(window, wanted, taus, DAVAR_TAUS_MAX);
            TEST_ASSERT_TRUE((count >= 1U) && (count <= wanted));
            TEST_ASSERT_EQUAL_UINT32(1U, taus[0]);
            for (uint8_t t = 1U; t < count; t++) {
                TEST_ASSERT_TRUE(taus[t] > taus[t - 1U]);
            }
            if (wanted > 1U) {
                TEST_ASSERT_EQUAL_UINT32((window < 18U) ? 1U : (window / 9U), taus[count - 1U]);
            }
        }
    }
    TEST_ASSERT_EQUAL_UINT8(2U, davar_taus_geometric(5400U, 12U, taus, 2U));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_octaves_stop_at_a_ninth_of_the_window);
    RUN_TEST(test_the_geometric_series_is_distinct_and_ends_at_a_ninth_of_the_window);
    return UNITY_END();
}
