/* Statement: davar_push_until_result_q15 (WIDE 1: davar_push_until_result_q31) and davar_gap, for
 * any samples, read and write inside the instance, its memory and the samples, and nothing signed
 * overflows. Every sample has any value of its type. Gaps: any one place among the pushes, any
 * number missing; then two more, each GAP_APART pushes later (gaps_max 2, so the window restarts).
 * Bound: PUSHES pushes from the start, which turn the ring of nine samples over twice; window 8,
 * cluster sizes 1, 2 (octaves) or 1, 3; law fixed, or with ADAPTIVE 1 the window follows kurtosis
 * and contribution; a result every STRIDE samples, by engine auto or with GRID 1 on a grid. */
#include "davar/davar.h"

#include "proof.h"

#ifndef PUSHES
#define PUSHES 18U
#endif
#ifndef GAPS /* places of the first gap: before push 0 .. GAPS; PUSHES: no gap */
#define GAPS PUSHES
#endif
#define GAP_APART 3U
#ifndef WIDE
#define WIDE 0
#endif
#ifndef ADAPTIVE
#define ADAPTIVE 0
#endif
#ifndef STRIDE
#define STRIDE 1
#endif
#ifndef GRID
#define GRID 0
#endif

#if WIDE
#define WORDS 2U
#define ENGINE davar_engine_grid_q31
#define INIT davar_init_q31
typedef int32_t sample_t;
#define ANY() any_i32(INT32_MIN, INT32_MAX)
#define PUSH davar_push_until_result_q31
#else
#define WORDS 1U
#define ENGINE davar_engine_grid_q15
#define INIT davar_init_q15
typedef int16_t sample_t;
#define ANY() any_i32(INT16_MIN, INT16_MAX)
#define PUSH davar_push_until_result_q15
#endif

/* Not one word more: the macros count the bounds of a law that a fixed window has not. */
#define UNUSED ((ADAPTIVE != 0) ? 0U : DAVAR_SONG_BYTES)
#define LONGEST 8U
#define SHORTEST (ADAPTIVE ? 6U : LONGEST)
#define SEGMENT (ADAPTIVE ? 3U : 0U)
#if GRID
#define NEED DAVAR_MEMORY_ON_GRID(WORDS, LONGEST, SHORTEST, SEGMENT, STRIDE, 3U, 2U, 2U)
#else
#define NEED DAVAR_MEMORY_SLIDING(WORDS, LONGEST, SEGMENT, STRIDE, 3U, 2U, 2U)
#endif
static uint64_t memory[(NEED - UNUSED) / 8U];
static const uint32_t octaves[2] = {1U, 2U};
static const uint32_t others[2] = {1U, 3U};

static void push(davar_t *davar)
{
    const sample_t sample = (sample_t)ANY();
    const size_t consumed = PUSH(davar, &sample, 1U);
    PROVE(consumed == 1U);
}

static void stream(const uint32_t *taus, uint32_t gap)
{
    static davar_t davar;
    davar_config_t config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 0.01;
    config.law = ADAPTIVE ? &davar_law_or : NULL;
    config.window.longest = LONGEST;
    config.window.shortest = SHORTEST;
    config.moments.segment = SEGMENT;
    config.stride = STRIDE;
    config.engine = GRID ? &ENGINE : NULL;
    config.window.gaps_max = 2U;
    config.taus = taus;
    config.tau_count = 2U;
    if (INIT(&davar, &config, memory, sizeof memory) != DAVAR_OK) {
        return; /* never, as tests/api shows; Eva cannot represent a double by its bits */
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
        stream(octaves, gap);
        stream(others, gap);
    }
}
