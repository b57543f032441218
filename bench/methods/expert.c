/* 25 lines of exact C: what an expert writes instead of davar. Sums of squared second differences of
 * the integer phase over the last 600 samples, each updated by the difference that enters the window
 * and the one that leaves it. Overlapping Allan deviation, IEEE Std 1139; the noise is that at one
 * sample. */
#include "method.h"

#define W 600U
#define TAUS 7U
#define MASK 1023U

typedef struct {
    int32_t phase[MASK + 1U];
    int64_t squares[TAUS];
    uint32_t n;
    double lsb_dps;
} expert_t;
static void expert_start(expert_t *s, const setup_t *setup)
{
    s->lsb_dps = setup->lsb_dps;
}
static void expert_push(expert_t *s, int16_t x)
{
    const uint32_t n = ++s->n;
    int32_t *const p = s->phase;
    p[n & MASK] = (int32_t)((uint32_t)p[(n - 1U) & MASK] + (uint32_t)x);
    for (unsigned t = 0U; t < TAUS; t++) {
        const uint32_t m = 1U << t;
        const uint32_t tail = n - W - 1U;
        const int32_t in = p[n & MASK] - (2 * p[(n - m) & MASK]) + p[(n - (2U * m)) & MASK];
        const int32_t out =
            p[(tail + (2U * m)) & MASK] - (2 * p[(tail + m) & MASK]) + p[tail & MASK];
        if (n > W) {
            s->squares[t] += (int64_t)(in - out) * (in + out);
        } else if (n >= (2U * m)) {
            s->squares[t] += (int64_t)in * in;
        }
    }
}
static answer_t expert_take(const expert_t *s)
{
    double adev[TAUS];
    for (unsigned t = 0U; t < TAUS; t++) {
        const double m = (double)(1U << t);
        adev[t] = s->lsb_dps * sqrt((double)s->squares[t] / (2.0 * m * m * (W - (2.0 * m) + 1.0)));
    }
    return only_sigma((s->n >= W) ? adev[0] : (double)NAN);
}
METHOD_WITHOUT_GAPS(expert)

PROGRAM({"25 lines of C", sizeof(expert_t), expert_run})
