/* davar - floor: a real transform of 64 samples as a complex one of 32 (14.1). */
#include "floor_transform.h"

const float davar_floor_sine[53] = {
    0.0F,          0.0980171403F, 0.195090322F,  0.290284677F,   0.382683432F,  0.471396737F,
    0.555570233F,  0.634393284F,  0.707106781F,  0.773010453F,   0.831469612F,  0.881921264F,
    0.923879533F,  0.956940336F,  0.98078528F,   0.995184727F,   1.0F,          0.995184727F,
    0.98078528F,   0.956940336F,  0.923879533F,  0.881921264F,   0.831469612F,  0.773010453F,
    0.707106781F,  0.634393284F,  0.555570233F,  0.471396737F,   0.382683432F,  0.290284677F,
    0.195090322F,  0.0980171403F, 0.0F,          -0.0980171403F, -0.195090322F, -0.290284677F,
    -0.382683432F, -0.471396737F, -0.555570233F, -0.634393284F,  -0.707106781F, -0.773010453F,
    -0.831469612F, -0.881921264F, -0.923879533F, -0.956940336F,  -0.98078528F,  -0.995184727F,
    -1.0F,         -0.995184727F, -0.98078528F,  -0.956940336F,  -0.923879533F};

/* The Hann window at half samples: it is even, so half of it is enough. */
static const float hann[FLOOR_HOP] = {
    0.000602271897F, 0.00541174502F, 0.0149843734F, 0.0292279674F, 0.0480053534F, 0.071135695F,
    0.0983962343F,   0.129524437F,   0.164220523F,  0.202150348F,  0.242948628F,  0.286222453F,
    0.331555073F,    0.37850991F,    0.426634763F,  0.475466163F,  0.524533837F,  0.573365237F,
    0.62149009F,     0.668444927F,   0.713777547F,  0.757051372F,  0.797849652F,  0.835779477F,
    0.870475563F,    0.901603766F,   0.928864305F,  0.951994647F,  0.970772033F,  0.985015627F,
    0.994588255F,    0.999397728F};

/* Places of complex numbers for a transform that begins with neighbours. */
static const uint8_t reversed[FLOOR_HOP] = {0,  16, 8,  24, 4,  20, 12, 28, 2,  18, 10,
                                            26, 6,  22, 14, 30, 1,  17, 9,  25, 5,  21,
                                            13, 29, 3,  19, 11, 27, 7,  23, 15, 31};

/* The transform of four complex numbers, without products; they are `step` floats apart, and the
 * second and the third are exchanged. */
static inline void transform_four(float *p, size_t step)
{
    float *const q = p + step;
    float *const r = q + step;
    float *const s = r + step;
    const float sum_r = p[0] + q[0];
    const float sum_i = p[1] + q[1];
    const float off_r = p[0] - q[0];
    const float off_i = p[1] - q[1];
    const float other_r = r[0] + s[0];
    const float other_i = r[1] + s[1];
    const float apart_r = r[0] - s[0];
    const float apart_i = r[1] - s[1];
    p[0] = sum_r + other_r;
    p[1] = sum_i + other_i;
    r[0] = sum_r - other_r;
    r[1] = sum_i - other_i;
    q[0] = off_r + apart_i;
    q[1] = off_i - apart_r;
    s[0] = off_r - apart_i;
    s[1] = off_i + apart_r;
}

/* Turns a number back by k 64ths of a turn. Sums only: gcc fuses a product with the difference of
 * such a pair. */
static inline void turn(float *z, size_t k)
{
    const float c = floor_cosine(k);
    const float s = davar_floor_sine[k];
    const float u = -s;
    const float r = z[0] * c + z[1] * s;
    z[1] = z[1] * c + z[0] * u;
    z[0] = r;
}

/* Joins transforms of 4 complex numbers into those of 16. */
static void middle_stages(float *z)
{
    for (size_t k = 0U; k < 4U; k++) {
        for (size_t i = 2U * k; i < FLOOR_SEGMENT; i += 32U) {
            turn(z + i + 8U, 8U * k);
            turn(z + i + 16U, 4U * k);
            turn(z + i + 24U, 12U * k);
            transform_four(z + i, 8U);
        }
    }
}

/* Joins two transforms of 16 complex numbers. */
static void last_stage(float *z)
{
    for (size_t k = 0U; k < FLOOR_HOP; k += 2U) {
        float *const p = z + k;
        float *const q = p + FLOOR_HOP;
        turn(q, k);
        const float r = q[0];
        const float i = q[1];
        q[0] = p[0] - r;
        q[1] = p[1] - i;
        p[0] += r;
        p[1] += i;
    }
}

static void load(const float ring[FLOOR_SEGMENT], size_t oldest, float *z)
{
    const float *const older = ring + oldest;
    const float *const newer = ring + (oldest ^ FLOOR_HOP);
    for (size_t i = 0U; i < FLOOR_HOP / 2U; i++) {
        float *const p = z + (size_t)2U * reversed[i];
        float *const q = z + (size_t)2U * reversed[i + (FLOOR_HOP / 2U)];
        p[0] = older[2U * i] * hann[2U * i];
        p[1] = older[2U * i + 1U] * hann[2U * i + 1U];
        q[0] = newer[2U * i] * hann[FLOOR_HOP - 1U - 2U * i];
        q[1] = newer[2U * i + 1U] * hann[FLOOR_HOP - 2U - 2U * i];
    }
}

void davar_floor_transform(const float ring[FLOOR_SEGMENT], size_t oldest, float power[31])
{
    float z[FLOOR_SEGMENT];
    load(ring, oldest, z);
    for (size_t i = 0U; i < FLOOR_SEGMENT; i += 8U) {
        transform_four(z + i, 2U);
    }
    middle_stages(z);
    last_stage(z);
    power[15] = 4.0F * (z[32] * z[32] + z[33] * z[33]);
    for (size_t k = 1U; k < 16U; k++) {
        const float *const a = z + 2U * k;
        const float *const b = z + FLOOR_SEGMENT - 2U * k;
        const float even_r = a[0] + b[0];
        const float even_i = a[1] - b[1];
        float odd[2] = {a[1] + b[1], b[0] - a[0]};
        turn(odd, k);
        power[k - 1U] =
            (even_r + odd[0]) * (even_r + odd[0]) + (even_i + odd[1]) * (even_i + odd[1]);
        power[31U - k] =
            (even_r - odd[0]) * (even_r - odd[0]) + (even_i - odd[1]) * (even_i - odd[1]);
    }
}
