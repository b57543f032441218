/* A sensor whose DMA fills a buffer in two halves: see dma_blocks.c. */
#ifndef DMA_BLOCKS_H
#define DMA_BLOCKS_H

#include "davar/davar.h"

#define DMA_HALF 50U /* samples */
#define DMA_FIRST 1U /* flags of the interrupt: the first half is full, */
#define DMA_SECOND 2U

/* Target of the circular transfer, which begins with the first half. */
extern volatile int16_t dma_buffer[2U * DMA_HALF];

/* Call it before the transfer. Returns DAVAR_OK, or the cause (davar_status_text). */
davar_status_t dma_blocks_start(void);

/* Call it from the half-transfer and the transfer-complete interrupt with the flags that were
 * pending. They must be cleared already. */
void dma_blocks_interrupt(uint32_t flags);

/* Call it from the main loop. False: no new result, and *arw is unchanged. True with arw->present:
 * value, low and high (95 %) in deg/sqrt(h). True without: the newest window is not white noise,
 * and `high` is an upper limit. */
bool dma_blocks_noise(davar_coefficient_t *arw);

/* Halves that were overwritten before their interrupt could run. */
uint32_t dma_blocks_lost(void);

#endif
