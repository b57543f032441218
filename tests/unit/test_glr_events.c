/* davar tests - events of the detector of changes at a step, a shock, a ramp, a gap, and the
 * windows that follow. */
#include "detector/glr.h"

#include "glr_fixture.h"

#include <string.h>

/* ---- events ---- */

static void knock(double size)
{
    int16_t sample[K_MAX] = {0};
    fill(sample, 20.0);
    sample[3] = rounded(size);
    push_samples(sample);
}

static void test_a_shock_is_dropped_and_changes_nothing(void)
{
    push_quiet(300U);
    const uint32_t cut = state.cut.at;
    for (uint32_t length = 1U; length <= 2U; length++) {
        const uint32_t before = state.now.sum.blocks;
        for (uint32_t i = 0U; i < length; i++) {
            knock(600.0);
            TEST_ASSERT_EQUAL(i + 1U, state.pending);
            TEST_ASSERT_EQUAL(0, event.resolved);
        }
        push_noise(20.0);
        TEST_ASSERT_EQUAL(length, event.dropped);
        TEST_ASSERT_EQUAL(length + 1U, event.resolved);
        TEST_ASSERT_EQUAL_UINT32(before + 1U, state.now.sum.blocks);
        push_quiet(20U);
    }
    TEST_ASSERT_EQUAL_UINT32(cut, state.cut.at);
    TEST_ASSERT_EQUAL_UINT32(300U + 22U + 23U, state.now.at);
}

static void push_blocks(uint64_t b, uint32_t count)
{
    const davar_spread_t block = {b, 0U, 1U};
    for (uint32_t i = 0U; i < count; i++) {
        davar_glr_push(&state, &config, &block, &event);
    }
}

static void skip(uint32_t count)
{
    for (uint32_t i = 0U; i < count; i++) {
        davar_glr_skip(&state, &config, &event);
    }
}

static void test_wide_samples_decide_as_narrow_ones_whatever_their_size(void)
{
    static davar_glr_t wide;
    static davar_glr_event_t other;
    davar_glr_reset(&wide);
    for (uint32_t n = 0U; n < 2000U; n++) {
        const double sigma = ((n / 300U) % 2U == 0U) ? 2000.0 : 8000.0;
        int64_t sum = 0;
        uint64_t squares = 0U;
        for (uint32_t i = 0U; i < 10U; i++) {
            const int16_t sample = rounded(sigma * random_gauss(&rng));
            sum += sample;
            squares += (uint64_t)(sample * (int64_t)sample);
        }
        if ((n % 97U) >= 95U) { /* a shock */
            sum += 30000;
            squares += UINT64_C(900000000);
        }
        const davar_u128_t scaled = {squares << 32U, squares >> 32U};
        davar_glr_push_q15(&state, &config, (int32_t)sum, squares, &event);
        davar_glr_push_q31(&wide, &config, sum * 65536, &scaled, &other);
        TEST_ASSERT_EQUAL(event.is_alarm, other.is_alarm);
        TEST_ASSERT_EQUAL(event.dropped, other.dropped);
        TEST_ASSERT_EQUAL_UINT32(state.cut.at, wide.cut.at);
    }
}

/* ---- windows ---- */

static davar_glr_window_t trailing(void)
{
    davar_glr_window_t window;
    davar_glr_trailing(&state, &config, &window);
    TEST_ASSERT_EQUAL_UINT32(state.now.at, window.end);
    return window;
}

static void test_a_trailing_window_may_have_only_gaps(void)
{
    skip(100U);
    TEST_ASSERT_EQUAL_UINT32(0U, trailing().begin);
    push_quiet(20U);
    TEST_ASSERT_EQUAL_UINT32(0U, trailing().begin);
    skip(50U);
    TEST_ASSERT_EQUAL_UINT32(0U, trailing().begin);
    config.near = 3U;
    TEST_ASSERT_EQUAL_UINT32(0U, trailing().begin);
}

/* So many cuts that the oldest are discarded; then no cut for so long that all are. */
static void test_the_oldest_cut_that_is_remembered_bounds_the_window(void)
{
    davar_glr_window_t window;
    for (uint32_t n = 0U; n < 150U; n++) {
        push_noise((((n / 10U) % 2U) == 0U) ? 20.0 : 400.0);
        (void)davar_glr_centred(&state, &config, config.half, &window);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(60U, window.end - window.begin);
    }
    TEST_ASSERT_EQUAL(GLR_CUTS, state.cuts);
    config.cut = config.alarm;
    push_quiet(1500U);
    (void)davar_glr_centred(&state, &config, config.half, &window);
    TEST_ASSERT_EQUAL(0, state.cuts);
    TEST_ASSERT_GREATER_THAN_UINT32(200U, window.end - window.begin);
    skip(70U);
    (void)blocks_to_alarm(400.0, 20U);
    TEST_ASSERT_EQUAL(1, state.cuts);
}

/* Between the blocks of 10^6 and those a fifth louder there is a gap; the cut is at the gap. */
static void test_a_cut_near_a_gap_counts(void)
{
    davar_glr_wish_t wish = usual;
    wish.block = 25U;
    davar_glr_start(&config, &wish);
    push_blocks(1000000U, 287U);
    skip(13U);
    push_blocks(1190000U, 36U);
    TEST_ASSERT_EQUAL_UINT32(288U, state.cut.at);
    push_blocks(1190000U, 4U);
    TEST_ASSERT_BIT_HIGH((int)(state.cuts - 1U), state.counts);
}

/* A change so small that its cut is older than the blocks that are stored one by one. */
static void test_a_cut_that_came_late_counts(void)
{
    push_blocks(1000000U, 320U);
    uint32_t n = 0U;
    for (; (n < 300U) && (state.cut.at == 0U); n++) {
        push_blocks(1170000U, 1U);
    }
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(GLR_RECENT, state.now.at - state.cut.at);
    push_blocks(1170000U, 4U);
    TEST_ASSERT_BIT_HIGH((int)(state.cuts - 1U), state.counts);
}

#define STEPS 6000U

static bool heard[STEPS + 1U]; /* block n was accepted */

static uint32_t heard_between(uint32_t begin, uint32_t end)
{
    uint32_t count = 0U;
    for (uint32_t n = begin; n < end; n++) {
        count += heard[n] ? 1U : 0U;
    }
    return count;
}

/* A window [begin, end) about the block that is followed by `accepted` accepted ones: within the
 * record, not empty, with the stated number of blocks. If no record contains its beginning, only
 * the newest blocks are counted one by one. */
static void check_centred_window(uint32_t accepted)
{
    davar_glr_window_t window;
    const uint32_t now = state.now.at;
    const uint32_t age = davar_glr_age_of(&state, accepted);
    if (!davar_glr_centred(&state, &config, age, &window)) {
        return;
    }
    const uint32_t newest = (now > GLR_RECENT) ? (now - GLR_RECENT) : 0U;
    const uint32_t from = (window.begin > newest) ? window.begin : newest;
    TEST_ASSERT_TRUE((int32_t)(window.end - window.begin) > 0);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(now, window.end);
    TEST_ASSERT_TRUE((now - window.begin) >= age);
    TEST_ASSERT_TRUE((now - window.end) < age);
    TEST_ASSERT_EQUAL_UINT32(heard_between(window.end, now), window.after);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(heard_between(window.begin, window.end), window.blocks);
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(heard_between(from, window.end), window.blocks);
}

/* Steps and gaps next to each other: where gaps leave few of many blocks, the records as old as the
 * window contain none of it. */
static void check_windows_beside_gaps(uint32_t block, uint32_t gaps)
{
    static const double levels[] = {20.0, 100.0, 20.0, 60.0};
    davar_glr_wish_t wish = usual;
    wish.block = block;
    wish.longest = 600U * block;
    davar_glr_start(&config, &wish);
    davar_glr_reset(&state);
    while (state.now.at < (STEPS - 4U)) {
        const uint32_t before = state.now.at;
        if ((random_next(&rng) % 100U) < gaps) {
            davar_glr_skip(&state, &config, &event);
            event.dropped = event.resolved;
        } else {
            push_noise(levels[(before / 150U) % 4U]);
        }
        for (uint32_t i = 0U; i < event.resolved; i++) {
            heard[before + i] = (i >= event.dropped);
        }
        check_centred_window(config.half + 1U + (before % 4U));
    }
}

static void test_windows_near_gaps(void)
{
    static const uint32_t blocks[] = {5U, 10U, 25U};
    for (uint32_t i = 0U; i < 3U; i++) {
        for (uint32_t gaps = 5U; gaps < 100U; gaps += 15U) {
            check_windows_beside_gaps(blocks[i], gaps);
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_shock_is_dropped_and_changes_nothing);
    RUN_TEST(test_wide_samples_decide_as_narrow_ones_whatever_their_size);
    RUN_TEST(test_a_trailing_window_may_have_only_gaps);
    RUN_TEST(test_the_oldest_cut_that_is_remembered_bounds_the_window);
    RUN_TEST(test_a_cut_near_a_gap_counts);
    RUN_TEST(test_a_cut_that_came_late_counts);
    RUN_TEST(test_windows_near_gaps);
    return UNITY_END();
}
