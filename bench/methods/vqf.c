/* VQF: the detector of rest. It reports no noise.
 *
 * Source: Laidig and Seel, Information Fusion 91 (2023) 187, doi.org/10.1016/j.inffus.2022.10.014,
 * rest detection with the defaults of github.com/dlaidig/vqf: at rest once the gyro has stayed within
 * 2 deg/s of its low-pass (Butterworth of two poles, 0.5 s), and this within 2 deg/s, for 1.5 s. The
 * accelerometer, which VQF also checks, is not in these records. */
#include "method.h"

typedef struct {
    double b, a1, a2, delay[2], timer_s, period_s, lsb_dps;
} vqf_t;
static void vqf_start(vqf_t *s, const setup_t *setup)
{
    /* The corner is sqrt(2) / (2 pi tau). */
    const double c = tan(1.4142135623730951 / (2.0 * 0.5 * setup->rate_hz));
    const double d = (c * c) + (1.4142135623730951 * c) + 1.0;
    s->b = c * c / d;
    s->a1 = 2.0 * ((c * c) - 1.0) / d;
    s->a2 = (1.0 - (1.4142135623730951 * c) + (c * c)) / d;
    s->period_s = 1.0 / setup->rate_hz;
    s->lsb_dps = setup->lsb_dps;
}
static void vqf_push(vqf_t *s, int16_t x)
{
    const double rate = s->lsb_dps * x;
    const double low = (s->b * rate) + s->delay[0];
    s->delay[0] = (2.0 * s->b * rate) - (s->a1 * low) + s->delay[1];
    s->delay[1] = (s->b * rate) - (s->a2 * low);
    const bool is_moving = (fabs(rate - low) >= 2.0) || (fabs(low) > 2.0);
    s->timer_s = is_moving ? 0.0 : (s->timer_s + s->period_s);
}
static answer_t vqf_take(const vqf_t *s)
{
    return only_alarm(s->timer_s < 1.5);
}
METHOD_WITHOUT_GAPS(vqf)

PROGRAM({"VQF rest", sizeof(vqf_t), vqf_run})
