/* Time, serial port, I2C and main of the small core. argv: sensor (mpu6050, lsm6ds, none), seconds
 * to run; optionally the second at which the processor is busy, and for how long. */
#include "Arduino.h"
#include "sensor.h"
#include <stdlib.h>
#include <string.h>

static uint64_t clock_us, end_us = 20000000, busy_at_us = UINT64_MAX, busy_us;
static Sensor *sensor;

static void pass(uint64_t microseconds)
{
    clock_us += microseconds;
    if (clock_us >= busy_at_us) {
        clock_us += busy_us;
        busy_at_us = UINT64_MAX;
    }
    if (sensor != NULL) {
        sensor->pass(clock_us);
    }
    if (clock_us >= end_us) {
        exit(0);
    }
}

uint32_t micros()
{
    pass(1);
    return (uint32_t)clock_us;
}

void delay(uint32_t milliseconds)
{
    pass(1000U * milliseconds);
}

HardwareSerial Serial;
TwoWire Wire;

void TwoWire::beginTransmission(uint8_t address)
{
    address_ = address;
    out_count_ = 0;
}

size_t TwoWire::write(uint8_t value)
{
    if (out_count_ == sizeof out_) {
        return 0;
    }
    out_[out_count_++] = value;
    return 1;
}

uint8_t TwoWire::endTransmission(bool)
{
    pass(23U * (1U + out_count_)); /* nine bits at 400 kHz */
    if (sensor == NULL || sensor->address != address_) {
        return 2; /* no acknowledge */
    }
    for (uint8_t i = 1; i < out_count_; i++) {
        sensor->write((out_[0] + i - 1) & 0x7F, out_[i]);
    }
    return 0;
}

uint8_t TwoWire::requestFrom(uint8_t address, uint8_t count)
{
    in_count_ = in_next_ = 0;
    pass(23U * (1U + count));
    if (sensor == NULL || sensor->address != address || count > sizeof in_) {
        return 0;
    }
    for (uint8_t reg = out_[0]; in_count_ < count;
         reg = (uint8_t)(reg + (sensor->stays(reg) ? 0 : 1))) {
        in_[in_count_++] = sensor->read(reg & 0x7F);
    }
    return count;
}

int TwoWire::available()
{
    return in_count_ - in_next_;
}
int TwoWire::read()
{
    return (in_next_ < in_count_) ? in_[in_next_++] : -1;
}

int main(int argc, char **argv)
{
    const char *name = (argc > 1) ? argv[1] : "mpu6050";
    sensor = (strcmp(name, "mpu6050") == 0)  ? mpu6050
             : (strcmp(name, "lsm6ds") == 0) ? lsm6ds
                                             : NULL;
    if (argc > 2) {
        end_us = 1000000U * strtoull(argv[2], NULL, 10);
    }
    if (argc > 4) {
        busy_at_us = 1000000U * strtoull(argv[3], NULL, 10);
        busy_us = 1000000U * strtoull(argv[4], NULL, 10);
    }
    setup();
    for (;;) {
        loop();
    }
}
