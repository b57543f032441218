/* A gyro with Zephyr's sensor interface, and time that passes in k_sleep: white noise with ARW 0.3
 * deg/sqrt(h) at the requested rate, which is sigma = 0.3 / 60 * sqrt(rate) deg/s. Ends after 20
 * s. */
#include <math.h>
#include <stdlib.h>
#include <zephyr/drivers/sensor.h>
#include <zephyr/kernel.h>

#define ARW 0.3
#define SECONDS 20

const struct device stub_gyro = {SENSOR_CHAN_GYRO_XYZ};
static sensor_trigger_handler_t handler;
static const struct sensor_trigger *trigger;
static int rate_hz, seconds;
static int64_t fetched; /* millionths of rad/s */

bool device_is_ready(const struct device *device)
{
    return device == &stub_gyro;
}

static double uniform(void)
{
    static uint64_t state = 1;
    state = state * 6364136223846793005U + 1442695040888963407U;
    return ((double)(state >> 11U) + 0.5) / 9007199254740992.0;
}

int sensor_sample_fetch_chan(const struct device *dev, enum sensor_channel type)
{
    const double pi = acos(-1.0);
    const double noise = sqrt(-2.0 * log(uniform())) * cos(2.0 * pi * uniform());
    const double degrees = 1.5 + ARW / 60.0 * sqrt(rate_hz) * noise;
    fetched = llround(degrees * pi / 180.0 * 1e6);
    return (type == (enum sensor_channel)dev->channel) ? 0 : -1;
}

int sensor_channel_get(const struct device *dev, enum sensor_channel chan, struct sensor_value *val)
{
    (void)dev;
    val->val1 = (int32_t)(fetched / 1000000);
    val->val2 = (int32_t)(fetched % 1000000);
    return (chan == SENSOR_CHAN_GYRO_Z) ? 0 : -1;
}

int sensor_attr_set(const struct device *dev, enum sensor_channel chan, enum sensor_attribute attr,
                    const struct sensor_value *val)
{
    rate_hz = val->val1;
    return (dev == &stub_gyro && chan == SENSOR_CHAN_GYRO_XYZ &&
            attr == SENSOR_ATTR_SAMPLING_FREQUENCY)
               ? 0
               : -1;
}

int sensor_trigger_set(const struct device *dev, const struct sensor_trigger *trig,
                       sensor_trigger_handler_t to)
{
    trigger = trig;
    handler = to;
    return (dev == &stub_gyro && trig->type == SENSOR_TRIG_DATA_READY) ? 0 : -1;
}

int k_sleep(k_timeout_t timeout)
{
    for (int i = 0; i < timeout.seconds * rate_hz; i++) {
        handler(&stub_gyro, trigger);
    }
    seconds += timeout.seconds;
    if (seconds >= SECONDS) {
        exit(0);
    }
    return 0;
}
