/* davar tests - the cost of the detector of changes on this target, in instructions (exact under
 * -icount): its mean per sample, including the sums of the block, and its worst block. One line
 * "name value" per figure. */
#include "laws/glr.h"

#include "board.h"

#define BLOCKS 4096U
#define K_MAX 25U

static davar_glr_t state;
static davar_glr_config_t config;
static davar_glr_event_t event;
static davar_glr_place_t begin;
static uint32_t random_bits = 1U;

typedef enum { DETECTOR, WINDOW } what_t;

/* Sum of four uniform variates: nearly Gaussian, sigma about 148 counts before the gain. */
static int16_t noise(uint32_t gain)
{
    int32_t sum = 0;
    for (uint32_t k = 0U; k < 4U; k++) {
        random_bits = (random_bits * 1664525U) + 1013904223U;
        sum += (int32_t)(random_bits >> 24U) - 128;
    }
    return (int16_t)((sum * (int32_t)gain) / 8);
}

static uint32_t block_cost(what_t what, uint32_t gain)
{
    int16_t sample[K_MAX];
    for (uint32_t i = 0U; i < config.block; i++) {
        sample[i] = noise(gain);
    }
    const uint32_t mark = board_mark();
    int32_t sum = 0;
    uint64_t squares = 0U;
    for (uint32_t i = 0U; i < config.block; i++) {
        sum += sample[i];
        squares += davar_square_i16(sample[i]);
    }
    davar_glr_push_q15(&state, &config, sum, squares, &event);
    if (what == WINDOW) {
        davar_glr_begin(&state, &config, &begin);
    }
    return board_instructions_since(mark);
}

static void start(uint32_t block)
{
    const davar_glr_wish_t wish = {100.0, 0.01, 300.0, 6000U, block, 2U};
    davar_glr_start(&config, &wish);
    davar_glr_reset(&state);
    random_bits = 1U;
}

static void measure(const char *mean, const char *worst, uint32_t block, what_t what)
{
    uint32_t total = 0U;
    uint32_t most = 0U;
    start(block);
    for (uint32_t n = 0U; n < BLOCKS; n++) {
        total += block_cost(what, 1U);
    }
    board_figure(mean, (total + (BLOCKS * block / 2U)) / (BLOCKS * block));
    for (uint32_t n = 0U; n < BLOCKS; n++) { /* steps, the larger the rarer; bursts */
        const uint32_t gain = ((n % 512U) >= 509U) ? 12U : ((((n / 256U) % 2U) != 0U) ? 3U : 1U);
        const uint32_t cost = block_cost(what, gain);
        most = (cost > most) ? cost : most;
    }
    board_figure(worst, most);
}

int main(void)
{
    measure("detector_10", "detector_10_worst", 10U, DETECTOR);
    measure("detector_25", "detector_25_worst", 25U, DETECTOR);
    measure("window_10", "window_10_worst", 10U, WINDOW);
    measure("window_25", "window_25_worst", 25U, WINDOW);
    board_figure("state_bytes", (uint32_t)sizeof state);
    board_exit(0);
}
