/* Simulates an MPU-6050 after RM-MPU-6000A-00 (revision 4.2): sleep, sample rate, full scale, FIFO
 * of 1024 bytes with overflow. */
#include "sensor.h"
#include <math.h>
#include <string.h>

namespace {
const unsigned FIFO_BYTES = 1024;

class Mpu6050 : public Sensor {
  public:
    Mpu6050()
    {
        memset(value_, 0, sizeof value_);
        value_[0x6B] = 0x40; /* asleep after power-up */
        value_[0x75] = 0x68;
    }
    bool answers(uint8_t address) override
    {
        return address == 0x68;
    }
    bool stays(uint8_t address) override
    {
        return address == 0x74;
    }

    uint8_t read(uint8_t address) override
    {
        const uint8_t value = value_[address & 0x7F];
        switch (address) {
        case 0x3A:
            value_[address] = 0;
            return value;
        case 0x72:
            latched_ = count_; /* both bytes belong to the time at which the high one is read */
            return (uint8_t)(latched_ >> 8);
        case 0x73:
            return (uint8_t)latched_;
        case 0x74:
            return take();
        default:
            return value;
        }
    }

    void write(uint8_t address, uint8_t value) override
    {
        if (address == 0x6A &&
            (value & 0x04) != 0) { /* a reset, only while the FIFO is off; the bit clears itself */
            count_ = ((value & 0x40) == 0) ? 0 : count_;
            value &= (uint8_t)~0x04;
        }
        value_[address & 0x7F] = value;
    }

    void pass(uint64_t now_us) override
    {
        const unsigned low_pass = value_[0x1A] & 7U;
        const double rate =
            ((low_pass == 0 || low_pass == 7) ? 8000.0 : 1000.0) / (1.0 + value_[0x19]);
        if ((value_[0x6B] & 0x40) != 0) {
            next_us_ = (double)now_us;
        }
        for (; next_us_ < (double)now_us; next_us_ += 1e6 / rate) {
            static const double counts_per_dps[] = {131.0, 65.5, 32.8, 16.4};
            sample((uint16_t)noise_count(rate, 42.0, counts_per_dps[value_[0x1B] >> 3 & 3]));
        }
    }

  private:
    uint8_t value_[128], fifo_[FIFO_BYTES];
    unsigned first_ = 0, count_ = 0, latched_ = 0;
    double next_us_ = 0.0;

    void sample(uint16_t counts)
    {
        value_[0x47] = (uint8_t)(counts >> 8);
        value_[0x48] = (uint8_t)counts;
        value_[0x3A] |= 0x01;
        if ((value_[0x6A] & 0x40) != 0 && (value_[0x23] & 0x10) != 0) {
            put(value_[0x47]);
            put(value_[0x48]);
        }
    }
    void put(uint8_t byte)
    {
        if (count_ == FIFO_BYTES) { /* the oldest is lost */
            (void)take();
            value_[0x3A] |= 0x10;
        }
        fifo_[(first_ + count_++) % FIFO_BYTES] = byte;
    }
    uint8_t take()
    {
        if (count_ == 0) {
            return 0xFF;
        }
        count_--;
        const uint8_t byte = fifo_[first_];
        first_ = (first_ + 1) % FIFO_BYTES;
        return byte;
    }
};
} // namespace

Sensor *mpu6050()
{
    static Mpu6050 sensor;
    return &sensor;
}

/* White noise of standard deviation 1. */
static double gauss()
{
    static uint64_t state = 1;
    double uniform[2];
    for (double &one : uniform) {
        state = state * 6364136223846793005U + 1442695040888963407U;
        one = ((double)(state >> 11U) + 0.5) / 9007199254740992.0;
    }
    return sqrt(-2.0 * log(uniform[0])) * cos(2.0 * acos(-1.0) * uniform[1]);
}

/* A Butterworth filter at eight times the rate, by the bilinear transform. */
int16_t noise_count(double rate_hz, double bandwidth_hz, double counts_per_dps)
{
    static double in[2], out[2];
    const int faster = 8;
    const double k = tan(acos(-1.0) * bandwidth_hz / (rate_hz * faster));
    const double under = 1.0 + k * sqrt(2.0) + k * k;
    for (int i = 0; i < faster; i++) {
        const double x = gauss() * sqrt((double)faster);
        const double y = (k * k * (x + 2.0 * in[0] + in[1]) - 2.0 * (k * k - 1.0) * out[0] -
                          (1.0 - k * sqrt(2.0) + k * k) * out[1]) /
                         under;
        in[1] = in[0];
        in[0] = x;
        out[1] = out[0];
        out[0] = y;
    }
    return (int16_t)lround((1.5 + 0.3 / 60.0 * sqrt(rate_hz) * out[0]) * counts_per_dps);
}
