/* Statement: one step of the sliding Allan variance of q15, at any position of the stream and after
 * any history, overflows nothing signed and reads only its span. The samples are any int16, each
 * difference D any value of its definition, |D| <= m 65535, the sums of squares any 64 bits. The
 * statement therefore covers the first push and every later one. Bound: octaves 1 .. LARGEST and 1,
 * 3, 10, 30 .. LARGEST; init accepts no m above 1290 (2.4). */
#include "number/q15.inc"

#include "core/window.h"

#include "core/allan.inc"

#include "core/slide.inc"

#include "proof.h"

#ifndef LARGEST
#define LARGEST 1024U
#endif
#define TAUS 12U

static sample_t samples[2U * (2U * LARGEST) + 1U];

static void step(const uint32_t *m, uint8_t count, bool octaves)
{
    tau_t tau[TAUS];
    for (uint32_t t = 0U; t < count; t++) {
        const int32_t most = (int32_t)m[t] * 65535;
        tau[t].sum = any_u64();
        tau[t].head = any_i32(-most, most);
        tau[t].tail = any_i32(-most, most);
    }
    allan_t allan = {.m = m, .tau = tau, .count = count, .octaves = octaves};
    const uint32_t reach = 2U * m[count - 1U];
    slide(&allan, samples + reach, samples + reach);
}

void prove(void)
{
    uint32_t m[TAUS];
    for (size_t i = 0U; i < sizeof samples / sizeof samples[0]; i++) {
        samples[i] = (sample_t)any_i32(INT16_MIN, INT16_MAX);
    }
    for (uint8_t count = 1U; count <= TAUS; count++) {
        m[count - 1U] = UINT32_C(1) << (count - 1U);
        if (m[count - 1U] <= LARGEST) {
            step(m, count, true);
            step(m, count, false);
        }
    }
    static const uint32_t thirds[] = {1U, 3U, 10U, 30U, 100U, 300U, LARGEST};
    for (uint8_t count = 1U; count <= 7U; count++) {
        step(thirds, count, false);
    }
    PROVED();
}
