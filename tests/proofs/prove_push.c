/* Statement: davar_push_q15 and davar_gap, of any samples, read and write inside the instance, its memory and the samples,
 * and nothing overflows that is signed. Every sample is any int16. Gaps: any one place among the pushes, any
 * number missing; then two more, each GAP_APART pushes on (gaps_max 2, so the window restarts). Bound: PUSHES pushes from the
 * start, which turns the ring over; window 8, cluster sizes 1, 2 (octaves) or 1, 3; centred and trailing, policy fixed. */
#include "davar/davar.h"

#include "proof.h"

#ifndef PUSHES
#define PUSHES 14U
#endif
#ifndef GAPS /* places of the first gap: in front of push 0 .. GAPS; PUSHES: none */
#define GAPS PUSHES
#endif
#define GAP_APART 3U

static uint64_t memory[DAVAR_MEMORY_Q15(8U, 3U, 2U, 2U) / 8U]; /* not a word more */
static const uint32_t octaves[2] = {1U, 2U};
static const uint32_t others[2] = {1U, 3U};

static void push(davar_t *davar)
{
    const int16_t sample = (int16_t)any_i32(INT16_MIN, INT16_MAX);
    const size_t consumed = davar_push_q15(davar, &sample, 1U);
    PROVE(consumed == 1U);
}

static void stream(davar_mode_t mode, const uint32_t *taus, uint32_t gap)
{
    static davar_t davar;
    davar_config_t config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 0.01;
    config.mode = mode;
    config.policy = DAVAR_POLICY_FIXED;
    config.window_max = 8U;
    config.window_min = 8U;
    config.segment = 0U;
    config.gaps_max = 2U;
    config.taus = taus;
    config.tau_count = 2U;
    if (davar_init_q15(&davar, &config, memory, sizeof memory) != DAVAR_OK) {
        return; /* never, as tests/api shows; Eva knows no double by its bits */
    }
    for (uint32_t i = 0U; i < PUSHES; i++) {
        if ((i == gap) || (i == gap + GAP_APART) || (i == gap + 2U * GAP_APART)) {
            davar_gap(&davar, any_u32(1U, UINT32_MAX));
        }
        push(&davar);
    }
    PROVED();
}

void prove(void)
{
    for (uint32_t gap = 0U; gap <= GAPS; gap++) {
        stream(DAVAR_MODE_CENTRED, octaves, gap);
        stream(DAVAR_MODE_TRAILING, octaves, gap);
        stream(DAVAR_MODE_CENTRED, others, gap);
        stream(DAVAR_MODE_TRAILING, others, gap);
    }
}
