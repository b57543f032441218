/* davar example - the angle random walk of a gyro's z axis, once per second, for any gyro with a
 * Zephyr driver and a data-ready trigger. The trigger's thread pushes and main takes, as an
 * instance allows. */
#include "davar/fit.h"
#include <davar/davar.h>
#include <zephyr/device.h>
#include <zephyr/drivers/sensor.h>
#include <zephyr/kernel.h>
#include <zephyr/sys/printk.h>

#define RATE_HZ 100
#define WINDOW 600
#define TAUS 7
#define DEGREES 57.29577951F

static const uint32_t taus[TAUS] = {1, 2, 4, 8, 16, 32, 64};
static uint64_t memory[DAVAR_MEMORY(F32, longest(WINDOW), shortest(WINDOW), stride(1), largest(64),
                                    taus(TAUS)) /
                       8];
static davar_config_t config;
static davar_plan_t plan;
static davar_t gyro_z;
static davar_result_t result;

static void sample_arrived(const struct device *gyro, const struct sensor_trigger *trigger)
{
    struct sensor_value rate; /* rad/s */
    (void)trigger;
    if (sensor_sample_fetch_chan(gyro, SENSOR_CHAN_GYRO_XYZ) != 0 ||
        sensor_channel_get(gyro, SENSOR_CHAN_GYRO_Z, &rate) != 0) {
        davar_gap(&gyro_z, 1);
        return;
    }
    const float degrees = DEGREES * ((float)rate.val1 + 1e-6F * (float)rate.val2);
    davar_push_f32(&gyro_z, &degrees, 1);
}

static davar_status_t start(void)
{
    config = davar_default_config;
    config.rate_hz = RATE_HZ;
    config.full_scale = 250.0; /* deg/s */
    config.law = NULL;
    config.window.longest = WINDOW;
    config.window.shortest = WINDOW;
    config.moments.segment = 0;
    config.taus = taus;
    config.tau_count = TAUS;
    /* Declare the low-pass of your gyro instead: davar_plan_init_filtered (davar/filter.h). */
    davar_plan_init(&plan, taus, TAUS);
    return davar_init_f32(&gyro_z, &config, memory, sizeof memory);
}

int main(void)
{
    const struct device *const gyro = DEVICE_DT_GET(DT_ALIAS(gyro0));
    static const struct sensor_trigger ready = {.type = SENSOR_TRIG_DATA_READY,
                                                .chan = SENSOR_CHAN_GYRO_XYZ};
    const struct sensor_value rate = {.val1 = RATE_HZ};

    const davar_status_t status = start();
    if (status != DAVAR_OK) {
        printk("davar: %s\n", davar_status_text(status));
        return 0;
    }
    if (!device_is_ready(gyro) ||
        sensor_attr_set(gyro, SENSOR_CHAN_GYRO_XYZ, SENSOR_ATTR_SAMPLING_FREQUENCY, &rate) != 0 ||
        sensor_trigger_set(gyro, &ready, sample_arrived) != 0) {
        printk("the gyro has no data-ready trigger at %d Hz\n", RATE_HZ);
        return 0;
    }
    for (;;) {
        k_sleep(K_SECONDS(1));
        if (davar_take(&gyro_z, &result)) {
            davar_fit(&plan, config.rate_hz, &result);
            const davar_coefficient_t *arw = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
            printk("%d samples, ARW %.4f (%.4f to %.4f) deg/sqrt(h)\n", (int)result.window_samples,
                   arw->value, arw->low, arw->high);
        }
    }
}
