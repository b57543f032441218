/* davar tests - storage that is cut, damaged, unsteady or dead: the restored state is complete, the
 * previous one, or absent. */
#include "state_fixture.h"

#define HEADER_BYTES 20U /* of an image, before its payload */

/* Both slots hold an image: of 100 samples, and, the newer, of 150. */
static void save_twice(void)
{
    init(Q15, &original, 0U);
    feed(0U, 100U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    feed(100U, 150U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
}

static void test_power_lost_at_any_byte_of_a_save_leaves_the_image_before(void)
{
    save_twice();
    feed(150U, 200U);
    static unsigned char before[sizeof cells];
    memcpy(before, cells, sizeof cells);
    for (size_t bytes = 0U; bytes < davar_state_bytes(&original); bytes++) {
        memcpy(cells, before, sizeof cells);
        budget = bytes;
        TEST_ASSERT_EQUAL(DAVAR_ERR_STATE_STORAGE, davar_state_save(&original, &storage));
        TEST_ASSERT_EQUAL_UINT64(151U - 20U, restored_epoch());
    }
    memcpy(cells, before, sizeof cells);
    budget = davar_state_bytes(&original);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    TEST_ASSERT_EQUAL_UINT64(201U - 20U, restored_epoch());
}

static void test_a_single_damaged_byte_is_found(void)
{
    init(Q15, &original, 0U);
    feed(0U, 100U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    for (size_t byte = 0U; byte < davar_state_bytes(&original); byte++) {
        for (unsigned bit = 0U; bit < 8U; bit += 3U) {
            cells[byte] ^= (unsigned char)(1U << bit);
            init(Q15, &restored, 1U);
            TEST_ASSERT_EQUAL(DAVAR_ERR_STATE_NONE, davar_state_restore(&restored, &storage));
            cells[byte] ^= (unsigned char)(1U << bit);
        }
    }
    TEST_ASSERT_EQUAL_UINT64(101U - 20U, restored_epoch());
}

/* The storage may fail at any read: a state that could not be read to its end is never used. */
static void test_storage_that_fails_at_any_read_is_survived(void)
{
    init(Q15, &original, 0U);
    feed(0U, 100U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    unsigned failures = 0U;
    davar_status_t status;
    do {
        failures++;
        reads = failures;
        init(Q15, &restored, 1U);
        status = davar_state_restore(&restored, &storage);
        TEST_ASSERT_TRUE((status == DAVAR_OK) || (status == DAVAR_ERR_STATE_STORAGE) ||
                         (status == DAVAR_ERR_STATE_NONE));
    } while (status != DAVAR_OK);
    TEST_ASSERT_GREATER_THAN_UINT(4U, failures);
    reads = 2U;
    TEST_ASSERT_EQUAL(DAVAR_ERR_STATE_STORAGE, davar_state_save(&original, &storage));
    reads = SIZE_MAX;
    TEST_ASSERT_EQUAL_UINT64(101U - 20U, restored_epoch());
}

/* A storage whose second reading of a byte differs from the first in one bit. */
static size_t flip_offset;
static unsigned char flip_mask;
static bool flip_seen;

static bool read_unsteady(void *context, size_t offset, void *data, size_t bytes)
{
    const bool done = read_cells(context, offset, data, bytes);
    if ((flip_offset >= offset) && (flip_offset < (offset + bytes))) {
        unsigned char *const byte = &((unsigned char *)data)[flip_offset - offset];
        *byte ^= flip_seen ? flip_mask : 0U;
        flip_seen = true;
    }
    return done;
}

/* Restores while one bit of the second reading of a slot is flipped. */
static davar_status_t restore_unsteadily(size_t offset, unsigned bit)
{
    flip_offset = offset;
    flip_mask = (unsigned char)(1U << bit);
    flip_seen = false;
    storage.read = read_unsteady;
    const davar_status_t status = davar_state_restore(&restored, &storage);
    storage.read = read_cells;
    return status;
}

static void goes_on_as(uint64_t epoch)
{
    davar_result_t result;
    TEST_ASSERT_TRUE(step(Q15, &restored, 0U, &result));
    TEST_ASSERT_EQUAL_UINT64(epoch, result.epoch);
}

/* `restored` just after init, byte for byte. */
static davar_t fresh;
static uint64_t fresh_memory[1024];

static void init_afresh(void)
{
    init(Q15, &restored, 1U);
    fresh = restored;
    memcpy(fresh_memory, memory[1], sizeof fresh_memory);
}

static void is_as_after_init(void)
{
    TEST_ASSERT_EQUAL_MEMORY(&fresh, &restored, sizeof fresh);
    TEST_ASSERT_EQUAL_MEMORY(fresh_memory, memory[1], sizeof fresh_memory);
}

/* One bit in every `bits_apart`. */
static void no_second_reading_is_believed(uint32_t stride, unsigned bits_apart)
{
    setUp();
    config.stride = stride;
    config.window.longest = 20U;
    config.window.shortest = 10U;
    init(Q15, &original, 0U);
    feed(0U, 120U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    const size_t bytes = davar_state_bytes(&original);
    for (size_t bit = (size_t)8U * HEADER_BYTES; bit < (8U * bytes); bit += bits_apart) {
        init_afresh();
        TEST_ASSERT_EQUAL(DAVAR_ERR_STATE_STORAGE,
                          restore_unsteadily(bit / 8U, (unsigned)(bit % 8U)));
        TEST_ASSERT_TRUE(flip_seen);
        is_as_after_init();
    }
}

static void test_a_second_reading_that_differs_is_rejected(void)
{
    no_second_reading_is_believed(1U, 1U);
    no_second_reading_is_believed(7U, 13U);
}

static void test_the_other_slot_steps_in_for_a_reading_that_differs(void)
{
    save_twice();
    const size_t bytes = davar_state_bytes(&original);
    for (size_t offset = SLOT + HEADER_BYTES; offset < (SLOT + bytes); offset++) {
        init(Q15, &restored, 1U);
        TEST_ASSERT_EQUAL(DAVAR_OK, restore_unsteadily(offset, (unsigned)(offset % 8U)));
        TEST_ASSERT_TRUE(flip_seen);
        goes_on_as(101U - 20U);
    }
}

/* The status of restore if only the first `count` - 1 reads succeed. */
static davar_status_t status_of_restore(size_t count)
{
    reads = count;
    init_afresh();
    return davar_state_restore(&restored, &storage);
}

/* The second reading fails anywhere: the instance stays as after init. */
static void test_a_second_reading_that_fails_leaves_the_instance_as_init_made_it(void)
{
    init(Q15, &original, 0U);
    feed(0U, 100U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    size_t n = 1U;
    for (; status_of_restore(n) != DAVAR_OK; n++) {
        is_as_after_init();
    }
    TEST_ASSERT_GREATER_THAN_UINT(8U, n);
}

/* Flash that lost its power in the middle of a page never answers a read of that page. */
static unsigned dead_slot;

static bool read_half_dead(void *context, size_t offset, void *data, size_t bytes)
{
    return ((offset / SLOT) != dead_slot) && read_cells(context, offset, data, bytes);
}

static bool revive(void *context, size_t offset, const void *data, size_t bytes)
{
    dead_slot = ((offset / SLOT) == dead_slot) ? 2U : dead_slot;
    return write_cells(context, offset, data, bytes);
}

static void test_a_slot_that_cannot_be_read_costs_only_itself(void)
{
    init(Q15, &original, 0U);
    feed(0U, 100U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    storage.write = revive;
    storage.read = read_half_dead;
    for (unsigned slot = 0U; slot < 2U; slot++) {
        const uint32_t n = 100U + (50U * slot);
        feed(n, n + 50U);
        dead_slot = 1U - slot; /* the other one is intact */
        TEST_ASSERT_EQUAL_UINT64(n + 1U - 20U, restored_epoch());
        TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
        TEST_ASSERT_EQUAL_UINT(2U, dead_slot);
        TEST_ASSERT_EQUAL_UINT64(n + 51U - 20U, restored_epoch());
    }
    memset(cells, 0xFF, sizeof cells);
    dead_slot = 0U; /* the very first save was cut */
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_power_lost_at_any_byte_of_a_save_leaves_the_image_before);
    RUN_TEST(test_a_single_damaged_byte_is_found);
    RUN_TEST(test_storage_that_fails_at_any_read_is_survived);
    RUN_TEST(test_a_second_reading_that_differs_is_rejected);
    RUN_TEST(test_the_other_slot_steps_in_for_a_reading_that_differs);
    RUN_TEST(test_a_second_reading_that_fails_leaves_the_instance_as_init_made_it);
    RUN_TEST(test_a_slot_that_cannot_be_read_costs_only_itself);
    return UNITY_END();
}
