/* davar tests - the selection of a gyro: settings, samples, and each kind of fault (DESIGN 13). */
#include "davar/select.h"
#include "random.h"
#include "select_parts.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#define GYROS DAVAR_SELECT_GYROS
#define SIGMA 0.05

static davar_select_config_t config;
static davar_select_t selection;
static davar_select_gyro_t gyro[GYROS];
static davar_select_pair_t pair[DAVAR_SELECT_PAIRS(GYROS)];
static davar_select_verdict_t verdict;
static random_t source;
static double own[GYROS];
static double bias[GYROS];
static double motion;

void setUp(void)
{
    config = (davar_select_config_t){
        .gyros = 3U, .axes = 1U, .block = 10U, .rate_hz = 100.0F, DAVAR_SELECT_DEFAULTS};
    source = random_seeded(41U);
    motion = 0.0;
    for (uint32_t i = 0U; i < GYROS; i++) {
        own[i] = 1.0;
        bias[i] = 0.0;
    }
}
void tearDown(void) {}

static davar_select_status_t start(void)
{
    return davar_select_init(&selection, &config, gyro, pair);
}

static bool starts(void)
{
    return start() == DAVAR_SELECT_OK;
}

/* Blocks of noise. The bits of `present` and `moving` are gyros. */
static void fly(uint32_t blocks, uint8_t present, uint8_t moving)
{
    for (uint32_t t = 0U; t < blocks; t++) {
        for (uint32_t k = 0U; k < config.block; k++) {
            float rates[GYROS * DAVAR_SELECT_AXES];
            for (uint32_t a = 0U; a < config.axes; a++) {
                const double common = motion * random_gauss(&source);
                for (uint32_t i = 0U; i < config.gyros; i++) {
                    const double noise = own[i] * SIGMA * random_gauss(&source);
                    const bool moves = (((unsigned)moving >> i) & 1U) != 0U;
                    const float rate = moves ? (float)(common + bias[i] + noise) : 0.25F;
                    rates[(i * config.axes) + a] =
                        (((unsigned)present >> i) & 1U) != 0U ? rate : NAN;
                }
            }
            TEST_ASSERT_EQUAL(k + 1U == config.block, davar_select_add(&selection, rates));
        }
        davar_select_update(&selection, &verdict);
    }
}

/* A range includes its ends, and nothing beyond. */
static void check_range(float *setting, float low, float high, davar_select_status_t status)
{
    const float good = *setting;
    const float ends[] = {low, high};
    const float bad[] = {nextafterf(low, -INFINITY), nextafterf(high, INFINITY), NAN};
    for (uint32_t i = 0U; i < 2U; i++) {
        *setting = ends[i];
        TEST_ASSERT_TRUE(starts());
    }
    for (uint32_t i = 0U; i < 3U; i++) {
        *setting = bad[i];
        TEST_ASSERT_EQUAL(status, start());
    }
    *setting = good;
    TEST_ASSERT_TRUE(starts());
}

static void test_settings_out_of_range_are_refused(void)
{
    check_range(&config.rate_hz, 40.0F, 250.00002F, /* of 10 samples, in floats */
                DAVAR_SELECT_ERR_RATE);
    check_range(&config.errors_per_1000_h, 1e-3F, 1e6F, DAVAR_SELECT_ERR_ERRORS);
    check_range(&config.scale_tolerance, 1e-9F, 1.0F, DAVAR_SELECT_ERR_TOLERANCE);
    check_range(&config.time_tolerance_s, 1e-9F, 1.0F, DAVAR_SELECT_ERR_TOLERANCE);
    check_range(&config.drift_tolerance_dps_per_s, 1e-9F, 1.0F, DAVAR_SELECT_ERR_TOLERANCE);
    memset(&selection, 0x5A, sizeof selection);
    const davar_select_t before = selection;
    for (uint32_t bad = 0U; bad < 6U; bad++) {
        setUp();
        config.gyros = (uint8_t)((bad == 0U) ? 1U : ((bad == 1U) ? 5U : 2U));
        config.axes = (uint8_t)((bad == 2U) ? 0U : ((bad == 3U) ? 4U : 1U));
        config.block = (uint16_t)((bad == 4U) ? 3U : ((bad == 5U) ? 1001U : 10U));
        config.rate_hz = 10.0F * (float)config.block;
        static const davar_select_status_t expected[] = {
            DAVAR_SELECT_ERR_GYROS, DAVAR_SELECT_ERR_AXES, DAVAR_SELECT_ERR_BLOCK};
        TEST_ASSERT_EQUAL(expected[bad / 2U], start());
        TEST_ASSERT_EQUAL_MEMORY(&before, &selection, sizeof before);
    }
    setUp();
    const davar_select_status_t null = DAVAR_SELECT_ERR_NULL;
    TEST_ASSERT_EQUAL(null, davar_select_init(NULL, &config, gyro, pair));
    TEST_ASSERT_EQUAL(null, davar_select_init(&selection, NULL, gyro, pair));
    TEST_ASSERT_EQUAL(null, davar_select_init(&selection, &config, NULL, pair));
    TEST_ASSERT_EQUAL(null, davar_select_init(&selection, &config, gyro, NULL));
    TEST_ASSERT_EQUAL_MEMORY(&before, &selection, sizeof before);
}

static void test_the_quieter_gyro_is_chosen_and_weighs_more(void)
{
    for (uint8_t gyros = 2U; gyros <= GYROS; gyros++) {
        setUp();
        config.gyros = gyros;
        TEST_ASSERT_TRUE(starts());
        own[0] = 2.0;
        fly(300U, 0xFU, 0xFU);
        TEST_ASSERT_NOT_EQUAL(0U, verdict.chosen);
        TEST_ASSERT_TRUE(verdict.usable);
        const double expected = 0.25 / (gyros - 0.75);
        TEST_ASSERT_FLOAT_WITHIN(0.1F * (float)expected + 0.01F, (float)expected,
                                 verdict.weight[0]);
        const uint8_t chosen = verdict.chosen;
        own[0] = 1.0;
        own[chosen] = 5.0;
        fly(20U, 0xFU, 0xFU);
        TEST_ASSERT_NOT_EQUAL(chosen, verdict.chosen);
    }
}

static void test_common_motion_cancels_with_three_gyros_and_hides_the_noise_of_two(void)
{
    for (uint8_t gyros = 2U; gyros <= GYROS; gyros++) {
        setUp();
        config.gyros = gyros;
        config.axes = 3U;
        TEST_ASSERT_TRUE(starts());
        motion = 0.3;
        own[0] = 2.0;
        fly(300U, 0xFU, 0xFU);
        TEST_ASSERT_EQUAL(gyros == 2U, verdict.hidden);
        TEST_ASSERT_EQUAL(gyros == 2U, verdict.chosen == 0U);
        const float expected = (gyros == 2U) ? 0.5F : (0.25F / ((float)gyros - 0.75F));
        TEST_ASSERT_FLOAT_WITHIN(0.03F, expected, verdict.weight[0]);
        fly(100U, 0x3U, 0xFU); /* two are left */
        TEST_ASSERT_TRUE(verdict.hidden);
        fly(100U, 0x1U, 0xFU);
        TEST_ASSERT_FALSE(verdict.hidden);
        TEST_ASSERT_EQUAL_FLOAT(1.0F, verdict.weight[0]);
    }
}

/* Scale and time mismatch, within the tolerances, could be larger than the noise. */
static void test_violent_motion_hides_the_noise_of_any_number_of_gyros(void)
{
    for (uint8_t gyros = 2U; gyros <= GYROS; gyros++) {
        setUp();
        config.gyros = gyros;
        TEST_ASSERT_TRUE(starts());
        motion = 5.0;
        fly(50U, 0xFU, 0xFU); /* nothing was learned yet */
        TEST_ASSERT_TRUE(verdict.hidden);
        TEST_ASSERT_FLOAT_WITHIN(0.15F, 1.0F / (float)gyros, verdict.weight[1]);
        motion = 0.0;
        own[0] = 2.0;
        fly(300U, 0xFU, 0xFU);
        TEST_ASSERT_FALSE(verdict.hidden);
        const davar_select_verdict_t before = verdict;
        TEST_ASSERT_NOT_EQUAL(0U, before.chosen);
        motion = 5.0;
        own[before.chosen] = 3.0;
        for (uint32_t t = 0U; t < 300U; t++) {
            fly(1U, 0xFU, 0xFU);
            TEST_ASSERT_TRUE(verdict.hidden);
            TEST_ASSERT_EQUAL(before.chosen, verdict.chosen);
            TEST_ASSERT_FLOAT_WITHIN(1e-6F, before.weight[0], verdict.weight[0]);
        }
    }
}

static void test_an_absent_gyro_is_left_at_once_and_returns_after_2_s(void)
{
    TEST_ASSERT_TRUE(starts());
    fly(100U, 0xFU, 0xFU);
    TEST_ASSERT_EQUAL(0U, verdict.chosen);
    fly(1U, 0x6U, 0xFU);
    TEST_ASSERT_TRUE(verdict.switched);
    TEST_ASSERT_NOT_EQUAL(0U, verdict.chosen);
    TEST_ASSERT_EQUAL(DAVAR_SELECT_ABSENT, verdict.fault[0]);
    TEST_ASSERT_EQUAL_FLOAT(0.0F, verdict.weight[0]);
    fly(21U, 0xFU, 0xFU); /* the first sample of these has no step */
    TEST_ASSERT_EQUAL(DAVAR_SELECT_ABSENT, verdict.fault[0]);
    fly(1U, 0xFU, 0xFU);
    TEST_ASSERT_EQUAL(0U, verdict.fault[0]);
    TEST_ASSERT_TRUE(verdict.weight[0] > 0.2F);
    fly(1U, 0x0U, 0xFU);
    TEST_ASSERT_FALSE(verdict.usable);
    TEST_ASSERT_FALSE(verdict.switched);
    for (uint32_t i = 0U; i < 3U; i++) {
        TEST_ASSERT_EQUAL_FLOAT(0.0F, verdict.weight[i]);
    }
}

static void test_a_stuck_gyro_is_left_after_3_blocks(void)
{
    TEST_ASSERT_TRUE(starts());
    fly(100U, 0xFU, 0xFU);
    fly(3U, 0xFU, 0xEU); /* the first of these still has a step */
    TEST_ASSERT_EQUAL(0U, verdict.fault[0]);
    fly(1U, 0xFU, 0xEU);
    TEST_ASSERT_EQUAL(DAVAR_SELECT_STUCK, verdict.fault[0]);
    TEST_ASSERT_NOT_EQUAL(0U, verdict.chosen);
    fly(50U, 0xFU, 0xEU);
    TEST_ASSERT_EQUAL(DAVAR_SELECT_STUCK, verdict.fault[0]);
    fly(1U, 0xFU, 0xDU); /* the others are not chosen because they are silent */
    TEST_ASSERT_NOT_EQUAL(0U, verdict.chosen);
}

static void test_a_mean_that_jumps_is_reported_and_named_if_two_others_agree(void)
{
    for (uint8_t gyros = 2U; gyros <= GYROS; gyros++) {
        for (uint8_t axes = 1U; axes <= 3U; axes++) {
            setUp();
            config.gyros = gyros;
            config.axes = axes;
            TEST_ASSERT_TRUE(starts());
            bias[1] = 5.0;
            fly(200U, 0xFU, 0xFU);
            TEST_ASSERT_FALSE(verdict.disagree);
            bias[0] = -1.0;
            fly(12U, 0xFU, 0xFU);
            TEST_ASSERT_TRUE(verdict.disagree);
            TEST_ASSERT_EQUAL((gyros > 2U) ? DAVAR_SELECT_MEAN : 0U, verdict.fault[0]);
            TEST_ASSERT_EQUAL(0U, verdict.fault[1]);
            TEST_ASSERT_EQUAL(gyros == 2U, verdict.chosen == 0U);
            bias[0] = 0.0;
            fly(60U, 0xFU, 0xFU);
            TEST_ASSERT_FALSE(verdict.disagree);
            TEST_ASSERT_EQUAL((gyros > 2U) ? DAVAR_SELECT_MEAN : 0U, verdict.fault[0]);
            fly(150U, 0xFU, 0xFU);
            TEST_ASSERT_EQUAL(0U, verdict.fault[0]);
        }
    }
}

/* The biases drift on while a gyro is absent, within the tolerance. */
static void test_a_gyro_that_returns_within_the_drift_tolerance_is_trusted(void)
{
    TEST_ASSERT_TRUE(starts());
    fly(300U, 0xFU, 0xFU);
    fly(6000U, 0xEU, 0xFU); /* 600 s */
    bias[0] = 0.3;          /* a quarter of the tolerance */
    fly(25U, 0xFU, 0xFU);
    for (uint32_t t = 0U; t < 1000U; t++) {
        fly(1U, 0xFU, 0xFU);
        TEST_ASSERT_EQUAL(0U, verdict.fault[0]);
        TEST_ASSERT_FALSE(verdict.disagree);
    }
    bias[0] = 1.3; /* the tolerance is small again */
    fly(40U, 0xFU, 0xFU);
    TEST_ASSERT_EQUAL(DAVAR_SELECT_MEAN, verdict.fault[0]);
}

static void check_verdict(void)
{
    float sum = 0.0F;
    bool usable = false;
    for (uint32_t i = 0U; i < config.gyros; i++) {
        const uint8_t bad = DAVAR_SELECT_ABSENT | DAVAR_SELECT_STUCK | DAVAR_SELECT_MEAN;
        const bool good = (verdict.fault[i] & bad) == 0U;
        TEST_ASSERT_TRUE((verdict.weight[i] >= 0.0F) && (verdict.weight[i] <= 1.0F));
        TEST_ASSERT_EQUAL(good, verdict.weight[i] > 0.0F);
        sum += verdict.weight[i];
        usable = usable || good;
    }
    TEST_ASSERT_EQUAL(usable, verdict.usable);
    TEST_ASSERT_FLOAT_WITHIN(1e-5F, usable ? 1.0F : 0.0F, sum);
    TEST_ASSERT_TRUE(verdict.chosen < config.gyros);
    TEST_ASSERT_EQUAL(usable, verdict.weight[verdict.chosen] > 0.0F);
}

/* A gyro that saturates repeats its full scale. */
static void test_a_saturated_gyro_is_left(void)
{
    TEST_ASSERT_TRUE(starts());
    fly(100U, 0xFU, 0xFU);
    for (uint32_t t = 0U; t < 10U; t++) {
        for (uint32_t k = 0U; k < config.block; k++) {
            const float rate = 250.0F + (float)(10U * t + k);
            const float rates[3] = {250.0F, rate, rate + (0.05F * (float)random_gauss(&source))};
            (void)davar_select_add(&selection, rates);
        }
        davar_select_update(&selection, &verdict);
        check_verdict();
    }
    TEST_ASSERT_EQUAL(DAVAR_SELECT_STUCK, verdict.fault[0]);
    TEST_ASSERT_NOT_EQUAL(0U, verdict.chosen);
}

static void test_two_means_of_four_that_jump_are_reported_but_not_named(void)
{
    config.gyros = 4U;
    TEST_ASSERT_TRUE(starts());
    fly(200U, 0xFU, 0xFU);
    bias[0] = 1.0;
    bias[1] = -1.0;
    fly(20U, 0xFU, 0xFU);
    TEST_ASSERT_TRUE(verdict.disagree);
    for (uint32_t i = 0U; i < 4U; i++) {
        TEST_ASSERT_EQUAL(0U, verdict.fault[i]);
    }
}

static void test_noise_far_beyond_the_past_is_a_warning_until_it_ends(void)
{
    for (uint8_t gyros = 2U; gyros <= GYROS; gyros++) {
        setUp();
        config.gyros = gyros;
        TEST_ASSERT_TRUE(starts());
        fly(600U, 0xFU, 0xFU);
        TEST_ASSERT_EQUAL(0U, verdict.fault[1]);
        own[1] = 10.0;
        fly(60U, 0xFU, 0xFU);
        TEST_ASSERT_EQUAL(DAVAR_SELECT_NOISE, verdict.fault[1]);
        TEST_ASSERT_EQUAL(0U, verdict.fault[0]);
        TEST_ASSERT_TRUE(verdict.weight[1] < 0.1F);
        fly(20U, 0x1U, 0xFU);
        TEST_ASSERT_EQUAL(DAVAR_SELECT_NOISE | DAVAR_SELECT_ABSENT, verdict.fault[1]);
        own[1] = 1.0;
        fly(200U, 0xFU, 0xFU);
        TEST_ASSERT_EQUAL(0U, verdict.fault[1]);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_settings_out_of_range_are_refused);
    RUN_TEST(test_the_quieter_gyro_is_chosen_and_weighs_more);
    RUN_TEST(test_common_motion_cancels_with_three_gyros_and_hides_the_noise_of_two);
    RUN_TEST(test_violent_motion_hides_the_noise_of_any_number_of_gyros);
    RUN_TEST(test_an_absent_gyro_is_left_at_once_and_returns_after_2_s);
    RUN_TEST(test_a_stuck_gyro_is_left_after_3_blocks);
    RUN_TEST(test_a_mean_that_jumps_is_reported_and_named_if_two_others_agree);
    RUN_TEST(test_a_gyro_that_returns_within_the_drift_tolerance_is_trusted);
    RUN_TEST(test_a_saturated_gyro_is_left);
    RUN_TEST(test_two_means_of_four_that_jump_are_reported_but_not_named);
    RUN_TEST(test_noise_far_beyond_the_past_is_a_warning_until_it_ends);
    return UNITY_END();
}
