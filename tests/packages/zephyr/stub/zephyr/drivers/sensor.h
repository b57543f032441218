/* Stands in for Zephyr's sensor interface: the names, types and meanings of its documentation that
 * the example uses. */
#ifndef STUB_SENSOR_H
#define STUB_SENSOR_H
#include <stdint.h>
#include <zephyr/device.h>
enum sensor_channel { SENSOR_CHAN_GYRO_Z = 6, SENSOR_CHAN_GYRO_XYZ = 7 };
enum sensor_trigger_type { SENSOR_TRIG_DATA_READY = 1 };
enum sensor_attribute { SENSOR_ATTR_SAMPLING_FREQUENCY = 0 };
struct sensor_value {
    int32_t val1; /* whole part */
    int32_t val2; /* millionths, of the same sign */
};
struct sensor_trigger {
    enum sensor_trigger_type type;
    enum sensor_channel chan;
};
typedef void (*sensor_trigger_handler_t)(const struct device *dev,
                                         const struct sensor_trigger *trigger);
int sensor_sample_fetch_chan(const struct device *dev, enum sensor_channel type);
int sensor_channel_get(const struct device *dev, enum sensor_channel chan,
                       struct sensor_value *val);
int sensor_attr_set(const struct device *dev, enum sensor_channel chan, enum sensor_attribute attr,
                    const struct sensor_value *val);
int sensor_trigger_set(const struct device *dev, const struct sensor_trigger *trig,
                       sensor_trigger_handler_t handler);
#endif
