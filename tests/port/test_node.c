/* davar tests - the node loop with a port that stalls and fails: results are complete and in order,
 * whatever the port does. */
#include "davar/cascade.h"
#include "davar/fit.h"
#include "davar_law_id.h"
#include "davar_node.h"
#include "random.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define TAUS 2U
#define CHANNELS ((size_t)3U)
#define SAMPLES 330U
#define FIRST 7U /* epoch: the shortest window has 8 samples */
#define EPOCHS (SAMPLES - FIRST)
#define RESULTS_MAX (CHANNELS * SAMPLES)
#define STEPS_MAX 100000U

/* The behaviour of the port; all 0 is a port that always works. */
typedef struct {
    size_t block;        /* longest block */
    uint32_t read_again; /* period, in reads, of "nothing now"; 0: never */
    uint32_t read_fault; /* period, in reads, of a fault */
    uint32_t send_again; /* period, in sends, of "no room" */
    uint32_t send_fault; /* this send (from 1) fails */
    size_t gap_at;       /* samples are missing before this one; 0: none */
} script_t;

typedef struct {
    size_t channel;
    davar_result_t result;
} sent_t;

/* A port in memory. */
typedef struct {
    script_t script;
    size_t position;
    uint32_t reads;
    uint32_t sends;
    uint32_t time_us;
    uint32_t faults[2];
    uint32_t reads_after_end;
    bool ended;
    davar_port_samples_t samples[CHANNELS];
    sent_t sent[RESULTS_MAX];
    size_t sent_count;
} fake_t;

static const uint32_t taus[TAUS] = {1U, 2U};
static int16_t first[SAMPLES];
static int32_t second[SAMPLES];
static float third[SAMPLES];
static uint64_t memory[CHANNELS][1024];
static davar_t instance[CHANNELS];
static davar_node_channel_t channel[CHANNELS];
static davar_config_t config;
static davar_config_t wide; /* the same for q31 and f32 */
static davar_node_t node;
static fake_t fake;
static fake_t plain; /* the run for comparison */
static davar_port_t port;

static bool every(uint32_t period, uint32_t count)
{
    return (period > 0U) && ((count % period) == 0U);
}

static size_t block_length(const fake_t *self)
{
    size_t count = SAMPLES - self->position;
    if ((self->script.block > 0U) && (count > self->script.block)) {
        count = self->script.block;
    }
    const bool gap_inside =
        (self->position < self->script.gap_at) && (self->position + count > self->script.gap_at);
    return gap_inside ? self->script.gap_at - self->position : count;
}

static davar_port_read_t fake_read(void *context, davar_port_block_t *block)
{
    fake_t *self = context;
    self->reads++;
    self->reads_after_end += self->ended ? 1U : 0U;
    if (every(self->script.read_fault, self->reads)) {
        return DAVAR_PORT_READ_FAULT;
    }
    if (every(self->script.read_again, self->reads)) {
        return DAVAR_PORT_READ_AGAIN;
    }
    self->ended = (self->position == SAMPLES);
    if (self->ended) {
        return DAVAR_PORT_READ_END;
    }
    self->samples[0].q15 = first + self->position;
    self->samples[1].q31 = second + self->position;
    self->samples[2].f32 = third + self->position;
    block->samples = self->samples;
    block->count = block_length(self);
    block->missing =
        ((self->script.gap_at > 0U) && (self->position == self->script.gap_at)) ? 7U : 0U;
    self->position += block->count;
    return DAVAR_PORT_READ_BLOCK;
}

static davar_port_send_t fake_send(void *context, size_t c, const davar_result_t *result)
{
    fake_t *self = context;
    self->sends++;
    if (self->sends == self->script.send_fault) {
        return DAVAR_PORT_SEND_FAULT;
    }
    if (every(self->script.send_again, self->sends)) {
        return DAVAR_PORT_SEND_AGAIN;
    }
    TEST_ASSERT_LESS_THAN_size_t(RESULTS_MAX, self->sent_count);
    self->sent[self->sent_count].channel = c;
    self->sent[self->sent_count].result = *result;
    self->sent_count++;
    return DAVAR_PORT_SEND_DONE;
}

/* Each call of the clock takes 3 us, and the counter wraps soon. */
static uint32_t fake_now_us(void *context)
{
    fake_t *self = context;
    self->time_us += 3U;
    return self->time_us;
}

static void fake_fault(void *context, davar_port_fault_t what)
{
    fake_t *self = context;
    self->faults[what]++;
}

/* Starts the node with instances that are started already. */
static void restart(size_t channels, script_t script)
{
    for (size_t c = 0; c < CHANNELS; c++) {
        channel[c].davar = &instance[c];
    }
    channel[0].number = DAVAR_PORT_Q15;
    channel[1].number = DAVAR_PORT_Q31;
    channel[2].number = DAVAR_PORT_F32;
    memset(&fake, 0, sizeof fake);
    fake.script = script;
    fake.time_us = UINT32_MAX - 10U;
    davar_node_init(&node, channel, channels, &port);
}

static void start(size_t channels, script_t script)
{
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&instance[0], &config, memory[0], sizeof memory[0]));
    wide = config;
    davar_retype(&wide, true);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q31(&instance[1], &wide, memory[1], sizeof memory[1]));
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_f32(&instance[2], &wide, memory[2], sizeof memory[2]));
    restart(channels, script);
}

/* Steps until the stream is done, past all faults. */
static void run(void)
{
    davar_node_state_t state = DAVAR_NODE_RUNNING;
    for (uint32_t i = 0U; (state != DAVAR_NODE_DONE) && (i < STEPS_MAX); i++) {
        state = davar_node_step(&node);
    }
    TEST_ASSERT_EQUAL(DAVAR_NODE_DONE, state);
}

static void run_script(script_t script)
{
    start(CHANNELS, script);
    run();
}

static void run_plain(void)
{
    const script_t works = {0};
    run_script(works);
    plain = fake;
}

static void assert_same_results(const sent_t *expected, const sent_t *got, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        TEST_ASSERT_EQUAL_size_t(expected[i].channel, got[i].channel);
        TEST_ASSERT_EQUAL_UINT64(expected[i].result.epoch, got[i].result.epoch);
        TEST_ASSERT_EQUAL_UINT32(expected[i].result.window_samples, got[i].result.window_samples);
        TEST_ASSERT_EQUAL_MEMORY(&expected[i].result.tau[0].adev, &got[i].result.tau[0].adev,
                                 sizeof(double));
        TEST_ASSERT_EQUAL_MEMORY(&expected[i].result.kurtosis, &got[i].result.kurtosis,
                                 sizeof(double));
    }
}

void setUp(void)
{
    random_t random = random_seeded(7U);
    for (size_t i = 0; i < SAMPLES; i++) {
        first[i] = (int16_t)(random_next(&random) % 201U);
        second[i] = first[i];
        third[i] = (float)first[i];
    }
    config = davar_default_config;
    config.rate_hz = 10.0;
    config.unit_per_count = 1.0;
    config.full_scale = 1024.0;
    config.window.longest = 12U;
    config.window.shortest = 8U;
    config.moments.segment = 2U;
    config.taus = taus;
    config.tau_count = TAUS;
    const davar_port_t works = {&fake, fake_read, fake_send, fake_now_us, fake_fault};
    port = works;
}

void tearDown(void) {}

static void test_every_sample_gets_a_result_in_every_channel_epoch_by_epoch(void)
{
    run_plain();
    TEST_ASSERT_EQUAL_size_t(CHANNELS * EPOCHS, fake.sent_count);
    for (size_t i = 0; i < fake.sent_count; i++) {
        const double adev = fake.sent[i].result.tau[1].adev;
        TEST_ASSERT_EQUAL_size_t(i % CHANNELS, fake.sent[i].channel);
        TEST_ASSERT_EQUAL_UINT64(FIRST + i / CHANNELS, fake.sent[i].result.epoch);
        TEST_ASSERT_DOUBLE_WITHIN(((i % CHANNELS) == 2U) ? 1e-6 : 0.0, /* floats are rounded */
                                  fake.sent[i - i % CHANNELS].result.tau[1].adev, adev);
    }
    TEST_ASSERT_EQUAL(DAVAR_NODE_DONE, davar_node_step(&node));
    TEST_ASSERT_EQUAL(DAVAR_NODE_DONE, davar_node_step(&node));
    TEST_ASSERT_EQUAL_size_t(plain.sent_count, fake.sent_count);
    TEST_ASSERT_EQUAL_UINT32(0U, fake.reads_after_end);
}

static void test_results_do_not_depend_on_blocks_and_on_a_port_that_fails(void)
{
    static const script_t scripts[] = {
        {.block = 1U},
        {.block = 3U},
        {.block = 40U},
        {.block = 64U, .read_again = 7U},
        {.block = 4U, .read_again = 2U, .send_again = 3U},
        {.block = 4U, .read_fault = 5U},
        {.block = 16U, .read_fault = 2U, .send_again = 2U},
    };
    run_plain();
    for (size_t i = 0U; i < sizeof scripts / sizeof scripts[0]; i++) {
        const script_t *const script = &scripts[i];
        run_script(*script);
        TEST_ASSERT_EQUAL_size_t(plain.sent_count, fake.sent_count);
        assert_same_results(plain.sent, fake.sent, plain.sent_count);
        TEST_ASSERT_EQUAL_UINT32((SAMPLES + script->block - 1U) / script->block,
                                 node.counters.blocks);
        TEST_ASSERT_EQUAL_UINT64(SAMPLES, node.counters.samples);
        TEST_ASSERT_EQUAL_UINT64(CHANNELS * EPOCHS, node.counters.results);
        TEST_ASSERT_EQUAL_UINT32(3U, node.counters.longest_step_us);
        TEST_ASSERT_EQUAL_UINT32((script->send_again > 0U) ? (fake.sends / script->send_again) : 0U,
                                 node.counters.send_retries);
        const uint32_t faults = (script->read_fault > 0U) ? (fake.reads / script->read_fault) : 0U;
        TEST_ASSERT_EQUAL_UINT32(faults, node.counters.read_faults);
        TEST_ASSERT_EQUAL_UINT32(faults, fake.faults[DAVAR_PORT_FAULT_READ]);
        TEST_ASSERT_EQUAL_UINT32(0U, fake.faults[DAVAR_PORT_FAULT_SEND]);
    }
    const script_t fails = {.read_fault = 1U};
    start(1U, fails);
    TEST_ASSERT_EQUAL(DAVAR_NODE_FAULT, davar_node_step(&node));
}

static void test_a_busy_bus_stops_reading_and_keeps_the_result(void)
{
    const script_t script = {.send_again = 1U};
    start(1U, script);
    TEST_ASSERT_EQUAL(DAVAR_NODE_RUNNING, davar_node_step(&node)); /* reads */
    TEST_ASSERT_EQUAL(DAVAR_NODE_IDLE, davar_node_step(&node)); /* pushes, sends the first result */
    for (uint32_t i = 0U; i < 10U; i++) {
        TEST_ASSERT_EQUAL(DAVAR_NODE_IDLE, davar_node_step(&node));
    }
    TEST_ASSERT_EQUAL_UINT32(1U, fake.reads);
    TEST_ASSERT_EQUAL_UINT32(11U, fake.sends);
    fake.script.send_again = 0U;
    run();
    TEST_ASSERT_EQUAL_size_t(EPOCHS, fake.sent_count);
    TEST_ASSERT_EQUAL_UINT64(FIRST, fake.sent[0].result.epoch);
}

static void test_a_send_fault_loses_that_result_only(void)
{
    run_plain();
    const script_t script = {.send_fault = 5U};
    run_script(script);
    TEST_ASSERT_EQUAL_UINT32(1U, node.counters.send_faults);
    TEST_ASSERT_EQUAL_UINT32(1U, fake.faults[DAVAR_PORT_FAULT_SEND]);
    TEST_ASSERT_EQUAL_size_t(plain.sent_count - 1U, fake.sent_count);
    assert_same_results(plain.sent, fake.sent, 4U);
    assert_same_results(plain.sent + 5U, fake.sent + 4U, plain.sent_count - 5U);
}

static void test_a_gap_reaches_every_channel(void)
{
    const script_t script = {.block = 64U, .gap_at = 40U};
    run_script(script);
    for (size_t c = 0; c < CHANNELS; c++) {
        TEST_ASSERT_EQUAL_UINT32(1U, davar_health(&instance[c]).gaps);
        TEST_ASSERT_EQUAL_UINT32(7U, davar_health(&instance[c]).missing);
    }
    TEST_ASSERT_EQUAL_UINT32(0U, fake.sent[CHANNELS * (39U - FIRST)].result.gaps_in_window);
    TEST_ASSERT_EQUAL_UINT32(1U, fake.sent[CHANNELS * (40U - FIRST)].result.gaps_in_window);
}

/* A float channel with its own lost samples falls behind. Each channel still has all its results in
 * order. */
static void test_a_channel_out_of_step_does_not_disturb_the_others(void)
{
    run_plain();
    third[30] = INFINITY;
    const script_t script = {.block = 16U};
    run_script(script);
    uint64_t next[CHANNELS] = {FIRST, FIRST, FIRST};
    for (size_t i = 0; i < fake.sent_count; i++) {
        const size_t c = fake.sent[i].channel;
        TEST_ASSERT_EQUAL_UINT64(next[c], fake.sent[i].result.epoch);
        next[c]++;
    }
    TEST_ASSERT_EQUAL_UINT64(SAMPLES, next[0]);
    TEST_ASSERT_EQUAL_UINT64(SAMPLES, next[1]);
    TEST_ASSERT_EQUAL_UINT64(SAMPLES - 1U, next[2]);
}

static void test_a_grid_ends_properly(void)
{
    config.stride = 4U;
    config.engine = &davar_engine_grid_q15;
    run_plain();
    TEST_ASSERT_EQUAL_UINT64(7U, fake.sent[0].result.epoch);
    TEST_ASSERT_EQUAL_UINT64(SAMPLES - 3U, fake.sent[fake.sent_count - 1U].result.epoch);
}

static void test_a_port_without_clock_and_fault_works(void)
{
    port.now_us = NULL;
    port.fault = NULL;
    const script_t script = {.read_fault = 2U, .send_fault = 2U};
    run_script(script);
    TEST_ASSERT_EQUAL_UINT32(0U, node.counters.longest_step_us);
    TEST_ASSERT_EQUAL_UINT32(1U, node.counters.send_faults);
}

static void test_a_plan_adds_the_fit(void)
{
    static davar_plan_t plan;
    const script_t works = {0};
    run_plain();
    TEST_ASSERT_TRUE(isnan(plain.sent[0].result.tau[0].edf));
    start(CHANNELS, works);
    davar_plan_init(&plan, taus, TAUS);
    channel[0].plan = &plan;
    run();
    channel[0].plan = NULL;
    TEST_ASSERT_EQUAL_size_t(plain.sent_count, fake.sent_count);
    for (size_t i = 0; i < fake.sent_count; i++) {
        TEST_ASSERT_EQUAL(fake.sent[i].channel == 0U, !isnan(fake.sent[i].result.tau[0].edf));
    }
    assert_same_results(plain.sent, fake.sent, plain.sent_count);
}

/* Law glr has results after the end: those of the samples in its queue, channel by channel. */
static void test_the_results_of_a_flush_are_sent_epoch_by_epoch(void)
{
    const script_t works = {.block = 7U};
    config.law = &davar_law_glr_q15;
    config.window.longest = 80U;
    config.moments.segment = 0U;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&instance[0], &config, memory[0], sizeof memory[0]));
    restart(1U, works);
    run();
    const size_t alone = fake.sent_count;
    TEST_ASSERT_EQUAL_UINT64(SAMPLES - 1U, fake.sent[alone - 1U].result.epoch);
    for (size_t i = 0; i < alone; i++) {
        TEST_ASSERT_EQUAL_UINT64(fake.sent[0].result.epoch + i, fake.sent[i].result.epoch);
    }
}

/* The same samples and gaps reach a cascade, and its sizes follow those of the window. */
static void test_a_cascade_follows_every_channel(void)
{
    static const davar_cascade_config_t long_config = {.rate_hz = 10.0,
                                                       .unit_per_count = 1.0,
                                                       .full_scale = 1024.0,
                                                       .shortest = 64U,
                                                       .tau_count = 1U,
                                                       .clusters = 4U};
    static uint64_t stages[CHANNELS][DAVAR_CASCADE_MEMORY(Q31, 1U) / 8U];
    static davar_cascade_t cascade[CHANNELS];
    for (size_t gap_at = 0U; gap_at <= 40U; gap_at += 40U) {
        const script_t script = {.block = 7U, .gap_at = gap_at};
        run_script(script);
        plain = fake;
        start(CHANNELS, script);
        TEST_ASSERT_EQUAL(DAVAR_CASCADE_OK, davar_cascade_init_q15(&cascade[0], &long_config,
                                                                   stages[0], sizeof stages[0]));
        TEST_ASSERT_EQUAL(DAVAR_CASCADE_OK, davar_cascade_init_q31(&cascade[1], &long_config,
                                                                   stages[1], sizeof stages[1]));
        TEST_ASSERT_EQUAL(DAVAR_CASCADE_OK, davar_cascade_init_f32(&cascade[2], &long_config,
                                                                   stages[2], sizeof stages[2]));
        for (size_t c = 0; c < CHANNELS; c++) {
            channel[c].cascade = &cascade[c];
        }
        run();
        assert_same_results(plain.sent, fake.sent, plain.sent_count);
        for (size_t c = 0; c < CHANNELS; c++) {
            channel[c].cascade = NULL;
            TEST_ASSERT_EQUAL_UINT32((gap_at > 0U) ? 7U : 0U,
                                     davar_cascade_health(&cascade[c]).missing);
            const davar_result_t *const early = &fake.sent[c].result;
            const davar_result_t *const last = &fake.sent[fake.sent_count - CHANNELS + c].result;
            TEST_ASSERT_EQUAL_UINT8(TAUS + 1U, last->tau_count);
            TEST_ASSERT_EQUAL_UINT32(64U, last->tau[TAUS].m);
            TEST_ASSERT_EQUAL_UINT32(0U, early->tau[TAUS].differences);
            /* ends of spans at 128, 144, .. 320; after a gap at 40 from 176 on */
            TEST_ASSERT_EQUAL_UINT32((gap_at > 0U) ? 10U : 13U, last->tau[TAUS].differences);
        }
    }
}

#ifdef NDEBUG
/* A channel with another number type than its instance: its samples are counted as missing. */
static void test_samples_of_another_type_are_counted_as_missing(void)
{
    const script_t blocks = {.block = 30U};
    start(1U, blocks);
    channel[0].number = DAVAR_PORT_Q31;
    run();
    TEST_ASSERT_EQUAL_size_t(0U, fake.sent_count);
    TEST_ASSERT_EQUAL_UINT32(SAMPLES, davar_health(channel[0].davar).missing);
}
#endif

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_plan_adds_the_fit);
    RUN_TEST(test_the_results_of_a_flush_are_sent_epoch_by_epoch);
    RUN_TEST(test_a_cascade_follows_every_channel);
#ifdef NDEBUG
    RUN_TEST(test_samples_of_another_type_are_counted_as_missing);
#endif
    RUN_TEST(test_every_sample_gets_a_result_in_every_channel_epoch_by_epoch);
    RUN_TEST(test_results_do_not_depend_on_blocks_and_on_a_port_that_fails);
    RUN_TEST(test_a_busy_bus_stops_reading_and_keeps_the_result);
    RUN_TEST(test_a_send_fault_loses_that_result_only);
    RUN_TEST(test_a_gap_reaches_every_channel);
    RUN_TEST(test_a_channel_out_of_step_does_not_disturb_the_others);
    RUN_TEST(test_a_grid_ends_properly);
    RUN_TEST(test_a_port_without_clock_and_fault_works);
    return UNITY_END();
}
