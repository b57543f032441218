/* davar tests - kalman (davar/kalman.h): its variances against the scatter of integrated noise, and
 * which ARW is used without a value. */
#include "davar/kalman.h"
#include "random.h"
#include "unity.h"

#define RATE_HZ 200.0
#define SAMPLES 400U
#define RUNS 4000U
#define DEGREE (3.14159265358979323846 / 180.0)

void setUp(void) {}

void tearDown(void) {}

/* An ARW of 0.3 deg/sqrt(h) is 0.3 deg after an hour, 0.005 deg after a second. */
static void test_white_noise_turns_by_its_walk(void)
{
    random_t random = random_seeded(1U);
    const double density = davar_rate_density(0.3, DAVAR_DEG_PER_S);
    const double sigma = sqrt(davar_rate_variance(density, RATE_HZ));
    double squares = 0.0;
    TEST_ASSERT_DOUBLE_WITHIN(1e-16, 0.005 * DEGREE, density);
    for (uint32_t run = 0U; run < RUNS; run++) {
        double angle = 0.0;
        for (uint32_t n = 0U; n < SAMPLES; n++) {
            angle += sigma * random_gauss(&random) / RATE_HZ;
        }
        squares += angle * angle;
    }
    const double expected = davar_process_variance(density, SAMPLES / RATE_HZ);
    TEST_ASSERT_DOUBLE_WITHIN(0.1, 1.0, squares / RUNS / expected);
}

/* A rate random walk of 3 deg/h/sqrt(h) is 3 deg/h after an hour. */
static void test_the_bias_walks(void)
{
    const double density = davar_walk_density(3.0, DAVAR_DEG_PER_S);
    const double hour = davar_process_variance(density, 3600.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-12, 3.0 * DEGREE / 3600.0, sqrt(hour));
}

static void test_the_unit_of_the_samples_is_that_of_the_result(void)
{
    const double arw_deg = 0.7;
    const double arw_rad = arw_deg * DEGREE; /* of the same samples, in rad/s */
    const double expected = davar_rate_density(arw_deg, DAVAR_DEG_PER_S);
    TEST_ASSERT_DOUBLE_WITHIN(1e-16, expected, davar_rate_density(arw_rad, DAVAR_RAD_PER_S));
    TEST_ASSERT_DOUBLE_WITHIN(1e-18, davar_walk_density(arw_deg, DAVAR_DEG_PER_S),
                              davar_walk_density(arw_rad, DAVAR_RAD_PER_S));
}

static void test_what_is_no_variance_is_nan(void)
{
    TEST_ASSERT_TRUE(isnan(davar_rate_variance(1.0, 0.0)));
    TEST_ASSERT_TRUE(isnan(davar_rate_variance(1.0, (double)NAN)));
    TEST_ASSERT_TRUE(isnan(davar_process_variance(1.0, -1e-9)));
    TEST_ASSERT_TRUE(isnan(davar_process_variance(1.0, (double)NAN)));
    TEST_ASSERT_TRUE(isnan(davar_process_variance((double)NAN, 1.0)));
}

static void test_without_a_value_the_one_before_stays_below_the_limit(void)
{
    davar_result_t result = {.epoch = 0U};
    davar_coefficient_t *const arw = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
    *arw = (davar_coefficient_t){.present = true, .value = 0.3, .low = 0.2, .high = 0.4};
    TEST_ASSERT_EQUAL_DOUBLE(0.3, davar_arw_to_use(&result, 9.0));
    *arw = (davar_coefficient_t){.value = (double)NAN, .low = (double)NAN, .high = 0.4};
    TEST_ASSERT_EQUAL_DOUBLE(0.3, davar_arw_to_use(&result, 0.3));
    TEST_ASSERT_EQUAL_DOUBLE(0.4, davar_arw_to_use(&result, 0.5));
    arw->high = (double)NAN; /* not fitted yet */
    TEST_ASSERT_EQUAL_DOUBLE(0.5, davar_arw_to_use(&result, 0.5));
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_white_noise_turns_by_its_walk);
    RUN_TEST(test_the_bias_walks);
    RUN_TEST(test_the_unit_of_the_samples_is_that_of_the_result);
    RUN_TEST(test_what_is_no_variance_is_nan);
    RUN_TEST(test_without_a_value_the_one_before_stays_below_the_limit);
    return UNITY_END();
}
