/* davar tests - the cost of the cascade on this target, in instructions (exact under -icount) and
 * bytes. One line "name value" per figure; tools/support/targets.py reads them. */
#include "measuring.h"

#include "davar/cascade.h"

#include <string.h>

#define TAUS 18U
#define RESULT_TAUS 8U
#define BATCH 64U
#define COUNT 65536U /* samples; a hop of every stage but the last is among them */

static const davar_cascade_config_t config = {.rate_hz = 100.0,
                                              .unit_per_count = 0.01,
                                              .full_scale = 300.0,
                                              .shortest = 256U,
                                              .tau_count = TAUS,
                                              .clusters = 32U};
static uint64_t memory[DAVAR_CASCADE_MEMORY(Q31, TAUS) / 8U];
static davar_cascade_t cascade;
static davar_result_t result;
static volatile int32_t sink;

static int16_t narrow[BATCH];
static int32_t wide[BATCH];
static int32_t large[BATCH]; /* differences of more than 32 bits */
static float rates[BATCH];

static void make_samples(void)
{
    for (uint32_t k = 0U; k < BATCH; k++) {
        narrow[k] = (int16_t)(20 + noise_of(4U)); /* sigma about 120 counts */
        wide[k] = narrow[k];
        large[k] = narrow[k] * 1048576;
        rates[k] = (float)narrow[k];
    }
}

/* Returns the instructions of a loop over a batch with an empty body. */
static uint32_t instructions_of_loop(void)
{
    const uint32_t mark = board_mark();
    for (uint32_t k = 0U; k < BATCH; k++) {
        __asm__ volatile("" : : "r"(&narrow[k]) : "memory");
    }
    return board_instructions_since(mark);
}

/* Instructions of a push of one sample with its call: the mean over COUNT samples, without those of
 * the loop around it, and the worst. */
#define MEASURE(type, samples)                                                                     \
    do {                                                                                           \
        uint32_t total = 0U;                                                                       \
        uint32_t worst = 0U;                                                                       \
        const uint32_t loop = instructions_of_loop();                                              \
        const uint32_t nothing = instructions_of_nothing();                                        \
        if (davar_cascade_init_##type(&cascade, &config, memory, sizeof memory) !=                 \
            DAVAR_CASCADE_OK) {                                                                    \
            break;                                                                                 \
        }                                                                                          \
        for (uint32_t i = 0U; i < COUNT; i += BATCH) {                                             \
            make_samples();                                                                        \
            const uint32_t mark = board_mark();                                                    \
            for (uint32_t k = 0U; k < BATCH; k++) {                                                \
                davar_cascade_push_##type(&cascade, &(samples)[k], 1U);                            \
            }                                                                                      \
            total += board_instructions_since(mark) - loop;                                        \
        }                                                                                          \
        for (uint32_t i = 0U; i < COUNT; i++) {                                                    \
            const uint32_t mark = board_mark();                                                    \
            davar_cascade_push_##type(&cascade, &(samples)[i % BATCH], 1U);                        \
            const uint32_t spent = board_instructions_since(mark) - nothing;                       \
            worst = larger(worst, spent);                                                          \
        }                                                                                          \
        board_figure("cascade_" #type "_" #samples "_push_x100",                                   \
                     (uint32_t)((100U * (uint64_t)total) / COUNT));                                \
        board_figure("cascade_" #type "_" #samples "_worst_push", worst);                          \
    } while (false)

/* The same in blocks of 64. */
static void measure_blocks(void)
{
    uint32_t total = 0U;
    for (uint32_t i = 0U; i < (COUNT / BATCH); i++) {
        make_samples();
        const uint32_t mark = board_mark();
        davar_cascade_push_q15(&cascade, narrow, BATCH);
        total += board_instructions_since(mark);
    }
    board_figure("cascade_blocks_x100", (uint32_t)((100U * (uint64_t)total) / COUNT));
}

/* As many sizes as a result has here; the samples fill all of them. */
static const davar_cascade_config_t few = {.rate_hz = 100.0,
                                           .unit_per_count = 0.01,
                                           .shortest = 256U,
                                           .tau_count = RESULT_TAUS,
                                           .clusters = 32U};

/* A checksum of every number of the result: the same on all cores. */
static uint32_t checksum(void)
{
    uint32_t sum = 0U;
    for (uint32_t t = 0U; t < RESULT_TAUS; t++) {
        uint32_t word[2];
        _Static_assert(sizeof word == sizeof result.tau[t].adev, "two words a number");
        memcpy(word, &result.tau[t].adev, sizeof word);
        for (uint32_t i = 0U; (i < 2U) && (result.tau[t].adev > 0.0); i++) {
            sum = (sum * 31U) + word[i];
        }
    }
    return sum;
}

static void measure_result(void)
{
    if (davar_cascade_init_q15(&cascade, &few, memory, sizeof memory) != DAVAR_CASCADE_OK) {
        return;
    }
    for (uint32_t i = 0U; i < COUNT; i += BATCH) {
        make_samples();
        davar_cascade_push_q15(&cascade, narrow, BATCH);
    }
    uint32_t mark = board_mark();
    sink += davar_cascade_append(&cascade, &result) ? 1 : 0;
    board_figure("cascade_append", board_instructions_since(mark));
    board_figure("cascade_checksum", checksum());
    mark = board_mark();
    davar_cascade_gap(&cascade, 1U);
    board_figure("cascade_gap", board_instructions_since(mark));
}

int main(void)
{
    MEASURE(q15, narrow);
    measure_blocks();
    measure_result();
    MEASURE(q31, wide);
    MEASURE(q31, large);
    MEASURE(f32, rates);
    board_figure("cascade_memory_bytes", (uint32_t)DAVAR_CASCADE_MEMORY(Q15, TAUS));
    board_figure("cascade_t_bytes", (uint32_t)sizeof cascade);
    return 0;
}
