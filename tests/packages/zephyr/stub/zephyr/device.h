/* Stands in for Zephyr: one device, the gyro of kernel.c. */
#ifndef STUB_DEVICE_H
#define STUB_DEVICE_H
#include <stdbool.h>
struct device {
    int channel;
};
extern const struct device stub_gyro;
#define DT_ALIAS(name) stub_##name
#define DEVICE_DT_GET(node) DEVICE_OF(node)
#define DEVICE_OF(node) (&node##_device)
#define stub_gyro0_device stub_gyro
bool device_is_ready(const struct device *device);
#endif
