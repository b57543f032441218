/* davar in Betaflight: the noise of the gyro, at rest and in flight.
 *
 *   gyroUpdate -> ring -> taskHandleSerial: push, take -> report -> debug[], MAVLink
 *
 * The gyro loop only copies a sample. Push and take run in the serial task. Betaflight's tasks do
 * not interrupt each other, so no lock is needed. If the task is late, the lost samples are
 * counted and reported to davar as a gap.
 *
 * For your board: make davar_setup.c with tools/davar-plan (README.md). Compile it and lib/src
 * apart from the firmware, without -ffast-math and -fsingle-precision-constant. */
#include "davar_gyro.h"

#include "platform.h"

#include "build/debug.h"
#include "common/maths.h"
#include "sensors/gyro.h"

#include "davar/glr.h"
#include "davar_filtered.h"
#include "davar_setup.h"

#define RING 512U      /* samples, a power of two; 64 ms at 8 kHz */
#define NO_LIMIT 1e30f /* deg/sqrt(h) and above: infinity */

static struct {
    int16_t counts[RING][DAVAR_GYRO_AXES];
    uint32_t put; /* both count samples modulo 2^32 */
    uint32_t got;
} ring;

static enum { COLD, REFUSED, RUNNING } state;
static davar_gyro_report_t report;

const davar_gyro_report_t *davar_gyro_report(void)
{
    return &report;
}

/* --- used by the gyro loop --- */

void davar_gyro_sample(void)
{
    for (int axis = 0; axis < DAVAR_GYRO_AXES; axis++) {
        ring.counts[ring.put % RING][axis] = gyro.rawSensorDev->gyroADCRaw[axis];
    }
    ring.put++;
    davar_filtered_sample();
}

/* --- used by the task --- */

/* Refuses a gyro that the plan is not for: its results would be calmly wrong. */
static void start(void)
{
    const bool planned = gyro.sampleRateHz == (uint16_t)DAVAR_SETUP_RATE_HZ;
    state = (planned && (davar_setup_start() == DAVAR_OK)) ? RUNNING : REFUSED;
    if (state == RUNNING) {
        davar_filtered_start();
    }
    ring.got = ring.put;
}

static void push(void)
{
    const uint32_t waiting = ring.put - ring.got;
    if (waiting > RING) {
        report.lost += waiting;
        davar_setup_gap(waiting);
        ring.got = ring.put;
    }
    while (ring.got != ring.put) {
        const uint32_t at = ring.got % RING;
        const uint32_t n = MIN(ring.put - ring.got, RING - at);
        davar_setup_push(ring.counts[at], n);
        ring.got += n;
    }
}

static davar_gyro_noise_t scaled(bool present, float value, float low, float high, float scale)
{
    return (davar_gyro_noise_t){.present = present,
                                .value = scale * value,
                                .low = scale * low,
                                .high = (high < NO_LIMIT) ? scale * high : 0.0f};
}

davar_gyro_noise_t davar_gyro_noise(const davar_result_t *result, float scale)
{
    const davar_coefficient_t *arw = &result->coefficient[DAVAR_ANGLE_RANDOM_WALK];
    return scaled(arw->present, (float)arw->value, (float)arw->low, (float)arw->high, scale);
}

/* The newest result of one axis in each call, so that a call stays short. */
static void take(void)
{
    static uint8_t axis;
    davar_glr_report_t changes;
    /* The plan states a size of the count; the firmware knows the range that is set. */
    const float scale = gyro.scale / (float)davar_setup_config()->unit_per_count;
    const davar_result_t *result = davar_setup_take(axis);
    const davar_floor_result_t *floor = davar_setup_floor(axis);
    if (floor != NULL) {
        report.floor[axis] =
            scaled(floor->why == DAVAR_FLOOR_VALUE, floor->value, floor->low, floor->high, scale);
    }
    if (result != NULL) {
        report.sensor[axis] = davar_gyro_noise(result, scale);
        davar_glr_report(davar_setup_instance(axis), &changes);
        report.alarms += changes.alarm;
        report.results += (axis == 0U);
    }
    davar_filtered_take(axis, &report.filtered[axis]);
    axis = (uint8_t)((axis + 1U) % DAVAR_GYRO_AXES);
}

/* In 1e-3 deg/sqrt(h); -1: no value. */
static NOINLINE int16_t milli(const davar_gyro_noise_t *noise)
{
    return noise->present ? (int16_t)MIN(noise->value * 1e3f + 0.5f, 32767.0f) : -1;
}

/* For MSP_DEBUG and the black box, unless the pilot debugs something else. */
static void show(void)
{
    if (debugMode != DEBUG_NONE) {
        return;
    }
    for (int axis = 0; axis < DAVAR_GYRO_AXES; axis++) {
        debug[axis] = milli(&report.sensor[axis]);
        debug[DAVAR_GYRO_AXES + axis] = milli(&report.floor[axis]);
    }
    debug[6] = (int16_t)report.results;
    debug[7] = (int16_t)report.alarms;
}

void davar_gyro_task(void)
{
    if (state == COLD) {
        start();
        show(); /* -1 also in REFUSED: 0 would read as a gyro without noise */
    }
    if (state == RUNNING) {
        push();
        davar_filtered_push();
        take();
        show();
    }
}
