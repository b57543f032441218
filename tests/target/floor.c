/* davar tests - the cost of davar/floor.h on this target, in instructions (exact under -icount) and
 * bytes. One line "name value" per figure; tools/support/targets.py reads them. */
#include "measuring.h"

#include "davar/floor.h"

#include <string.h>

#define SAMPLES 16384U
#define BLOCK 256U

static davar_floor_t axis;
static davar_floor_plan_t plan;
static davar_floor_result_t result;
static uint32_t checksum;

static void add_bits(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    checksum = (checksum * 31U) + bits;
}

/* Noise, then twice as much, with a knock, a gap and a line. */
static int32_t sample_of(uint32_t n)
{
    static const int16_t line[16] = {0, 96,  177,  231,  250,  231,  177,  96,
                                     0, -96, -177, -231, -250, -231, -177, -96};
    const int32_t noise = noise_of(4U) / ((n < (SAMPLES / 2U)) ? 8 : 4);
    return noise + line[n % 16U] + ((n == 9000U) ? 20000 : 0);
}

int main(void)
{
    const davar_floor_config_t config = {
        .rate_hz = 1000.0, .unit_per_count = 0.01, .rail = 32767, .block = BLOCK};
    const uint32_t nothing = instructions_of_nothing();
    uint64_t pushed = 0U;
    uint64_t taken = 0U;
    uint32_t most = 0U;
    uint32_t results = 0U;
    if (davar_floor_plan(&plan, &config) != DAVAR_FLOOR_OK) {
        board_exit(1);
    }
    davar_floor_start(&axis);
    for (uint32_t n = 0U; n < SAMPLES; n++) {
        const int32_t sample = sample_of(n);
        if (n == 12000U) {
            davar_floor_gap(&axis);
        }
        uint32_t mark = board_mark();
        const bool is_due = davar_floor_push(&axis, &plan, sample);
        const uint32_t spent = board_instructions_since(mark) - nothing;
        pushed += spent;
        most = larger(most, spent);
        if (is_due) {
            mark = board_mark();
            davar_floor_take(&axis, &plan, &result);
            taken += board_instructions_since(mark) - nothing;
            results++;
            if (result.why == DAVAR_FLOOR_VALUE) {
                add_bits(result.value);
            }
            add_bits(result.high);
        }
    }
    board_figure("floor_push_x100", (uint32_t)(100U * pushed / SAMPLES));
    board_figure("floor_worst_push", most);
    board_figure("floor_take", (uint32_t)(taken / results));
    board_figure("floor_all_x100", (uint32_t)(100U * (pushed + taken) / SAMPLES));
    board_figure("floor_t_bytes", (uint32_t)sizeof axis);
    board_figure("floor_plan_bytes", (uint32_t)sizeof plan);
    board_figure("floor_checksum", checksum);
    return 0;
}
