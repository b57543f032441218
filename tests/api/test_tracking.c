/* davar tests - law glr from outside: a change is reported and the window begins after it; shocks,
 * gaps, restarts and settings. tests/tracking/test_forever.c compares the sums with brute
 * force. */
#include "davar/davar.h"

#include "random.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define SAMPLES 9000U
#define STEP 5000U
#define TAUS 5U
#define NO_TIME UINT32_MAX

typedef enum { Q15, Q31, F32 } type_t;

static const uint32_t taus[TAUS] = {1U, 2U, 4U, 8U, 16U};
static davar_config_t config;
static uint64_t memory[4096];
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
    config.rate_hz = 100.0;
    config.unit_per_count = 0.25;
    config.full_scale = 4096.0;
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

static void init(type_t type)
{
    davar_status_t status = DAVAR_OK;
    if (config.law != NULL) {
        config.law = (type == Q15) ? &davar_law_glr_q15 : &davar_law_glr_q31;
    }
    memset(memory, 0xA5, sizeof memory);
    if (type == Q15) {
        TEST_ASSERT_LESS_OR_EQUAL_size_t(sizeof memory, davar_memory_size_q15(&config));
        status = davar_init_q15(&davar, &config, memory, sizeof memory);
    } else if (type == Q31) {
        status = davar_init_q31(&davar, &config, memory, sizeof memory);
    } else {
        status = davar_init_f32(&davar, &config, memory, sizeof memory);
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

typedef struct {
    uint32_t results;
    uint32_t alarms;
    uint32_t alarm_at;
    uint32_t cut_at;   /* the change, from the alarm */
    uint32_t shortest; /* window after the alarm */
    uint64_t last;     /* epoch */
} story_t;

/* Pushes samples [from, to), `block` at a time, and looks at every result. */
static story_t run(type_t type, uint32_t from, uint32_t to, uint32_t block)
{
    story_t story = {0U, 0U, NO_TIME, NO_TIME, UINT32_MAX, 0U};
    for (uint32_t n = from; n < to;) {
        n += (uint32_t)push(type, n, ((to - n) < block) ? (to - n) : block);
        if (davar_take(&davar, &result)) {
            TEST_ASSERT_LESS_THAN_UINT64(n, result.epoch);
            TEST_ASSERT_TRUE((story.results == 0U) || (result.epoch > story.last));
            TEST_ASSERT_EQUAL_UINT64(0U, (result.epoch + 1U) % config.stride);
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
        }
    }
    return story;
}

/* --- tests --- */

/* A step of 1.8 is detected within two seconds, and soon the window has no older samples. */
static void check_step(type_t type, uint32_t stride, uint32_t block)
{
    config.stride = stride;
    init(type);
    const story_t story = run(type, 0U, SAMPLES, block);
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
        init(Q15);
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

/* A gap completes no result. Samples accepted before it continue with the samples after it, and
 * each result can be taken. */
static void check_every_result_can_be_taken(uint32_t stride, uint32_t shock_blocks)
{
    uint32_t results = 0U;
    config.stride = stride;
    config.glr.shock_blocks = shock_blocks;
    config.window.gaps_max = 400U;
    init(Q15);
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
        check_every_result_can_be_taken(1U, shock_blocks);
        check_every_result_can_be_taken(3U, shock_blocks);
        check_every_result_can_be_taken(10U, shock_blocks);
    }
}

static uint32_t flush_all(void)
{
    uint32_t results = 0U;
    for (; davar_flush(&davar); results++) {
        TEST_ASSERT_TRUE(davar_take(&davar, &result));
    }
    return results;
}

/* A record that ends within a block; one shorter than a block; a result at every sample. */
static void test_a_flush_passes_the_samples_in_the_queue(void)
{
    make_stream(5U, STEP, 8.0);
    config.stride = 5U;
    init(Q15);
    (void)run(Q15, 0U, 4009U, 64U);
    TEST_ASSERT_GREATER_THAN_UINT32(0U, flush_all());
    TEST_ASSERT_EQUAL_UINT64(4004U, result.epoch);
    init(Q15);
    TEST_ASSERT_EQUAL_UINT32(0U, run(Q15, 0U, 9U, 64U).results);
    TEST_ASSERT_EQUAL_UINT32(0U, flush_all()); /* shorter than the shortest window */
    config.stride = 1U;
    init(Q15);
    const uint32_t results = run(Q15, 0U, 1004U, 64U).results;
    TEST_ASSERT_GREATER_THAN_UINT32(0U, flush_all());
    TEST_ASSERT_LESS_THAN_UINT32(1004U, results);
    TEST_ASSERT_EQUAL_UINT64(1003U, result.epoch);
}

/* An alarm that was not taken is in the next result that is taken. */
static void test_an_alarm_waits_to_be_taken(void)
{
    init(Q15);
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

static void test_kurtosis_is_kept_on_request(void)
{
    config.moments.segment = 10U;
    init(Q15);
    (void)run(Q15, 0U, 4000U, 1U);
    TEST_ASSERT_DOUBLE_WITHIN(0.6, 2.9, result.kurtosis);
    TEST_ASSERT_FALSE(result.unstable);
    config.moments.segment = 0U;
    init(Q15);
    (void)run(Q15, 0U, 4000U, 1U);
    TEST_ASSERT_TRUE(isnan(result.kurtosis));
}

/* Each is counted once, for any block length. */
static void test_saturated_samples_are_counted_once(void)
{
    static const type_t types[2] = {Q15, F32};
    for (uint32_t i = 0U; i < 300U; i++) {
        stream[1000U + i] = INT16_MAX;
    }
    config.full_scale = 0.25 * 30000.0;
    config.stride = 10U;
    for (unsigned t = 0U; t < 2U; t++) {
        for (uint32_t block = 1U; block <= 64U; block += 21U) {
            init(types[t]);
            (void)run(types[t], 0U, 4000U, block);
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
        init(Q15);
        for (uint32_t n = 0U; n < SAMPLES; n++) {
            (void)push(Q15, n, 1U);
            unstable += (davar_take(&davar, &result) && result.unstable) ? 1U : 0U;
            TEST_ASSERT_LESS_OR_EQUAL_UINT32(SAMPLES, result.cut_age_samples);
        }
        TEST_ASSERT_EQUAL_UINT32(davar_health(&davar).cuts, unstable);
    }
}

static void refused(void)
{
    TEST_ASSERT_EQUAL(DAVAR_ERR_TRACKING, davar_init_q15(&davar, &config, memory, sizeof memory));
    setUp();
}

static void test_errors_of_init(void)
{
    config.glr.block = 4U, refused();
    config.glr.block = 65U, refused();
    config.glr.shock_blocks = 3U, refused();
    config.window.longest = 79U, refused();
    config.stride = 1201U;
    TEST_ASSERT_EQUAL(DAVAR_ERR_STRIDE_LONG,
                      davar_init_q15(&davar, &config, memory, sizeof memory));
    setUp();
    config.stride = 7U, config.window.shortest = 1192U,
    refused(); /* its windows begin between two blocks */
    config.stride = 7U, config.window.shortest = 1191U;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
    setUp();
    config.stride = 20U, config.window.longest = 1205U, config.window.shortest = 1201U, refused();
    config.stride = 20U, config.window.longest = 1205U, config.window.shortest = 1200U;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
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
        TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
        setUp();
        config.glr.false_alarms_per_hour = nextafter(ends[i], beyond), refused();
        config.glr.cut_interval_s = nextafter(ends[i], beyond), refused();
    }
}

/* After a reset there has been no alarm. */
static void test_a_reset_takes_no_alarm_along(void)
{
    init(Q15);
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
    RUN_TEST(test_a_change_reported_before_the_window_reaches_it_is_not_old);
    RUN_TEST(test_every_result_near_gaps_can_be_taken);
    RUN_TEST(test_a_flush_passes_the_samples_in_the_queue);
    RUN_TEST(test_an_alarm_waits_to_be_taken);
    RUN_TEST(test_kurtosis_is_kept_on_request);
    RUN_TEST(test_saturated_samples_are_counted_once);
    RUN_TEST(test_a_cut_is_unstable);
    RUN_TEST(test_errors_of_init);
    RUN_TEST(test_a_reset_takes_no_alarm_along);
    return UNITY_END();
}
