/* davar tests - the cost of a sample and of a result on this target, in instructions (exact under
 * -icount), and in bytes of stack and RAM. One line "name value" per figure;
 * tools/support/targets.py reads them. */
#include "davar/davar.h"
#include "davar/fit.h"
#include "davar/glr.h"
#include "davar_law_id.h"

#include "measuring.h"

#define STACK_WORDS 1024U
#include "stack_paint.h"

#define TAUS 8U
#define WINDOW 600U
#define STRIDE 60U
#define FIR_TAPS 64U
#define BATCH 50U

static const uint32_t octaves[TAUS] = {1U, 2U, 4U, 8U, 16U, 32U, 64U, 128U};
static int16_t samples[STRIDE * 16U];
static uint64_t memory[1060]; /* a grid of 10, with pointers of 64 bits */
static uint32_t glr_block = 10U;
static davar_plan_t plan;
static davar_config_t config;
static davar_t davar;
static davar_result_t result;
static volatile int32_t sink;

static void make_samples(void)
{
    for (size_t i = 0U; i < (sizeof samples / sizeof samples[0]); i++) {
        samples[i] = (int16_t)noise_of(4U); /* sigma about 120 counts */
    }
}

static const davar_engine_t *engine = &davar_engine_grid_q15;

static void start(davar_law_id_t id, uint32_t stride)
{
    config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 0.01;
    config.law = davar_law_of_id(id, false);
    config.window.longest = WINDOW;
    config.window.shortest =
        (id == DAVAR_LAW_ID_FIXED) ? WINDOW : ((id == DAVAR_LAW_ID_GLR) ? 20U : 360U);
    config.moments.segment = (id == DAVAR_LAW_ID_OR) ? 120U : 0U;
    config.glr.block = glr_block;
    config.stride = stride;
    config.engine = engine;
    config.taus = octaves;
    config.tau_count = TAUS;
    const size_t bytes = davar_memory_size_q15(&config);
    if (davar_init_q15(&davar, &config, memory, sizeof memory) != DAVAR_OK) {
        board_figure("refused_needs_bytes", (uint32_t)bytes);
        board_exit(1);
    }
    davar_plan_init_white(&plan, config.taus, config.tau_count);
    const char *const slides = (id == DAVAR_LAW_ID_FIXED) ? "ram_bytes" : "ram_or_bytes";
    const char *const ram = (stride == 1U) ? slides : "ram_grid_bytes";
    board_figure((id == DAVAR_LAW_ID_GLR) ? "ram_glr_bytes" : ram,
                 (uint32_t)(bytes + sizeof davar)); /* of glr, the last one counts: stride 60 */
}

static int16_t sample_at(uint32_t i)
{
    return samples[i % (sizeof samples / sizeof samples[0])];
}

static void feed(uint32_t count)
{
    for (uint32_t i = 0U; i < count; i++) {
        const int16_t sample = sample_at(i);
        davar_push_q15(&davar, &sample, 1U);
    }
}

/* A result with all features. */
static void take(void)
{
    if (davar_take(&davar, &result)) {
        davar_fit(&plan, config.rate_hz, &result);
        sink++;
    }
}

/* Instructions of pushing one sample, including call and loop: the mean over three turns of the
 * ring, and the worst. */
static void measure_single(const char *mean_name, const char *worst_name)
{
    uint32_t total = 0U;
    uint32_t worst = 0U;
    const uint32_t count = 3U * 600U;
    for (uint32_t i = 0U; i < count; i += BATCH) {
        const uint32_t mark = board_mark();
        for (uint32_t k = 0U; k < BATCH; k++) {
            davar_push_q15(&davar, &samples[(i + k) % 900U], 1U);
        }
        total += board_instructions_since(mark);
    }
    for (uint32_t i = 0U; i < count; i++) {
        const uint32_t mark = board_mark();
        davar_push_q15(&davar, &samples[i % 900U], 1U);
        const uint32_t spent = board_instructions_since(mark);
        worst = larger(worst, spent);
    }
    board_figure(mean_name, (100U * total) / count);
    if (worst_name != NULL) {
        board_figure(worst_name, worst);
    }
}

static void measure_every_sample(void)
{
    start(DAVAR_LAW_ID_FIXED, 1U);
    feed(2U * WINDOW);
    measure_single("every_sample_push_x100", "every_sample_worst_push");
}

/* Blocks of one stride, as from a DMA, with every result taken. */
static void measure_grid(void)
{
    start(DAVAR_LAW_ID_OR, STRIDE);
    feed(2U * WINDOW);
    take();
    uint32_t push = 0U;
    uint32_t adev = 0U;
    uint32_t arw = 0U;
    uint32_t all = 0U;
    const uint32_t rounds = 64U;
    for (uint32_t i = 0U; i < rounds; i++) {
        uint32_t mark = board_mark();
        const int16_t *block = &samples[STRIDE * (i % 16U)];
        davar_push_q15(&davar, block, STRIDE);
        push += board_instructions_since(mark);
        mark = board_mark();
        sink += davar_take(&davar, &result) ? 1 : 0;
        adev += board_instructions_since(mark);
        mark = board_mark();
        (void)davar_fit_white(&plan, config.rate_hz, &result);
        sink += (result.noise == DAVAR_NOISE_WHITE) ? 1 : 0;
        arw += board_instructions_since(mark);
        mark = board_mark();
        davar_fit(&plan, config.rate_hz, &result);
        all += board_instructions_since(mark);
    }
    board_figure("grid_push_x100", (100U * push) / (rounds * STRIDE));
    board_figure("grid_take", (adev + all) / rounds);
    board_figure("grid_take_adev", adev / rounds);
    board_figure("grid_arw_x100", (100U * (push + adev + arw)) / (rounds * STRIDE));
    measure_single("grid_single_push_x100", NULL);
}

/* Blocks as from a DMA, with no result taken: instructions. */
static uint32_t push_blocks(uint32_t block, uint32_t rounds)
{
    uint32_t total = 0U;
    for (uint32_t i = 0U; i < rounds; i++) {
        const int16_t *from = &samples[block * (i % 14U)];
        const uint32_t mark = board_mark();
        davar_push_q15(&davar, from, block);
        total += board_instructions_since(mark);
    }
    return total;
}

/* A fixed window in blocks of 64, newest result only; the additional cost of law glr in blocks,
 * and the whole cost of a result at every sample. */
static void measure_blocks(void)
{
    start(DAVAR_LAW_ID_FIXED, 64U);
    feed(2U * WINDOW);
    board_figure("block64_x100", (100U * push_blocks(64U, 64U)) / (64U * 64U));
    start(DAVAR_LAW_ID_FIXED, STRIDE);
    feed(2U * WINDOW);
    const uint32_t fixed = push_blocks(STRIDE, 64U);
    for (glr_block = 10U; glr_block <= 25U; glr_block += 15U) {
        start(DAVAR_LAW_ID_GLR, STRIDE);
        feed(2U * WINDOW);
        const uint32_t spent = push_blocks(STRIDE, 64U) - fixed;
        board_figure((glr_block == 10U) ? "glr_x100" : "glr_of_25_x100",
                     (100U * spent) / (64U * STRIDE));
    }
    glr_block = 10U;
    start(DAVAR_LAW_ID_GLR, 1U);
    feed(2U * WINDOW);
    measure_single("glr_every_sample_x100", NULL);
}

/* A result every few samples, fixed window: the engine for it, pushed sample by sample and in
 * blocks of a stride. */
static void measure_engine(const davar_engine_t *by, uint32_t stride, const char *const names[4])
{
    engine = by;
    start(DAVAR_LAW_ID_FIXED, stride);
    feed(2U * WINDOW);
    measure_single(names[0], names[1]);
    board_figure(names[2], (100U * push_blocks(stride, 60U)) / (60U * stride));
    board_figure(names[3], (uint32_t)(davar_memory_size_q15(&config) + sizeof davar));
    engine = &davar_engine_grid_q15;
}

static void measure_engines(void)
{
    static const char *const auto_of_2[] = {"auto2_x100", "auto2_worst", "auto2_blocks_x100",
                                            "auto2_ram"};
    static const char *const auto_of_10[] = {"auto10_x100", "auto10_worst", "auto10_blocks_x100",
                                             "auto10_ram"};
    static const char *const auto_of_60[] = {"auto60_x100", "auto60_worst", "auto60_blocks_x100",
                                             "auto60_ram"};
    static const char *const grid_of_10[] = {"grid10_x100", "grid10_worst", "grid10_blocks_x100",
                                             "grid10_ram"};
    static const char *const grid_of_60[] = {"grid60_x100", "grid60_worst", "grid60_blocks_x100",
                                             "grid60_ram"};
    measure_engine(NULL, 2U, auto_of_2);
    measure_engine(NULL, 10U, auto_of_10);
    measure_engine(NULL, STRIDE, auto_of_60);
    measure_engine(&davar_engine_grid_q15, 10U, grid_of_10);
    measure_engine(&davar_engine_grid_q15, STRIDE, grid_of_60);
}

/* --- the default: adaptive window, steps of the noise, gaps --- */

typedef struct {
    uint32_t pushes;
    uint32_t total;
    uint32_t worst;
    uint32_t worst_take;
} rough_t;

/* Noise that is at times five times as large, with occasional gaps, also near a step. */
static void push_roughly(rough_t *rough, uint32_t i)
{
    const int16_t sample = (int16_t)((((i / 700U) % 2U) == 0U) ? sample_at(i) : (5 * sample_at(i)));
    if (((i % 977U) == 400U) || ((i % 2100U) == 705U)) {
        davar_gap(&davar, 1U);
    }
    const uint32_t mark = board_mark();
    davar_push_q15(&davar, &sample, 1U);
    const uint32_t spent = board_instructions_since(mark);
    rough->total += spent;
    rough->pushes++;
    rough->worst = larger(rough->worst, spent);
}

static rough_t measure_roughly(davar_law_id_t id, uint32_t stride, uint32_t take_every)
{
    rough_t rough = {0U, 0U, 0U, 0U};
    start(id, stride);
    for (uint32_t i = 0U; i < 5600U; i++) {
        push_roughly(&rough, i);
        if ((i % take_every) == 0U) {
            const uint32_t mark = board_mark();
            take();
            const uint32_t spent = board_instructions_since(mark);
            rough.worst_take = larger(rough.worst_take, spent);
        }
    }
    return rough;
}

static void measure_default(void)
{
    const rough_t each = measure_roughly(DAVAR_LAW_ID_OR, 1U, 50U);
    board_figure("default_push_x100", (100U * (each.total / 100U)) / (each.pushes / 100U));
    board_figure("default_worst_push", each.worst);
    const rough_t grid = measure_roughly(DAVAR_LAW_ID_OR, STRIDE, 1U);
    const rough_t glr = measure_roughly(DAVAR_LAW_ID_GLR, STRIDE, 1U);
    board_figure("glr_worst_push", glr.worst);
    board_figure("grid_worst_push", grid.worst);
    board_figure("worst_take", larger(each.worst_take, grid.worst_take));
}

/* The paper's law at its own settings in plain white noise, every result taken. */
static void measure_white(void)
{
    start(DAVAR_LAW_ID_OR, 1U);
    uint32_t push = 0U;
    uint32_t adev = 0U;
    const uint32_t count = 6000U;
    noise_state = 7U;
    for (uint32_t i = 0U; i < count; i++) {
        const int16_t sample = (int16_t)(noise_of(12U) / 2); /* the kurtosis is 2.9 */
        uint32_t mark = board_mark();
        davar_push_q15(&davar, &sample, 1U);
        push += board_instructions_since(mark);
        mark = board_mark();
        sink += davar_take(&davar, &result) ? 1 : 0;
        adev += board_instructions_since(mark);
    }
    board_figure("adaptive_white", push / count);
    board_figure("take_white_mean", adev / count);
}

/* For comparison: a common filter, plain and with four taps per iteration. Which is faster depends
 * on the core. */
static __attribute__((noinline)) int16_t fir_plain(const int16_t *x, const int16_t *h)
{
    int32_t sum = 0;
    for (unsigned k = 0U; k < FIR_TAPS; k++) {
        sum += (int32_t)x[k] * h[k];
    }
    return (int16_t)(sum >> 15);
}

static __attribute__((noinline)) int16_t fir_by_four(const int16_t *x, const int16_t *h)
{
    int32_t sum = 0;
    for (unsigned k = 0U; k < FIR_TAPS; k += 4U) {
        sum += (int32_t)x[k] * h[k];
        sum += (int32_t)x[k + 1U] * h[k + 1U];
        sum += (int32_t)x[k + 2U] * h[k + 2U];
        sum += (int32_t)x[k + 3U] * h[k + 3U];
    }
    return (int16_t)(sum >> 15);
}

static void measure_fir(void)
{
    static int16_t taps[FIR_TAPS];
    for (unsigned k = 0U; k < FIR_TAPS; k++) {
        taps[k] = (int16_t)(100U + k);
    }
    uint32_t mark = board_mark();
    for (uint32_t i = 0U; i < 100U; i++) {
        sink += fir_plain(&samples[i], taps);
    }
    const uint32_t plain = board_instructions_since(mark);
    mark = board_mark();
    for (uint32_t i = 0U; i < 100U; i++) {
        sink += fir_by_four(&samples[i], taps);
    }
    const uint32_t by_four = board_instructions_since(mark);
    board_figure("fir64_q15_x100", (plain < by_four) ? plain : by_four);
}

/* --- stack --- */

/* The deepest of many pushes (gaps, restarts and window changes among them), and of many takes. */
static void measure_stack(void)
{
    uint32_t push = 0U;
    uint32_t deepest = 0U;
    start(DAVAR_LAW_ID_OR, 1U);
    for (uint32_t i = 0U; i < 2000U; i++) {
        const int16_t sample =
            (int16_t)((((i / 300U) % 2U) == 0U) ? sample_at(i) : (20 * sample_at(i)));
        const uintptr_t from = stack_pointer();
        paint(from);
        if (((i % 377U) == 100U) || ((i >= 1500U) && (i < 1510U))) {
            davar_gap(&davar, 1U);
        }
        davar_push_q15(&davar, &sample, 1U);
        const uint32_t of_push = used(from);
        push = (of_push > push) ? of_push : push;
        if ((i % 20U) == 0U) {
            paint(from);
            take();
            const uint32_t of_take = used(from);
            deepest = (of_take > deepest) ? of_take : deepest;
        }
    }
    board_figure("stack_push_bytes", push);
    board_figure("stack_take_bytes", deepest);
}

int main(void)
{
    make_samples();
    measure_every_sample();
    measure_grid();
    measure_blocks();
    measure_engines();
    measure_default();
    measure_white();
    measure_fir();
    measure_stack();
    board_figure("davar_t_bytes", (uint32_t)sizeof davar);
    board_figure("plan_bytes", (uint32_t)sizeof plan);
    board_figure("result_bytes", (uint32_t)sizeof result);
    return 0;
}
