/* davar in Betaflight: see davar_gyro.c. */
#ifndef DAVAR_GYRO_H
#define DAVAR_GYRO_H

#include <stdbool.h>
#include <stdint.h>

#define DAVAR_GYRO_AXES 3

/* The noise of an axis, in deg/sqrt(h), with its 95 % interval. */
typedef struct {
    bool present; /* false: davar has no value; ignore value and low */
    float value;
    float low;
    float high; /* without a value, an upper limit; 0: none */
} davar_gyro_noise_t;

typedef struct {
    davar_gyro_noise_t sensor[DAVAR_GYRO_AXES]; /* ARW before the firmware's filters, sensor axes */
    davar_gyro_noise_t floor[DAVAR_GYRO_AXES]; /* noise in flight, between rotor lines and motion */
    davar_gyro_noise_t filtered[DAVAR_GYRO_AXES]; /* ARW after the filters, axes of the craft */
    uint32_t results;                             /* of the first axis of the sensor */
    uint32_t alarms; /* of all axes; needs a plan with --false-alarms-per-hour */
    uint32_t lost;   /* samples that the task came too late for */
} davar_gyro_report_t;

/* Call it at the end of gyroUpdate(). Copies a sample; costs some 30 instructions. */
void davar_gyro_sample(void);

/* Call it at the end of taskHandleSerial(). The first call starts davar. */
void davar_gyro_task(void);

/* Call it at the end of handleMAVLinkTelemetry(): sends the report of an axis every 0.1 s. */
void davar_gyro_mavlink(void);

/* The newest values. They change only in davar_gyro_task. */
const davar_gyro_report_t *davar_gyro_report(void);

#endif
