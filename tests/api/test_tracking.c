/* davar tests - policy glr from outside. Every Allan deviation is that of the samples in the
 * result's window. A change is reported and the window begins after it. A shock and a gap are in no
 * sum. */
#include "davar/davar.h"
#include "davar/state.h"

#include "random.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define SAMPLES 9000U
#define STEP 5000U
#define TAUS 5U
#define NO_TIME UINT32_MAX
#define HALF 300U /* of a centred window */

typedef enum { Q15, Q31, F32 } type_t;

static const uint32_t taus[TAUS] = {1U, 2U, 4U, 8U, 16U};
static davar_config_t config;
static uint64_t memory[2][4096];
static davar_t davar;
static davar_result_t result;
static int16_t stream[SAMPLES];

static double uniform(random_t *random)
{
    return ((double)(random_next(random) >> 11U) / 9007199254740992.0) - 0.5;
}

/* Sigma 20 counts, from `step` onward `ratio` times as much. */
static void make_stream(uint64_t seed, uint32_t step, double ratio)
{
    random_t random = random_seeded(seed);
    for (uint32_t i = 0U; i < SAMPLES; i++) {
        double sum = 0.0;
        for (unsigned k = 0U; k < 12U; k++) {
            sum += uniform(&random);
        }
        stream[i] = (int16_t)lround(sum * ((i < step) ? 20.0 : (20.0 * ratio)));
    }
}

void setUp(void)
{
    config = davar_default_config;
    config.window.mode = DAVAR_MODE_CENTRED;
    config.rate_hz = 100.0;
    config.unit_per_count = 0.25;
    config.full_scale = 4096.0;
    config.window.mode = DAVAR_MODE_TRAILING;
    config.law = &davar_law_glr_q15;
    config.window.longest = 1200U;
    config.window.shortest = 20U;
    config.moments.segment = 0U;
    config.window.shrink = 16U;
    config.window.grow = 1U;
    config.window.gaps_max = 8U;
    config.glr.false_alarms_per_hour = 0.01;
    config.taus = taus;
    config.tau_count = TAUS;
    make_stream(3U, STEP, 1.8);
}

void tearDown(void) {}

static void init(type_t type, unsigned which)
{
    davar_status_t status = DAVAR_OK;
    if (config.law != NULL) {
        config.law = (type == Q15) ? &davar_law_glr_q15 : &davar_law_glr_q31;
    }
    memset(memory[which], 0xA5, sizeof memory[which]);
    if (type == Q15) {
        TEST_ASSERT_LESS_OR_EQUAL_size_t(sizeof memory[which], davar_memory_size_q15(&config));
        status = davar_init_q15(&davar, &config, memory[which], sizeof memory[which]);
    } else if (type == Q31) {
        status = davar_init_q31(&davar, &config, memory[which], sizeof memory[which]);
    } else {
        status = davar_init_f32(&davar, &config, memory[which], sizeof memory[which]);
    }
    TEST_ASSERT_EQUAL(DAVAR_OK, status);
}

/* Up to `count` samples from index n on; returns how many. */
static size_t push(type_t type, uint32_t n, size_t count)
{
    int32_t wide[64];
    float rate[64];
    const size_t most = (count < 64U) ? count : 64U;
    for (size_t i = 0U; i < most; i++) {
        wide[i] = stream[n + i];
        rate[i] = 0.25F * (float)stream[n + i];
    }
    if (type == Q15) {
        return davar_push_until_result_q15(&davar, &stream[n], most);
    }
    return (type == Q31) ? davar_push_until_result_q31(&davar, wide, most)
                         : davar_push_until_result_f32(&davar, rate, most);
}

/* --- the samples that a result speaks of
 * -------------------------------------------------------------------------- */

static bool lost[SAMPLES];   /* in a shock, or left out in front of a gap */
static bool behind[SAMPLES]; /* a boundary lies in front of this sample */

static void lose(uint32_t from, uint32_t to)
{
    for (uint32_t i = from; i < to; i++) {
        lost[i] = true;
    }
    behind[to] = true;
}

/* ADEV of the `length` samples up to `epoch` that were not lost, by its definition; no difference
 * spans a boundary. */
static double adev_of(uint64_t epoch, uint32_t length, uint32_t m, uint32_t *differences)
{
    static int16_t window[SAMPLES];
    static uint32_t runs[SAMPLES]; /* number of boundaries up to each sample */
    uint32_t taken = 0U;
    uint32_t run = 0U;
    for (uint32_t i = (uint32_t)epoch + 1U; (i > 0U) && (taken < length); i--) {
        if (!lost[i - 1U]) {
            window[taken] = stream[i - 1U];
            runs[taken] = run;
            taken++;
        }
        run += behind[i - 1U] ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL_UINT32(length, taken);
    uint64_t sum = 0U;
    *differences = 0U;
    for (uint32_t i = 0U; (i + (2U * m)) <= length; i++) {
        int64_t difference = 0;
        for (uint32_t k = 0U; k < m; k++) {
            difference += window[i + k] - window[i + m + k];
        }
        if (runs[i] == runs[i + (2U * m) - 1U]) {
            sum += (uint64_t)(difference * difference);
            (*differences)++;
        }
    }
    return 0.25 * sqrt((double)sum / (2.0 * m * m * *differences));
}

static bool is_lost(uint32_t i)
{
    return (i < SAMPLES) && lost[i];
}

/* One past the last sample of the window; centred windows end before the newest. Valid right after
 * the sample that completed the result. */
static uint32_t window_end(void)
{
    uint32_t end = (uint32_t)(davar.window.origin + davar.window.received);
    for (uint32_t left = davar.window.lag; (left > 0U) || is_lost(end - 1U); end--) {
        TEST_ASSERT_GREATER_THAN_UINT32(0U, end);
        left -= is_lost(end - 1U) ? 0U : 1U;
    }
    return end;
}

static void check_window(void)
{
    const uint64_t end =
        (config.window.mode == DAVAR_MODE_CENTRED) ? (window_end() - 1U) : result.epoch;
    for (uint32_t t = 0U; t < config.tau_count; t++) {
        uint32_t differences = 0U;
        const double expected = adev_of(end, result.window_samples, taus[t], &differences);
        TEST_ASSERT_EQUAL_UINT32(differences, result.tau[t].differences);
        if (differences > 0U) {
            TEST_ASSERT_DOUBLE_WITHIN(1e-14 * expected, expected, result.tau[t].adev);
        }
    }
}

typedef struct {
    uint32_t results;
    uint32_t alarms;
    uint32_t alarm_at;
    uint32_t cut_at;   /* the change, from the alarm */
    uint32_t shortest; /* window after the alarm */
    uint64_t last;     /* epoch */
} story_t;

/* Pushes samples [from, to), `block` at a time, looks at every result and checks every
 * `every`-th. */
static story_t run(type_t type, uint32_t from, uint32_t to, uint32_t block, uint32_t every)
{
    story_t story = {0U, 0U, NO_TIME, NO_TIME, UINT32_MAX, 0U};
    for (uint32_t n = from; n < to;) {
        n += (uint32_t)push(type, n, ((to - n) < block) ? (to - n) : block);
        if (davar_take(&davar, &result)) {
            TEST_ASSERT_LESS_THAN_UINT64(n, result.epoch);
            TEST_ASSERT_TRUE((story.results == 0U) || (result.epoch > story.last));
            TEST_ASSERT_TRUE(result.dispersion >= 1.0);
            story.last = result.epoch;
            story.results++;
            if (result.alarm) {
                story.alarms++;
                story.alarm_at = (uint32_t)result.epoch;
                story.cut_at = (uint32_t)result.epoch - result.cut_age_samples;
            }
            if ((story.alarms > 0U) && (result.window_samples < story.shortest)) {
                story.shortest = result.window_samples;
            }
            if ((story.results % every) == 0U) {
                check_window();
            }
        }
    }
    return story;
}

static void nothing_lost(void)
{
    memset(lost, 0, sizeof lost);
    memset(behind, 0, sizeof behind);
}

/* --- tests --- */

/* A step of 1.8 is detected within two seconds, and soon the window has no older samples. */
static void check_step(type_t type, uint32_t stride, uint32_t block)
{
    nothing_lost();
    config.stride = stride;
    init(type, 0U);
    const story_t story = run(type, 0U, SAMPLES, block, (stride == 1U) ? 37U : 3U);
    TEST_ASSERT_EQUAL_UINT32(1U, story.alarms);
    TEST_ASSERT_GREATER_THAN_UINT32(STEP, story.alarm_at);
    TEST_ASSERT_LESS_THAN_UINT32(STEP + 200U, story.alarm_at);
    TEST_ASSERT_LESS_THAN_UINT32(450U, story.shortest);
    TEST_ASSERT_GREATER_THAN_UINT32((SAMPLES / stride) - (80U / stride) - 3U, story.results);
    const davar_health_t health = davar_health(&davar);
    TEST_ASSERT_EQUAL_UINT32(1U, health.alarms);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(1U, health.cuts);
    TEST_ASSERT_EQUAL_UINT32(0U, health.missed + health.gaps + health.restarts);
    TEST_ASSERT_UINT32_WITHIN(60U, STEP, story.cut_at);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(1200U, result.window_samples);
}

static void test_a_step_is_reported_and_the_window_begins_after_it(void)
{
    check_step(Q15, 1U, 1U);
    check_step(Q15, 1U, 64U);
    check_step(Q15, 10U, 1U);
    check_step(Q15, 10U, 64U);
    check_step(Q15, 7U, 13U);
    check_step(Q15, 60U, 64U);
    check_step(Q31, 1U, 1U);
    check_step(Q31, 10U, 64U);
    check_step(F32, 1U, 1U);
    check_step(F32, 10U, 64U);
    config.window.shrink = 5000U;
    check_step(Q15, 1U, 1U);
}

/* Samples one by one or in blocks give the same results. */
static void test_block_lengths_do_not_change_results(void)
{
    static davar_result_t single[SAMPLES / 10U + 1U];
    uint32_t count = 0U;
    config.stride = 10U;
    init(Q15, 0U);
    for (uint32_t n = 0U; n < SAMPLES; n++) {
        (void)push(Q15, n, 1U);
        count += davar_take(&davar, &single[count]) ? 1U : 0U;
    }
    init(Q15, 0U);
    uint32_t again = 0U;
    random_t random = random_seeded(9U);
    for (uint32_t n = 0U; n < SAMPLES;) {
        const size_t most = 1U + (size_t)(random_next(&random) % 64U);
        n += (uint32_t)push(Q15, n, ((SAMPLES - n) < most) ? (SAMPLES - n) : most);
        if (davar_take(&davar, &result)) {
            TEST_ASSERT_EQUAL_UINT64(single[again].epoch, result.epoch);
            TEST_ASSERT_EQUAL_UINT32(single[again].window_samples, result.window_samples);
            TEST_ASSERT_EQUAL_MEMORY(single[again].tau, result.tau, sizeof result.tau[0] * TAUS);
            again++;
        }
    }
    TEST_ASSERT_UINT32_WITHIN(1U, count, again);
}

/* A shock of three samples: its block is excluded, there is no alarm, and the epochs continue with
 * the samples. */
static uint32_t latency(void)
{
    return (config.window.mode == DAVAR_MODE_CENTRED) ? HALF : 0U;
}

static void check_shock(type_t type, uint32_t stride)
{
    nothing_lost();
    make_stream(4U, SAMPLES, 1.0);
    stream[4003] = 900;
    stream[4004] = -800;
    stream[4006] = 700;
    lose(4000U, 4010U);
    config.stride = stride;
    init(type, 0U);
    const story_t story = run(type, 0U, 6000U, 64U, (stride == 1U) ? 17U : 1U);
    TEST_ASSERT_EQUAL_UINT32(0U, story.alarms);
    TEST_ASSERT_EQUAL_UINT32(1U, davar_health(&davar).shocks);
    TEST_ASSERT_EQUAL_UINT32(0U, davar_health(&davar).gaps);
    TEST_ASSERT_GREATER_THAN_UINT64(5900U - latency(), result.epoch);
}

static void test_a_shock_is_excluded(void)
{
    check_shock(Q15, 1U);
    check_shock(Q15, 10U);
    check_shock(Q31, 1U);
}

/* A lasting change: an assumed shock is accepted, and all waiting samples catch up. */
static void test_an_assumed_shock_is_accepted_later(void)
{
    nothing_lost();
    make_stream(5U, STEP, 8.0);
    init(Q15, 0U);
    const story_t story = run(Q15, 0U, SAMPLES, 1U, 29U);
    TEST_ASSERT_EQUAL_UINT32(1U, story.alarms);
    TEST_ASSERT_EQUAL_UINT32(0U, davar_health(&davar).shocks);
    TEST_ASSERT_EQUAL_UINT32(0U, davar_health(&davar).missed);
    TEST_ASSERT_GREATER_THAN_UINT64(SAMPLES - 25U, story.last);
}

/* All waiting blocks may follow the change: it is reported before the window has reached it. */
static void test_a_change_reported_before_the_window_reaches_it_is_not_old(void)
{
    static int16_t quiet[SAMPLES];
    uint32_t ahead = 0U;
    make_stream(5U, SAMPLES, 1.0);
    memcpy(quiet, stream, sizeof quiet);
    config.glr.block = 25U;
    for (uint32_t turn = 0U; turn < 300U; turn++) {
        for (uint32_t n = 0U; n < 1400U; n++) {
            const int16_t sample = quiet[(n + (29U * turn)) % SAMPLES];
            stream[n] = (int16_t)((n < (1000U + (turn % 50U))) ? sample : (6 * sample));
        }
        init(Q15, 0U);
        for (uint32_t n = 0U; n < 1400U; n++) {
            (void)push(Q15, n, 1U);
            if (davar_take(&davar, &result)) {
                TEST_ASSERT_LESS_OR_EQUAL_UINT32(n + 1U, result.cut_age_samples);
                ahead += (result.cut_age_samples == 0U) ? 1U : 0U;
            }
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT32(0U, ahead);
}

static void test_without_shock_blocks_a_shock_is_a_change(void)
{
    nothing_lost();
    make_stream(4U, SAMPLES, 1.0);
    stream[4003] = 900;
    config.glr.shock_blocks = 0U;
    init(Q15, 0U);
    (void)run(Q15, 0U, 6000U, 1U, 29U);
    TEST_ASSERT_EQUAL_UINT32(0U, davar_health(&davar).shocks);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(1U, davar_health(&davar).cuts);
}

/* A gap discards unprocessed samples; all others continue. */
static void check_gaps(uint32_t stride)
{
    nothing_lost();
    make_stream(6U, SAMPLES, 1.0);
    config.stride = stride;
    init(Q15, 0U);
    (void)run(Q15, 0U, 3007U, 1U, 50U);
    davar_gap(&davar, 4U);
    lose(3000U, 3007U);
    (void)run(Q15, 3007U, 3010U, 1U, 50U);
    davar_gap(&davar, 1U);
    lose(3007U, 3010U);
    const story_t story = run(Q15, 3010U, 5000U, 1U, (stride == 1U) ? 17U : 1U);
    TEST_ASSERT_GREATER_THAN_UINT64(4960U - latency(), story.last);
    TEST_ASSERT_EQUAL_UINT32(2U, davar_health(&davar).gaps);
}

static void test_gaps(void)
{
    check_gaps(1U);
    check_gaps(10U);
}

/* A gap during a possible shock, and one while a reported shock has not been passed. */
static void test_a_gap_near_a_shock(void)
{
    for (uint32_t at = 3985U; at < 4035U; at++) {
        nothing_lost();
        make_stream(4U, SAMPLES, 1.0);
        stream[4003] = 900;
        config.stride = 1U;
        init(Q15, 0U);
        (void)run(Q15, 0U, at, 1U, 100000U);
        davar_gap(&davar, 1U);
        (void)run(Q15, at, 6000U, 1U, 100000U);
        TEST_ASSERT_GREATER_THAN_UINT64(5980U, result.epoch);
        TEST_ASSERT_LESS_OR_EQUAL_UINT64(5999U, result.epoch);
    }
}

/* A gap completes no result. Samples accepted before it continue with the samples after it, and
 * each result can be taken. */
static void check_every_result_can_be_taken(davar_mode_t mode, uint32_t stride,
                                            uint32_t shock_blocks)
{
    uint32_t results = 0U;
    config.window.mode = mode;
    config.stride = stride;
    config.glr.shock_blocks = shock_blocks;
    config.window.gaps_max = 400U;
    init(Q15, 0U);
    for (uint32_t n = 0U; n < SAMPLES; n++) {
        if ((n > 0U) && ((n % 47U) == 0U)) {
            davar_gap(&davar, 1U);
            TEST_ASSERT_FALSE(davar_take(&davar, &result));
        }
        (void)push(Q15, n, 1U);
        results += davar_take(&davar, &result) ? 1U : 0U;
    }
    TEST_ASSERT_EQUAL_UINT32(0U, davar_health(&davar).missed);
    /* of 47 samples about seven are in the block with the gap */
    TEST_ASSERT_GREATER_THAN_UINT32(SAMPLES / stride * 3U / 5U, results);
}

static void test_every_result_near_gaps_can_be_taken(void)
{
    for (uint32_t shock_blocks = 0U; shock_blocks <= 2U; shock_blocks++) {
        check_every_result_can_be_taken(DAVAR_MODE_TRAILING, 1U, shock_blocks);
        check_every_result_can_be_taken(DAVAR_MODE_TRAILING, 3U, shock_blocks);
        check_every_result_can_be_taken(DAVAR_MODE_TRAILING, 10U, shock_blocks);
        check_every_result_can_be_taken(DAVAR_MODE_CENTRED, 5U, shock_blocks);
        check_every_result_can_be_taken(DAVAR_MODE_CENTRED, 10U, shock_blocks);
    }
}

/* More gaps than the window can store: it restarts, and the detector continues. */
static void test_a_restart(void)
{
    nothing_lost();
    make_stream(6U, SAMPLES, 1.0);
    config.window.gaps_max = 1U;
    init(Q15, 0U);
    (void)run(Q15, 0U, 3000U, 1U, 1000000U);
    davar_gap(&davar, 1U);
    (void)run(Q15, 3000U, 3100U, 1U, 1000000U);
    davar_gap(&davar, 1U);
    const story_t story = run(Q15, 3100U, 6000U, 1U, 1000000U);
    TEST_ASSERT_EQUAL_UINT32(1U, davar_health(&davar).restarts);
    TEST_ASSERT_EQUAL_UINT32(0U, story.alarms);
    TEST_ASSERT_GREATER_THAN_UINT32(300U, result.window_samples);
}

static void test_reset_restarts(void)
{
    nothing_lost();
    init(Q15, 0U);
    const story_t first = run(Q15, 0U, SAMPLES, 1U, 1000000U);
    const davar_result_t expected = result;
    davar_reset(&davar);
    const story_t second = run(Q15, 0U, SAMPLES, 1U, 1000000U);
    TEST_ASSERT_EQUAL_UINT32(first.results, second.results);
    TEST_ASSERT_EQUAL_UINT32(first.alarm_at, second.alarm_at);
    TEST_ASSERT_EQUAL_MEMORY(expected.tau, result.tau, sizeof expected.tau[0] * TAUS);
}

/* --- centred --- */

/* Every result's window is that of its ADEV and contains its epoch. The step separates windows
 * before and after it. */
static void check_centred(type_t type, uint32_t stride, uint32_t block)
{
    nothing_lost();
    config.window.mode = DAVAR_MODE_CENTRED;
    config.stride = stride;
    init(type, 0U);
    uint32_t due = stride - 1U;
    uint32_t alarms = 0U;
    bool flushed = false;
    for (uint32_t n = 0U; !flushed;) {
        if (n < SAMPLES) {
            n += (uint32_t)push(type, n, ((SAMPLES - n) < block) ? (SAMPLES - n) : block);
        } else {
            flushed = !davar_flush(&davar);
        }
        if (!davar_take(&davar, &result)) {
            continue;
        }
        const uint32_t end = window_end();
        const uint32_t begin = end - result.window_samples;
        TEST_ASSERT_EQUAL_UINT64(due, result.epoch);
        TEST_ASSERT_TRUE((begin <= due) && (due < end));
        TEST_ASSERT_TRUE((end <= SAMPLES) && (end <= (due + 1U + HALF)));
        if ((due > (STEP - 150U)) && (due < (STEP - stride - 20U))) {
            TEST_ASSERT_LESS_OR_EQUAL_UINT32(STEP + 20U, end);
        }
        if ((due > (STEP + stride + 20U)) && (due < (STEP + 1200U))) {
            TEST_ASSERT_GREATER_OR_EQUAL_UINT32(STEP - 20U, begin);
        }
        if ((n < SAMPLES) && ((due % 7U) == 2U)) {
            check_window();
        }
        alarms += result.alarm ? 1U : 0U;
        due += stride;
    }
    TEST_ASSERT_EQUAL_UINT32(((SAMPLES / stride) * stride) + stride - 1U, due);
    TEST_ASSERT_EQUAL_UINT32(1U, alarms);
    TEST_ASSERT_EQUAL_UINT32(0U, davar_health(&davar).missed);
}

static void test_a_centred_window_ends_at_the_step(void)
{
    check_centred(Q15, 10U, 1U);
    check_centred(Q15, 10U, 64U);
    check_centred(Q31, 30U, 7U);
    check_centred(F32, 60U, 64U);
    check_centred(Q15, 100U, 64U);
    config.window.shortest = 100U; /* about the step the window uses the available samples */
    check_centred(Q15, 20U, 64U);
}

static uint32_t flush_all(void)
{
    uint32_t results = 0U;
    for (; davar_flush(&davar); results++) {
        TEST_ASSERT_TRUE(davar_take(&davar, &result));
    }
    return results;
}

/* Waiting blocks are accepted together; a record ends within a block; a record is shorter than half
 * a window; a result at every sample. */
static void test_centred_windows_where_little_or_much_has_come(void)
{
    nothing_lost();
    config.window.mode = DAVAR_MODE_CENTRED;
    make_stream(5U, STEP, 8.0);
    config.stride = 10U;
    init(Q15, 0U);
    TEST_ASSERT_EQUAL_UINT32(1U, run(Q15, 0U, SAMPLES, 1U, 7U).alarms);
    TEST_ASSERT_EQUAL_UINT32(0U, davar_health(&davar).shocks);
    config.stride = 5U;
    init(Q15, 0U);
    (void)run(Q15, 0U, 4009U, 64U, 100000U);
    (void)flush_all();
    TEST_ASSERT_EQUAL_UINT64(4004U, result.epoch);
    config.stride = 10U;
    init(Q15, 0U);
    TEST_ASSERT_EQUAL_UINT32(0U, run(Q15, 0U, 95U, 64U, 1U).results);
    TEST_ASSERT_EQUAL_UINT32(9U, flush_all());
    TEST_ASSERT_EQUAL_UINT64(89U, result.epoch);
    TEST_ASSERT_EQUAL_UINT32(90U, result.window_samples);
    config.glr.block = 5U; /* half a window is 150 samples then */
    config.window.longest = 300U;
    config.tau_count = 1U;
    config.stride = 1U;
    init(Q15, 0U);
    const uint32_t results = run(Q15, 0U, 1000U, 64U, 7U).results;
    TEST_ASSERT_UINT32_WITHIN(4U, 1000U - 150U,
                              results); /* of a block that continues sample by sample */
    TEST_ASSERT_EQUAL_UINT32(1000U, results + flush_all());
    TEST_ASSERT_EQUAL_UINT64(999U, result.epoch);
}

static void test_centred_windows_near_shocks_and_gaps(void)
{
    config.window.mode = DAVAR_MODE_CENTRED;
    check_shock(Q15, 10U);
    check_gaps(10U);
    config.window.gaps_max = 1U;
    config.stride = 10U;
    nothing_lost();
    init(Q15, 0U);
    (void)run(Q15, 0U, 3000U, 1U, 1000000U);
    davar_gap(&davar, 1U);
    (void)run(Q15, 3000U, 3100U, 1U, 1000000U);
    davar_gap(&davar, 1U);
    (void)run(Q15, 3100U, 6000U, 1U, 1000000U);
    TEST_ASSERT_EQUAL_UINT32(1U, davar_health(&davar).restarts);
    TEST_ASSERT_EQUAL_UINT64(5999U - HALF, result.epoch);
}

/* An alarm that was not taken is in the next result that is taken. */
static void test_an_alarm_waits_to_be_taken(void)
{
    init(Q15, 0U);
    uint32_t n = 0U;
    for (; davar_health(&davar).alarms == 0U; n++) {
        TEST_ASSERT_LESS_THAN_UINT32(SAMPLES, n);
        (void)push(Q15, n, 1U);
    }
    for (uint32_t end = n + 100U; n < end; n++) {
        (void)push(Q15, n, 1U);
    }
    TEST_ASSERT_TRUE(davar_take(&davar, &result));
    TEST_ASSERT_TRUE(result.alarm);
    (void)push(Q15, n, 1U);
    TEST_ASSERT_TRUE(davar_take(&davar, &result));
    TEST_ASSERT_FALSE(result.alarm);
}

static unsigned char cells[2U * 16384U];

static bool read_cells(void *context, size_t offset, void *data, size_t bytes)
{
    (void)context;
    memcpy(data, &cells[offset], bytes);
    return true;
}

static bool write_cells(void *context, size_t offset, const void *data, size_t bytes)
{
    (void)context;
    memcpy(&cells[offset], data, bytes);
    return true;
}

static void test_a_restored_stream_continues_bit_for_bit(void)
{
    static const davar_storage_t storage = {read_cells, write_cells, NULL, 16384U};
    make_stream(4U, 4300U, 1.6);
    stream[4003] = 900;
    for (uint32_t cut = 3990U; cut < 4040U; cut += 3U) {
        init(Q15, 0U);
        (void)run(Q15, 0U, cut, 1U, 1000000U);
        TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_save(&davar, &storage));
        (void)run(Q15, cut, 6000U, 1U, 1000000U);
        const davar_result_t expected = result;
        const davar_health_t health = davar_health(&davar);
        init(Q15, 1U);
        memset(memory[0], 0, sizeof memory[0]);
        TEST_ASSERT_EQUAL(DAVAR_OK, davar_state_restore(&davar, &storage));
        (void)run(Q15, cut, 6000U, 1U, 1000000U);
        const davar_health_t again = davar_health(&davar);
        TEST_ASSERT_EQUAL_MEMORY(&health, &again, sizeof health);
        TEST_ASSERT_EQUAL_UINT64(expected.epoch, result.epoch);
        TEST_ASSERT_EQUAL_UINT32(expected.window_samples, result.window_samples);
        TEST_ASSERT_EQUAL_MEMORY(expected.tau, result.tau, sizeof expected.tau[0] * TAUS);
    }
}

static void test_kurtosis_is_kept_on_request(void)
{
    nothing_lost();
    config.moments.segment = 10U;
    init(Q15, 0U);
    (void)run(Q15, 0U, 4000U, 1U, 101U);
    TEST_ASSERT_DOUBLE_WITHIN(0.6, 2.9, result.kurtosis);
    TEST_ASSERT_FALSE(result.unstable);
    config.moments.segment = 0U;
    init(Q15, 0U);
    (void)run(Q15, 0U, 4000U, 1U, 101U);
    TEST_ASSERT_TRUE(isnan(result.kurtosis));
}

/* Each is counted once, for any block length. */
static void test_saturated_samples_are_counted_once(void)
{
    static const type_t types[2] = {Q15, F32};
    nothing_lost();
    for (uint32_t i = 0U; i < 300U; i++) {
        stream[1000U + i] = INT16_MAX;
    }
    config.full_scale = 0.25 * 30000.0;
    config.stride = 10U;
    for (unsigned t = 0U; t < 2U; t++) {
        for (uint32_t block = 1U; block <= 64U; block += 21U) {
            init(types[t], 0U);
            (void)run(types[t], 0U, 4000U, block, 100000U);
            TEST_ASSERT_EQUAL_UINT32(300U, davar_health(&davar).saturated);
        }
    }
}

/* ... and at least one result reports it, with or without moments. */
static void test_a_cut_is_unstable(void)
{
    for (uint32_t segment = 0U; segment <= 10U; segment += 10U) {
        uint32_t unstable = 0U;
        config.moments.segment = segment;
        init(Q15, 0U);
        for (uint32_t n = 0U; n < SAMPLES; n++) {
            (void)push(Q15, n, 1U);
            unstable += (davar_take(&davar, &result) && result.unstable) ? 1U : 0U;
            TEST_ASSERT_LESS_OR_EQUAL_UINT32(SAMPLES, result.cut_age_samples);
        }
        TEST_ASSERT_EQUAL_UINT32(davar_health(&davar).cuts, unstable);
    }
}

/* (10.14): the cut is at most eight blocks old, or not reached yet. At every result, for each block
 * size. */
static void test_young_is_what_was_cut_eight_blocks_ago_at_most(void)
{
    static const uint32_t blocks[] = {5U, 10U, 25U};
    for (unsigned k = 0U; k < sizeof blocks / sizeof blocks[0]; k++) {
        uint32_t youngs = 0U;
        config.glr.block = blocks[k];
        init(Q15, 0U);
        for (uint32_t n = 0U; n < SAMPLES; n++) {
            (void)push(Q15, n, 1U);
            if (!davar_take(&davar, &result)) {
                continue;
            }
            const bool cut_lately = (result.cut_age_samples <= (8U * config.glr.block));
            const bool reaches = (result.cut_age_samples < result.window_samples);
            const bool young = (davar_health(&davar).cuts > 0U) && (cut_lately || reaches);
            TEST_ASSERT_EQUAL(young, result.young);
            youngs += young ? 1U : 0U;
        }
        TEST_ASSERT_GREATER_THAN_UINT32(0U, youngs);
    }
}

/* No other policy has cuts. */
static void test_without_a_detector_nothing_is_young(void)
{
    config.law = NULL;
    config.window.grow = 0U;
    init(Q15, 0U);
    for (uint32_t n = 0U; n < 3000U; n++) {
        (void)push(Q15, n, 1U);
        if (davar_take(&davar, &result)) {
            TEST_ASSERT_FALSE(result.young || result.alarm);
            TEST_ASSERT_EQUAL_UINT32(0U, result.cut_age_samples);
            TEST_ASSERT_EQUAL_UINT32(0U, result.change.m);
            TEST_ASSERT_TRUE(isnan(result.dispersion));
        }
    }
    TEST_ASSERT_GREATER_THAN_UINT32(0U, result.window_samples);
}

static void refused(void)
{
    TEST_ASSERT_EQUAL(DAVAR_ERR_TRACKING,
                      davar_init_q15(&davar, &config, memory[0], sizeof memory[0]));
    setUp();
}

static void test_errors_of_init(void)
{
    config.window.mode = DAVAR_MODE_CENTRED, config.stride = 10U, config.window.longest = 590U,
    refused();
    config.window.mode = DAVAR_MODE_CENTRED, config.glr.block = 65U, refused();
    config.window.mode = DAVAR_MODE_CENTRED, config.engine = DAVAR_ENGINE_EDGES;
    TEST_ASSERT_EQUAL(DAVAR_ERR_ENGINE,
                      davar_init_q15(&davar, &config, memory[0], sizeof memory[0]));
    setUp();
    config.glr.block = 4U, refused();
    config.glr.block = 65U, refused();
    config.glr.shock_blocks = 3U, refused();
    config.window.longest = 79U, refused();
    config.stride = 1201U;
    TEST_ASSERT_EQUAL(DAVAR_ERR_STRIDE_LONG,
                      davar_init_q15(&davar, &config, memory[0], sizeof memory[0]));
    setUp();
    config.stride = 10U, config.engine = DAVAR_ENGINE_EDGES;
    TEST_ASSERT_EQUAL(DAVAR_ERR_ENGINE,
                      davar_init_q15(&davar, &config, memory[0], sizeof memory[0]));
    setUp();
    config.engine = DAVAR_ENGINE_EDGES; /* no effect at stride 1 */
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory[0], sizeof memory[0]));
    setUp();
    config.stride = 7U, config.window.shortest = 1192U,
    refused(); /* its windows begin between two blocks */
    config.stride = 7U, config.window.shortest = 1191U;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory[0], sizeof memory[0]));
    setUp();
    config.stride = 20U, config.window.longest = 1205U, config.window.shortest = 1201U, refused();
    config.stride = 20U, config.window.longest = 1205U, config.window.shortest = 1200U;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory[0], sizeof memory[0]));
    setUp();
    config.window.longest = 7690U, refused();
    config.window.longest = 7680U; /* 768 blocks of 10 */
    TEST_ASSERT_NOT_EQUAL(0U, davar_memory_size_q15(&config));
    setUp();
    config.glr.false_alarms_per_hour = 0.0, refused();
    config.glr.cut_interval_s = -1.0, refused();
    static const double ends[2] = {1e-9, 1e9};
    for (unsigned i = 0U; i < 2U; i++) {
        const double beyond = (i == 0U) ? 0.0 : 1e10;
        config.glr.false_alarms_per_hour = ends[i], config.glr.cut_interval_s = ends[1U - i];
        TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory[0], sizeof memory[0]));
        setUp();
        config.glr.false_alarms_per_hour = nextafter(ends[i], beyond), refused();
        config.glr.cut_interval_s = nextafter(ends[i], beyond), refused();
    }
}

/* After a reset there has been no alarm. */
static void test_a_reset_takes_no_alarm_along(void)
{
    init(Q15, 0U);
    uint32_t n = 0U;
    for (; davar_health(&davar).alarms == 0U; n++) {
        davar_push_q15(&davar, &stream[n], 1U);
    }
    while (davar_take(&davar, &result)) {
    }
    for (uint32_t more = 0U; more < 64U; more++) {
        davar_push_q15(&davar, &stream[n + more], 1U);
    }
    davar_reset(&davar);
    TEST_ASSERT_EQUAL_UINT32(0U, davar_health(&davar).alarms);
    for (n = 0U; !davar_take(&davar, &result); n++) {
        davar_push_q15(&davar, &stream[n], 1U);
    }
    TEST_ASSERT_FALSE(result.alarm);
    TEST_ASSERT_EQUAL_UINT32(0U, davar_health(&davar).missed); /* nor results that were not taken */
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_step_is_reported_and_the_window_begins_after_it);
    RUN_TEST(test_block_lengths_do_not_change_results);
    RUN_TEST(test_a_shock_is_excluded);
    RUN_TEST(test_an_assumed_shock_is_accepted_later);
    RUN_TEST(test_a_change_reported_before_the_window_reaches_it_is_not_old);
    RUN_TEST(test_without_shock_blocks_a_shock_is_a_change);
    RUN_TEST(test_gaps);
    RUN_TEST(test_a_gap_near_a_shock);
    RUN_TEST(test_every_result_near_gaps_can_be_taken);
    RUN_TEST(test_a_restart);
    RUN_TEST(test_reset_restarts);
    RUN_TEST(test_a_centred_window_ends_at_the_step);
    RUN_TEST(test_centred_windows_where_little_or_much_has_come);
    RUN_TEST(test_centred_windows_near_shocks_and_gaps);
    RUN_TEST(test_an_alarm_waits_to_be_taken);
    RUN_TEST(test_a_restored_stream_continues_bit_for_bit);
    RUN_TEST(test_kurtosis_is_kept_on_request);
    RUN_TEST(test_saturated_samples_are_counted_once);
    RUN_TEST(test_a_cut_is_unstable);
    RUN_TEST(test_young_is_what_was_cut_eight_blocks_ago_at_most);
    RUN_TEST(test_without_a_detector_nothing_is_young);
    RUN_TEST(test_errors_of_init);
    RUN_TEST(test_a_reset_takes_no_alarm_along);
    return UNITY_END();
}
