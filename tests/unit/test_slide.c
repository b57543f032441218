/* davar tests - the window moves by one sample: both methods (octaves, which share taps and have
 * hand-written instructions on some targets, and any cluster sizes) compared with the definition of
 * D and of the sum (1.1). */
#include "number/q15.inc"

#include "core/window.h"
#include "random.h"
#include "unity.h"

#include "core/allan.inc"

#include "core/slide.inc"

#define TAUS 6U
#define RING 300U
#define HISTORY 700U
#define TRIALS 24U

static random_t source;
static int16_t history[HISTORY]; /* all samples, oldest first */
static int16_t ring_memory[2U * RING];
static tau_t tau[TAUS];
static uint32_t sizes[TAUS];
static stages_t stages;
static uint32_t lag;
static uint32_t length;

void setUp(void)
{
    source = random_seeded(20U);
}

void tearDown(void) {}

static uint32_t below(uint32_t bound)
{
    return (uint32_t)(random_next(&source) % bound);
}

/* The difference of the span of 2 m samples that begins at position `first`. */
static int32_t difference_at(uint32_t first, uint32_t m)
{
    int32_t difference = 0;
    for (uint32_t i = 0U; i < m; i++) {
        difference += history[first + m + i] - history[first + i];
    }
    return difference;
}

/* The expected state of each tau after `received` samples, for the window given by lag and
 * length. */
static tau_t expected_tau(uint32_t received, uint32_t m)
{
    const uint32_t end = received - lag;
    const uint32_t start = end - length;
    tau_t expected = {0U, difference_at(end - (2U * m), m), difference_at(start, m)};
    for (uint32_t first = start; (first + (2U * m)) <= end; first++) {
        const int64_t difference = difference_at(first, m);
        expected.sum += (uint64_t)(difference * difference);
    }
    return expected;
}

static void choose_sizes(bool octaves)
{
    uint32_t m = 1U + below(3U);
    stages.allan.count = (uint8_t)(1U + below(TAUS));
    for (uint32_t t = 0U; t < stages.allan.count; t++) {
        sizes[t] = m;
        m = octaves ? (2U * m) : (m + 1U + below(12U));
    }
    stages.allan.m = sizes;
    stages.allan.tau = tau;
    stages.allan.octaves = octaves;
}

static int16_t any_sample(bool extreme)
{
    if (extreme) {
        return (below(2U) == 0U) ? INT16_MIN : INT16_MAX;
    }
    return (int16_t)((int32_t)below(65536U) - 32768);
}

/* A window at least as long as the longest span, a ring as long as both edges' taps need, or
 * longer. */
static void choose_window(uint32_t span)
{
    const bool extreme = (below(4U) == 0U);
    length = span + below(40U);
    lag = below(30U);
    const uint32_t reach = lag + ((length > span) ? length : span);
    stages.ring.sample = ring_memory;
    stages.ring.capacity = reach + 1U + below(RING - reach);
    stages.ring.reach = span;
    stages.ring.repeated = span;
    for (uint32_t i = 0U; i < HISTORY; i++) {
        history[i] = any_sample(extreme);
    }
}

/* Sets the ring to its state after `received` samples. */
static void fill_ring(uint32_t received)
{
    stages.ring.next = below(stages.ring.capacity);
    for (uint32_t i = received - stages.ring.capacity; i < received; i++) {
        ring_put(&stages.ring, history[i]);
    }
    for (uint32_t t = 0U; t < stages.allan.count; t++) {
        tau[t] = expected_tau(received, sizes[t]);
    }
}

static void slide_one(uint32_t received)
{
    ring_put(&stages.ring, history[received]);
    slide(&stages.allan, ring_leading(&stages.ring, lag + 1U),
          ring_trailing(&stages.ring, lag + 1U + length));
}

static void check_taus(uint32_t received)
{
    for (uint32_t t = 0U; t < stages.allan.count; t++) {
        const tau_t expected = expected_tau(received, sizes[t]);
        TEST_ASSERT_EQUAL_INT32(expected.head, tau[t].head);
        TEST_ASSERT_EQUAL_INT32(expected.tail, tau[t].tail);
        TEST_ASSERT_EQUAL_HEX64(expected.sum, tau[t].sum);
    }
}

/* Once round the ring, so that every tap passes its end at both edges. Brute force runs only for
 * some samples. */
static void slide_round(bool octaves)
{
    choose_sizes(octaves);
    choose_window(2U * sizes[stages.allan.count - 1U]);
    const uint32_t start = RING + 1U;
    fill_ring(start);
    for (uint32_t i = 0U; i <= stages.ring.capacity; i++) {
        slide_one(start + i);
        if ((i % 64U) == (length % 64U)) {
            check_taus(start + i + 1U);
        }
    }
    check_taus(start + stages.ring.capacity + 1U);
}

static void test_octaves_are_the_definition(void)
{
    for (uint32_t i = 0U; i < TRIALS; i++) {
        slide_round(true);
    }
}

static void test_any_cluster_sizes_are_the_definition(void)
{
    for (uint32_t i = 0U; i < TRIALS; i++) {
        slide_round(false);
    }
}

/* A window of full scale that changes its sign once: the largest D of these cluster sizes. */
static void test_the_largest_differences_fit(void)
{
    static const int16_t ends[2] = {INT16_MIN, INT16_MAX};
    choose_sizes(true);
    choose_window(2U * sizes[stages.allan.count - 1U]);
    for (uint32_t i = 0U; i < HISTORY; i++) {
        history[i] = ends[(i / sizes[stages.allan.count - 1U]) % 2U];
    }
    fill_ring(RING + 1U);
    for (uint32_t i = 0U; i < 128U; i++) {
        slide_one(RING + 1U + i);
    }
    check_taus(RING + 1U + 128U);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_octaves_are_the_definition);
    RUN_TEST(test_any_cluster_sizes_are_the_definition);
    RUN_TEST(test_the_largest_differences_fit);
    return UNITY_END();
}
