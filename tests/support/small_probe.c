/* davar tests - what a small setup of tools/davar-plan returns (SMALL), or the complete library for
 * the same windows: a checksum for each stream, and how often each kind of noise came. WINDOW,
 * STRIDE: of the setup; RATE, UNIT: its rate and the size of a count. The complete library fits with
 * `own_plan`. ON_BOARD: a board prints. */
#ifdef SMALL
#include "davar_setup.h"
#else
#include "davar/davar.h"
#include "davar/fit.h"
#endif

#include "small_streams.h"

void board_figure(const char *name, uint32_t value); /* of the board, or this one */

#ifndef ON_BOARD
#include <stdio.h>

void board_figure(const char *name, uint32_t value)
{
    (void)printf("%s %lu\n", name, (unsigned long)value);
}
#endif

#define SAMPLES (60U * WINDOW)
#define BLOCK_MOST 40U

/* --- the two sides ------------------------------------------------------------------------------ */

#ifdef SMALL
static void start(void)
{
    if (davar_setup_start() != DAVAR_OK) {
        board_figure("refused", 1U);
    }
    davar_setup_restart();
}

#define PUSH davar_setup_push
#define GAP davar_setup_gap

static const davar_result_t *take(void)
{
    return davar_setup_take(0U);
}

static davar_health_t health(void)
{
    return davar_setup_health(0U);
}
#else
extern davar_plan_t own_plan;
static const uint32_t taus[] = {TAUS};
static const davar_config_t config = {.rate_hz = RATE,
                                      .unit_per_count = UNIT,
                                      .stride = STRIDE,
                                      .window = {.longest = WINDOW, .shortest = WINDOW},
                                      .taus = taus,
                                      .tau_count = sizeof taus / sizeof taus[0]};
static uint64_t memory[1024];
static davar_t davar;
static davar_result_t result;

static void start(void)
{
    if (davar_init_q15(&davar, &config, memory, sizeof memory) != DAVAR_OK) {
        board_figure("refused", 1U);
    }
}

static void PUSH(const int16_t *samples, size_t count)
{
    davar_push_q15(&davar, samples, count);
}

static void GAP(uint32_t missing)
{
    davar_gap(&davar, missing);
}

static const davar_result_t *take(void)
{
    if (!davar_take(&davar, &result)) {
        return NULL;
    }
    (void)davar_fit_white(&own_plan, RATE, &result);
    return &result;
}

static davar_health_t health(void)
{
    return davar_health(&davar);
}
#endif

/* --- what comes out ----------------------------------------------------------------------------- */

static uint32_t checksum;
static uint32_t seen[DAVAR_NOISE_FILTERED + 1];
static uint32_t unstable;

static void add(const void *data, size_t bytes)
{
    const uint8_t *const byte = data;
    for (size_t i = 0U; i < bytes; i++) {
        checksum = (checksum ^ byte[i]) * 16777619U;
    }
}

#define ADD(field) add(&(field), sizeof(field))

static void add_flag(bool flag)
{
    const uint8_t byte = flag ? 1U : 0U;
    ADD(byte);
}

static void add_result(const davar_result_t *found)
{
    const davar_coefficient_t *const walk = &found->coefficient[DAVAR_ANGLE_RANDOM_WALK];
    const uint32_t noise_found = (uint32_t)found->noise;
    ADD(found->epoch);
    ADD(found->window_samples);
    ADD(found->gaps_in_window);
    ADD(found->equal_samples);
    ADD(noise_found);
    add_flag(found->unstable);
    for (uint8_t t = 0U; t < found->tau_count; t++) {
        ADD(found->tau[t].m);
        ADD(found->tau[t].differences);
        ADD(found->tau[t].adev);
    }
    add_flag(walk->present);
    ADD(walk->value);
    ADD(walk->low);
    ADD(walk->high);
    seen[found->noise]++;
    unstable += found->unstable ? 1U : 0U;
}

static void add_health(void)
{
    const davar_health_t now = health();
    ADD(now.gaps);
    ADD(now.missing);
    ADD(now.saturated);
    ADD(now.restarts);
    ADD(now.missed);
}

/* Blocks of any size, some results not taken, and in every second stream gaps. */
static void run(int stream)
{
    int16_t samples[BLOCK_MOST];
    start();
    for (uint32_t i = 0U; i < SAMPLES;) {
        const uint32_t count = 1U + random_below(BLOCK_MOST);
        for (uint32_t k = 0U; k < count; k++) {
            samples[k] = clipped(sample_of(stream, i + k));
        }
        i += count;
        PUSH(samples, count);
        if ((stream % 2 == 1) && (random_below(4U * WINDOW) < count)) {
            GAP(1U + random_below(3U));
        }
        const davar_result_t *const found = (random_below(4U) > 0U) ? take() : NULL;
        if (found != NULL) {
            add_result(found);
        }
    }
    add_health();
}

int main(void)
{
    static const char *const names[] = {"unknown",  "white",  "mixed",
                                        "constant", "coarse", "filtered"};
    for (int stream = 0; stream < STREAMS; stream++) {
        stream_state = 1U + (uint32_t)stream;
        checksum = 2166136261U;
        run(stream);
        board_figure("stream", (uint32_t)stream);
        board_figure("checksum", checksum);
    }
    for (int k = 0; k <= (int)DAVAR_NOISE_FILTERED; k++) {
        board_figure(names[k], seen[k]);
    }
    board_figure("unstable", unstable);
    return 0;
}
