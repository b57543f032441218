/* Simulates an LSM6DSO after its data sheet: off after power-up, data rate, full scale, a sample
 * that is overwritten if it is not read. */
#include "sensor.h"
#include <string.h>

namespace {
class Lsm6ds : public Sensor {
  public:
    Lsm6ds()
    {
        memset(value_, 0, sizeof value_);
        value_[0x0F] = 0x6C;
        value_[0x12] = 0x04; /* IF_INC */
    }
    bool answers(uint8_t address) override
    {
        return address == 0x6B;
    }
    bool stays(uint8_t) override
    {
        return (value_[0x12] & 0x04) == 0;
    }

    uint8_t read(uint8_t address) override
    {
        if (address == 0x27) {
            value_[0x1E] &= (uint8_t)~0x02; /* GDA */
        }
        return value_[address & 0x7F];
    }

    void write(uint8_t address, uint8_t value) override
    {
        value_[address & 0x7F] = value;
    }

    void pass(uint64_t now_us) override
    {
        static const double rates[] = {0.0,   12.5,  26.0,   52.0,   104.0, 208.0,
                                       416.0, 833.0, 1666.0, 3332.0, 6664.0};
        static const double mdps[] = {8.75, 17.5, 35.0, 70.0};
        const unsigned odr = value_[0x11] >> 4;
        if (odr == 0 || odr > 10) {
            next_us_ = (double)now_us;
            return;
        }
        for (; next_us_ < (double)now_us; next_us_ += 1e6 / rates[odr]) {
            const double scale = ((value_[0x11] & 0x02) != 0) ? 4.375 : mdps[value_[0x11] >> 2 & 3];
            const uint16_t counts = (uint16_t)noise_count(rates[odr], 33.0, 1000.0 / scale);
            value_[0x26] = (uint8_t)counts;
            value_[0x27] = (uint8_t)(counts >> 8);
            value_[0x1E] |= 0x02;
        }
    }

  private:
    uint8_t value_[128];
    double next_us_ = 0.0;
};
} // namespace

Sensor *lsm6ds()
{
    static Lsm6ds sensor;
    return &sensor;
}
