/* A gyro on the I2C bus: white noise with ARW 0.3 deg/sqrt(h) about 1.5 deg/s, after a low-pass of
 * two poles, in the registers of a chip. */
#ifndef SENSOR_H
#define SENSOR_H

#include <stdint.h>

class Sensor {
  public:
    virtual bool answers(uint8_t address) = 0;
    virtual uint8_t read(uint8_t address) = 0;
    virtual void write(uint8_t address, uint8_t value) = 0;
    virtual bool stays(uint8_t address) = 0; /* true if the register address does not increment */
    virtual void pass(uint64_t now_us) = 0;  /* up to this time */
};
Sensor *mpu6050();
Sensor *lsm6ds();

/* The next sample at this rate, in counts. bandwidth_hz: -3 dB. */
int16_t noise_count(double rate_hz, double bandwidth_hz, double counts_per_dps);

#endif
