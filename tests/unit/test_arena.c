/* davar tests - memory is allocated without overlap. A size that does not fit a size_t looks too
 * large, never small. */
#include "core/arena.h"

#include "unity.h"

void setUp(void) {}

void tearDown(void) {}

static void test_pieces_follow_one_another_at_multiples_of_eight(void)
{
    uint64_t memory[8];
    davar_arena_t arena = {(unsigned char *)memory, 0U};
    TEST_ASSERT_EQUAL_PTR(&memory[0], davar_arena_take(&arena, 3U, 3U));
    TEST_ASSERT_EQUAL_PTR(&memory[2], davar_arena_take(&arena, 1U, 1U));
    TEST_ASSERT_NULL(davar_arena_take(&arena, 0U, 4U));
    TEST_ASSERT_EQUAL_size_t(24U, arena.used);
}

static void test_sizes_that_do_not_fit_stay_too_large(void)
{
    davar_arena_t arena = {NULL, 0U};
    TEST_ASSERT_NULL(davar_arena_take(&arena, (SIZE_MAX / 3U) + 1U, 3U));
    TEST_ASSERT_EQUAL_size_t(SIZE_MAX - 7U, arena.used);
    TEST_ASSERT_NULL(davar_arena_take(&arena, 100U, 8U));
    TEST_ASSERT_EQUAL_size_t(SIZE_MAX - 7U, arena.used);
    arena.used = 0U;
    (void)davar_arena_take(&arena, 1U, SIZE_MAX / 2U);
    (void)davar_arena_take(&arena, 1U, SIZE_MAX / 2U);
    TEST_ASSERT_EQUAL_size_t(SIZE_MAX - 7U, arena.used);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_pieces_follow_one_another_at_multiples_of_eight);
    RUN_TEST(test_sizes_that_do_not_fit_stay_too_large);
    return UNITY_END();
}
