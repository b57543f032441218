/* davar tests - the power fails while a state is saved. The storage damages the current cell,
 * writes its rows in any order, and reads half-written cells differently each time. The restored
 * state is the complete one of this save or of the previous one. */
#include "state_fixture.h"

#include "random.h"

#define ROW 32U /* bytes that the storage writes together */
#define ROWS (sizeof cells / ROW)
#define GOES_ON 60U

static unsigned char before[sizeof cells]; /* the cells' content when the save began */
static unsigned char meant[sizeof cells];  /* their content after a complete save */
static bool unsure[sizeof cells];          /* cells that the power failure left half written */
static random_t chance = {1U};

/* An unsure cell reads as before, as intended, or as neither, differently each time. */
static bool read_unsure(void *context, size_t offset, void *data, size_t bytes)
{
    unsigned char *const to = data;
    (void)context;
    for (size_t i = 0U; i < bytes; i++) {
        const uint64_t which = unsure[offset + i] ? (random_next(&chance) >> 33U) : 0U;
        to[i] = ((which % 4U) == 0U)   ? cells[offset + i]
                : ((which % 4U) == 1U) ? before[offset + i]
                : ((which % 4U) == 2U) ? meant[offset + i]
                                       : (unsigned char)(which >> 8U);
    }
    return true;
}

/* Completes a save. `meant` then has the new content, `before` and the cells the old one. */
static void begin_save(void)
{
    memcpy(before, cells, sizeof cells);
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_state_save(&original, &storage));
    memcpy(meant, cells, sizeof cells);
    memcpy(cells, before, sizeof cells);
    memset(unsure, 0, sizeof unsure);
}

/* An instance that has learned from the first `samples`, and its later results. */
static davar_result_t after[2][GOES_ON];
static bool has[2][GOES_ON];
static uint32_t produced[2];

static void listen(unsigned which, uint32_t samples)
{
    produced[which] = restored.produced;
    for (uint32_t n = 0U; n < GOES_ON; n++) {
        has[which][n] = step(Q15, &restored, samples + n, &after[which][n]);
    }
}

/* Two saves, of 100 samples and of 150; then `original` has learned from 200. `after` has the
 * results of an instance after 150 and 200. */
static void learn(void)
{
    setUp();
    config.window.longest = 20U;
    config.window.shortest = 10U;
    init(Q15, &original, 0U);
    feed(0U, 100U);
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_state_save(&original, &storage));
    feed(100U, 150U);
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_state_save(&original, &storage));
    init(Q15, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_state_restore(&restored, &storage));
    listen(0U, 150U);
    const uint64_t epoch = restored_epoch();
    feed(150U, 200U);
    begin_save();
    memcpy(cells, meant, sizeof cells);
    init(Q15, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_state_restore(&restored, &storage));
    listen(1U, 200U);
    TEST_ASSERT_EQUAL_UINT64(epoch + 50U, restored_epoch());
    memcpy(cells, before, sizeof cells);
}

/* The state with which `restored` continues bit for bit: 0 or 1. */
static unsigned state_of_restored(void)
{
    davar_result_t result;
    const unsigned which = (restored.produced == produced[1]) ? 1U : 0U;
    for (uint32_t n = 0U; n < GOES_ON; n++) {
        TEST_ASSERT_EQUAL(has[which][n],
                          step(Q15, &restored, ((which == 0U) ? 150U : 200U) + n, &result));
        TEST_ASSERT_EQUAL_MEMORY(&after[which][n], &result, sizeof result);
    }
    return which;
}

/* The power is back: restores from the present cells. */
static unsigned power_up(void)
{
    init(Q15, &restored, 1U);
    storage.read = read_unsure;
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_state_restore(&restored, &storage));
    storage.read = read_cells;
    return state_of_restored();
}

/* A save after the failure is intact, whatever the failure left. */
static void next_save_is_whole(void)
{
    TEST_ASSERT_EQUAL(DAVAR_STATE_OK, davar_state_save(&original, &storage));
    memset(unsure, 0, sizeof unsure);
    TEST_ASSERT_EQUAL_UINT(1U, power_up());
}

static void cut_at(size_t from, size_t to)
{
    memcpy(cells, before, sizeof cells);
    memset(unsure, 0, sizeof unsure);
    memcpy(&cells[from], &meant[from], to - from);
}

/* Offset of the slot that this save writes. */
static size_t slot_written(void)
{
    return (memcmp(before, meant, SLOT) != 0) ? 0U : SLOT;
}

/* The cell at which the power failed and the rest of its row hold any content, the same at every
 * reading. From the front, and from the back. */
static void test_a_torn_write_at_any_byte(void)
{
    learn();
    const size_t slot = slot_written();
    const size_t bytes = davar_state_bytes(&original);
    for (size_t cut = 0U; cut < bytes; cut++) {
        const size_t row = cut - (cut % ROW);
        for (unsigned backwards = 0U; backwards < 2U; backwards++) {
            cut_at((backwards == 1U) ? (slot + cut + 1U) : slot,
                   (backwards == 1U) ? (slot + bytes) : (slot + cut));
            const size_t from = (backwards == 1U) ? row : cut;
            const size_t to = (backwards == 1U) ? (cut + 1U) : (row + ROW);
            for (size_t at = slot + from; at < (slot + to); at++) {
                cells[at] = (unsigned char)(random_next(&chance) >> 40U);
            }
            TEST_ASSERT_EQUAL_UINT(0U, power_up());
        }
    }
    next_save_is_whole();
}

/* The cells before the failure, or those after it, have been written. The row between them reads
 * differently each time. */
static void test_readings_that_differ_after_a_cut_at_any_byte(void)
{
    learn();
    const size_t slot = slot_written();
    const size_t bytes = davar_state_bytes(&original);
    unsigned whole = 0U;
    for (size_t cut = 0U; cut < bytes; cut++) {
        for (unsigned backwards = 0U; backwards < 2U; backwards++) {
            cut_at((backwards == 1U) ? (slot + cut) : slot,
                   (backwards == 1U) ? (slot + bytes) : (slot + cut));
            memset(&unsure[(slot + cut) - (cut % ROW)], 1, ROW);
            whole += power_up();
            whole += power_up();
        }
    }
    TEST_ASSERT_LESS_THAN_UINT(
        bytes / 8U,
        whole); /* sometimes all cells read as intended: then it is the state of this save */
    next_save_is_whole();
}

/* Rows reach the cells in any order: any subset of an interrupted save may be present. */
static void test_rows_that_are_written_in_another_order(void)
{
    learn();
    for (uint32_t trial = 0U; trial < 4000U; trial++) {
        const uint64_t share = 1U + (trial % 63U); /* written rows, of 64 */
        bool all = true;
        cut_at(0U, 0U);
        for (size_t row = 0U; row < ROWS; row++) {
            const bool written = ((random_next(&chance) >> 40U) % 64U) < share;
            if (written) {
                memcpy(&cells[row * ROW], &meant[row * ROW], ROW);
            }
            all = all && (written || (memcmp(&before[row * ROW], &meant[row * ROW], ROW) == 0));
        }
        TEST_ASSERT_EQUAL_UINT(all ? 1U : 0U, power_up());
    }
    next_save_is_whole();
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_torn_write_at_any_byte);
    RUN_TEST(test_readings_that_differ_after_a_cut_at_any_byte);
    RUN_TEST(test_rows_that_are_written_in_another_order);
    return UNITY_END();
}
