/* davar tests - examples/bare_metal on an emulated core. The timer's interrupt simulates the DMA:
 * it writes a sample, and after each full half it runs that half's interrupt, except one that comes
 * half a buffer too late. Prints the results, how many contain the true value, and the lost
 * halves. */
#include "board.h"
#include "dma_blocks.h"

#define SAMPLES 6000U
#define LATE 40U /* the half whose interrupt cannot run in time */

static volatile uint32_t written;
static uint32_t pending;

/* Sum of twelve uniform variates: sigma 64 counts. */
static int16_t noise(void)
{
    static uint32_t state = 1U;
    int32_t sum = 0;
    for (unsigned k = 0U; k < 12U; k++) {
        state = (state * 1664525U) + 1013904223U;
        sum += (int32_t)(state >> 26U) - 32;
    }
    return (int16_t)sum;
}

void board_tick(void)
{
    if (written == SAMPLES) {
        return;
    }
    dma_buffer[written % (2U * DMA_HALF)] = noise();
    written++;
    if ((written % DMA_HALF) == 0U) {
        pending |= (((written / DMA_HALF) % 2U) != 0U) ? DMA_FIRST : DMA_SECOND;
        if ((written / DMA_HALF) != LATE) {
            dma_blocks_interrupt(pending);
            pending = 0U;
        }
    }
}

int main(void)
{
    uint32_t results = 0U;
    uint32_t held = 0U;
    board_start();
    if (dma_blocks_start() != DAVAR_OK) {
        board_exit(1);
    }
    board_tick_every(200U);
    while (written < SAMPLES) {
        davar_coefficient_t arw;
        if (dma_blocks_noise(&arw) && arw.present) {
            /* Of counts of 1/64 of the range 64: variance 12 (64^2 - 1) / 12, then 0.05 deg/s, 60 /
             * sqrt(1000). */
            const double truth = 63.992 * 0.05 * 1.8973666;
            results++;
            held += ((arw.low <= truth) && (truth <= arw.high)) ? 1U : 0U;
        }
    }
    board_figure("results", results);
    board_figure("held", held);
    board_figure("lost", dma_blocks_lost());
    board_exit(0);
}
