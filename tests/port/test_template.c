/* davar tests - the port to copy: transferred samples reach the instance, and overruns are
 * counted. */
#include "davar_node.h"
#include "template_port.h"
#include "unity.h"

static const uint32_t taus[1] = {1U};
static uint64_t memory[256];
static davar_config_t config;
static davar_t davar;
static davar_node_channel_t channel = {.davar = &davar, .number = DAVAR_PORT_Q15};
static davar_node_t node;
static template_port_t state;
static davar_port_t port;

void setUp(void)
{
    config = davar_default_config;
    config.rate_hz = 1000.0;
    config.unit_per_count = 0.01;
    config.law = NULL;
    config.window.longest = 128U;
    config.window.shortest = 128U;
    config.moments.segment = 0U;
    config.taus = taus;
    config.tau_count = 1U;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
    port = template_port(&state);
    davar_node_init(&node, &channel, 1U, &port);
}

void tearDown(void) {}

/* Fills the next half, as an interrupt does. */
static void transfer(uint32_t half)
{
    for (uint32_t i = 0U; i < TEMPLATE_PORT_HALF; i++) {
        state.counts[half % 2U][i] = (int16_t)(((half % 2U) == 0U) ? i : (100U + i));
    }
    template_port_half_done(&state);
}

static void work(void)
{
    while (davar_node_step(&node) == DAVAR_NODE_RUNNING) {
    }
}

static void test_nothing_comes_before_the_first_half(void)
{
    TEST_ASSERT_EQUAL(DAVAR_NODE_IDLE, davar_node_step(&node));
    TEST_ASSERT_EQUAL_UINT64(0U, node.counters.samples);
}

static void test_every_half_arrives_once_and_in_order(void)
{
    for (uint32_t half = 0U; half < 3U; half++) {
        transfer(half);
        work();
        TEST_ASSERT_EQUAL_UINT64((half + 1U) * TEMPLATE_PORT_HALF, node.counters.samples);
    }
    TEST_ASSERT_EQUAL_UINT32(0U, davar_health(&davar).gaps);
}

static void test_a_node_too_slow_for_the_transfer_gets_a_gap(void)
{
    transfer(0U);
    work();
    transfer(1U);
    transfer(2U);
    transfer(3U);
    work();
    TEST_ASSERT_EQUAL_UINT64(2U * TEMPLATE_PORT_HALF, node.counters.samples);
    TEST_ASSERT_EQUAL_UINT32(1U, davar_health(&davar).gaps);
    TEST_ASSERT_EQUAL_UINT32(2U * TEMPLATE_PORT_HALF, davar_health(&davar).missing);
}

static void test_a_result_waits_for_the_line(void)
{
    for (uint32_t half = 0U; half < 5U; half++) {
        transfer(half);
        work();
    }
    TEST_ASSERT_GREATER_THAN_UINT32(0U, node.counters.send_retries);
    TEST_ASSERT_EQUAL_UINT64(0U, node.counters.results);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_nothing_comes_before_the_first_half);
    RUN_TEST(test_every_half_arrives_once_and_in_order);
    RUN_TEST(test_a_node_too_slow_for_the_transfer_gets_a_gap);
    RUN_TEST(test_a_result_waits_for_the_line);
    return UNITY_END();
}
