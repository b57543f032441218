/* FusionBias: is the gyro at rest, so that its offset may be learned? It reports no noise.
 *
 * Source: github.com/xioTechnologies/Fusion, Fusion/FusionBias.c, written from what it does: at rest
 * once the rate without its offset has stayed within 3 deg/s for 3 s; the offset then follows the rate
 * with a corner of 0.02 Hz. */
#include "method.h"

typedef struct {
    float offset, gain, lsb_dps;
    unsigned timer, timeout;
} fusion_t;
static void fusion_start(fusion_t *s, const setup_t *setup)
{
    s->gain = (float)(6.283185307179586 * 0.02 / setup->rate_hz);
    s->timeout = (unsigned)(3.0 * setup->rate_hz);
    s->lsb_dps = (float)setup->lsb_dps;
}
static void fusion_push(fusion_t *s, int16_t x)
{
    const float rate = (s->lsb_dps * (float)x) - s->offset;
    if (fabsf(rate) > 3.0F) {
        s->timer = 0U;
    } else if (s->timer < s->timeout) {
        s->timer++;
    } else {
        s->offset += s->gain * rate;
    }
}
static answer_t fusion_take(const fusion_t *s)
{
    return only_alarm(s->timer < s->timeout);
}
METHOD_WITHOUT_GAPS(fusion)

PROGRAM({"FusionBias", sizeof(fusion_t), fusion_run})
