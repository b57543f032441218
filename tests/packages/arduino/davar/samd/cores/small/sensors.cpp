/* Two gyros after their data sheets. */
#include "sensor.h"
#include <math.h>

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

/* The next sample at this rate, in counts, after a Butterworth filter at eight times the rate, by
 * the bilinear transform. bandwidth_hz: -3 dB. */
static uint16_t noise_count(double rate_hz, double bandwidth_hz, double counts_per_dps)
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
    return (uint16_t)lround((1.5 + 0.3 / 60.0 * sqrt(rate_hz) * out[0]) * counts_per_dps);
}

/* MPU-6050 (RM-MPU-6000A-00, revision 4.2): sleep, sample rate, full scale, FIFO of 1024 bytes with
 * overflow. */
static struct : Sensor {
    uint8_t fifo[1024];
    unsigned first = 0, count = 0, latched = 0;

    bool stays(uint8_t at) override
    {
        return at == 0x74;
    }
    double rate_hz() override
    {
        const unsigned low_pass = value[0x1A] & 7U;
        const double internal = (low_pass == 0 || low_pass == 7) ? 8000.0 : 1000.0;
        return ((value[0x6B] & 0x40) != 0) ? 0.0 : internal / (1.0 + value[0x19]);
    }
    void sample() override
    {
        static const double counts_per_dps[] = {131.0, 65.5, 32.8, 16.4};
        const uint16_t counts = noise_count(rate_hz(), 42.0, counts_per_dps[value[0x1B] >> 3 & 3]);
        value[0x47] = (uint8_t)(counts >> 8);
        value[0x48] = (uint8_t)counts;
        value[0x3A] |= 0x01;
        for (int at = 0x47; (value[0x6A] & 0x40) != 0 && (value[0x23] & 0x10) != 0 && at <= 0x48;
             at++) {
            if (count == sizeof fifo) { /* the oldest is lost */
                (void)take();
                value[0x3A] |= 0x10;
            }
            fifo[(first + count++) % sizeof fifo] = value[at];
        }
    }
    uint8_t take()
    {
        const uint8_t byte = (count > 0) ? fifo[first] : 0xFF;
        first = (first + (count > 0)) % sizeof fifo;
        count -= count > 0;
        return byte;
    }
    uint8_t read(uint8_t at) override
    {
        const uint8_t byte = value[at];
        if (at == 0x3A) {
            value[at] = 0;
        }
        if (at == 0x72) { /* both bytes belong to the time at which the high one is read */
            latched = count;
        }
        return (at == 0x72)   ? (uint8_t)(latched >> 8)
               : (at == 0x73) ? (uint8_t)latched
               : (at == 0x74) ? take()
                              : byte;
    }
    void write(uint8_t at, uint8_t byte) override
    {
        /* A reset, only while the FIFO is off; the bit clears itself. */
        const bool resets = at == 0x6A && (byte & 0x04) != 0;
        count = (resets && (byte & 0x40) == 0) ? 0 : count;
        value[at] = resets ? (byte & (uint8_t)~0x04) : byte;
    }
} mpu;

/* LSM6DSO: off after power-up, data rate, full scale, a sample that is overwritten if it is not
 * read. */
static struct : Sensor {
    bool stays(uint8_t) override
    {
        return (value[0x12] & 0x04) == 0;
    }
    double rate_hz() override
    {
        static const double rates[16] = {0.0,   12.5,  26.0,   52.0,   104.0, 208.0,
                                         416.0, 833.0, 1666.0, 3332.0, 6664.0};
        return rates[value[0x11] >> 4];
    }
    void sample() override
    {
        static const double mdps[] = {8.75, 17.5, 35.0, 70.0};
        const double scale = ((value[0x11] & 0x02) != 0) ? 4.375 : mdps[value[0x11] >> 2 & 3];
        const uint16_t counts = noise_count(rate_hz(), 33.0, 1000.0 / scale);
        value[0x26] = (uint8_t)counts;
        value[0x27] = (uint8_t)(counts >> 8);
        value[0x1E] |= 0x02;
    }
    uint8_t read(uint8_t at) override
    {
        value[0x1E] &= (at == 0x27) ? (uint8_t)~0x02 : 0xFF; /* GDA */
        return value[at];
    }
} lsm;

static Sensor *started(Sensor *sensor, uint8_t address, uint8_t at, uint8_t byte, uint8_t who)
{
    sensor->address = address;
    sensor->value[at] = byte; /* after power-up */
    sensor->value[(address == 0x68) ? 0x75 : 0x0F] = who;
    return sensor;
}
Sensor *const mpu6050 = started(&mpu, 0x68, 0x6B, 0x40, 0x68); /* asleep */
Sensor *const lsm6ds = started(&lsm, 0x6B, 0x12, 0x04, 0x6C);  /* IF_INC */
