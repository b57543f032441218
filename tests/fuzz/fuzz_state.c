/* davar tests - decaying storage: an image is overwritten with bytes at places that the input
 * selects, and readings differ. The restored state is the saved image, or the instance is as after
 * init. */
#include "davar/davar.h"
#include "fuzzing.h"
#include "small_config.h"

#include <string.h>

#define MEMORY_WORDS 576
#define SLOT 4608U

typedef struct {
    unsigned from_read; /* applies from this reading onward */
    size_t offset;
    uint8_t flip;
} damage_t;

static const uint32_t taus[4] = {1U, 2U, 5U, 8U};
static unsigned char cells[2U * SLOT];
static damage_t damages[8];
static unsigned damage_count;
static unsigned reading;
static uint64_t memory[3][MEMORY_WORDS];
static davar_config_t config;

static bool read_cells(void *context, size_t offset, void *data, size_t bytes)
{
    unsigned char *const to = data;
    (void)context;
    REQUIRE((offset <= sizeof cells) && (bytes <= (sizeof cells - offset)));
    memcpy(data, &cells[offset], bytes);
    reading++;
    for (unsigned i = 0U; i < damage_count; i++) {
        const damage_t *const damage = &damages[i];
        if ((reading > damage->from_read) && (damage->offset >= offset) &&
            (damage->offset < (offset + bytes))) {
            to[damage->offset - offset] ^= damage->flip;
        }
    }
    return true;
}

static bool write_cells(void *context, size_t offset, const void *data, size_t bytes)
{
    (void)context;
    REQUIRE((offset <= sizeof cells) && (bytes <= (sizeof cells - offset)));
    memcpy(&cells[offset], data, bytes);
    return true;
}

static const davar_storage_t storage = {read_cells, write_cells, NULL, SLOT};

static void start(davar_t *davar, unsigned which)
{
    memset(memory[which], 0xA5, sizeof memory[which]);
    REQUIRE(davar_init_q15(davar, &config, memory[which], sizeof memory[which]) == DAVAR_OK);
}

static bool step(davar_t *davar, uint32_t n, davar_result_t *result)
{
    const int16_t sample = (int16_t)((n * 2654435761U) >> 24U);
    memset(result, 0, sizeof *result);
    if ((n % 61U) == 60U) {
        davar_gap(davar, 2U);
    }
    davar_push_q15(davar, &sample, 1U);
    return davar_take(davar, result);
}

static void alike(davar_t *a, davar_t *b, uint32_t from)
{
    davar_result_t of_a;
    davar_result_t of_b;
    for (uint32_t n = from; n < (from + 60U); n++) {
        REQUIRE(step(a, n, &of_a) == step(b, n, &of_b));
        REQUIRE(memcmp(&of_a, &of_b, sizeof of_a) == 0);
    }
}

/* Three bytes of place and kind, one of damage. The second half of the kinds also overwrites a
 * range with input bytes. */
static void choose_damage(bytes_t *bytes)
{
    damage_count = 0U;
    while ((bytes->next < bytes->end) && (damage_count < 8U)) {
        const uint8_t kind = byte(bytes);
        size_t offset = byte(bytes);
        offset = (offset + (256U * (size_t)byte(bytes))) % sizeof cells;
        if (kind < 128U) {
            damages[damage_count++] = (damage_t){kind % 16U, offset, byte(bytes)};
            continue;
        }
        for (unsigned i = 0U;
             (i < (kind - 127U)) && ((offset + i) < sizeof cells) && (bytes->next < bytes->end);
             i++) {
            cells[offset + i] = byte(bytes);
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    bytes_t bytes = {data, data + size};
    davar_t original;
    davar_t older;
    davar_t restored;
    davar_result_t result;
    config = small_config(taus, 4U);
    config.window.mode = mode(&bytes);
    const uint32_t drawn = between(&bytes, 0U, 17U);
    config.stride = 1U + (drawn % 9U);
    config.engine = (drawn < 9U) ? DAVAR_ENGINE_GRID : DAVAR_ENGINE_AUTO;
    const uint32_t cut = between(&bytes, 1U, 120U);
    memset(cells, 0xFF, sizeof cells);
    damage_count = 0U;
    start(&original, 0U);
    start(&older, 1U);
    for (uint32_t n = 0U; n < cut; n++) {
        (void)step(&original, n, &result);
        (void)step(&older, n, &result);
    }
    REQUIRE(davar_state_save(&original, &storage) == DAVAR_OK);
    (void)step(&original, cut, &result);
    REQUIRE(davar_state_save(&original, &storage) == DAVAR_OK);
    start(&restored, 2U);
    choose_damage(&bytes);
    reading = 0U;
    if (davar_state_restore(&restored, &storage) != DAVAR_OK) {
        start(&original, 0U);
        alike(&original, &restored, 0U);
    } else if (restored.window.received == original.window.received) {
        alike(&original, &restored, cut + 1U);
    } else {
        alike(&older, &restored, cut);
    }
    return 0;
}
