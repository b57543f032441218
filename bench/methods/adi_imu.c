/* adi_imu, the ROS 2 driver of Analog Devices: its five covariance providers with their defaults.
 *
 * Source: analogdevicesinc.github.io/imu_ros2, classes StaticCovarianceProvider to
 * KalmanCovarianceProvider and MotionDetector, written from their documentation. Variances are in
 * (rad/s)^2 of at least 1e-9; all but the first two skip samples above 0.05 rad/s. The accelerometer,
 * which MotionDetector also checks, is not in these records. */
#include "method.h"

#define RAD_PER_DEG 0.017453292519943295
#define LEAST 1e-9
#define WARM 100U

static answer_t of_variance(double variance, bool is_ready)
{
    return only_sigma(is_ready ? (sqrt(fmax(variance, LEAST)) / RAD_PER_DEG) : (double)NAN);
}

/* static: what the user states; here, the data sheet. */
typedef struct {
    double variance;
} sheet_t;
static void sheet_start(sheet_t *s, const setup_t *setup)
{
    s->variance = pow(setup->sheet_dps * RAD_PER_DEG, 2.0);
}
static void sheet_push(const sheet_t *s, int16_t x)
{
    (void)s;
    (void)x;
}
static answer_t sheet_take(const sheet_t *s)
{
    return of_variance(s->variance, true);
}
METHOD_WITHOUT_GAPS(sheet)

/* welford: the variance of the first 1000 samples. */
typedef struct {
    double unit, mean, squares;
    uint32_t n;
} welford_t;
static void welford_start(welford_t *s, const setup_t *setup)
{
    s->unit = setup->lsb_dps * RAD_PER_DEG;
}
static void welford_push(welford_t *s, int16_t x)
{
    if (s->n < 1000U) {
        const double from_old = (s->unit * x) - s->mean;
        s->mean += from_old / ++s->n;
        s->squares += from_old * ((s->unit * x) - s->mean);
    }
}
static answer_t welford_take(const welford_t *s)
{
    return of_variance(s->squares / (s->n - 1.0), s->n == 1000U);
}
METHOD_WITHOUT_GAPS(welford)

/* sliding_window: the variance of the last 500 samples. */
#define WINDOW 500U
typedef struct {
    double unit, ring[WINDOW];
    uint32_t n;
} sliding_t;
static void sliding_start(sliding_t *s, const setup_t *setup)
{
    s->unit = setup->lsb_dps * RAD_PER_DEG;
}
static bool is_still(double rate)
{
    return fabs(rate) <= 0.05;
}
static void sliding_push(sliding_t *s, int16_t x)
{
    if (is_still(s->unit * x)) {
        s->ring[s->n++ % WINDOW] = s->unit * x;
    }
}
static answer_t sliding_take(const sliding_t *s)
{
    const uint32_t count = (s->n < WINDOW) ? s->n : WINDOW;
    double mean = 0.0;
    double squares = 0.0;
    for (uint32_t i = 0U; i < count; i++) {
        mean += s->ring[i] / count;
    }
    for (uint32_t i = 0U; i < count; i++) {
        squares += (s->ring[i] - mean) * (s->ring[i] - mean);
    }
    return of_variance(squares / (count - 1.0), count >= WARM);
}
METHOD_WITHOUT_GAPS(sliding)

/* ewma: exponential means with a weight of 0.02. */
typedef struct {
    double unit, mean, variance;
    uint32_t n;
} ewma_t;
static void ewma_start(ewma_t *s, const setup_t *setup)
{
    s->unit = setup->lsb_dps * RAD_PER_DEG;
}
static void ewma_push(ewma_t *s, int16_t x)
{
    const double rate = s->unit * x;
    if (is_still(rate)) {
        s->mean = (s->n++ == 0U) ? rate : ((0.02 * rate) + (0.98 * s->mean));
        s->variance = (0.02 * (rate - s->mean) * (rate - s->mean)) + (0.98 * s->variance);
    }
}
static answer_t ewma_take(const ewma_t *s)
{
    return of_variance(s->variance, s->n >= WARM);
}
METHOD_WITHOUT_GAPS(ewma)

/* kalman: a scalar filter of squared residuals, Q = 1e-6, R = 1e-4; the mean has a weight of 0.01. */
typedef struct {
    double unit, mean, variance, p;
    uint32_t n;
} kalman_t;
static void kalman_start(kalman_t *s, const setup_t *setup)
{
    s->unit = setup->lsb_dps * RAD_PER_DEG;
    s->variance = 1e-4;
    s->p = 1.0;
}
static void kalman_push(kalman_t *s, int16_t x)
{
    const double rate = s->unit * x;
    if (is_still(rate)) {
        s->mean = (s->n++ == 0U) ? rate : ((0.01 * rate) + (0.99 * s->mean));
        const double predicted = s->p + 1e-6;
        const double gain = predicted / (predicted + 1e-4);
        s->variance += gain * (((rate - s->mean) * (rate - s->mean)) - s->variance);
        s->variance = fmax(s->variance, LEAST);
        s->p = (1.0 - gain) * predicted;
    }
}
static answer_t kalman_take(const kalman_t *s)
{
    return of_variance(s->variance, s->n >= WARM);
}
METHOD_WITHOUT_GAPS(kalman)

PROGRAM({"adi_imu static", sizeof(sheet_t), sheet_run},
        {"adi_imu welford", sizeof(welford_t), welford_run},
        {"adi_imu sliding", sizeof(sliding_t), sliding_run},
        {"adi_imu ewma", sizeof(ewma_t), ewma_run},
        {"adi_imu kalman", sizeof(kalman_t), kalman_run})
