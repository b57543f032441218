/* davar tests - the cost of davar/torn.h on this target, in instructions (exact under -icount) and
 * bytes. One line "name value" per figure; tools/support/targets.py reads them. */
#include "measuring.h"

#include "davar/torn.h"

#define COUNT 4096U
#define AT 1000U /* of the torn read */

static int16_t samples[COUNT];
static davar_torn_t torn;
static volatile uint32_t sink;

/* Sigma about 3 counts; one torn read, of the largest power of two in 16 bits, which costs most. */
static void make_samples(void)
{
    for (uint32_t i = 0U; i < COUNT; i++) {
        samples[i] = (int16_t)((noise_of(4U) / 40) - 16384 + ((i == AT) ? 32768 : 0));
    }
}

/* As in the interrupt of a user, with the call. */
__attribute__((noinline)) static davar_torn_step_t push(int32_t sample, int32_t *before)
{
    return davar_torn_push(&torn, sample, before);
}

int main(void)
{
    const uint32_t nothing = instructions_of_nothing();
    uint32_t total = 0U;
    uint32_t worst = 0U;
    uint32_t checksum = 0U;
    make_samples();
    davar_torn_init(&torn);
    for (uint32_t i = 0U; i < COUNT; i++) {
        int32_t before = 0;
        const int32_t sample = samples[i];
        const uint32_t mark = board_mark();
        const davar_torn_step_t step = push(sample, &before);
        const uint32_t spent = board_instructions_since(mark) - nothing;
        total += spent;
        worst = larger(worst, spent);
        checksum = (checksum * 31U) + (uint32_t)before + (uint32_t)step;
    }
    sink = checksum;
    board_figure("torn_push_x100", (100U * total) / COUNT);
    board_figure("torn_worst_push", worst);
    board_figure("torn_t_bytes", (uint32_t)sizeof torn);
    board_figure("torn_reads", davar_torn_reads(&torn));
    board_figure("torn_checksum", checksum);
    return 0;
}
