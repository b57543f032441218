/* davar - floor: a real transform of 64 samples as a complex one of 32 (14.1). */
#include "floor_transform.h"

const float davar_floor_sine[49] = {
    0.0F,          0.0980171403F, 0.195090322F,  0.290284677F,   0.382683432F,  0.471396737F,
    0.555570233F,  0.634393284F,  0.707106781F,  0.773010453F,   0.831469612F,  0.881921264F,
    0.923879533F,  0.956940336F,  0.98078528F,   0.995184727F,   1.0F,          0.995184727F,
    0.98078528F,   0.956940336F,  0.923879533F,  0.881921264F,   0.831469612F,  0.773010453F,
    0.707106781F,  0.634393284F,  0.555570233F,  0.471396737F,   0.382683432F,  0.290284677F,
    0.195090322F,  0.0980171403F, 0.0F,          -0.0980171403F, -0.195090322F, -0.290284677F,
    -0.382683432F, -0.471396737F, -0.555570233F, -0.634393284F,  -0.707106781F, -0.773010453F,
    -0.831469612F, -0.881921264F, -0.923879533F, -0.956940336F,  -0.98078528F,  -0.995184727F,
    -1.0F};

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

/* Two stages without products, of four complex numbers. */
static void first_stages(float *z)
{
    for (float *p = z; p < z + FLOOR_SEGMENT; p += 8) {
        const float sum_r = p[0] + p[2];
        const float sum_i = p[1] + p[3];
        const float off_r = p[0] - p[2];
        const float off_i = p[1] - p[3];
        const float other_r = p[4] + p[6];
        const float other_i = p[5] + p[7];
        const float apart_r = p[4] - p[6];
        const float apart_i = p[5] - p[7];
        p[0] = sum_r + other_r;
        p[1] = sum_i + other_i;
        p[4] = sum_r - other_r;
        p[5] = sum_i - other_i;
        p[2] = off_r + apart_i;
        p[3] = off_i - apart_r;
        p[6] = off_r - apart_i;
        p[7] = off_i + apart_r;
    }
}

/* Joins transforms of 4 complex numbers into those of 16, in two stages at once. */
static void middle_stages(float *z)
{
    for (size_t k = 0U; k < 4U; k++) {
        const float c = floor_cosine(8U * k);
        const float s = davar_floor_sine[8U * k];
        const float d = floor_cosine(4U * k);
        const float t = davar_floor_sine[4U * k];
        const float u = -s; /* sums only: gcc fuses a product with a difference of such a pair */
        const float v = -t;
        for (float *p = z + 2U * k; p < z + FLOOR_SEGMENT; p += 32) {
            const float one_r = p[8] * c + p[9] * s;
            const float one_i = p[9] * c + p[8] * u;
            const float three_r = p[24] * c + p[25] * s;
            const float three_i = p[25] * c + p[24] * u;
            const float even_r = p[0] + one_r;
            const float even_i = p[1] + one_i;
            const float odd_r = p[0] - one_r;
            const float odd_i = p[1] - one_i;
            const float more_r = p[16] + three_r;
            const float more_i = p[17] + three_i;
            const float less_r = p[16] - three_r;
            const float less_i = p[17] - three_i;
            const float two_r = more_r * d + more_i * t;
            const float two_i = more_i * d + more_r * v;
            const float four_r = less_r * d + less_i * t;
            const float four_i = less_i * d + less_r * v;
            p[0] = even_r + two_r;
            p[1] = even_i + two_i;
            p[16] = even_r - two_r;
            p[17] = even_i - two_i;
            p[8] = odd_r + four_i;
            p[9] = odd_i - four_r;
            p[24] = odd_r - four_i;
            p[25] = odd_i + four_r;
        }
    }
}

/* Joins two transforms of 16 complex numbers. */
static void last_stage(float *z)
{
    float *p = z;
    for (const float *s = davar_floor_sine; s < davar_floor_sine + FLOOR_HOP; s += 2) {
        const float u = -s[0];
        const float r = p[32] * s[16] + p[33] * s[0];
        const float i = p[33] * s[16] + p[32] * u;
        p[32] = p[0] - r;
        p[33] = p[1] - i;
        p[0] += r;
        p[1] += i;
        p += 2;
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
    first_stages(z);
    middle_stages(z);
    last_stage(z);
    power[15] = 4.0F * (z[32] * z[32] + z[33] * z[33]);
    for (size_t k = 1U; k < 16U; k++) {
        const float *const a = z + 2U * k;
        const float *const b = z + FLOOR_SEGMENT - 2U * k;
        const float even_r = a[0] + b[0];
        const float even_i = a[1] - b[1];
        const float odd_r = a[1] + b[1];
        const float odd_i = b[0] - a[0];
        const float c = floor_cosine(k);
        const float s = davar_floor_sine[k];
        const float u = -s;
        const float r = odd_r * c + odd_i * s;
        const float i = odd_i * c + odd_r * u;
        power[k - 1U] = (even_r + r) * (even_r + r) + (even_i + i) * (even_i + i);
        power[31U - k] = (even_r - r) * (even_r - r) + (even_i - i) * (even_i - i);
    }
}
