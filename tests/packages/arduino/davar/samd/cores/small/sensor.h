/* A gyro on the I2C bus: white noise with ARW 0.3 deg/sqrt(h) about 1.5 deg/s, after a low-pass of
 * two poles, in the registers of a chip. */
#ifndef SENSOR_H
#define SENSOR_H

#include <stdint.h>

struct Sensor {
    uint8_t address;
    uint8_t value[128];
    double next_us;

    virtual uint8_t read(uint8_t at)
    {
        return value[at];
    }
    virtual void write(uint8_t at, uint8_t byte)
    {
        value[at] = byte;
    }
    virtual bool stays(uint8_t at) = 0; /* true if the register address does not increment */
    virtual double rate_hz() = 0;       /* 0: asleep */
    virtual void sample() = 0;

    void pass(uint64_t now_us)
    {
        if (!(rate_hz() > 0.0)) {
            next_us = (double)now_us;
        }
        for (; next_us < (double)now_us; next_us += 1e6 / rate_hz()) {
            sample();
        }
    }
};
extern Sensor *const mpu6050;
extern Sensor *const lsm6ds;

#endif
