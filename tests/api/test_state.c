/* davar tests - a state that is saved and restored goes on bit for bit; a cut, damaged or foreign one is refused. */
#include "davar/davar.h"
#include "unity.h"

#include <string.h>

#define SLOT 8192U
#define SAMPLES 700U
#define HEADER_BYTES 20U /* of an image, in front of its payload */

static const uint32_t taus[4] = {1U, 2U, 5U, 8U};
static uint64_t memory[2][1024];
static davar_config_t config;
static davar_fit_plan_t plan;
static davar_t original;
static davar_t restored;

/* Two slots in RAM; the power goes when `budget` bytes have been written, or `reads` reads are done. */
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
    config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 0.01;
    config.full_scale = 300.0;
    config.window_max = 40U;
    config.window_min = 20U;
    config.segment = 5U;
    config.taus = taus;
    config.tau_count = 4U;
    config.fit_plan = &plan;
}

void tearDown(void) {}

typedef enum { Q15, Q31, F32 } type_t;

static void init(type_t type, davar_t *davar, unsigned which)
{
    davar_status_t status = DAVAR_OK;
    memset(memory[which], 0xA5, sizeof memory[which]);
    switch (type) {
    case Q15:
        status = davar_init_q15(davar, &config, memory[which], sizeof memory[which]);
        break;
    case Q31:
        status = davar_init_q31(davar, &config, memory[which], sizeof memory[which]);
        break;
    case F32:
    default:
        status = davar_init_f32(davar, &config, memory[which], sizeof memory[which]);
        break;
    }
    TEST_ASSERT_EQUAL(DAVAR_OK, status);
}

/* One sample of a noise that is at times four times as large, with a gap now and then; true: a result was taken. */
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
        (void)davar_push_q15(davar, &narrow, 1U);
    } else if (type == Q31) {
        (void)davar_push_q31(davar, &sample, 1U);
    } else {
        (void)davar_push_f32(davar, &rate, 1U);
    }
    memset(result, 0, sizeof *result);
    return davar_take(davar, result);
}

static void same_step(type_t type, uint32_t n)
{
    davar_result_t expected;
    davar_result_t actual;
    TEST_ASSERT_EQUAL(step(type, &original, n, &expected), step(type, &restored, n, &actual));
    TEST_ASSERT_EQUAL_MEMORY(&expected, &actual, sizeof expected);
}

static void survives(type_t type, uint32_t cut)
{
    davar_result_t result;
    init(type, &original, 0U);
    for (uint32_t n = 0U; n < cut; n++) {
        (void)step(type, &original, n, &result);
    }
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    init(type, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_restore(&restored, &storage));
    for (uint32_t n = cut; n < (cut + 250U); n++) {
        same_step(type, n);
    }
    const davar_health_t expected = davar_health(&original);
    const davar_health_t actual = davar_health(&restored);
    TEST_ASSERT_EQUAL_MEMORY(&expected, &actual, sizeof expected);
}

static void survives_anywhere(void)
{
    for (uint32_t cut = 0U; cut < SAMPLES; cut += 23U) {
        survives(Q15, cut);
        survives(Q31, cut);
        survives(F32, cut);
    }
}

static void test_a_restored_stream_goes_on_bit_for_bit(void)
{
    survives_anywhere();
    config.mode = DAVAR_MODE_TRAILING;
    survives_anywhere();
    config.policy = DAVAR_POLICY_FIXED;
    config.segment = 0U;
    survives_anywhere();
}

static void test_a_restored_grid_goes_on_bit_for_bit(void)
{
    config.stride = 7U;
    survives_anywhere();
    config.mode = DAVAR_MODE_TRAILING;
    survives_anywhere();
    config.stride = 90U; /* beyond the window: gaps between windows */
    survives_anywhere();
}

/* A waiting result of a grid lies in its records: it can be taken from the restored instance. */
static void test_a_waiting_result_survives(void)
{
    davar_result_t expected = {0};
    davar_result_t actual = {0};
    config.stride = 20U;
    init(Q15, &original, 0U);
    for (uint32_t n = 0U; !original.ready || (n % 20U != 7U); n++) {
        const int16_t sample = (int16_t)((n * 31U) % 17U);
        (void)davar_push_q15(&original, &sample, 1U);
    }
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    init(Q15, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_restore(&restored, &storage));
    TEST_ASSERT_TRUE(davar_take(&original, &expected) && davar_take(&restored, &actual));
    TEST_ASSERT_EQUAL_MEMORY(&expected, &actual, sizeof expected);
}

/* Epoch of the next result of what the storage holds. */
static uint64_t restored_epoch(void)
{
    davar_result_t result;
    init(Q15, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_restore(&restored, &storage));
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

static void test_power_lost_at_any_byte_of_a_save_leaves_the_image_before(void)
{
    init(Q15, &original, 0U);
    feed(0U, 100U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    feed(100U, 150U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
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

static void test_a_refused_image_leaves_the_instance_as_init_made_it(void)
{
    init(Q15, &original, 0U);
    init(Q15, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_ERR_STATE_NONE, davar_state_restore(&restored, &storage));
    for (uint32_t n = 0U; n < 100U; n++) {
        same_step(Q15, n);
    }
}

static void foreign(type_t type)
{
    init(type, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_ERR_STATE_FOREIGN, davar_state_restore(&restored, &storage));
    setUp();
}

static void test_an_image_of_another_configuration_is_foreign(void)
{
    static const uint32_t other_taus[4] = {1U, 2U, 5U, 9U};
    init(Q15, &original, 0U);
    feed(0U, 100U);
    static unsigned char image[sizeof cells];
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    memcpy(image, cells, sizeof cells);
    foreign(Q31);
    memcpy(cells, image, sizeof cells), config.taus = other_taus, foreign(Q15);
    memcpy(cells, image, sizeof cells), config.unit_per_count = 0.02, foreign(Q15);
    memcpy(cells, image, sizeof cells), config.stride = 2U, foreign(Q15);
    memcpy(cells, image, sizeof cells), config.kurtosis_high = 3.4, foreign(Q15);
    memcpy(cells, image, sizeof cells), config.mirrored_end = true, foreign(Q15);
    memcpy(cells, &image[SLOT], SLOT), memcpy(&cells[SLOT], image, SLOT), config.grow = 0U, foreign(Q15);
}

static void test_storage_that_is_too_small_is_refused(void)
{
    init(Q15, &original, 0U);
    storage.slot_bytes = davar_state_bytes(&original) - 1U;
    TEST_ASSERT_EQUAL(DAVAR_ERR_STATE_STORAGE, davar_state_save(&original, &storage));
    TEST_ASSERT_EQUAL(DAVAR_ERR_STATE_STORAGE, davar_state_restore(&original, &storage));
}

/* The storage may fail at any read: nothing is taken for whole that could not be read to its end. */
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

/* Storage whose second reading of a byte differs from the first, in one bit. */
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

/* Restores while one bit of the second reading of a slot is turned. */
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

/* `restored` just after init, to the byte. */
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
    config.window_max = 20U;
    config.window_min = 10U;
    config.fit_plan = NULL;
    init(Q15, &original, 0U);
    feed(0U, 120U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    const size_t bytes = davar_state_bytes(&original);
    for (size_t bit = (size_t)8U * HEADER_BYTES; bit < (8U * bytes); bit += bits_apart) {
        init_afresh();
        TEST_ASSERT_EQUAL(DAVAR_ERR_STATE_STORAGE, restore_unsteadily(bit / 8U, (unsigned)(bit % 8U)));
        TEST_ASSERT_TRUE(flip_seen);
        is_as_after_init();
    }
}

static void test_a_second_reading_that_differs_is_refused(void)
{
    no_second_reading_is_believed(1U, 1U);
    no_second_reading_is_believed(7U, 13U);
}

static void test_the_other_slot_steps_in_for_a_reading_that_differs(void)
{
    init(Q15, &original, 0U);
    feed(0U, 100U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    feed(100U, 150U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    const size_t bytes = davar_state_bytes(&original);
    for (size_t offset = SLOT + HEADER_BYTES; offset < (SLOT + bytes); offset++) {
        init(Q15, &restored, 1U);
        TEST_ASSERT_EQUAL(DAVAR_OK, restore_unsteadily(offset, (unsigned)(offset % 8U)));
        TEST_ASSERT_TRUE(flip_seen);
        goes_on_as(101U - 20U);
    }
}

/* What restoring says when only the first `count` - 1 reads are done. */
static davar_status_t status_of_restore(size_t count)
{
    reads = count;
    init_afresh();
    return davar_state_restore(&restored, &storage);
}

/* The second reading fails, wherever: the instance is as init made it. */
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

/* Flash that lost its power in the middle of a page answers no read of it, for ever. */
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
        dead_slot = 1U - slot; /* the other one is whole */
        TEST_ASSERT_EQUAL_UINT64(n + 1U - 20U, restored_epoch());
        TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
        TEST_ASSERT_EQUAL_UINT(2U, dead_slot);
        TEST_ASSERT_EQUAL_UINT64(n + 51U - 20U, restored_epoch());
    }
    memset(cells, 0xFF, sizeof cells);
    dead_slot = 0U; /* the very first save was cut */
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
}

/* An image says which version and how many bytes: both are checked even when the rest happens to agree. */
static void test_an_image_of_another_size_is_foreign(void)
{
    init(Q15, &original, 0U);
    feed(0U, 100U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    cells[4]--; /* one byte less, and a check that agrees */
    const size_t bytes = davar_state_bytes(&original) - 1U - 20U;
    uint32_t crc = 0xFFFFFFFFU;
    for (size_t i = 0U; i < (16U + bytes); i++) {
        crc ^= cells[(i < 16U) ? i : (i + 4U)];
        for (unsigned k = 0U; k < 8U; k++) {
            crc = ((crc & 1U) != 0U) ? ((crc >> 1U) ^ 0xEDB88320U) : (crc >> 1U);
        }
    }
    crc = ~crc;
    memcpy(&cells[16], &crc, sizeof crc);
    init(Q15, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_ERR_STATE_FOREIGN, davar_state_restore(&restored, &storage));
}

/* Hundreds of saves: the slots take turns, and the newest wins. */
static void test_saves_take_turns(void)
{
    init(Q15, &original, 0U);
    feed(0U, 50U);
    for (uint32_t n = 50U; n < 300U; n++) {
        feed(n, n + 1U);
        TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
        TEST_ASSERT_EQUAL_UINT64(n + 2U - 20U, restored_epoch());
    }
}

/* One plan for many instances, or none at all: the fit is a pure function. */
static void test_results_do_not_depend_on_the_plan(void)
{
    davar_config_t planned = config;
    davar_result_t expected;
    davar_result_t actual;
    config.fit_plan = NULL;
    init(Q15, &original, 0U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&restored, &planned, memory[1], sizeof memory[1]));
    for (uint32_t n = 0U; n < 200U; n++) {
        TEST_ASSERT_EQUAL(step(Q15, &original, n, &expected), step(Q15, &restored, n, &actual));
        TEST_ASSERT_EQUAL_MEMORY(&expected, &actual, sizeof expected);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_restored_stream_goes_on_bit_for_bit);
    RUN_TEST(test_a_restored_grid_goes_on_bit_for_bit);
    RUN_TEST(test_a_waiting_result_survives);
    RUN_TEST(test_power_lost_at_any_byte_of_a_save_leaves_the_image_before);
    RUN_TEST(test_a_single_damaged_byte_is_found);
    RUN_TEST(test_a_refused_image_leaves_the_instance_as_init_made_it);
    RUN_TEST(test_an_image_of_another_configuration_is_foreign);
    RUN_TEST(test_storage_that_is_too_small_is_refused);
    RUN_TEST(test_storage_that_fails_at_any_read_is_survived);
    RUN_TEST(test_a_second_reading_that_differs_is_refused);
    RUN_TEST(test_the_other_slot_steps_in_for_a_reading_that_differs);
    RUN_TEST(test_a_second_reading_that_fails_leaves_the_instance_as_init_made_it);
    RUN_TEST(test_a_slot_that_cannot_be_read_costs_only_itself);
    RUN_TEST(test_an_image_of_another_size_is_foreign);
    RUN_TEST(test_saves_take_turns);
    RUN_TEST(test_results_do_not_depend_on_the_plan);
    return UNITY_END();
}
