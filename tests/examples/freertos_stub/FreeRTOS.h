/* davar tests - the few names of FreeRTOS that the example uses, after its documentation (v10 and
 * v11). The package registries of the tests do not have the kernel. There is one task; a wait for a
 * queue runs the interrupts until an item arrives. */
#ifndef STUB_FREERTOS_H
#define STUB_FREERTOS_H

#include <assert.h>
#include <stddef.h>
#include <stdint.h>

typedef long BaseType_t;
typedef unsigned long UBaseType_t;
typedef uint32_t TickType_t;
typedef size_t StackType_t;
typedef struct stub_queue *QueueHandle_t;
typedef void (*TaskFunction_t)(void *);
typedef void *TaskHandle_t;

#define pdFALSE ((BaseType_t)0)
#define pdTRUE ((BaseType_t)1)
#define pdPASS pdTRUE
#define portMAX_DELAY ((TickType_t)0xFFFFFFFFUL)
#define portYIELD_FROM_ISR(woken) ((void)(woken))
#define configASSERT(condition) assert(condition)
#define tskIDLE_PRIORITY ((UBaseType_t)0U)

QueueHandle_t xQueueCreate(UBaseType_t length, UBaseType_t item_bytes);
BaseType_t xQueueSendFromISR(QueueHandle_t queue, const void *item, BaseType_t *woken);
BaseType_t xQueueReceive(QueueHandle_t queue, void *item, TickType_t wait);
BaseType_t xTaskCreate(TaskFunction_t code, const char *name, uint16_t stack_words, void *context,
                       UBaseType_t priority, TaskHandle_t *handle);
void vTaskStartScheduler(void);

#endif
