/* Betaflight: the energy of the differences of samples.
 *
 * Source: github.com/betaflight/betaflight, src/main/flight/adaptive_filter.c of commit 0eb1c7c5
 * (proposed; not on the main branch in August 2026), written from what it does: the squared difference
 * of consecutive samples passes a leaky integrator of 0.05 s. There the samples are those of the D
 * term; here, those of the gyro. White noise has twice its variance as energy. */
#include "method.h"

typedef struct {
    float before, energy, gain, lsb_dps;
    bool is_started;
} betaflight_t;
static void betaflight_start(betaflight_t *s, const setup_t *setup)
{
    const double dt = 1.0 / setup->rate_hz;
    s->gain = (float)(dt / (0.05 + dt));
    s->lsb_dps = (float)setup->lsb_dps;
}
static void betaflight_push(betaflight_t *s, int16_t x)
{
    const float rate = s->lsb_dps * (float)x;
    const float difference = rate - s->before;
    if (s->is_started) {
        s->energy += s->gain * ((difference * difference) - s->energy);
    }
    s->before = rate;
    s->is_started = true;
}
static answer_t betaflight_take(const betaflight_t *s)
{
    return only_sigma(sqrt(0.5 * (double)s->energy));
}
METHOD_WITHOUT_GAPS(betaflight)

PROGRAM({"Betaflight", sizeof(betaflight_t), betaflight_run})
