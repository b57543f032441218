/* davar under FreeRTOS: the sensor's interrupt fills blocks and queues them. A task pushes them,
 * takes results and reports.
 *
 *   data-ready interrupt -> block of 20 -> queue -> noise task: gap, push, take, fit -> report
 *
 * Interrupts stay short (a copy). Push and take are in one task, so no lock is needed. If the task
 * is late and the queue is full, the block is lost. The loss is counted and reported to davar as a
 * gap before the next block.
 *
 * For your board: call noise_sample from the data-ready interrupt, and noise_start before the
 * scheduler. Fill noise_report. The fit needs 2 kB of stack (docs/COST.md), so the task has 4 kB.
 * Its priority must be below that of flight-critical tasks. */
#include "noise_task.h"
#include "davar/fit.h"

#include "FreeRTOS.h"
#include "queue.h"
#include "task.h"

#define BLOCK 20U
#define QUEUE_BLOCKS 4U
#define STACK_BYTES 4096U

typedef struct {
    uint32_t missing; /* samples lost before it */
    int16_t count[BLOCK];
} block_t;

static const uint32_t taus[] = {1, 2, 4, 8, 16, 32, 64};
#define TAUS (sizeof taus / sizeof taus[0])

static uint64_t memory[DAVAR_MEMORY_GRID(Q15, longest(600), shortest(400), stride(100), largest(64),
                                         taus(TAUS)) /
                       8];
static davar_plan_t plan;
static davar_config_t config;
static davar_t gyro;
static QueueHandle_t queue;

/* --- used by the interrupt --- */

static block_t filling;
static uint32_t filled;
static volatile uint32_t lost; /* blocks */

void noise_sample(int16_t count)
{
    BaseType_t woken = pdFALSE;
    filling.count[filled] = count;
    filled++;
    if (filled < BLOCK) {
        return;
    }
    filled = 0;
    if (xQueueSendFromISR(queue, &filling, &woken) == pdTRUE) {
        filling.missing = 0;
    } else {
        filling.missing += BLOCK;
        lost++;
    }
    portYIELD_FROM_ISR(woken);
}

uint32_t noise_blocks_lost(void)
{
    return lost;
}

/* --- used by the task --- */

static void push_and_report(const int16_t *counts, size_t count)
{
    static davar_result_t result;
    for (size_t done = 0; done < count;) {
        done += davar_push_until_result_q15(&gyro, counts + done, count - done);
        if (davar_take(&gyro, &result)) {
            (void)davar_fit_white(&plan, config.rate_hz, &result);
            noise_report(&result);
        }
    }
}

static void noise_task(void *context)
{
    static block_t block;
    (void)context;
    for (;;) {
        if (xQueueReceive(queue, &block, portMAX_DELAY) == pdTRUE) {
            if (block.missing > 0U) {
                davar_gap(&gyro, block.missing);
            }
            push_and_report(block.count, BLOCK);
        }
    }
}

davar_status_t noise_start(void)
{
    config = davar_default_config;
    config.rate_hz = 200.0;
    config.unit_per_count = 0.05;
    config.window.grow = 1;
    config.stride = 100;
    config.engine = &davar_engine_grid_q15; /* for samples in blocks (docs/COST.md) */
    config.taus = taus;
    config.tau_count = TAUS;
    /* Declare the low-pass of your gyro instead: davar_plan_init_filtered (davar/filter.h). */
    davar_plan_init(&plan, taus, TAUS);
    const davar_status_t status = davar_init_q15(&gyro, &config, memory, sizeof memory);
    if (status == DAVAR_OK) {
        queue = xQueueCreate(QUEUE_BLOCKS, sizeof(block_t));
        configASSERT(queue != NULL);
        const BaseType_t made = xTaskCreate(noise_task, "noise", STACK_BYTES / sizeof(StackType_t),
                                            NULL, tskIDLE_PRIORITY + 1, NULL);
        configASSERT(made == pdPASS);
        (void)made;
    }
    return status;
}
