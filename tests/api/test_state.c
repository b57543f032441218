/* davar tests - a saved and restored state continues bit for bit; a foreign one is rejected. */
#include "fitted.h"
#include "state_fixture.h"

#include <math.h>

#define SAMPLES 700U
#ifndef CUTS_APART /* an emulated board uses fewer */
#define CUTS_APART 23U
#endif

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
    for (uint32_t cut = 0U; cut < SAMPLES; cut += CUTS_APART) {
        survives(Q15, cut);
        survives(Q31, cut);
        survives(F32, cut);
    }
}

static void test_a_restored_stream_continues_bit_for_bit(void)
{
    survives_anywhere();
    config.window.mode = DAVAR_MODE_TRAILING;
    survives_anywhere();
    config.law = NULL;
    config.moments.segment = 0U;
    survives_anywhere();
}

static void survives_a_stride(davar_engine_t engine)
{
    config.engine = engine;
    config.window.mode = DAVAR_MODE_CENTRED;
    config.stride = 7U;
    survives_anywhere();
    config.window.mode = DAVAR_MODE_TRAILING;
    survives_anywhere();
    config.stride = config.window.longest; /* windows side by side */
    survives_anywhere();
}

static void test_a_restored_stride_continues_bit_for_bit(void)
{
    survives_a_stride(DAVAR_ENGINE_AUTO);
}

static void test_a_restored_grid_continues_bit_for_bit(void)
{
    survives_a_stride(DAVAR_ENGINE_GRID);
}

static void waiting_result_survives(davar_engine_t engine)
{
    davar_result_t expected = {0};
    davar_result_t actual = {0};
    config.stride = 20U;
    config.engine = engine;
    init(Q15, &original, 0U);
    for (uint32_t n = 0U; !original.ready || (n % 20U != 7U) || !original.unstable; n++) {
        TEST_ASSERT_LESS_THAN_UINT32(10000U, n);
        const int16_t sample = (int16_t)(((n * 31U) % 17U) * (((n / 50U) % 2U == 0U) ? 1U : 9U));
        davar_push_q15(&original, &sample, 1U);
    }
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    TEST_ASSERT_TRUE(take_fitted(&original, &expected));
    memset(memory[0], 0x5A, sizeof memory[0]); /* nothing of it may be read */
    init(Q15, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_restore(&restored, &storage));
    TEST_ASSERT_TRUE(take_fitted(&restored, &actual));
    TEST_ASSERT_EQUAL_MEMORY(&expected, &actual, sizeof expected);
    TEST_ASSERT_TRUE(actual.unstable);
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
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    memcpy(image, cells, sizeof image);
    memset(cells, 0xFF, sizeof cells);
    dirty_stack(0xA5);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    TEST_ASSERT_EQUAL_MEMORY(image, cells, sizeof image);
}

/* The restored instance can take a result of before: the copy of its sums, or the records of the
 * grid, are in the image. */
static void test_a_waiting_result_survives(void)
{
    waiting_result_survives(DAVAR_ENGINE_AUTO);
    waiting_result_survives(DAVAR_ENGINE_GRID);
}

/* In the middle of a run of floats that are not numbers: still one gap. */
static void test_a_gap_that_continues_survives(void)
{
    const float none = NAN;
    init(F32, &original, 0U);
    davar_push_f32(&original, &none, 1U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    init(F32, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_restore(&restored, &storage));
    davar_push_f32(&restored, &none, 1U);
    TEST_ASSERT_EQUAL_UINT32(1U, davar_health(&restored).gaps);
    TEST_ASSERT_EQUAL_UINT32(2U, davar_health(&restored).missing);
}

/* A finished record stays finished, and its results continue. */
static void test_a_finished_record_survives(void)
{
    davar_result_t expected;
    davar_result_t actual;
    uint32_t results = 0U;
    const int16_t sample = 3;
    init(Q15, &original, 0U);
    feed(0U, 100U);
    TEST_ASSERT_TRUE(davar_flush(&original));
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    init(Q15, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_restore(&restored, &storage));
#ifdef NDEBUG
    const uint32_t missing = davar_health(&restored).missing;
    TEST_ASSERT_EQUAL_size_t(1U, davar_push_until_result_q15(&restored, &sample, 1U));
    TEST_ASSERT_EQUAL_UINT32(missing + 1U, davar_health(&restored).missing);
#endif
    while (davar_flush(&original)) {
        TEST_ASSERT_TRUE(davar_flush(&restored));
        memset(&expected, 0, sizeof expected);
        memset(&actual, 0, sizeof actual);
        TEST_ASSERT_TRUE(take_fitted(&original, &expected) && take_fitted(&restored, &actual));
        TEST_ASSERT_EQUAL_MEMORY(&expected, &actual, sizeof expected);
        results++;
    }
    TEST_ASSERT_FALSE(davar_flush(&restored));
    TEST_ASSERT_GREATER_THAN_UINT32(2U, results);
    davar_reset(&restored);
    TEST_ASSERT_EQUAL_size_t(1U, davar_push_until_result_q15(&restored, &sample, 1U));
}

static void test_a_rejected_image_leaves_the_instance_as_after_init(void)
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
    config.taus = other_taus, foreign(Q15);
    memcpy(cells, image, sizeof cells), config.unit_per_count = 0.02, foreign(Q15);
    memcpy(cells, image, sizeof cells), config.stride = 2U, foreign(Q15);
    memcpy(cells, image, sizeof cells), config.stride = 2U, config.engine = DAVAR_ENGINE_GRID,
                                        foreign(Q15);
    memcpy(cells, image, sizeof cells), config.moments.kurtosis_high = 3.4, foreign(Q15);
    memcpy(cells, image, sizeof cells), config.window.mirrored_end = true, foreign(Q15);
    memcpy(cells, image, sizeof cells), config.law = &davar_law_and, foreign(Q15);
    memcpy(cells, &image[SLOT], SLOT), memcpy(&cells[SLOT], image, SLOT), config.window.grow = 0U,
                                                                          foreign(Q15);
}

static void test_an_image_of_another_number_type_is_foreign(void)
{
    static const type_t types[] = {Q15, Q31, F32};
    for (unsigned i = 0U; i < 9U; i++) {
        const type_t type = types[i / 3U];
        davar_result_t result;
        init(type, &original, 0U);
        (void)step(type, &original, 0U, &result);
        TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
        init(types[i % 3U], &restored, 1U);
        TEST_ASSERT_EQUAL((type == types[i % 3U]) ? DAVAR_OK : DAVAR_ERR_STATE_FOREIGN,
                          davar_state_restore(&restored, &storage));
        setUp();
    }
}

/* Every field of the configuration with one bit changed: if init accepts it, the image is
 * foreign. */
static const struct {
    const char *name;
    size_t offset;
    size_t bytes;
} fields[] = {
/* tests/style/test_config_fields.py checks that the list is complete */
#define FIELD(member, kind, low, high, usual, status, option, unit, help)                          \
    {#member, offsetof(davar_config_t, member), sizeof config.member},
#include "davar/config_fields.inc"
};

static uint32_t bits_that_matter(size_t which)
{
    const davar_config_t before = config;
    uint32_t taken = 0U;
    const bool is_choice = (fields[which].offset ==
                            offsetof(davar_config_t, window.mirrored_end)); /* a bool has one bit */
    for (uint32_t bit = 0U; bit < (is_choice ? 1U : (8U * (uint32_t)fields[which].bytes)); bit++) {
        unsigned char *const byte = (unsigned char *)&config + fields[which].offset + (bit / 8U);
        *byte ^= (unsigned char)(1U << (bit % 8U));
        if (davar_init_q15(&restored, &config, memory[1], sizeof memory[1]) == DAVAR_OK) {
            TEST_ASSERT_EQUAL_MESSAGE(DAVAR_ERR_STATE_FOREIGN,
                                      davar_state_restore(&restored, &storage), fields[which].name);
            taken++;
        }
        config = before;
    }
    return taken;
}

static void test_one_bit_of_the_configuration_makes_an_image_foreign(void)
{
    static uint32_t more_taus[DAVAR_TAUS_MAX];
    uint32_t taken = 0U;
    for (uint32_t t = 0U; t < DAVAR_TAUS_MAX; t++) {
        more_taus[t] = t + 1U;
    }
    config.taus = more_taus;
    init(Q15, &original, 0U);
    feed(0U, 100U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    for (size_t i = 0U; i < (sizeof fields / sizeof fields[0]); i++) {
        taken += bits_that_matter(i);
    }
    TEST_ASSERT_GREATER_THAN_UINT32(500U, taken);
}

static void test_storage_that_is_too_small_is_rejected(void)
{
    init(Q15, &original, 0U);
    storage.slot_bytes = davar_state_bytes(&original) - 1U;
    TEST_ASSERT_EQUAL(DAVAR_ERR_STATE_STORAGE, davar_state_save(&original, &storage));
    TEST_ASSERT_EQUAL(DAVAR_ERR_STATE_STORAGE, davar_state_restore(&original, &storage));
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

/* An image states its version and size. Both are checked even if the rest matches. */
static void test_an_image_of_another_size_is_foreign(void)
{
    init(Q15, &original, 0U);
    feed(0U, 100U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    cells[4]--; /* one byte less, and a matching check */
    const uint32_t check = check_of_image(cells, davar_state_bytes(&original) - 1U - 20U);
    memcpy(&cells[16], &check, sizeof check);
    init(Q15, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_ERR_STATE_FOREIGN, davar_state_restore(&restored, &storage));
}

static void reverse(unsigned char *word)
{
    for (unsigned i = 0U; i < 2U; i++) {
        const unsigned char kept = word[i];
        word[i] = word[3U - i];
        word[3U - i] = kept;
    }
}

/* Rewrites the header of slot 0 in the other byte order, with the matching check. */
static void swap_slot_0(size_t payload)
{
    for (unsigned field = 0U; field < 4U; field++) {
        reverse(&cells[(size_t)4U * field]);
    }
    const uint32_t check = check_of_image(cells, payload);
    memcpy(&cells[16], &check, sizeof check);
    reverse(&cells[16]);
}

/* Even if everything else matches, its numbers have another meaning: the image is foreign, not
 * absent, and never restored. */
static void test_an_image_of_the_other_byte_order_is_foreign(void)
{
    init(Q15, &original, 0U);
    feed(0U, 100U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    swap_slot_0(davar_state_bytes(&original) - 20U);
    init(Q15, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_ERR_STATE_FOREIGN, davar_state_restore(&restored, &storage));
    cells[50] ^= 1U;
    TEST_ASSERT_EQUAL(DAVAR_ERR_STATE_NONE, davar_state_restore(&restored, &storage));
    cells[50] ^= 1U;
    cells[4] = 0xFFU; /* more bytes than a slot has */
    TEST_ASSERT_EQUAL(DAVAR_ERR_STATE_NONE, davar_state_restore(&restored, &storage));
    cells[4] = 0U;
    TEST_ASSERT_EQUAL(DAVAR_OK,
                      davar_state_save(&original, &storage)); /* next to it, and then over it */
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_restore(&restored, &storage));
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_restore(&restored, &storage));
    for (uint32_t n = 100U; n < 200U; n++) {
        same_step(Q15, n);
    }
}

/* Hundreds of saves: the slots alternate, and the newest image wins. */
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

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_restored_stream_continues_bit_for_bit);
    RUN_TEST(test_a_restored_stride_continues_bit_for_bit);
    RUN_TEST(test_a_restored_grid_continues_bit_for_bit);
    RUN_TEST(test_the_same_state_has_the_same_image);
    RUN_TEST(test_a_waiting_result_survives);
    RUN_TEST(test_a_gap_that_continues_survives);
    RUN_TEST(test_a_finished_record_survives);
    RUN_TEST(test_a_rejected_image_leaves_the_instance_as_after_init);
    RUN_TEST(test_an_image_of_another_configuration_is_foreign);
    RUN_TEST(test_an_image_of_another_number_type_is_foreign);
    RUN_TEST(test_one_bit_of_the_configuration_makes_an_image_foreign);
    RUN_TEST(test_storage_that_is_too_small_is_rejected);
    RUN_TEST(test_an_image_of_another_size_is_foreign);
    RUN_TEST(test_an_image_of_the_other_byte_order_is_foreign);
    RUN_TEST(test_saves_take_turns);
    return UNITY_END();
}
