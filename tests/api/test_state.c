/* davar tests - a saved and restored state continues bit for bit. A foreign image is rejected; from
 * storage that is cut, damaged, unsteady or dead comes a complete state or none. */
#include "davar_law_id.h"
#include "fitted.h"
#include "state_fixture.h"

#include <math.h>

#define SAMPLES 700U
#ifndef CUTS_APART /* an emulated board uses fewer */
#define CUTS_APART 23U
#endif
#define HEADER_BYTES 20U /* of an image, before its payload */

static void save(void)
{
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_state_save(&original, &storage));
}

/* `original` after `samples`, and its image. */
static void save_after(type_t type, uint32_t samples)
{
    davar_result_t result;
    init(type, &original, 0U);
    for (uint32_t n = 0U; n < samples; n++) {
        (void)step(type, &original, n, &result);
    }
    save();
}

static void restore(type_t type)
{
    init(type, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_state_restore(&restored, &storage));
}

static void same_step(type_t type, uint32_t n)
{
    davar_result_t expected;
    davar_result_t actual;
    TEST_ASSERT_EQUAL(step(type, &original, n, &expected), step(type, &restored, n, &actual));
    TEST_ASSERT_EQUAL_MEMORY(&expected, &actual, sizeof expected);
}

static void test_a_restored_stream_continues_bit_for_bit(void)
{
    static const struct {
        uint32_t stride; /* 40: windows side by side */
        bool is_grid;
        bool is_fixed;
    } cases[] = {
        {1U, false, false},  {1U, false, true}, {7U, false, false},
        {40U, false, false}, {7U, true, false}, {40U, true, false},
    };
    for (size_t i = 0U; i < sizeof cases / sizeof cases[0]; i++) {
        config.stride = cases[i].stride;
        config.law = cases[i].is_fixed ? NULL : &davar_law_or;
        config.moments.segment = cases[i].is_fixed ? 0U : 5U;
        for (uint32_t cut = 0U; cut < SAMPLES; cut += CUTS_APART) {
            for (type_t type = Q15; type <= F32; type++) {
                config.engine = davar_grid_of(cases[i].is_grid, type != Q15);
                save_after(type, cut);
                restore(type);
                for (uint32_t n = cut; n < (cut + 250U); n++) {
                    same_step(type, n);
                }
                const davar_health_t expected = davar_health(&original);
                const davar_health_t actual = davar_health(&restored);
                TEST_ASSERT_EQUAL_MEMORY(&expected, &actual, sizeof expected);
            }
        }
    }
}

/* Leaves bytes on the stack for the variables of the next call. */
static void dirty_stack(int byte)
{
    volatile unsigned char bytes[4096];
    for (size_t i = 0U; i < sizeof bytes; i++) {
        bytes[i] = (unsigned char)byte;
    }
}

/* The padding of the image has no bytes of an earlier call. */
static void test_the_same_state_has_the_same_image(void)
{
    static unsigned char image[sizeof cells];
    init(Q15, &original, 0U);
    feed(0U, 500U);
    dirty_stack(0x5A);
    save();
    memcpy(image, cells, sizeof image);
    memset(cells, 0xFF, sizeof cells);
    dirty_stack(0xA5);
    save();
    TEST_ASSERT_EQUAL_MEMORY(image, cells, sizeof image);
}

/* In the middle of a run of floats that are not numbers: still one gap. */
static void test_a_gap_that_continues_survives(void)
{
    const float none = NAN;
    init(F32, &original, 0U);
    davar_push_f32(&original, &none, 1U);
    save();
    restore(F32);
    davar_push_f32(&restored, &none, 1U);
    TEST_ASSERT_EQUAL_UINT32(1U, davar_health(&restored).gaps);
    TEST_ASSERT_EQUAL_UINT32(2U, davar_health(&restored).missing);
}

/* ---- foreign images ---- */

static void test_an_image_of_another_number_type_is_foreign(void)
{
    for (uint32_t i = 0U; i < 9U; i++) {
        const type_t type = (type_t)(i / 3U);
        setUp();
        save_after(type, 1U);
        init((type_t)(i % 3U), &restored, 1U);
        TEST_ASSERT_EQUAL((type == (type_t)(i % 3U)) ? DAVAR_STATE_OK : DAVAR_STATE_ERR_FOREIGN,
                          davar_state_restore(&restored, &storage));
    }
}

/* Every field of the configuration but a pointer with one bit changed: if init accepts it, the image
 * is foreign. */
static const struct {
    const char *name;
    size_t offset;
    size_t bytes;
} fields[] = {
/* tests/style/test_config_fields.py checks that the list is complete */
#define FIELD(member, kind) {#member, offsetof(davar_config_t, member), sizeof config.member},
#include "davar/config_fields.inc"
};

static uint32_t bits_that_matter(size_t which)
{
    const davar_config_t before = config;
    uint32_t taken = 0U;
    const bool is_pointer = (fields[which].offset == offsetof(davar_config_t, engine));
    const uint32_t bits = is_pointer ? 0U : (8U * (uint32_t)fields[which].bytes);
    for (uint32_t bit = 0U; bit < bits; bit++) {
        unsigned char *const byte = (unsigned char *)&config + fields[which].offset + (bit / 8U);
        *byte ^= (unsigned char)(1U << (bit % 8U));
        if (davar_init_q15(&restored, &config, memory[1], sizeof memory[1]) == DAVAR_OK) {
            TEST_ASSERT_EQUAL_MESSAGE(DAVAR_STATE_ERR_FOREIGN,
                                      davar_state_restore(&restored, &storage), fields[which].name);
            taken++;
        }
        config = before;
    }
    return taken;
}

static void test_one_bit_of_the_configuration_makes_an_image_foreign(void)
{
    static const uint32_t other_taus[4] = {1U, 2U, 5U, 9U};
    static uint32_t more_taus[DAVAR_TAUS_MAX];
    uint32_t taken = 0U;
    for (uint32_t t = 0U; t < DAVAR_TAUS_MAX; t++) {
        more_taus[t] = t + 1U;
    }
    config.taus = more_taus;
    save_after(Q15, 100U);
    for (size_t i = 0U; i < (sizeof fields / sizeof fields[0]); i++) {
        taken += bits_that_matter(i);
    }
    TEST_ASSERT_GREATER_THAN_UINT32(500U, taken);
    config.engine = &davar_engine_grid_q15;
    init(Q15, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_STATE_ERR_FOREIGN, davar_state_restore(&restored, &storage));
    config.engine = NULL;
    config.law = &davar_law_and;
    init(Q15, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_STATE_ERR_FOREIGN, davar_state_restore(&restored, &storage));
    config.law = &davar_law_or;
    config.taus = other_taus;
    memcpy(&cells[SLOT], cells, SLOT); /* in the other slot alone */
    memset(cells, 0xFF, SLOT);
    init(Q15, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_STATE_ERR_FOREIGN, davar_state_restore(&restored, &storage));
}

static void test_storage_that_is_too_small_is_rejected(void)
{
    init(Q15, &original, 0U);
    storage.slot_bytes = davar_state_bytes(&original) - 1U;
    TEST_ASSERT_EQUAL(DAVAR_STATE_ERR_STORAGE, davar_state_save(&original, &storage));
    TEST_ASSERT_EQUAL(DAVAR_STATE_ERR_STORAGE, davar_state_restore(&original, &storage));
}

/* The CRC-32 of an image with `bytes` of payload: of all its bytes except the check itself. */
static uint32_t check_of_image(const unsigned char *image, size_t bytes)
{
    uint32_t crc = 0xFFFFFFFFU;
    for (size_t i = 0U; i < (16U + bytes); i++) {
        crc ^= image[(i < 16U) ? i : (i + 4U)];
        for (unsigned k = 0U; k < 8U; k++) {
            crc = ((crc & 1U) != 0U) ? ((crc >> 1U) ^ 0xEDB88320U) : (crc >> 1U);
        }
    }
    return ~crc;
}

static void reverse(unsigned char *word)
{
    for (unsigned i = 0U; i < 2U; i++) {
        const unsigned char kept = word[i];
        word[i] = word[3U - i];
        word[3U - i] = kept;
    }
}

/* An image states its version, size and byte order. All are checked even if the rest matches: a
 * foreign image is not absent, and is never restored. */
static void test_an_image_of_another_size_or_byte_order_is_foreign(void)
{
    save_after(Q15, 100U);
    const size_t payload = davar_state_bytes(&original) - HEADER_BYTES;
    init(Q15, &restored, 1U);
    cells[4]--; /* one byte less, and a matching check */
    uint32_t check = check_of_image(cells, payload - 1U);
    memcpy(&cells[16], &check, sizeof check);
    TEST_ASSERT_EQUAL(DAVAR_STATE_ERR_FOREIGN, davar_state_restore(&restored, &storage));
    cells[4]++;
    for (unsigned field = 0U; field < 4U; field++) {
        reverse(&cells[(size_t)4U * field]);
    }
    check = check_of_image(cells, payload);
    memcpy(&cells[16], &check, sizeof check);
    reverse(&cells[16]);
    TEST_ASSERT_EQUAL(DAVAR_STATE_ERR_FOREIGN, davar_state_restore(&restored, &storage));
    cells[50] ^= 1U;
    TEST_ASSERT_EQUAL(DAVAR_STATE_ERR_NONE, davar_state_restore(&restored, &storage));
    cells[50] ^= 1U;
    cells[4] = 0xFFU; /* more bytes than a slot has */
    TEST_ASSERT_EQUAL(DAVAR_STATE_ERR_NONE, davar_state_restore(&restored, &storage));
    for (unsigned i = 0U; i < 2U; i++) { /* next to it, and then over it */
        save();
        restore(Q15);
    }
    for (uint32_t n = 100U; n < 200U; n++) {
        same_step(Q15, n);
    }
}

/* ---- faults of the storage ---- */

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

/* Both slots hold an image: of 100 samples, and, the newer, of 150. */
static void save_twice(void)
{
    save_after(Q15, 100U);
    feed(100U, 150U);
    save();
}

static void test_power_lost_at_any_byte_of_a_save_leaves_the_image_before(void)
{
    static unsigned char before[sizeof cells];
    save_twice();
    feed(150U, 200U);
    memcpy(before, cells, sizeof cells);
    for (size_t bytes = 0U; bytes < davar_state_bytes(&original); bytes++) {
        memcpy(cells, before, sizeof cells);
        budget = bytes;
        TEST_ASSERT_EQUAL(DAVAR_STATE_ERR_STORAGE, davar_state_save(&original, &storage));
        TEST_ASSERT_EQUAL_UINT64(151U - 1U, restored_epoch());
    }
    memcpy(cells, before, sizeof cells);
    budget = davar_state_bytes(&original);
    save();
    TEST_ASSERT_EQUAL_UINT64(201U - 1U, restored_epoch());
}

static void test_a_single_damaged_byte_is_found(void)
{
    save_after(Q15, 100U);
    for (size_t byte = 0U; byte < davar_state_bytes(&original); byte++) {
        for (unsigned bit = 0U; bit < 8U; bit += 3U) {
            cells[byte] ^= (unsigned char)(1U << bit);
            init_afresh();
            TEST_ASSERT_EQUAL(DAVAR_STATE_ERR_NONE, davar_state_restore(&restored, &storage));
            is_as_after_init();
            cells[byte] ^= (unsigned char)(1U << bit);
        }
    }
    TEST_ASSERT_EQUAL_UINT64(101U - 1U, restored_epoch());
}

/* The storage may fail at any read: the instance is then as after init. */
static void test_storage_that_fails_at_any_read_is_survived(void)
{
    for (uint32_t images = 1U; images < 3U; images++) {
        setUp();
        save_after(Q15, 100U);
        if (images > 1U) {
            save();
        }
        davar_state_status_t status = DAVAR_STATE_ERR_NONE;
        for (size_t n = 1U; status != DAVAR_STATE_OK; n++) {
            reads = n;
            init_afresh();
            status = davar_state_restore(&restored, &storage);
            if (status != DAVAR_STATE_OK) {
                TEST_ASSERT_TRUE((status == DAVAR_STATE_ERR_STORAGE) ||
                                 (status == DAVAR_STATE_ERR_NONE));
                is_as_after_init();
            }
            TEST_ASSERT_TRUE((status != DAVAR_STATE_OK) || (n > 4U));
        }
        reads = 2U;
        TEST_ASSERT_EQUAL(DAVAR_STATE_ERR_STORAGE, davar_state_save(&original, &storage));
        reads = SIZE_MAX;
        TEST_ASSERT_EQUAL_UINT64(101U - 1U, restored_epoch());
    }
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
static davar_state_status_t restore_unsteadily(size_t offset, unsigned bit)
{
    flip_offset = offset;
    flip_mask = (unsigned char)(1U << bit);
    flip_seen = false;
    storage.read = read_unsteady;
    init_afresh();
    const davar_state_status_t status = davar_state_restore(&restored, &storage);
    storage.read = read_cells;
    TEST_ASSERT_TRUE(flip_seen);
    return status;
}

static void test_a_second_reading_that_differs_is_rejected(void)
{
    static const uint32_t strides[] = {1U, 7U};
    static const size_t bits_apart[] = {1U, 13U};
    for (uint32_t i = 0U; i < 2U; i++) {
        setUp();
        config.stride = strides[i];
        config.window.longest = 20U;
        config.window.shortest = 10U;
        save_after(Q15, 120U);
        const size_t bytes = davar_state_bytes(&original);
        for (size_t bit = (size_t)8U * HEADER_BYTES; bit < (8U * bytes); bit += bits_apart[i]) {
            TEST_ASSERT_EQUAL(DAVAR_STATE_ERR_STORAGE,
                              restore_unsteadily(bit / 8U, (unsigned)(bit % 8U)));
            is_as_after_init();
        }
    }
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
    save_after(Q15, 100U);
    storage.write = revive;
    storage.read = read_half_dead;
    for (unsigned slot = 0U; slot < 2U; slot++) {
        const uint32_t n = 100U + (50U * slot);
        feed(n, n + 50U);
        dead_slot = 1U - slot; /* the other one is intact */
        TEST_ASSERT_EQUAL_UINT64(n + 1U - 1U, restored_epoch());
        save();
        TEST_ASSERT_EQUAL_UINT(2U, dead_slot);
        TEST_ASSERT_EQUAL_UINT64(n + 51U - 1U, restored_epoch());
    }
    memset(cells, 0xFF, sizeof cells);
    dead_slot = 0U; /* the very first save was cut */
    save();
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_restored_stream_continues_bit_for_bit);
    RUN_TEST(test_the_same_state_has_the_same_image);
    RUN_TEST(test_a_gap_that_continues_survives);
    RUN_TEST(test_an_image_of_another_number_type_is_foreign);
    RUN_TEST(test_one_bit_of_the_configuration_makes_an_image_foreign);
    RUN_TEST(test_storage_that_is_too_small_is_rejected);
    RUN_TEST(test_an_image_of_another_size_or_byte_order_is_foreign);
    RUN_TEST(test_power_lost_at_any_byte_of_a_save_leaves_the_image_before);
    RUN_TEST(test_a_single_damaged_byte_is_found);
    RUN_TEST(test_storage_that_fails_at_any_read_is_survived);
    RUN_TEST(test_a_second_reading_that_differs_is_rejected);
    RUN_TEST(test_a_slot_that_cannot_be_read_costs_only_itself);
    return UNITY_END();
}
