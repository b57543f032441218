/* davar tests - a saved and restored cascade continues bit for bit; a foreign image is rejected,
 * and a loss of power leaves the older image. */
#include "davar/cascade.h"
#include "davar/state.h"
#include "random.h"
#include "unity.h"

#include <string.h>

#define SLOT 4096U
#define TAUS 9U
#define BYTES DAVAR_CASCADE_MEMORY(Q31, TAUS)

typedef enum { Q15, Q31, F32 } type_t;

static davar_cascade_config_t config;
static davar_cascade_t original;
static davar_cascade_t restored;
static uint64_t memory[2][BYTES / 8U];
static unsigned char cells[2U * SLOT];
static size_t budget; /* the power fails after so many written bytes */
static davar_storage_t storage;

static bool read_cells(void *context, size_t offset, void *data, size_t bytes)
{
    (void)context;
    memcpy(data, &cells[offset], bytes);
    return true;
}

static bool write_cells(void *context, size_t offset, const void *data, size_t bytes)
{
    (void)context;
    const size_t done = (bytes < budget) ? bytes : budget;
    memcpy(&cells[offset], data, done);
    budget -= done;
    return done == bytes;
}

void setUp(void)
{
    storage = (davar_storage_t){read_cells, write_cells, NULL, SLOT};
    memset(cells, 0xFF, sizeof cells);
    budget = SIZE_MAX;
    config = (davar_cascade_config_t){.rate_hz = 100.0,
                                      .unit_per_count = 0.5,
                                      .full_scale = 300.0,
                                      .shortest = 64U,
                                      .tau_count = TAUS,
                                      .clusters = 8U};
}

void tearDown(void) {}

static void init(type_t type, davar_cascade_t *cascade, unsigned which)
{
    davar_cascade_status_t (*const start[])(davar_cascade_t *, const davar_cascade_config_t *,
                                            void *, size_t) = {
        davar_cascade_init_q15, davar_cascade_init_q31, davar_cascade_init_f32};
    memset(memory[which], 0xA5, sizeof memory[which]);
    TEST_ASSERT_EQUAL(DAVAR_CASCADE_OK, start[type](cascade, &config, memory[which], BYTES));
}

static void step(type_t type, davar_cascade_t *cascade, random_t *random)
{
    const uint64_t draw = random_next(random);
    const int16_t narrow = (int16_t)(draw >> 48U);
    const int32_t wide = (int32_t)(uint32_t)draw;
    const float rate = ((draw % 300U) == 7U) ? (float)INFINITY : (float)(draw % 290U);
    if ((draw % 500U) == 3U) {
        davar_cascade_gap(cascade, 1U);
    }
    switch (type) {
    case Q15:
        davar_cascade_push_q15(cascade, &narrow, 1U);
        break;
    case Q31:
        davar_cascade_push_q31(cascade, &wide, 1U);
        break;
    case F32:
    default:
        davar_cascade_push_f32(cascade, &rate, 1U);
        break;
    }
}

static void test_an_image_does_not_depend_on_addresses(void)
{
    static unsigned char image[sizeof cells];
    random_t random = random_seeded(7U);
    init(Q31, &original, 0U);
    init(Q31, &restored, 1U);
    for (uint32_t i = 0U; i < 5000U; i++) {
        random_t again = random;
        step(Q31, &original, &random);
        step(Q31, &restored, &again);
    }
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_cascade_save(&original, &storage));
    memcpy(image, cells, sizeof image);
    memset(cells, 0xFF, sizeof cells);
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_cascade_save(&restored, &storage));
    TEST_ASSERT_EQUAL_MEMORY(image, cells, sizeof image);
}

static void assert_foreign(type_t type)
{
    init(type, &restored, 1U);
    const davar_cascade_t fresh = restored;
    TEST_ASSERT_EQUAL(DAVAR_STATE_ERR_FOREIGN, davar_cascade_restore(&restored, &storage));
    TEST_ASSERT_EQUAL_MEMORY(&fresh, &restored, sizeof fresh);
}

/* Q31 and f32 have images of the same length. */
static void test_an_image_of_other_settings_or_type_is_foreign(void)
{
    const davar_cascade_config_t saved = config;
    init(Q15, &original, 0U);
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_cascade_save(&original, &storage));
    for (uint32_t field = 0U; field < 6U; field++) {
        config.rate_hz += (field == 0U) ? 1.0 : 0.0;
        config.unit_per_count += (field == 1U) ? 0.25 : 0.0;
        config.full_scale += (field == 2U) ? 1.0 : 0.0;
        config.shortest += (field == 3U) ? 4U : 0U;
        config.tau_count = (uint8_t)(TAUS - ((field == 4U) ? 1U : 0U));
        config.clusters = (uint16_t)((field == 5U) ? 16U : 8U);
        assert_foreign(Q15);
        config = saved;
    }
    assert_foreign(Q31);
    init(Q15, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_cascade_restore(&restored, &storage));
    init(Q31, &original, 0U);
    memset(cells, 0xFF, sizeof cells);
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_cascade_save(&original, &storage));
    assert_foreign(F32);
}

static void test_a_slot_must_be_long_enough(void)
{
    init(Q15, &original, 0U);
    const size_t bytes = davar_cascade_state_bytes(&original);
    TEST_ASSERT_TRUE((bytes > original.memory_bytes) && (bytes <= (original.memory_bytes + 200U)));
    storage.slot_bytes = bytes - 1U;
    TEST_ASSERT_EQUAL(DAVAR_STATE_ERR_STORAGE, davar_cascade_save(&original, &storage));
    TEST_ASSERT_EQUAL(DAVAR_STATE_ERR_STORAGE, davar_cascade_restore(&original, &storage));
    storage.slot_bytes = bytes;
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_cascade_save(&original, &storage));
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_cascade_restore(&original, &storage));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_an_image_does_not_depend_on_addresses);
    RUN_TEST(test_an_image_of_other_settings_or_type_is_foreign);
    RUN_TEST(test_a_slot_must_be_long_enough);
    return UNITY_END();
}
