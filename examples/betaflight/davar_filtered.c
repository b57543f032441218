/* davar in Betaflight, after its filters: the angle random walk of what the PID loop gets.
 *
 *   gyro.gyroADCf -> means of 32 -> ring -> taskHandleSerial: push, take -> report
 *
 * The low-pass filters of the firmware are declared to the fit, so the result is that of the gyro
 * before them. What is not declared, the notches and how the dynamic low-pass moves, matters
 * little at the averaging times used, 16 to 128 ms, and is part of the interval. */
#ifdef DAVAR_GYRO_FILTERED

#include "davar_filtered.h"
#include "davar/fit.h"

#include <math.h>

#include "platform.h"

#include "common/filter.h"
#include "common/maths.h"
#include "sensors/gyro.h"

#define MEAN 32U       /* samples of the gyro in one of davar's */
#define RING 16U       /* means, a power of two; 64 ms at 8 kHz */
#define WINDOW 2000U   /* means; 8 s at 8 kHz */
#define STRIDE 125U    /* means; 0.5 s at 8 kHz */
#define LONGEST 32U    /* the largest cluster size */
#define STEP 0.25f     /* of a count of the gyro: means are finer. The range is +-500 deg/s */
#define UNCERTAIN 0.3f /* of the cutoff: notches, and the dynamic low-pass within its range */

static const uint32_t taus[] = {4, 8, 16, LONGEST};
#define TAUS (sizeof taus / sizeof taus[0])

static uint64_t memory[DAVAR_GYRO_AXES]
                      [DAVAR_MEMORY_GRID(Q15, longest(WINDOW), shortest(WINDOW), stride(STRIDE),
                                         largest(LONGEST), taus(TAUS)) /
                       8U];
static davar_config_t config = {.stride = STRIDE,
                                .engine = &davar_engine_grid_q15,
                                DAVAR_FIXED(WINDOW),
                                .taus = taus,
                                .tau_count = TAUS};
static davar_plan_t plan;
static davar_t signal[DAVAR_GYRO_AXES];
static bool running;

static struct {
    float mean[RING][DAVAR_GYRO_AXES];
    float sum[DAVAR_GYRO_AXES];
    uint32_t summed;
    uint32_t put; /* both count means modulo 2^32 */
    uint32_t got;
} ring;

/* --- used by the gyro loop --- */

void davar_filtered_sample(void)
{
    const bool whole = ++ring.summed == MEAN;
    for (int axis = 0; axis < DAVAR_GYRO_AXES; axis++) {
        ring.sum[axis] += gyro.gyroADCf[axis];
        if (whole) {
            ring.mean[ring.put % RING][axis] = ring.sum[axis] / (float)MEAN;
            ring.sum[axis] = 0.0f;
        }
    }
    if (whole) {
        ring.summed = 0;
        ring.put++;
    }
}

/* --- used by the task --- */

/* Appends a low-pass of the firmware. False: a type without its coefficients here. */
static bool append(davar_filter_t *filter, int type, float cutoff_hz)
{
    const double cutoff = (double)cutoff_hz / (double)gyro.sampleRateHz;
    if (cutoff_hz <= 0.0f) {
        return true;
    }
    if (type == FILTER_PT1) {
        davar_filter_pt1(filter, cutoff);
    } else if (type == FILTER_BIQUAD) {
        davar_filter_biquad(filter, cutoff);
    } else {
        return false;
    }
    return true;
}

void davar_filtered_start(void)
{
    const gyroConfig_t *set = gyroConfig();
    const bool dynamic = set->gyro_lpf1_dyn_min_hz > 0U; /* its cutoff rises with the throttle */
    const float slow = dynamic ? set->gyro_lpf1_dyn_min_hz : set->gyro_lpf1_static_hz;
    const float fast = dynamic ? set->gyro_lpf1_dyn_max_hz : set->gyro_lpf1_static_hz;
    const float middle = (slow > 0.0f) ? 2.0f / (1.0f / slow + 1.0f / fast) : 0.0f;
    config.rate_hz = (double)gyro.sampleRateHz / (double)MEAN;
    config.unit_per_count = (double)(gyro.scale * STEP);
    davar_filter_t filter = {.uncertainty = (double)UNCERTAIN};
    if (!append(&filter, set->gyro_lpf1_type, middle) ||
        !append(&filter, set->gyro_lpf2_type, set->gyro_lpf2_static_hz)) {
        return;
    }
    davar_filter_cic(&filter, 1, MEAN);
    if (!davar_filter_is_valid(&filter)) {
        return; /* a cutoff out of its range */
    }
    davar_plan_init_filtered(&plan, taus, TAUS, &filter);
    running = true;
    for (int axis = 0; axis < DAVAR_GYRO_AXES; axis++) {
        running = running && (davar_init_q15(&signal[axis], &config, memory[axis],
                                             sizeof memory[axis]) == DAVAR_OK);
    }
    ring.got = ring.put;
}

/* A mean beyond the range is a gap, because a clamped one has no noise. */
static void push_mean(davar_t *to, float mean)
{
    const float counts = mean / (gyro.scale * STEP);
    if (fabsf(counts) > 32767.0f) {
        davar_gap(to, 1);
    } else {
        const int16_t count = (int16_t)lrintf(counts);
        davar_push_q15(to, &count, 1);
    }
}

void davar_filtered_push(void)
{
    const uint32_t waiting = ring.put - ring.got;
    if (!running || (waiting > RING)) {
        ring.got = ring.put;
    }
    for (int axis = 0; running && (axis < DAVAR_GYRO_AXES); axis++) {
        if (waiting > RING) {
            davar_gap(&signal[axis], waiting);
        }
        for (uint32_t at = ring.got; at != ring.put; at++) {
            push_mean(&signal[axis], ring.mean[at % RING][axis]);
        }
    }
    ring.got = ring.put;
}

void davar_filtered_take(uint8_t axis, davar_gyro_noise_t *noise)
{
    static davar_result_t result;
    if (running && davar_take(&signal[axis], &result)) {
        (void)davar_fit_white(&plan, config.rate_hz, &result);
        *noise = davar_gyro_noise(&result, 1.0f);
    }
}

#endif
