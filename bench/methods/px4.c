/* PX4: the vibration metric of the gyro.
 *
 * Source: github.com/PX4/PX4-Autopilot, src/modules/sensors/vehicle_imu/VehicleIMU.cpp, written from
 * what it does: 0.99 of the metric plus 0.01 of the length of the difference from the previous rate.
 * PX4 takes the length over three axes; here it is one. White noise has 2 / sqrt(pi) times its
 * standard deviation as mean. */
#include "method.h"

typedef struct {
    float before, metric, lsb_dps;
} px4_t;
static void px4_start(px4_t *s, const setup_t *setup)
{
    s->lsb_dps = (float)setup->lsb_dps;
}
static void px4_push(px4_t *s, int16_t x)
{
    const float rate = s->lsb_dps * (float)x;
    s->metric = (0.99F * s->metric) + (0.01F * fabsf(rate - s->before));
    s->before = rate;
}
static answer_t px4_take(const px4_t *s)
{
    return only_sigma(0.8862269254527580 * (double)s->metric); /* sqrt(pi) / 2 */
}
METHOD_WITHOUT_GAPS(px4)

PROGRAM({"PX4", sizeof(px4_t), px4_run})
