/* davar tests - the example with a stub of FreeRTOS. Reads counts on standard input; "lost N" lines
 * let the task sleep through N samples. Prints "value low high" of each result, then the losses:
 * blocks, and samples reported to davar. */
#include "noise_task.h"

#include "queue.h"
#include "task.h"

#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct stub_queue {
    unsigned char *items;
    size_t length;
    size_t bytes;
    size_t first;
    size_t count;
};

static TaskFunction_t task;
static jmp_buf end;
static uint32_t gaps;

QueueHandle_t xQueueCreate(UBaseType_t length, UBaseType_t item_bytes)
{
    QueueHandle_t queue = calloc(1, sizeof *queue);
    *queue = (struct stub_queue){malloc(length * item_bytes), length, item_bytes, 0U, 0U};
    return queue;
}

BaseType_t xQueueSendFromISR(QueueHandle_t queue, const void *item, BaseType_t *woken)
{
    if (queue->count == queue->length) {
        return pdFALSE;
    }
    memcpy(&queue->items[((queue->first + queue->count) % queue->length) * queue->bytes], item,
           queue->bytes);
    queue->count++;
    *woken = pdTRUE;
    return pdTRUE;
}

/* An interrupt for each line of the input, or for each sample that the task sleeps through. The
 * test ends with the input. */
static void interrupts(void)
{
    char line[64];
    long asleep = 1;
    while (asleep > 0) {
        if (fgets(line, sizeof line, stdin) == NULL) {
            longjmp(end, 1);
        }
        if (strncmp(line, "lost ", 5) == 0) {
            asleep = strtol(&line[5], NULL, 10) + 1;
        } else {
            noise_sample((int16_t)strtol(line, NULL, 10));
        }
        asleep--;
    }
}

BaseType_t xQueueReceive(QueueHandle_t queue, void *item, TickType_t wait)
{
    (void)wait;
    while (queue->count == 0U) {
        interrupts();
    }
    memcpy(item, &queue->items[queue->first * queue->bytes], queue->bytes);
    queue->first = (queue->first + 1U) % queue->length;
    queue->count--;
    return pdTRUE;
}

BaseType_t xTaskCreate(TaskFunction_t code, const char *name, uint16_t stack_words, void *context,
                       UBaseType_t priority, TaskHandle_t *handle)
{
    (void)name, (void)context, (void)priority, (void)handle;
    task = code;
    return (stack_words * sizeof(StackType_t) >= 4096U) ? pdPASS : pdFALSE;
}

void vTaskStartScheduler(void)
{
    task(NULL);
}

void noise_report(const davar_result_t *result)
{
    const davar_coefficient_t *const arw = &result->coefficient[DAVAR_ANGLE_RANDOM_WALK];
    gaps = (result->gaps_in_window > gaps) ? result->gaps_in_window : gaps;
    printf("%.9g %.9g %.9g\n", arw->value, arw->low, arw->high);
}

int main(void)
{
    if (noise_start() != DAVAR_OK) {
        return 1;
    }
    if (setjmp(end) == 0) {
        vTaskStartScheduler();
    }
    printf("lost %u gaps %u\n", (unsigned)noise_blocks_lost(), (unsigned)gaps);
    return 0;
}
