/* davar tests - the floor (davar/floor.h): its transform by the definition, what a plan rejects, and
 * why a window has no value. */
#include "davar/filter.h"
#include "davar/floor.h"
#include "floor_transform.h"
#include "random.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define TURN 6.283185307179586

static davar_floor_plan_t plan;
static davar_floor_t axis;
static davar_floor_result_t result;

static davar_floor_config_t usual(void)
{
    return (davar_floor_config_t){
        .rate_hz = 1000.0, .unit_per_count = 0.01, .rail = 32767, .block = 256U};
}

void setUp(void)
{
    const davar_floor_config_t config = usual();
    TEST_ASSERT_EQUAL(DAVAR_FLOOR_OK, davar_floor_plan(&plan, &config));
    davar_floor_start(&axis);
}

void tearDown(void) {}

static bool push(int32_t count)
{
    const bool is_due = davar_floor_push(&axis, &plan, count);
    if (is_due) {
        davar_floor_take(&axis, &plan, &result);
    }
    return is_due;
}

/* Pushes noise of a standard deviation in counts, next to a line. Returns the results. */
static unsigned push_noise(random_t *random, unsigned count, double sigma, double line)
{
    static unsigned time = 0U; /* the line has no jumps */
    unsigned results = 0U;
    for (unsigned n = 0U; n < count; n++, time++) {
        const double value = sigma * random_gauss(random) + line * sin(TURN * 0.11 * time);
        results += push((int32_t)lrint(value)) ? 1U : 0U;
    }
    return results;
}

static void test_the_transform_is_that_of_the_definition(void)
{
    random_t random = random_seeded(1U);
    float ring[FLOOR_SEGMENT];
    for (uint32_t oldest = 0U; oldest <= FLOOR_HOP; oldest += FLOOR_HOP) {
        float power[31];
        for (uint32_t i = 0U; i < FLOOR_SEGMENT; i++) {
            ring[i] = (float)(1000.0 * random_gauss(&random));
        }
        davar_floor_transform(ring, oldest, power);
        for (uint32_t k = 1U; k <= 31U; k++) {
            double re = 0.0;
            double im = 0.0;
            for (uint32_t i = 0U; i < FLOOR_SEGMENT; i++) {
                const double window = 0.5 - 0.5 * cos(TURN * (i + 0.5) / 64.0);
                const double x = window * (double)ring[(oldest + i) % FLOOR_SEGMENT];
                re += x * cos(TURN * k * i / 64.0);
                im += x * sin(TURN * k * i / 64.0);
            }
            TEST_ASSERT_DOUBLE_WITHIN(1e-5 * (re * re + im * im) + 100.0, 4.0 * (re * re + im * im),
                                      (double)power[k - 1U]);
        }
    }
}

static void test_a_plan_names_what_is_wrong(void)
{
    davar_floor_config_t config = usual();
    davar_filter_t narrow = {.b = {0.0}};
    davar_filter_low_pass(&narrow, 5.0, 2U, 0.0);
    config.rate_hz = 0.0;
    TEST_ASSERT_EQUAL(DAVAR_FLOOR_ERR_RATE, davar_floor_plan(&plan, &config));
    config = usual();
    config.unit_per_count = (double)NAN;
    TEST_ASSERT_EQUAL(DAVAR_FLOOR_ERR_UNIT, davar_floor_plan(&plan, &config));
    config.unit_per_count = (double)INFINITY;
    TEST_ASSERT_EQUAL(DAVAR_FLOOR_ERR_UNIT, davar_floor_plan(&plan, &config));
    config = usual();
    config.rail = 0;
    TEST_ASSERT_EQUAL(DAVAR_FLOOR_ERR_RAIL, davar_floor_plan(&plan, &config));
    for (uint32_t block = 0U; block <= 8192U; block += 32U) {
        config = usual();
        config.block = (uint16_t)block;
        const bool is_good = (block <= 4096U) && ((block % 64U) == 0U);
        TEST_ASSERT_EQUAL(is_good ? DAVAR_FLOOR_OK : DAVAR_FLOOR_ERR_BLOCK,
                          davar_floor_plan(&plan, &config));
    }
    config = usual();
    config.filter = &narrow;
    TEST_ASSERT_EQUAL(DAVAR_FLOOR_ERR_FILTER, davar_floor_plan(&plan, &config));
}

static void test_the_usual_block_depends_on_the_rate(void)
{
    const struct {
        double rate_hz;
        uint16_t block;
    } cases[] = {{50.0, 128U}, {799.9, 128U}, {800.0, 256U}, {8000.0, 256U}};
    for (uint32_t i = 0U; i < 4U; i++) {
        davar_floor_config_t config = usual();
        davar_floor_plan_t stated;
        config.rate_hz = cases[i].rate_hz;
        config.block = cases[i].block;
        TEST_ASSERT_EQUAL(DAVAR_FLOOR_OK, davar_floor_plan(&stated, &config));
        config.block = 0U;
        TEST_ASSERT_EQUAL(DAVAR_FLOOR_OK, davar_floor_plan(&plan, &config));
        TEST_ASSERT_EQUAL(stated.segments, plan.segments);
    }
}

static void test_every_status_and_reason_has_a_text(void)
{
    for (int i = 0; i <= 7; i++) {
        TEST_ASSERT_GREATER_THAN(1U, strlen(davar_floor_status_text((davar_floor_status_t)i)));
        TEST_ASSERT_GREATER_THAN(3U, strlen(davar_floor_why_text((davar_floor_why_t)i)));
    }
}

static void test_a_result_comes_after_each_block_and_a_value_after_four(void)
{
    random_t random = random_seeded(2U);
    unsigned results = 0U;
    for (unsigned n = 1U; n <= 32U + 10U * 256U + 1U; n++) {
        const bool is_due = push((int32_t)lrint(20.0 * random_gauss(&random)));
        TEST_ASSERT_EQUAL(((n - 33U) % 256U == 0U) && (n > 33U), is_due);
        results += is_due ? 1U : 0U;
        if (is_due) {
            TEST_ASSERT_EQUAL((results < 4U) ? DAVAR_FLOOR_FILLING : DAVAR_FLOOR_VALUE, result.why);
            TEST_ASSERT_TRUE((results < 4U) == (isinf(result.high) != 0));
            TEST_ASSERT_TRUE((results < 4U) == (isnan(result.value) != 0));
        }
    }
    TEST_ASSERT_EQUAL(10U, results);
}

static void test_a_line_hides_neither_the_density_nor_where_it_is_quiet(void)
{
    random_t random = random_seeded(3U);
    const double arw = 60.0 * 0.01 * 20.0 / sqrt(1000.0);
    double sum = 0.0;
    unsigned count = 0U;
    for (unsigned i = 0U; i < 200U; i++) {
        TEST_ASSERT_LESS_OR_EQUAL(1U, push_noise(&random, 256U, 20.0, 2000.0));
        if (i > 5U) {
            TEST_ASSERT_EQUAL(DAVAR_FLOOR_VALUE, result.why);
            TEST_ASSERT_TRUE(result.low < result.value && result.value < result.high);
            sum += (double)result.value / arw;
            count++;
        }
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.03, 1.0, sum / count);
}

static void test_why_there_is_no_value(void)
{
    random_t random = random_seeded(4U);
    davar_floor_config_t config = usual();
    davar_filter_t filter = {.b = {0.0}};
    (void)push_noise(&random, 3000U, 0.3, 0.0);
    TEST_ASSERT_EQUAL(DAVAR_FLOOR_COARSE, result.why);
    TEST_ASSERT_TRUE((double)result.high > 60.0 * 0.01 * 0.3 / sqrt(1000.0));
    (void)push_noise(&random, 3000U, 5.0, 0.0);
    TEST_ASSERT_EQUAL(DAVAR_FLOOR_VALUE, result.why);
    for (unsigned n = 0U; n < 3000U; n++) {
        (void)push(7);
    }
    TEST_ASSERT_EQUAL(DAVAR_FLOOR_STILL, result.why);
    TEST_ASSERT_TRUE(isinf(result.high));
    (void)push_noise(&random, 3000U, 5.0, 0.0);
    (void)push(32767);
    (void)push_noise(&random, 600U, 5.0, 0.0);
    TEST_ASSERT_EQUAL(DAVAR_FLOOR_CLIPPED, result.why);
    TEST_ASSERT_EQUAL(1U, result.clipped);
    davar_filter_biquad(&filter, 0.15);
    config.filter = &filter;
    TEST_ASSERT_EQUAL(DAVAR_FLOOR_OK, davar_floor_plan(&plan, &config));
    davar_floor_start(&axis);
    (void)push_noise(&random, 3000U, 5.0, 0.0);
    TEST_ASSERT_EQUAL(DAVAR_FLOOR_NARROW, result.why);
    TEST_ASSERT_TRUE(isnan(result.value) && !isinf(result.high));
    memset(&filter, 0, sizeof filter);
    davar_filter_biquad(&filter, 0.03);
    TEST_ASSERT_EQUAL(DAVAR_FLOOR_OK, davar_floor_plan(&plan, &config));
    davar_floor_start(&axis);
    (void)push_noise(&random, 3000U, 5.0, 0.0);
    TEST_ASSERT_EQUAL(DAVAR_FLOOR_NARROW, result.why);
    TEST_ASSERT_TRUE(isinf(result.high));
}

/* A digital Butterworth low-pass: its power, and half of what a cutoff 10 % off changes it by. */
static void test_the_doubt_of_a_cutoff_is_in_each_frequency_and_leaves_out_the_worst(void)
{
    davar_filter_t filter = {.b = {0.0}};
    davar_floor_config_t config = usual();
    config.filter = &filter;
    davar_filter_biquad(&filter, 0.2);
    filter.uncertainty = 0.1;
    TEST_ASSERT_EQUAL(DAVAR_FLOOR_OK, davar_floor_plan(&plan, &config));
    for (uint32_t k = 1U; k <= 31U; k++) {
        double power[2];
        for (uint32_t side = 0U; side < 2U; side++) {
            const double at = fmin(0.5, k / 64.0 / (side ? 1.1 : 0.9));
            power[side] = 1.0 / (1.0 + pow(tan(TURN / 2.0 * at) / tan(TURN / 10.0), 4.0));
        }
        const double doubt = (power[1] - power[0]) / (power[1] + power[0]);
        TEST_ASSERT_TRUE((double)plan.doubt[k - 1U] >= doubt - 1e-6);
    }
    const uint32_t usable = plan.usable;
    TEST_ASSERT_TRUE((usable > 8U) && (usable < 31U));
    filter.uncertainty = 0.3;
    TEST_ASSERT_EQUAL(DAVAR_FLOOR_OK, davar_floor_plan(&plan, &config));
    TEST_ASSERT_LESS_THAN(usable, plan.usable);
}

static void test_two_counts_in_turn_are_not_a_stuck_sensor(void)
{
    for (int32_t n = 0; n < 3000; n++) {
        (void)push(n % 2);
    }
    TEST_ASSERT_NOT_EQUAL(DAVAR_FLOOR_STILL, result.why);
}

static void test_a_take_that_is_not_due_is_of_the_same_window(void)
{
    random_t random = random_seeded(10U);
    while ((push_noise(&random, 1U, 5.0, 0.0) == 0U) || (result.why != DAVAR_FLOOR_VALUE)) {
        /* fills */
    }
    const davar_floor_result_t before = result;
    for (uint32_t h = 0U; h < 2U; h++) { /* the next segment begins a block */
        davar_floor_take(&axis, &plan, &result);
        TEST_ASSERT_EQUAL(DAVAR_FLOOR_VALUE, result.why);
        TEST_ASSERT_FLOAT_WITHIN(0.2F * before.value, before.value, result.value);
    }
}

static void test_no_segment_spans_a_gap_and_the_window_stays(void)
{
    random_t random = random_seeded(5U);
    (void)push_noise(&random, 4000U, 5.0, 0.0);
    const float before = result.value;
    for (unsigned i = 0U; i < 40U; i++) { /* the rate jumps while samples are missing */
        davar_floor_gap(&axis);
        for (unsigned n = 0U; n < 100U; n++) {
            const double value = 5.0 * random_gauss(&random) + 3000.0 * (i % 2U);
            (void)push((int32_t)lrint(value));
        }
    }
    TEST_ASSERT_EQUAL(DAVAR_FLOOR_VALUE, result.why);
    TEST_ASSERT_FLOAT_WITHIN(0.2F * before, before, result.value);
}

/* Those of a delayed axis are the results of one that begins later, also after a gap. */
static void test_a_delay_moves_the_segments_and_changes_no_result(void)
{
    static davar_floor_t later;
    for (uint8_t delay = 0U; delay < 32U; delay += 7U) {
        davar_floor_result_t expected = {.why = DAVAR_FLOOR_FILLING};
        unsigned results = 0U;
        random_t random = random_seeded(9U);
        davar_floor_start(&axis);
        davar_floor_delay(&axis, delay);
        davar_floor_start(&later);
        for (unsigned n = 0U, since = 0U; n < 5000U; n++, since++) {
            const int32_t count = (int32_t)lrint(5.0 * random_gauss(&random));
            if (n == 2500U) {
                davar_floor_gap(&axis);
                davar_floor_gap(&later);
                since = 0U;
            }
            const bool is_due = push(count);
            const bool is_later = (since >= delay) && davar_floor_push(&later, &plan, count);
            TEST_ASSERT_EQUAL(is_later, is_due);
            if (is_due) {
                davar_floor_take(&later, &plan, &expected);
                TEST_ASSERT_EQUAL_MEMORY(&expected.high, &result.high, sizeof expected.high);
                TEST_ASSERT_EQUAL(expected.why, result.why);
                results++;
            }
        }
        TEST_ASSERT_GREATER_THAN(15U, results);
    }
}

static void test_a_shock_is_left_out_and_a_change_is_not(void)
{
    random_t random = random_seeded(6U);
    (void)push_noise(&random, 4000U, 5.0, 0.0);
    const float before = result.value;
    (void)push(3000);
    (void)push_noise(&random, 300U, 5.0, 0.0);
    TEST_ASSERT_TRUE((result.shocks >= 1U) && (result.shocks <= 2U));
    TEST_ASSERT_FLOAT_WITHIN(0.3F * before, before, result.value);
    (void)push_noise(&random, 1400U, 50.0, 0.0);
    TEST_ASSERT_FLOAT_WITHIN(1.5F * before, 10.0F * before, result.value);
}

static void test_a_result_that_is_not_taken_is_lost_and_the_next_is_right(void)
{
    random_t random = random_seeded(7U);
    unsigned due = 0U;
    for (unsigned n = 0U; n < 8000U; n++) {
        const int32_t count = (int32_t)lrint(20.0 * random_gauss(&random));
        if (davar_floor_push(&axis, &plan, count)) {
            due++;
            if ((due % 3U) == 0U) {
                davar_floor_take(&axis, &plan, &result);
            }
        }
    }
    TEST_ASSERT_EQUAL(31U, due);
    TEST_ASSERT_EQUAL(DAVAR_FLOOR_VALUE, result.why);
    TEST_ASSERT_FLOAT_WITHIN(0.08F, 0.379F, result.value);
}

/* --- flights --- */

/* Ten windows of a flight in some bands. */
static davar_floor_flight_t flown(random_t *random, double level)
{
    davar_floor_flight_t flight = {.sum = {0.0F}};
    davar_floor_result_t window = {.why = DAVAR_FLOOR_VALUE};
    for (uint32_t n = 0U; n < 40U; n++) {
        const uint32_t band = n % 4U;
        window.value = (float)(level * (1.0 + band) * exp(0.3 * random_gauss(random)));
        davar_floor_flight_add(&flight, band, &window);
    }
    return flight;
}

/* Crafts whose flights scatter by 20 %: how often is one that is `factor` as loud called louder? */
static double louder_of(double factor, unsigned flights)
{
    random_t random = random_seeded(8U);
    unsigned louder = 0U;
    for (unsigned craft = 0U; craft < 2000U; craft++) {
        davar_floor_baseline_t baseline = {.mean = {0.0F}};
        davar_floor_change_t change;
        for (unsigned f = 0U; f < flights; f++) {
            const davar_floor_flight_t before = flown(&random, exp(0.2 * random_gauss(&random)));
            davar_floor_baseline_add(&baseline, &before);
        }
        const davar_floor_flight_t now = flown(&random, factor * exp(0.2 * random_gauss(&random)));
        davar_floor_compare(&baseline, &now, &change);
        TEST_ASSERT_TRUE(change.is_known);
        TEST_ASSERT_TRUE((change.low < change.factor) && (change.factor < change.high));
        louder += (change.low > 1.0F) ? 1U : 0U;
    }
    return louder / 2000.0;
}

static void test_a_flight_is_louder_than_the_scatter_of_flights(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(0.03, 0.02, louder_of(1.0, 4U));
    TEST_ASSERT_DOUBLE_WITHIN(0.03, 0.03, louder_of(1.0, 20U));
    TEST_ASSERT_DOUBLE_WITHIN(0.04, 0.87, louder_of(2.0, 12U));
    TEST_ASSERT_TRUE(louder_of(1.3, 12U) < 0.6);
}

static void test_three_flights_and_eight_windows_are_needed(void)
{
    random_t random = random_seeded(9U);
    davar_floor_baseline_t baseline = {.mean = {0.0F}};
    davar_floor_flight_t flight = flown(&random, 1.0);
    const davar_floor_flight_t few = {.sum = {7.0F}, .windows = {7U}};
    const davar_floor_result_t none = {.why = DAVAR_FLOOR_CLIPPED};
    davar_floor_change_t change;
    for (unsigned f = 0U; f < 4U; f++) {
        davar_floor_compare(&baseline, &flight, &change);
        TEST_ASSERT_EQUAL(f >= 3U, change.is_known);
        TEST_ASSERT_EQUAL(f < 3U, isnan(change.factor) != 0);
        davar_floor_baseline_add(&baseline, &flight);
    }
    TEST_ASSERT_FLOAT_WITHIN(1e-5F, 1.0F, change.factor);
    davar_floor_compare(&baseline, &few, &change);
    TEST_ASSERT_FALSE(change.is_known);
    davar_floor_flight_add(&flight, 4U, &none);
    TEST_ASSERT_EQUAL_UINT32(0U, flight.windows[4]);
    TEST_ASSERT_LESS_OR_EQUAL(64U, sizeof baseline);
}

static void test_after_many_flights_the_baseline_follows_slowly(void)
{
    random_t random = random_seeded(11U);
    davar_floor_baseline_t baseline = {.mean = {0.0F}};
    for (unsigned f = 0U; f < 200U; f++) {
        const davar_floor_flight_t flight = flown(&random, (f < 100U) ? 1.0 : 2.0);
        davar_floor_baseline_add(&baseline, &flight);
    }
    const double followed = 2.0 - pow(0.99, 100.0); /* in units of the first hundred */
    TEST_ASSERT_EQUAL_UINT16(100U, baseline.flights[0]);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, followed * exp(0.3 * 0.3 / 2.0), (double)baseline.mean[0]);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_after_many_flights_the_baseline_follows_slowly);
    RUN_TEST(test_a_flight_is_louder_than_the_scatter_of_flights);
    RUN_TEST(test_three_flights_and_eight_windows_are_needed);
    RUN_TEST(test_the_transform_is_that_of_the_definition);
    RUN_TEST(test_a_plan_names_what_is_wrong);
    RUN_TEST(test_the_usual_block_depends_on_the_rate);
    RUN_TEST(test_every_status_and_reason_has_a_text);
    RUN_TEST(test_a_result_comes_after_each_block_and_a_value_after_four);
    RUN_TEST(test_a_line_hides_neither_the_density_nor_where_it_is_quiet);
    RUN_TEST(test_why_there_is_no_value);
    RUN_TEST(test_the_doubt_of_a_cutoff_is_in_each_frequency_and_leaves_out_the_worst);
    RUN_TEST(test_two_counts_in_turn_are_not_a_stuck_sensor);
    RUN_TEST(test_a_take_that_is_not_due_is_of_the_same_window);
    RUN_TEST(test_no_segment_spans_a_gap_and_the_window_stays);
    RUN_TEST(test_a_delay_moves_the_segments_and_changes_no_result);
    RUN_TEST(test_a_shock_is_left_out_and_a_change_is_not);
    RUN_TEST(test_a_result_that_is_not_taken_is_lost_and_the_next_is_right);
    return UNITY_END();
}
