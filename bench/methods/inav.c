/* INAV: the root mean square of the gyro above 15 Hz.
 *
 * Source: github.com/iNavFlight/inav, src/main/flight/adaptive_filter.c and .h, written from what it
 * does: a low-pass of one pole at 15 Hz is subtracted, the last 32 samples are kept; 100 times per
 * second their rms passes a low-pass of one pole at 1 Hz. Divided here by the gain of that high-pass
 * for white noise. */
#include "method.h"

#define KEPT 32U
#define TASK_HZ 100.0

typedef struct {
    float ring[KEPT];
    float low, rms;
    float low_gain, rms_gain, white_gain, lsb_dps;
    float tasks_per_sample, due;
    uint32_t n;
} inav_t;
static float pt1_gain(double cutoff_hz, double rate_hz)
{
    const double rc = 1.0 / (6.283185307179586 * cutoff_hz);
    return (float)(1.0 / ((rc * rate_hz) + 1.0));
}
static void inav_start(inav_t *s, const setup_t *setup)
{
    const double k = (double)(s->low_gain = pt1_gain(15.0, setup->rate_hz));
    s->rms_gain = pt1_gain(1.0, TASK_HZ);
    s->white_gain = (float)((1.0 - k) * sqrt(2.0 / (2.0 - k)));
    s->tasks_per_sample = (float)(TASK_HZ / setup->rate_hz);
    s->lsb_dps = (float)setup->lsb_dps;
}
static void inav_push(inav_t *s, int16_t x)
{
    const float rate = s->lsb_dps * (float)x;
    s->low += s->low_gain * (rate - s->low);
    s->ring[s->n++ % KEPT] = rate - s->low;
    s->due += s->tasks_per_sample;
    while (s->due >= 1.0F) {
        s->due -= 1.0F;
        float sum = 0.0F;
        for (unsigned i = 0U; i < KEPT; i++) {
            sum += s->ring[i] * s->ring[i];
        }
        s->rms += s->rms_gain * (sqrtf(sum / (float)KEPT) - s->rms);
    }
}
static answer_t inav_take(const inav_t *s)
{
    return only_sigma((double)(s->rms / s->white_gain));
}
METHOD_WITHOUT_GAPS(inav)

PROGRAM({"INAV", sizeof(inav_t), inav_run})
