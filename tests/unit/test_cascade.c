/* davar tests - the sums of the cascade equal brute force over the samples, for every number type,
 * cluster size and memory, with gaps, wrapping sums and extreme samples. */
#include "davar/cascade.h"
#include "number/real.h"
#include "random.h"
#include "stage.h"
#include "unity.h"

#include <string.h>

#ifndef SAMPLES
#define SAMPLES 2000000U
#endif

#define BLOCK_MAX 700U
#define GAPS_MAX 4096U

typedef enum { NOISE, SQUARE, EXTREMES, WALK, KINDS } kind_t;

typedef struct {
    kind_t kind;
    uint32_t gap_every; /* mean distance of gaps in samples; 0: none */
    uint64_t start;     /* of the running sum, so that it wraps */
    uint32_t first_hop; /* number of the hop at the start, so that it wraps */
} stream_t;

static davar_cascade_config_t config;
static davar_cascade_t cascade;
static davar_result_t result;
static uint64_t memory[DAVAR_CASCADE_MEMORY(Q31, DAVAR_CASCADE_TAUS_MAX) / 8U];
static int64_t phase[SAMPLES + 1U]; /* running sum of the samples */
static uint32_t gap[GAPS_MAX];
static uint32_t gap_count;

void setUp(void)
{
    config = (davar_cascade_config_t){.rate_hz = 100.0,
                                      .unit_per_count = 1.0,
                                      .full_scale = 1.0,
                                      .shortest = 64U,
                                      .tau_count = 12U,
                                      .clusters = 32U};
    gap_count = 0U;
}

void tearDown(void) {}

/* --- samples ---------------------------------------------------------------------------------- */

static int32_t limited(double value, int32_t highest)
{
    const double low = -(double)highest - 1.0;
    const double below = (value < (double)highest) ? value : (double)highest;
    return (int32_t)((below > low) ? below : low);
}

static int32_t sample_of(kind_t kind, random_t *random, int32_t highest, uint32_t i, double *walk)
{
    switch (kind) {
    case SQUARE: /* the largest difference of the longest cluster size */
        return (((i / (config.shortest << (config.tau_count - 1U))) % 2U) != 0U) ? highest
                                                                                 : (-highest - 1);
    case EXTREMES:
        return ((random_next(random) & 1U) != 0U) ? highest : (-highest - 1);
    case WALK:
        *walk += 0.001 * (double)highest * random_gauss(random);
        return limited(*walk, highest);
    case NOISE:
    case KINDS:
    default:
        return limited((0.001 * (double)highest * random_gauss(random)) + 7.0, highest);
    }
}

/* --- brute force ------------------------------------------------------------------------------ */

/* Is a gap inside the span (from, to)? Gaps are ascending; *next is the first one at or after the
 * `to` of the previous call. */
static bool spans_gap(uint32_t from, uint32_t to, uint32_t *next)
{
    while ((*next < gap_count) && (gap[*next] < to)) {
        (*next)++;
    }
    return (*next > 0U) && (gap[*next - 1U] > from);
}

/* The sum of squares at size t after `count` samples (11.1) to (11.5), from the definition. */
static davar_u128_t brute_sum(uint32_t t, uint32_t count, uint32_t *differences)
{
    const uint32_t m = config.shortest << t;
    const uint32_t hop = m / (4U << (t % CASCADE_TAUS));
    const uint32_t generation = config.clusters * (m / hop);
    const uint32_t hops = count / hop;
    const uint32_t now = (hops > 0U) ? ((hops - 1U) / generation) : 0U;
    const uint32_t oldest = (now > 0U) ? (((now - 1U) * generation) + 1U) : 1U;
    davar_u128_t sum = {0U, 0U};
    uint32_t next = 0U;
    *differences = 0U;
    for (uint32_t e = oldest; e <= hops; e++) {
        const uint64_t end = (uint64_t)e * hop;
        if ((end >= (2U * (uint64_t)m)) &&
            !spans_gap((uint32_t)end - (2U * m), (uint32_t)end, &next)) {
            const int64_t d = phase[end] - (2 * phase[end - m]) + phase[end - (2U * (uint64_t)m)];
            sum = davar_u128_add(sum, davar_multiply_i64(d, d));
            (*differences)++;
        }
    }
    return sum;
}

static void assert_equals_brute_force(uint32_t count, const char *what)
{
    davar_cascade_flush(&cascade);
    const cascade_stage_t *const stages = cascade.stages;
    result.tau_count = 0U;
    (void)davar_cascade_append(&cascade, &result);
    for (uint32_t t = 0U; t < config.tau_count; t++) {
        uint32_t expected;
        const davar_u128_t sum = brute_sum(t, count, &expected);
        const cascade_stage_t *const stage = &stages[t / CASCADE_TAUS];
        const size_t first = 2U * (size_t)(t % CASCADE_TAUS);
        const davar_u128_t all = davar_u128_add(stage->squares[first], stage->squares[first + 1U]);
        TEST_ASSERT_EQUAL_UINT32_MESSAGE(expected, result.tau[t].differences, what);
        TEST_ASSERT_EQUAL_HEX64_MESSAGE(sum.low, all.low, what);
        TEST_ASSERT_EQUAL_HEX64_MESSAGE(sum.high, all.high, what);
        TEST_ASSERT_EQUAL_UINT32(config.shortest << t, result.tau[t].m);
        if (expected > 0U) {
            const double m = (double)result.tau[t].m;
            const double adev = sqrt(davar_double_of_u128(sum) / (2.0 * m * m * (double)expected));
            TEST_ASSERT_DOUBLE_WITHIN(1e-14 * adev, adev,
                                      result.tau[t].adev / config.unit_per_count);
        } else {
            TEST_ASSERT_TRUE(isnan(result.tau[t].adev));
        }
    }
}

/* --- a stream --------------------------------------------------------------------------------- */

typedef enum { Q15, Q31, F32 } type_t;

static void init(type_t type)
{
    davar_cascade_status_t status = DAVAR_CASCADE_OK;
    switch (type) {
    case Q15:
        status = davar_cascade_init_q15(&cascade, &config, memory, sizeof memory);
        break;
    case Q31:
        status = davar_cascade_init_q31(&cascade, &config, memory, sizeof memory);
        break;
    case F32:
    default:
        status = davar_cascade_init_f32(&cascade, &config, memory, sizeof memory);
        config.unit_per_count = 1.0 / (double)cascade.counts_per_unit;
        break;
    }
    TEST_ASSERT_EQUAL(DAVAR_CASCADE_OK, status);
}

/* As if the stream had begun long ago: with a running sum and hop numbers that will wrap. */
static void begin_late(const stream_t *stream, type_t type)
{
    cascade_stage_t *const stages = cascade.stages;
    cascade.sum = stream->start;
    for (uint32_t k = 0U; k < cascade.stage_count; k++) {
        stages[k].hop = stream->first_hop;
        stages[k].low[0] = (uint32_t)stream->start;
        if (type == Q15) {
            ((uint16_t *)cascade.tops)[(size_t)k * CASCADE_HOPS] = (uint16_t)(stream->start >> 32U);
        } else {
            ((uint32_t *)cascade.tops)[(size_t)k * CASCADE_HOPS] = (uint32_t)(stream->start >> 32U);
        }
    }
}

static void push(type_t type, const int32_t *samples, uint32_t count)
{
    static int16_t narrow[BLOCK_MAX];
    static float rates[BLOCK_MAX];
    for (uint32_t i = 0U; i < count; i++) {
        narrow[i] = (int16_t)samples[i];
        rates[i] = (float)((double)samples[i] * config.unit_per_count);
    }
    switch (type) {
    case Q15:
        davar_cascade_push_q15(&cascade, narrow, count);
        break;
    case Q31:
        davar_cascade_push_q31(&cascade, samples, count);
        break;
    case F32:
    default:
        davar_cascade_push_f32(&cascade, rates, count);
        break;
    }
}

static int32_t highest_of(type_t type)
{
    return (type == Q15) ? INT16_MAX : ((type == Q31) ? INT32_MAX : ((1 << 24) - 1));
}

/* Gaps at random places, many of them at a hop or a sample beside it, some of them twice. */
static bool gap_is_due(const stream_t *stream, random_t *random, uint32_t i)
{
    if ((stream->gap_every == 0U) || (gap_count == GAPS_MAX)) {
        return false;
    }
    const uint32_t hop = config.shortest / 4U;
    const uint32_t beside = (i + 1U) % hop;
    const uint32_t every =
        (beside <= 2U) ? (1U + (stream->gap_every / (hop / 2U))) : (2U * stream->gap_every);
    return (random_next(random) % every) == 0U;
}

/* Returns the number of samples. */
static void run(const stream_t *stream, type_t type, uint32_t count, uint32_t seed)
{
    static int32_t block[BLOCK_MAX];
    random_t random = random_seeded(seed);
    double walk = 0.0;
    uint32_t length = 0U;
    gap_count = 0U;
    init(type);
    begin_late(stream, type);
    phase[0] = 0;
    for (uint32_t i = 0U; i < count; i++) {
        if (gap_is_due(stream, &random, i)) {
            push(type, block, length);
            length = 0U;
            davar_cascade_gap(&cascade, 3U);
            gap[gap_count++] = i;
        }
        block[length] = sample_of(stream->kind, &random, highest_of(type), i, &walk);
        phase[i + 1U] = phase[i] + block[length];
        length++;
        if ((length == BLOCK_MAX) || ((random_next(&random) % 100U) == 0U)) {
            push(type, block, length);
            length = 0U;
        }
    }
    push(type, block, length);
    assert_equals_brute_force(count, "sums");
    TEST_ASSERT_EQUAL_UINT32(gap_count, cascade.health.gaps);
}

static void run_all(type_t type, uint32_t count, uint32_t gap_every)
{
    for (int kind = 0; kind < (int)KINDS; kind++) {
        const stream_t stream = {(kind_t)kind, gap_every, 0U, 0U};
        run(&stream, type, count, (uint32_t)kind + 1U);
    }
}

static void test_sums_of_every_type_and_of_gaps_from_none_to_dense(void)
{
    static const uint32_t every[] = {100000U, 5000U, 700U, 100U};
    for (type_t type = Q15; type <= F32; type++) {
        const uint32_t count = (type == F32) ? (SAMPLES / 4U) : SAMPLES;
        run_all(type, count, 0U);
        for (size_t i = 0U; i < (sizeof every / sizeof every[0]); i++) {
            run_all(type, count / 8U, every[i]);
        }
    }
}

static void test_every_memory_cluster_size_and_number_of_sizes(void)
{
    static const uint16_t clusters[] = {4U, 8U, 64U, 2048U};
    static const uint32_t shortest[] = {64U, 68U, 100U, 256U, 4096U};
    const stream_t stream = {NOISE, 20000U, 0U, 0U};
    for (size_t c = 0U; c < (sizeof clusters / sizeof clusters[0]); c++) {
        for (size_t s = 0U; s < (sizeof shortest / sizeof shortest[0]); s++) {
            config.clusters = clusters[c];
            config.shortest = shortest[s];
            config.tau_count = (uint8_t)(1U + ((7U * c) + s) % 14U);
            run(&stream, Q15, SAMPLES / 16U, (uint32_t)(100U + (10U * c) + s));
            run(&stream, Q31, SAMPLES / 16U, (uint32_t)(200U + (10U * c) + s));
        }
    }
}

static void test_running_sum_and_hop_numbers_wrap(void)
{
    const uint64_t starts[] = {(UINT64_C(1) << 47U) - 1000U, (UINT64_C(1) << 48U) - 1000U,
                               (UINT64_C(1) << 63U) - 1000U, UINT64_MAX - 1000U};
    config.clusters = 4U;
    for (size_t i = 0U; i < (sizeof starts / sizeof starts[0]); i++) {
        const stream_t stream = {WALK, 30000U, starts[i], 0U - 8192U};
        run(&stream, Q15, SAMPLES / 8U, 31U);
        run(&stream, Q31, SAMPLES / 8U, 32U);
    }
}

/* The number of hops since a gap stays at its largest value. */
static void test_hops_since_a_gap_saturate(void)
{
    const stream_t stream = {NOISE, 0U, 0U, 0U};
    config.tau_count = 6U; /* spans of up to 4096 samples */
    run(&stream, Q15, 20000U, 3U);
    cascade.age = UINT32_MAX - 16U;
    for (uint32_t i = 20000U; i < 30000U; i++) {
        const int32_t sample = (int32_t)(i % 91U);
        phase[i + 1U] = phase[i] + sample;
        push(Q15, &sample, 1U);
    }
    assert_equals_brute_force(30000U, "saturated");
}

/* --- differences of any size ------------------------------------------------------------------ */

/* The running sums of stage 0 are set to random values, so that differences fill their whole range,
 * as after weeks at full scale. */
static void check_differences(type_t type, uint32_t bits, random_t *random)
{
    static int32_t zeros[16];
    uint64_t sums[CASCADE_HOPS + 1U];
    init(type);
    cascade_stage_t *const stage = cascade.stages;
    for (uint32_t i = 0U; i <= CASCADE_HOPS; i++) {
        sums[i] = random_next(random) >> (random_next(random) % 64U);
        stage->low[i % CASCADE_HOPS] = (uint32_t)sums[i];
        if (type == Q15) {
            ((uint16_t *)cascade.tops)[i % CASCADE_HOPS] = (uint16_t)(sums[i] >> 32U);
        } else {
            ((uint32_t *)cascade.tops)[i % CASCADE_HOPS] = (uint32_t)(sums[i] >> 32U);
        }
    }
    stage->hop = CASCADE_HOPS; /* slot 0 is that hop, the others are the hops 1, 2 .. before */
    cascade.age = CASCADE_HOPS;
    cascade.sum = random_next(random);
    push(type, zeros, 16U);
    davar_cascade_flush(&cascade);
    for (uint32_t t = 0U; t < CASCADE_TAUS; t++) {
        const uint32_t clusters = 4U << t;
        const uint32_t newest = CASCADE_HOPS + 1U;
        const uint64_t d =
            (cascade.sum - (2U * sums[newest - clusters]) + sums[newest - (2U * clusters)])
            << (64U - bits);
        const int64_t difference = (bits == 64U) ? (int64_t)d : ((int64_t)d / 65536);
        const davar_u128_t square = davar_multiply_i64(difference, difference);
        const uint32_t now =
            (2U * t) + ((((CASCADE_HOPS / (clusters * config.clusters)) % 2U) != 0U) ? 1U : 0U);
        TEST_ASSERT_EQUAL_HEX64(square.low, stage->squares[now].low);
        TEST_ASSERT_EQUAL_HEX64(square.high, stage->squares[now].high);
        TEST_ASSERT_EQUAL_UINT16(1U, stage->count[now]);
    }
}

static void test_differences_of_any_size(void)
{
    random_t random = random_seeded(11U);
    for (uint32_t i = 0U; i < 20000U; i++) {
        check_differences(Q15, 48U, &random);
        check_differences(Q31, 64U, &random);
    }
}

/* --- blocks ----------------------------------------------------------------------------------- */

/* A flush at any sample changes neither what follows nor the grid of hops. */
static void test_flushes_change_nothing_that_follows(void)
{
    const stream_t stream = {NOISE, 0U, 0U, 0U};
    random_t random = random_seeded(9U);
    double walk = 0.0;
    init(Q15);
    phase[0] = 0;
    for (uint32_t i = 0U; i < 50000U; i++) {
        const int32_t sample = sample_of(stream.kind, &random, INT16_MAX, i, &walk);
        phase[i + 1U] = phase[i] + sample;
        push(Q15, &sample, 1U);
        if ((random_next(&random) % 3U) == 0U) {
            davar_cascade_flush(&cascade);
        }
        if (((i + 1U) % 9973U) == 0U) {
            assert_equals_brute_force(i + 1U, "flushed");
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_sums_of_every_type_and_of_gaps_from_none_to_dense);
    RUN_TEST(test_every_memory_cluster_size_and_number_of_sizes);
    RUN_TEST(test_running_sum_and_hop_numbers_wrap);
    RUN_TEST(test_hops_since_a_gap_saturate);
    RUN_TEST(test_differences_of_any_size);
    RUN_TEST(test_flushes_change_nothing_that_follows);
    return UNITY_END();
}
