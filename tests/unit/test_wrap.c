/* davar tests - a stream so long that its 32-bit positions wrap continues correctly. */
#include "davar/davar.h"
#include "davar/glr.h"
#include "unity.h"

/* their states are private; the library's own copies are not linked as well */
#include "engines/grid_q15.c" /* NOLINT(bugprone-suspicious-include) */

#include "laws/glr_q15.c" /* NOLINT(bugprone-suspicious-include) */

#include <string.h>

static uint32_t fed;    /* samples before the time shift */
static uint32_t length; /* ... and after it */

static const uint32_t taus[3] = {1U, 3U, 8U};
static uint64_t memory[2][4096];
static davar_config_t config;

void setUp(void)
{
    config = davar_default_config;
    config.rate_hz = 1.0;
    config.unit_per_count = 1.0;
    config.window.longest = 60U;
    config.window.shortest = 30U;
    config.moments.segment = 10U;
    config.taus = taus;
    config.tau_count = 3U;
    config.window.gaps_max = 8U;
    fed = 400U;
    length = 1000U;
}

void tearDown(void) {}

/* Moves every position of a track by `offset`, as if that many more samples had passed. */
static void shift_records(edge_records_t *records, uint32_t offset, uint32_t count)
{
    records->due += offset;
    for (uint32_t t = 0U; (records->sum_due != NULL) && (t < count); t++) {
        records->sum_due[t] += offset;
    }
}

static void shift_place(davar_glr_place_t *place, uint32_t blocks)
{
    static const davar_spread_t far_on = {UINT64_MAX - 12345U, UINT32_MAX, UINT32_MAX - 777U};
    spread_add(&place->sum, &far_on);
    place->at += blocks;
}

/* As if this many more blocks had passed: complete turns of every octave's records. The running
 * sums are about to wrap too. */
static void shift_detector(davar_glr_t *detector, uint32_t blocks)
{
    shift_place(&detector->now, blocks);
    shift_place(&detector->alarm, blocks);
    shift_place(&detector->cut, blocks);
    for (uint32_t i = 0U; i < (GLR_LEVELS * GLR_RECORDS); i++) {
        davar_glr_place_t place = {detector->record[i / GLR_RECORDS][i % GLR_RECORDS], 0U};
        shift_place(&place, blocks);
        detector->record[i / GLR_RECORDS][i % GLR_RECORDS] = place.sum;
    }
}

#define TURN                                                                                       \
    (GLR_RECORDS << (GLR_LEVELS - 1U)) /* blocks after which every record has been overwritten */

static void shift(davar_t *davar, uint32_t offset)
{
    stages_t *const stages = davar->stages;
    glr_queue_t *const queue = davar->law_state;
    davar->window.received += offset;
    davar->window.origin -= offset;
    for (uint16_t i = 0U; i < davar->gaps.count; i++) {
        davar->gaps.position[i] += offset;
    }
    if (davar->config->law == &davar_law_glr_q15) {
        queue->tail += offset;
        queue->cut += offset;
        queue->end += offset;
        shift_detector(&queue->track.detector, 0U - TURN);
    }
    if (stages->engine != NULL) {
        grid_t *const grid = stages->engine_state;
        grid->next += offset;
        grid->sum_next += offset;
        for (unsigned i = 0U; i < grid->edges; i++) {
            shift_records(&grid->edge[i], offset, stages->allan.count);
        }
    }
}

static int16_t sample_at(uint32_t n)
{
    const int32_t size = ((n / 90U) % 2U == 0U) ? 40 : 400;
    return (int16_t)((int32_t)((n * 2654435761U) >> 16U) % size);
}

static bool feed(davar_t *davar, uint32_t n, davar_result_t *result)
{
    const int16_t sample = sample_at(n);
    if ((n % 130U) == 100U) {
        davar_gap(davar, 1U);
    }
    davar_push_q15(davar, &sample, 1U);
    return davar_take(davar, result);
}

static void same(const davar_result_t *a, const davar_result_t *b)
{
    TEST_ASSERT_EQUAL(a->chosen, b->chosen);
    TEST_ASSERT_EQUAL_MEMORY(&a->dispersion, &b->dispersion, sizeof a->dispersion);
    TEST_ASSERT_EQUAL_UINT64(a->epoch, b->epoch);
    TEST_ASSERT_EQUAL_UINT32(a->window_samples, b->window_samples);
    TEST_ASSERT_EQUAL_UINT32(a->gaps_in_window, b->gaps_in_window);
    TEST_ASSERT_EQUAL_DOUBLE(a->kurtosis, b->kurtosis);
    for (uint32_t t = 0U; t < 3U; t++) {
        TEST_ASSERT_EQUAL_UINT32(a->tau[t].differences, b->tau[t].differences);
        TEST_ASSERT_EQUAL_DOUBLE(a->tau[t].adev, b->tau[t].adev);
    }
}

static void same_reports(davar_t *a, davar_t *b)
{
    davar_glr_report_t of_a;
    davar_glr_report_t of_b;
    davar_glr_report(a, &of_a);
    davar_glr_report(b, &of_b);
    TEST_ASSERT_EQUAL_UINT32(of_a.cut_age_samples, of_b.cut_age_samples);
    TEST_ASSERT_EQUAL(of_a.young, of_b.young);
    TEST_ASSERT_EQUAL(of_a.alarm, of_b.alarm);
    TEST_ASSERT_EQUAL_UINT32(of_a.change.m, of_b.change.m);
    TEST_ASSERT_EQUAL_DOUBLE(of_a.change.older, of_b.change.older);
    TEST_ASSERT_EQUAL_DOUBLE(of_a.change.newer, of_b.change.newer);
}

/* `before`: samples to the wrap. 130 - 20 = 110 and 100 more put a gap exactly on it. */
static void wrapped(uint32_t before)
{
    davar_t plain;
    davar_t wrapping;
    davar_result_t result[2];
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&plain, &config, memory[0], sizeof memory[0]));
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&wrapping, &config, memory[1], sizeof memory[1]));
    for (uint32_t n = 0U; n < (fed + length); n++) {
        if (n == fed) {
            shift(&wrapping, 0U - fed - before);
        }
        const bool ready = feed(&plain, n, &result[0]);
        TEST_ASSERT_EQUAL(ready, feed(&wrapping, n, &result[1]));
        if (ready) {
            same(&result[0], &result[1]);
            same_reports(&plain, &wrapping);
        }
    }
    while (davar_flush(&plain)) {
        TEST_ASSERT_TRUE(davar_flush(&wrapping));
        TEST_ASSERT_TRUE(davar_take(&plain, &result[0]) && davar_take(&wrapping, &result[1]));
        same(&result[0], &result[1]);
        same_reports(&plain, &wrapping);
    }
    TEST_ASSERT_FALSE(davar_flush(&wrapping));
}

/* At every sample, at a stride, and on a grid. */
static void test_positions_wrap_unnoticed(void)
{
    for (uint32_t way = 0U; way < 3U; way++) {
        setUp();
        config.stride = (way == 0U) ? 1U : 7U;
        config.engine = (way == 2U) ? &davar_engine_grid_q15 : NULL;
        wrapped(90U); /* n = 490 = 3 * 130 + 100: a gap right on the wrap */
        wrapped(333U);
    }
}

static void test_positions_wrap_correctly_after_the_detector(void)
{
    static const uint32_t before[] = {90U, 333U, 700U};
    config.law = &davar_law_glr_q15;
    config.window.shortest = 20U;
    for (uint32_t i = 0U; i < 3U; i++) {
        config.window.longest = 80U;
        config.stride = 1U;
        wrapped(before[i]);
        config.stride = 7U;
        wrapped(before[i]);
        config.window.longest = 660U; /* the wrap comes while the window fills */
        config.stride = 20U;
        wrapped(before[i]);
    }
}

/* Samples, blocks, the running sums and their counts wrap, with windows of many blocks. */
static void wrapped_long(uint32_t stride, uint32_t block)
{
    config.law = &davar_law_glr_q15;
    config.window.longest = 60U * block;
    config.window.shortest = 3U * block;
    config.glr.block = block;
    config.stride = stride;
    config.window.gaps_max = 64U;
    fed = 1000U; /* the window is full */
    length = 3000U + (block * TURN);
    wrapped(90U);
    wrapped((block * TURN) - 1000U);
}

static void test_blocks_wrap_unnoticed(void)
{
    wrapped_long(1U, 5U);
    wrapped_long(10U, 10U);
    wrapped_long(33U, 10U);
}

/* A record of law glr ends exactly at the wrap and anywhere in the samples after it that wait: they
 * are not lost. */
static void test_a_record_that_ends_after_the_wrap_is_flushed(void)
{
    config.law = &davar_law_glr_q15;
    config.window.longest = 80U;
    config.window.shortest = 20U;
    for (uint32_t behind = 0U; behind < 35U; behind++) {
        config.stride = 1U;
        wrapped(1000U - behind);
        config.stride = 7U;
        wrapped(1000U - behind);
    }
}

/* A single gap, then none for 2^31 samples and more, then another: the first must not reappear.
 * Time advances for everything except the boundaries that are still stored. */
static void forgotten(uint32_t first, uint32_t later)
{
    davar_t plain;
    davar_t late;
    davar_result_t result[2];
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&plain, &config, memory[0], sizeof memory[0]));
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&late, &config, memory[1], sizeof memory[1]));
    for (uint32_t n = 0U; n < 1000U; n++) {
        const int16_t sample = sample_at(n);
        if ((n == first) || (n == 700U)) {
            davar_gap(&plain, 1U);
            davar_gap(&late, 1U);
        }
        if (n == 420U) {
            uint32_t positions[8];
            memcpy(positions, late.gaps.position, sizeof positions);
            shift(&late, later);
            memcpy(late.gaps.position, positions, sizeof positions);
        }
        davar_push_q15(&plain, &sample, 1U);
        davar_push_q15(&late, &sample, 1U);
        const bool ready = davar_take(&plain, &result[0]);
        TEST_ASSERT_EQUAL(ready, davar_take(&late, &result[1]));
        if (ready) {
            same(&result[0], &result[1]);
        }
    }
}

static void test_an_old_gap_is_forgotten(void)
{
    static const uint32_t later[] = {0x7FFFFE00U, 0x80000000U, 0xFFFFFFFFU - 600U};
    for (unsigned i = 0U; i < 9U; i++) { /* at every sample, at a stride, on a grid */
        config.stride = (i % 3U == 0U) ? 1U : 7U;
        config.engine = (i % 3U == 2U) ? &davar_engine_grid_q15 : NULL;
        forgotten(100U, later[i / 3U]);
    }
}

/* A gap among the first samples, of a window that fills and glides from then on. */
static void test_a_gap_next_to_the_start_is_forgotten(void)
{
    config.law = NULL;
    config.moments.segment = 0U;
    config.stride = 7U;
    forgotten(3U, 0x80000000U);
    config.engine = &davar_engine_grid_q15;
    forgotten(3U, 0x80000000U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_positions_wrap_unnoticed);
    RUN_TEST(test_positions_wrap_correctly_after_the_detector);
    RUN_TEST(test_blocks_wrap_unnoticed);
    RUN_TEST(test_a_record_that_ends_after_the_wrap_is_flushed);
    RUN_TEST(test_an_old_gap_is_forgotten);
    RUN_TEST(test_a_gap_next_to_the_start_is_forgotten);
    return UNITY_END();
}
