/* Velocity random walk of the three axes of an accelerometer, measured while it works.
 *
 * davar works with any unit. Set unit_per_count to m/s^2 per count. The coefficient called angle
 * random walk, in deg/sqrt(h) for a gyro, is then velocity random walk in m/s/sqrt(h), and ADEV is
 * in m/s^2.
 *
 * For your board: call accelerometer_start once, accelerometer_sample from the data-ready
 * interrupt, and accelerometer_noise from the main loop. Change rate, size of a count and cluster
 * times here. Gravity is a constant and has no effect; motion counts as noise. */
#include "accelerometer.h"

#include "davar/davar.h"
#include "davar/fit.h"

#define RATE_HZ 200.0
#define MPS2_PER_COUNT (9.80665 / 16384.0) /* +-2 g in 16 bits */
#define AXES 3
#define WINDOW 1200U /* samples: 6 s */
#define STRIDE 200U  /* one result per second */

static const uint32_t taus[] = {1, 2, 4, 8, 16, 32};
#define TAUS (sizeof taus / sizeof taus[0])

#define AXIS_BYTES                                                                                 \
    DAVAR_MEMORY_GRID(Q15, longest(WINDOW), shortest(WINDOW), stride(STRIDE), largest(32),         \
                      taus(TAUS))
static uint64_t memory[AXES][AXIS_BYTES / 8];
static davar_t axes[AXES]; /* x, y, z */
static davar_plan_t plan;  /* one for all axes */
static davar_config_t config;

davar_status_t accelerometer_start(void)
{
    config = davar_default_config;
    config.rate_hz = RATE_HZ;
    config.unit_per_count = MPS2_PER_COUNT;
    config.law = NULL;
    config.window.longest = WINDOW;
    config.window.shortest = WINDOW;
    config.moments.segment = 0;
    config.stride = STRIDE;
    config.engine = &davar_engine_grid_q15; /* least memory for short clusters and a long stride */
    config.taus = taus;
    config.tau_count = TAUS;
    davar_plan_init_white(&plan, taus, TAUS); /* its low-pass is far above 100 Hz */
    davar_status_t status = DAVAR_OK;
    for (int axis = 0; (axis < AXES) && (status == DAVAR_OK); axis++) {
        status = davar_init_q15(&axes[axis], &config, memory[axis], sizeof memory[axis]);
    }
    return status;
}

void accelerometer_sample(int16_t x, int16_t y, int16_t z)
{
    davar_push_q15(&axes[0], &x, 1);
    davar_push_q15(&axes[1], &y, 1);
    davar_push_q15(&axes[2], &z, 1);
}

void accelerometer_lost(uint32_t samples)
{
    for (int axis = 0; axis < AXES; axis++) {
        davar_gap(&axes[axis], samples);
    }
}

int accelerometer_noise(davar_coefficient_t *velocity_random_walk)
{
    static davar_result_t result;
    for (int axis = 0; axis < AXES; axis++) {
        if (davar_take(&axes[axis], &result)) {
            (void)davar_fit_white(&plan, RATE_HZ, &result); /* absent if the noise is not white */
            *velocity_random_walk = result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
            return axis;
        }
    }
    return -1;
}
