/* davar tests - a caller's bug fails the matching assertion. Compiled with the library's sources
 * and assertions on, in every build. */
#include "davar/cascade.h"
#include "davar/davar.h"
#include "davar/fit.h"
#include "davar/glr.h"
#include "davar/select.h"
#include "davar/telemetry.h"
#include "unity.h"

#include <math.h>
#include <setjmp.h>
#include <signal.h>

static jmp_buf back;
static davar_t davar;
static davar_config_t config;
static uint64_t memory[2048];
static const uint32_t taus[2] = {1U, 2U};

static void aborted(int signal_number)
{
    (void)signal_number;
    longjmp(back, 1);
}

/* True if `statement` fails an assertion. */
#define ASSERTS(statement)                                                                         \
    (signal(SIGABRT, aborted), (setjmp(back) != 0) ? true : ((void)(statement), false))

void setUp(void)
{
    config = davar_default_config;
    config.rate_hz = 1.0;
    config.unit_per_count = 1.0;
    config.full_scale = 1.0;
    config.taus = taus;
    config.tau_count = 2U;
}

void tearDown(void) {}

static void test_a_push_of_another_type_than_init_s(void)
{
    const int16_t narrow = 0;
    const int32_t wide = 0;
    const float rate = 0.0F;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
    TEST_ASSERT_FALSE(ASSERTS((davar_push_q15(&davar, &narrow, 1U), 0)));
    TEST_ASSERT_TRUE(ASSERTS((davar_push_q31(&davar, &wide, 1U), 0)));
    TEST_ASSERT_TRUE(ASSERTS((davar_push_f32(&davar, &rate, 1U), 0)));
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_f32(&davar, &config, memory, sizeof memory));
    TEST_ASSERT_FALSE(ASSERTS((davar_push_f32(&davar, &rate, 1U), 0)));
    TEST_ASSERT_TRUE(ASSERTS((davar_push_q31(&davar, &wide, 1U), 0)));
    TEST_ASSERT_TRUE(ASSERTS((davar_push_q15(&davar, &narrow, 1U), 0)));
}

static void test_a_push_of_another_type_to_a_cascade(void)
{
    static const davar_cascade_config_t settings = {
        .rate_hz = 1.0, .unit_per_count = 1.0, .shortest = 64U, .tau_count = 3U, .clusters = 32U};
    const int16_t narrow = 0;
    const int32_t wide = 0;
    const float rate = 0.0F;
    davar_cascade_t cascade;
    TEST_ASSERT_EQUAL(DAVAR_CASCADE_OK,
                      davar_cascade_init_q15(&cascade, &settings, memory, sizeof memory));
    TEST_ASSERT_FALSE(ASSERTS((davar_cascade_push_q15(&cascade, &narrow, 1U), 0)));
    TEST_ASSERT_TRUE(ASSERTS((davar_cascade_push_q31(&cascade, &wide, 1U), 0)));
    TEST_ASSERT_TRUE(ASSERTS((davar_cascade_push_f32(&cascade, &rate, 1U), 0)));
    TEST_ASSERT_EQUAL(DAVAR_CASCADE_OK,
                      davar_cascade_init_q31(&cascade, &settings, memory, sizeof memory));
    TEST_ASSERT_FALSE(ASSERTS((davar_cascade_push_q31(&cascade, &wide, 1U), 0)));
    TEST_ASSERT_TRUE(ASSERTS((davar_cascade_push_q15(&cascade, &narrow, 1U), 0)));
}

static void test_a_sample_or_a_gap_after_the_record_was_finished(void)
{
    const int16_t count = 0;
    config.law = &davar_law_glr_q15;
    config.moments.segment = 0U;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
    for (unsigned i = 0U; i < 605U; i++) {
        davar_push_q15(&davar, &count, 1U);
    }
    TEST_ASSERT_TRUE(davar_flush(&davar));
    TEST_ASSERT_TRUE(ASSERTS((davar_push_q15(&davar, &count, 1U), 0)));
    TEST_ASSERT_TRUE(ASSERTS((davar_gap(&davar, 1U), 0)));
    davar_reset(&davar);
    TEST_ASSERT_FALSE(ASSERTS((davar_push_q15(&davar, &count, 1U), 0)));
}

static void test_a_plan_of_no_cluster_size_and_a_window_shorter_than_a_span(void)
{
    davar_plan_t plan;
    TEST_ASSERT_TRUE(ASSERTS((davar_plan_init(&plan, taus, 0U), 0)));
    TEST_ASSERT_TRUE(ASSERTS(davar_edf(DAVAR_ANGLE_RANDOM_WALK, 2U, 3U)));
    TEST_ASSERT_FALSE(ASSERTS(davar_edf(DAVAR_ANGLE_RANDOM_WALK, 2U, 4U)));
}

static bool is_refused(davar_filter_t filter, uint8_t count)
{
    davar_plan_t plan;
    return ASSERTS((davar_plan_init_filtered(&plan, taus, count, &filter), 0));
}

/* What is not used may have any value: a length without averages. */
static void test_a_filter_outside_its_ranges(void)
{
    static const struct {
        davar_filter_t inside;
        davar_filter_t outside;
    } cases[] = {
        {{.b = {0.1}, .a = {1.0, -0.99}}, {.b = {0.1}, .a = {1.0, -0.999}}}, /* remembers longer */
        {{.b = {0.1}, .a = {1.0, 0.9}}, {.b = {0.1}, .a = {1.0, 1.0}}},
        {{.b = {0.1}, .a = {1.0, 0.0, 0.9}}, {.b = {0.1}, .a = {1.0, 0.0, -1.1}}},
        {{.b = {3.0}, .a = {1.0}}, {.b = {3.0}, .a = {2.0}}},
        {{.b = {3.0}}, {.b = {(double)NAN}}},
        {{.b = {1.0, 0.5}}, {.b = {1.0, -1.0}}}, /* passes nothing at 0 */
        {{.b = {1.0, 2.0}, .a = {1.0, 0.1}}, {.b = {1.0, 2.0}, .a = {0.0, 0.1}}},
        {{.b = {1.0}, .a = {1.0, 0.1}}, {.b = {0.0}, .a = {1.0, 0.1}}},
        {{.a = {1.0}}, {.a = {1.0, (double)INFINITY}}},
        {{.uncertainty = 0.5}, {.uncertainty = 0.51}},
        {{.level = 0.5}, {.level = 0.51}},
        {{.level = 0.0}, {.uncertainty = -0.1}},
        {{.averages = 8U, .length = 1U}, {.averages = 9U, .length = 1U}},
        {{.averages = 1U, .length = 1024U}, {.averages = 1U, .length = 1025U}},
        {{.averages = 8U, .length = 128U}, {.averages = 8U, .length = 129U}},
        {{.length = 5000U}, {.averages = 1U, .length = 0U}},
        {{.summed = 1U}, {.summed = 2U}},
        {{.summed = 2U, .count_variance = 1.0, .count_step = 1.0},
         {.summed = 2U, .count_variance = 1.0, .count_step = 2.1}},
    };
    for (size_t i = 0U; i < sizeof cases / sizeof cases[0]; i++) {
        TEST_ASSERT_FALSE(is_refused(cases[i].inside, 2U));
        TEST_ASSERT_TRUE(is_refused(cases[i].outside, 2U));
    }
    TEST_ASSERT_TRUE(is_refused(cases[4].inside, 0U));
}

static void test_windows_above_2_to_the_31_samples(void)
{
    static davar_plan_t plan;
    static davar_result_t result;
    const uint32_t longest = UINT32_C(1) << 31U;
    davar_plan_init_white(&plan, taus, 1U);
    result.tau_count = 1U;
    result.window_samples = longest;
    result.tau[0] = (davar_adev_t){.m = 1U, .differences = longest - 1U, .adev = 1.0};
    TEST_ASSERT_FALSE(ASSERTS(davar_fit_white(&plan, 1.0, &result)));
    TEST_ASSERT_FALSE(ASSERTS(davar_edf_least(&result, 0U)));
    result.mirrored_samples = 1U;
    TEST_ASSERT_TRUE(ASSERTS(davar_fit_white(&plan, 1.0, &result)));
    TEST_ASSERT_TRUE(ASSERTS(davar_edf_least(&result, 0U)));
    result.mirrored_samples = 0U;
    result.window_samples = longest + 1U;
    TEST_ASSERT_TRUE(ASSERTS(davar_fit_white(&plan, 1.0, &result)));
}

static void test_telemetry_without_an_object(void)
{
    static const davar_telemetry_address_t from = {.node = 1U};
    const davar_result_t result = {0};
    const double variances[3] = {0};
    uint8_t bytes[DAVAR_COVARIANCE_BYTES];
    davar_telemetry_t telemetry;
    davar_packet_t packet;
    bool good = false;
    TEST_ASSERT_TRUE(ASSERTS(good = davar_telemetry_init(NULL, &davar_cyphal, &from, 1.0)));
    TEST_ASSERT_TRUE(ASSERTS(good = davar_telemetry_init(&telemetry, NULL, &from, 1.0)));
    TEST_ASSERT_TRUE(ASSERTS(good = davar_telemetry_init(&telemetry, &davar_cyphal, NULL, 1.0)));
    TEST_ASSERT_FALSE(ASSERTS(good = davar_telemetry_init(&telemetry, &davar_cyphal, &from, 1.0)));
    TEST_ASSERT_TRUE(good);
    TEST_ASSERT_TRUE(ASSERTS(davar_telemetry_set_channel(NULL, 0U)));
    TEST_ASSERT_TRUE(ASSERTS((davar_telemetry_begin(&telemetry, NULL, NULL, 0U), 0)));
    TEST_ASSERT_FALSE(ASSERTS((davar_telemetry_begin(&telemetry, &result, NULL, 0U), 0)));
    TEST_ASSERT_TRUE(ASSERTS(davar_telemetry_next(&telemetry, NULL)));
    TEST_ASSERT_FALSE(ASSERTS(davar_telemetry_next(&telemetry, &packet)));
    TEST_ASSERT_TRUE(ASSERTS(davar_telemetry_heartbeat(&telemetry, 0U, NULL)));
    TEST_ASSERT_FALSE(ASSERTS(davar_telemetry_heartbeat(&telemetry, 0U, &packet)));
    TEST_ASSERT_TRUE(ASSERTS((davar_dronecan_covariance(variances, NULL, bytes), 0)));
}

static void test_a_sample_beyond_a_block_of_a_selection_and_an_update_within_it(void)
{
    static const davar_select_config_t settings = {
        .gyros = 2U, .axes = 1U, .block = 4U, .rate_hz = 40.0F, DAVAR_SELECT_DEFAULTS};
    const float rates[2] = {1.0F, 2.0F};
    static davar_select_t selection;
    static davar_select_gyro_t gyro[2];
    static davar_select_pair_t pair[1];
    davar_select_verdict_t verdict;
    TEST_ASSERT_EQUAL(DAVAR_SELECT_OK, davar_select_init(&selection, &settings, gyro, pair));
    while (!davar_select_add(&selection, rates)) {
        TEST_ASSERT_TRUE(ASSERTS((davar_select_update(&selection, &verdict), 0)));
    }
    TEST_ASSERT_TRUE(ASSERTS(davar_select_add(&selection, rates)));
    TEST_ASSERT_FALSE(ASSERTS((davar_select_update(&selection, &verdict), 0)));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_push_of_another_type_than_init_s);
    RUN_TEST(test_a_push_of_another_type_to_a_cascade);
    RUN_TEST(test_a_sample_or_a_gap_after_the_record_was_finished);
    RUN_TEST(test_a_plan_of_no_cluster_size_and_a_window_shorter_than_a_span);
    RUN_TEST(test_a_filter_outside_its_ranges);
    RUN_TEST(test_windows_above_2_to_the_31_samples);
    RUN_TEST(test_telemetry_without_an_object);
    RUN_TEST(test_a_sample_beyond_a_block_of_a_selection_and_an_update_within_it);
    return UNITY_END();
}
