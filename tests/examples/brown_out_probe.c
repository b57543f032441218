/* davar tests - the power fails at every byte of a save. After each failure the example must find
 * the older or the newer image, and then give the results of an instance that was never off and
 * received the same gap. Prints how often it found each. */
#include "brown_out.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FIRST 700U /* samples before the first save, */
#define SECOND 800U
#define REST 900U /* and after the restart */
#define MISSED 37U

static unsigned char cells[2U * BROWN_OUT_SLOT];
static size_t budget; /* bytes that can still be written */
static uint64_t written;

bool storage_read(size_t offset, void *data, size_t bytes)
{
    memcpy(data, &cells[offset], bytes);
    return true;
}

bool storage_write(size_t offset, const void *data, size_t bytes)
{
    const size_t most = (bytes < budget) ? bytes : budget;
    memcpy(&cells[offset], data, most);
    budget -= most;
    written += most;
    return most == bytes;
}

uint32_t brown_out_missed(void)
{
    return MISSED;
}

static int16_t count_at(uint32_t n)
{
    return (int16_t)((int32_t)((n * 2654435761U) >> 20U) % 301 - 150);
}

/* Pushes samples [from, to); returns a checksum of the bits of all results. */
static uint64_t feed(uint32_t from, uint32_t to)
{
    static davar_result_t result;
    uint64_t sum = 0U;
    for (uint32_t n = from; n < to; n++) {
        const int16_t count = count_at(n);
        davar_push_q15(brown_out_gyro(), &count, 1U);
        if (davar_take(brown_out_gyro(), &result)) {
            for (uint32_t t = 0U; t < result.tau_count; t++) {
                uint64_t bits;
                memcpy(&bits, &result.tau[t].adev, sizeof bits);
                sum = (sum ^ bits ^ result.epoch) * UINT64_C(1099511628211);
            }
        }
    }
    return sum;
}

static void require(bool good, const char *what, size_t cut)
{
    if (!good) {
        fprintf(stderr, "%s, cut at byte %zu\n", what, cut);
        exit(1);
    }
}

/* The checksum after a restart from an image saved after `saved` samples, computed by an instance
 * that was never off. */
static uint64_t expected(uint32_t saved)
{
    bool is_restored = false;
    memset(cells, 0xFF, sizeof cells);
    require((brown_out_start(&is_restored) == DAVAR_OK) && !is_restored,
            "a blank storage is restored", 0U);
    (void)feed(0U, saved);
    davar_gap(brown_out_gyro(), MISSED);
    return feed(5000U, 5000U + REST);
}

int main(void)
{
    const uint64_t of_first = expected(FIRST);
    const uint64_t of_second = expected(SECOND);
    unsigned older = 0U;
    unsigned newer = 0U;
    bool whole = false;
    for (size_t cut = 0U; !whole; cut++) {
        bool is_restored = false;
        memset(cells, 0xFF, sizeof cells);
        budget = SIZE_MAX;
        require(brown_out_start(&is_restored) == DAVAR_OK, "not started", cut);
        (void)feed(0U, FIRST);
        require(brown_out_save(), "not saved", cut);
        (void)feed(FIRST, SECOND);
        budget = cut; /* the power fails while the second image is written */
        whole = brown_out_save();
        budget = SIZE_MAX;
        require((brown_out_start(&is_restored) == DAVAR_OK) && is_restored, "nothing restored",
                cut);
        const uint64_t found = feed(5000U, 5000U + REST);
        require((found == of_first) || (found == of_second), "neither image", cut);
        older += (found == of_first) ? 1U : 0U;
        newer += (found == of_second) ? 1U : 0U;
        require(!whole || (found == of_second), "a whole save is not found", cut);
    }
    printf("%u %u\n", older, newer);
    return 0;
}
