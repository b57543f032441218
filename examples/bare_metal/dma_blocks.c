/* Bare metal: the DMA writes the sensor's counts into a ring of two halves. Its two interrupts push
 * the full half, and the main loop takes results. There is no copy, no queue and no operating
 * system.
 *
 *   sensor -> DMA -> [ first half | second half ]
 *                      half-transfer, transfer-complete: push        main loop: take, fit
 *
 * If both flags are pending, the interrupt came half a buffer too late, and the DMA is overwriting
 * the older half. That half is skipped, counted, and reported to davar as a gap. The newer half is
 * intact.
 *
 * For your board: call dma_blocks_interrupt from both interrupts (on an STM32 they share one
 * vector: read the flags, clear them, pass them). Set rate and size of a count. A push of 50
 * samples takes some 12 000 instructions here (docs/COST.md), so choose halves that leave enough
 * time. The test simulates the DMA with a timer interrupt on an emulated Cortex-M4F, because that
 * board has no DMA with a sensor. */
#include "dma_blocks.h"
#include "davar/fit.h"

static const uint32_t taus[] = {1, 2, 4, 8, 16, 32, 64};
#define TAUS (sizeof taus / sizeof taus[0])

volatile int16_t dma_buffer[2U * DMA_HALF];

static uint64_t memory[DAVAR_MEMORY_GRID(Q15, longest(600), shortest(400), stride(100), largest(64),
                                         taus(TAUS)) /
                       8];
static davar_plan_t plan;
static davar_config_t config;
static davar_t gyro;
static uint32_t expected = DMA_FIRST;
static volatile uint32_t lost;

davar_status_t dma_blocks_start(void)
{
    config = davar_default_config;
    config.rate_hz = 1000.0;
    config.unit_per_count = 0.05;
    config.window.grow = 1;
    config.stride = 100;
    config.engine = &davar_engine_grid_q15; /* for samples in blocks (docs/COST.md) */
    config.taus = taus;
    config.tau_count = TAUS;
    /* Declare the low-pass of your gyro instead: davar_plan_init_filtered (davar/filter.h). */
    davar_plan_init(&plan, taus, TAUS);
    return davar_init_q15(&gyro, &config, memory, sizeof memory);
}

static void push_half(uint32_t flag)
{
    const volatile int16_t *half = &dma_buffer[(flag == DMA_FIRST) ? 0U : DMA_HALF];
    int16_t counts[DMA_HALF]; /* what the DMA writes is volatile; davar reads it once */
    for (uint32_t i = 0; i < DMA_HALF; i++) {
        counts[i] = half[i];
    }
    davar_push_q15(&gyro, counts, DMA_HALF);
}

void dma_blocks_interrupt(uint32_t flags)
{
    if (flags == (DMA_FIRST | DMA_SECOND)) {
        lost++;
        davar_gap(&gyro, DMA_HALF);
        expected ^= DMA_FIRST | DMA_SECOND; /* the newer one */
    }
    push_half(expected);
    expected ^= DMA_FIRST | DMA_SECOND;
}

bool dma_blocks_noise(davar_coefficient_t *arw)
{
    static davar_result_t result;
    if (!davar_take(&gyro, &result)) {
        return false;
    }
    (void)davar_fit_white(&plan, config.rate_hz, &result);
    *arw = result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
    return true;
}

uint32_t dma_blocks_lost(void)
{
    return lost;
}
