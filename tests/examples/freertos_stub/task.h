/* davar tests - see FreeRTOS.h. */
#ifndef STUB_TASK_H
#define STUB_TASK_H

#include "FreeRTOS.h"

typedef void (*TaskFunction_t)(void *);
typedef void *TaskHandle_t;

#define tskIDLE_PRIORITY ((UBaseType_t)0U)

BaseType_t xTaskCreate(TaskFunction_t code, const char *name, uint16_t stack_words, void *context,
                       UBaseType_t priority, TaskHandle_t *handle);
void vTaskStartScheduler(void);

#endif
