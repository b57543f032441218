/* davar tests - the power goes while a state is saved, into storage that tears the cell it was at, writes its rows in an order of its own, and
 * reads what it had begun to write differently each time. What is restored is the state of this save, whole, or that of the one before. */
#include "state_fixture.h"

#include "random.h"

#define ROW 32U /* bytes that the storage writes at once */
#define ROWS (sizeof cells / ROW)
#define GOES_ON 60U

static unsigned char before[sizeof cells]; /* what the cells held when the save began */
static unsigned char meant[sizeof cells];  /* what they would hold, had it ended */
static bool unsure[sizeof cells];          /* cells that the power left half written */
static random_t chance = {1U};

/* A cell that is unsure reads as it was, as it was meant to be, or as neither, another way each time. */
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

/* Saves with power to the end; what it writes is in `meant`, what was there in `before` and in the cells. */
static void begin_save(void)
{
    memcpy(before, cells, sizeof cells);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    memcpy(meant, cells, sizeof cells);
    memcpy(cells, before, sizeof cells);
    memset(unsure, 0, sizeof unsure);
}

/* An instance that has learned from the first `samples`, and what it says from then on. */
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

/* Two saves, of 100 samples and of 150; then `original` has learned from 200. What an instance says behind 150 and 200 is in `after`. */
static void learn(void)
{
    setUp();
    config.window.longest = 20U;
    config.window.shortest = 10U;
    init(Q15, &original, 0U);
    feed(0U, 100U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    feed(100U, 150U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
    init(Q15, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_restore(&restored, &storage));
    listen(0U, 150U);
    const uint64_t epoch = restored_epoch();
    feed(150U, 200U);
    begin_save();
    memcpy(cells, meant, sizeof cells);
    init(Q15, &restored, 1U);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_restore(&restored, &storage));
    listen(1U, 200U);
    TEST_ASSERT_EQUAL_UINT64(epoch + 50U, restored_epoch());
    memcpy(cells, before, sizeof cells);
}

/* Which of the two states goes on as `restored` does, bit for bit: 0 or 1. */
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

/* The power is back: restores as the cells read now. */
static unsigned power_up(void)
{
    init(Q15, &restored, 1U);
    storage.read = read_unsure;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_restore(&restored, &storage));
    storage.read = read_cells;
    return state_of_restored();
}

/* A save behind the cut is whole, whatever the cut has left. */
static void next_save_is_whole(void)
{
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&original, &storage));
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

/* The cell at which the power went, and the rest of its row, hold anything, the same at every reading. From the front, and from the back. */
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

/* What came before the cut, or what comes behind it, has reached the cells; the row between them reads another way each time. */
static void test_readings_that_differ_behind_a_cut_at_any_byte(void)
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
        whole); /* now and then all cells read as they were meant: then it is this save's */
    next_save_is_whole();
}

/* All is written but for one cell, which reads another way each time: whole when it is judged, and damaged when it is loaded. */
static void test_one_cell_that_is_half_written(void)
{
    learn();
    const size_t slot = slot_written();
    const size_t bytes = davar_state_bytes(&original);
    unsigned whole = 0U;
    for (size_t at = slot; at < (slot + bytes); at++) {
        cut_at(slot, slot + bytes);
        unsure[at] = true;
        whole += power_up();
    }
    TEST_ASSERT_GREATER_THAN_UINT(bytes / 8U, whole);
    TEST_ASSERT_LESS_THAN_UINT(bytes - bytes / 8U, whole);
    next_save_is_whole();
}

/* Rows reach the cells in any order: of a cut save any of them may be there. */
static void test_rows_that_are_written_in_another_order(void)
{
    learn();
    for (uint32_t trial = 0U; trial < 4000U; trial++) {
        const uint64_t share = 1U + (trial % 63U); /* of 64 rows, that are written */
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

/* All but one row, whichever: the header of a new image may be there before the rest of it. */
static void test_one_row_that_is_not_written(void)
{
    learn();
    unsigned older = 0U;
    for (size_t row = 0U; row < ROWS; row++) {
        memcpy(cells, meant, sizeof cells);
        memcpy(&cells[row * ROW], &before[row * ROW], ROW);
        const bool same = memcmp(&before[row * ROW], &meant[row * ROW], ROW) == 0;
        TEST_ASSERT_EQUAL_UINT(same ? 1U : 0U, power_up());
        older += same ? 0U : 1U;
    }
    TEST_ASSERT_GREATER_THAN_UINT(8U, older);
    next_save_is_whole();
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_torn_write_at_any_byte);
    RUN_TEST(test_readings_that_differ_behind_a_cut_at_any_byte);
    RUN_TEST(test_one_cell_that_is_half_written);
    RUN_TEST(test_rows_that_are_written_in_another_order);
    RUN_TEST(test_one_row_that_is_not_written);
    return UNITY_END();
}
