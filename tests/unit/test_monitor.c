/* davar tests - the monitor: its formula compared with erfc and known values, the compared taus,
 * rejected settings. */
#include "davar/fit.h"
#include "davar/monitor.h"
#include "random.h"
#include "unity.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const davar_model_tau_t table[3] = {{4U, 0.5, 0.0}, {1U, 1.0, 0.0}, {2U, 0.7, 0.1}};
static davar_monitor_t monitor;
static davar_result_t result;
static davar_misfit_t misfit;

static void set_tau(uint8_t t, uint32_t m, double adev, double edf)
{
    result.tau[t] = (davar_adev_t){.m = m, .differences = 100U, .adev = adev, .edf = edf};
}

void setUp(void)
{
    result = (davar_result_t){.epoch = 1000U, .window_samples = 100U, .tau_count = 3};
    set_tau(0, 1U, 1.0, 50.0);
    set_tau(1, 2U, 0.7, 40.0);
    set_tau(2, 4U, 0.5, 20.0);
    TEST_ASSERT_EQUAL(DAVAR_MONITOR_OK, davar_monitor_init(&monitor, table, 3U, 4.0));
}

void tearDown(void) {}

static double tail(double z)
{
    return erfc(z / sqrt(2.0)); /* two-sided */
}

/* The cube root of the C library is the reference. */
static void test_a_deviation_is_the_normal_score_of_the_variance_ratio(void)
{
    for (int power = -32; power < 36; power++) {
        for (int root = 0; root < 10; root++) {
            const double adev = pow(1.78, power);
            const double edf = pow(3.1, root);
            const davar_model_tau_t model = {1U, 3.0, 0.25};
            const double ratio = fmin(1e12, fmax(1e-12, adev * adev / 9.0));
            const double scatter = 2.0 / (9.0 * edf);
            const double wanted =
                (cbrt(ratio) - 1.0 + scatter) / sqrt(scatter + 0.25 * 0.25 * 4.0 / 9.0);
            TEST_ASSERT_DOUBLE_WITHIN(1e-12 * fmax(1.0, fabs(wanted)), wanted,
                                      davar_deviation(adev, edf, &model));
        }
    }
}

/* Chi-square at 97.5 %, 20 degrees of freedom, is 34.170 (NIST table): 1.96 standard deviations
 * up. */
static void test_a_deviation_meets_the_published_quantiles(void)
{
    const davar_model_tau_t model = {1U, 1.0, 0.0};
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 1.96, davar_deviation(sqrt(34.170 / 20.0), 20.0, &model));
    TEST_ASSERT_DOUBLE_WITHIN(0.02, -1.96, davar_deviation(sqrt(9.591 / 20.0), 20.0, &model));
    TEST_ASSERT_DOUBLE_WITHIN(0.01, 1.96, davar_deviation(sqrt(129.561 / 100.0), 100.0, &model));
}

/* deviation| at health 1 must have a tail of 0.5 % over the number of taus, for every number, to
 * four decimals. */
static void test_the_limit_is_the_stated_share_for_every_number_of_taus(void)
{
    davar_model_tau_t one[DAVAR_TAUS_MAX];
    for (uint8_t count = 1U; count <= DAVAR_TAUS_MAX; count++) {
        for (uint8_t t = 0U; t < count; t++) {
            one[t] = (davar_model_tau_t){t + 1U, 1.0, 0.0};
            set_tau(t, t + 1U, 1.3, 30.0);
        }
        result.tau_count = count;
        TEST_ASSERT_EQUAL(DAVAR_MONITOR_OK, davar_monitor_init(&monitor, one, count, 1.0));
        davar_monitor_update(&monitor, &result, &misfit);
        TEST_ASSERT_DOUBLE_WITHIN(2e-6, 0.005, count * tail(misfit.tau[0].deviation / misfit.fast));
    }
}

static void test_taus_are_matched_by_m_and_absent_ones_reported(void)
{
    set_tau(1, 3U, 0.7, 40.0);
    result.tau[2].differences = 0U;
    result.tau[2].adev = (double)NAN;
    davar_monitor_update(&monitor, &result, &misfit);
    TEST_ASSERT_EQUAL(DAVAR_TAU_COMPARED, misfit.tau[0].match);
    TEST_ASSERT_EQUAL(DAVAR_TAU_NOT_IN_MODEL, misfit.tau[1].match);
    TEST_ASSERT_EQUAL(DAVAR_TAU_NOT_IN_WINDOW, misfit.tau[2].match);
    TEST_ASSERT_EQUAL(1, misfit.compared);
    TEST_ASSERT_EQUAL(0, misfit.worst);
    TEST_ASSERT_TRUE(isnan(misfit.tau[1].deviation) && isnan(misfit.tau[2].deviation));
    TEST_ASSERT_TRUE(isnan(misfit.tau[2].mean_deviation));
    TEST_ASSERT_TRUE(misfit.health < 0.1);
}

static void test_without_comparisons_there_is_no_health(void)
{
    result.tau_count = 1;
    set_tau(0, 3U, 0.7, 40.0);
    davar_monitor_update(&monitor, &result, &misfit);
    TEST_ASSERT_TRUE(isnan(misfit.health) && isnan(misfit.fast) && isnan(misfit.slow));
    TEST_ASSERT_EQUAL(0, misfit.compared);
    TEST_ASSERT_EQUAL(misfit.tau_count, misfit.worst);
}

/* A result without a fit has no degrees of freedom. The fewest of any noise replace them, and one
 * such window leaves no trace. */
static void test_a_window_that_no_fit_explains_is_compared_too(void)
{
    davar_misfit_t unfitted;
    davar_monitor_t fitted = monitor;
    for (uint8_t t = 0U; t < 3U; t++) {
        result.tau[t].differences = 101U - (2U * result.tau[t].m);
        result.tau[t].edf = (double)NAN;
        const double least = fmin(fmin(davar_edf(DAVAR_QUANTIZATION, result.tau[t].m, 100U),
                                       davar_edf(DAVAR_ANGLE_RANDOM_WALK, result.tau[t].m, 100U)),
                                  fmin(davar_edf(DAVAR_BIAS_INSTABILITY, result.tau[t].m, 100U),
                                       davar_edf(DAVAR_RATE_RANDOM_WALK, result.tau[t].m, 100U)));
        TEST_ASSERT_DOUBLE_WITHIN(1e-8 * least, least,
                                  davar_edf_least(&result, t)); /* the evidence has 32 bits */
    }
    davar_monitor_update(&monitor, &result, &unfitted);
    for (uint8_t t = 0U; t < 3U; t++) {
        result.tau[t].edf = davar_edf_least(&result, t);
    }
    davar_monitor_update(&fitted, &result, &misfit);
    TEST_ASSERT_EQUAL_MEMORY(&misfit, &unfitted, sizeof misfit);
    TEST_ASSERT_TRUE(isfinite(unfitted.health));
}

/* A value that is not an Allan deviation, from any source, is not compared. */
static void test_bad_allan_deviations_are_skipped(void)
{
    static const double none[] = {(double)NAN, (double)INFINITY, -(double)INFINITY, -1.0};
    for (size_t i = 0U; i < (sizeof none / sizeof none[0]); i++) {
        result.tau[1].adev = none[i];
        davar_monitor_update(&monitor, &result, &misfit);
        TEST_ASSERT_EQUAL(DAVAR_TAU_NOT_IN_WINDOW, misfit.tau[1].match);
        TEST_ASSERT_TRUE(isnan(misfit.tau[1].deviation) && isfinite(misfit.health));
    }
}

/* (9.3): the largest share of its limit that a deviation uses, of this window, of the mean, and of
 * both. The limit of three taus is the normal quantile of 0.01 / 6, two-sided; this window alone
 * has half of it. */
static void test_health_is_the_largest_share_of_the_limit(void)
{
    random_t random = random_seeded(16U);
    for (uint32_t n = 0; n < 500U; n++) {
        double fast = 0.0;
        double slow = 0.0;
        uint8_t worst = 3U;
        if ((n % 5U) == 0U) {
            setUp(); /* long memories make the slow health decide, the first window the fast one */
        }
        for (uint8_t t = 0U; t < 3U; t++) {
            const double off = exp(0.3 * random_gauss(&random));
            set_tau(t, 1U << t, off * table[(t + 1U) % 3U].adev_dps,
                    5.0 + (double)(random_next(&random) % 50U));
        }
        result.epoch += 1U + (random_next(&random) % 150U);
        davar_monitor_update(&monitor, &result, &misfit);
        for (uint8_t t = 0U; t < 3U; t++) {
            const double before = fmax(fast, slow);
            fast = fmax(fast, fabs(misfit.tau[t].deviation) / 3.1440);
            slow = fmax(slow, fabs(misfit.tau[t].mean_deviation) / 3.1440);
            worst = (fmax(fast, slow) > before) ? t : worst;
        }
        TEST_ASSERT_EQUAL_DOUBLE(fast, misfit.fast);
        TEST_ASSERT_EQUAL_DOUBLE(slow, misfit.slow);
        TEST_ASSERT_EQUAL_DOUBLE(fmax(fast, slow), misfit.health);
        TEST_ASSERT_EQUAL(worst, misfit.worst);
    }
}

/* Four equal windows in a row count as four: their mean deviates twice as much as one. */
static void test_the_mean_of_four_windows_deviates_twice_as_much(void)
{
    set_tau(0, 1U, 1.05, 50.0);
    for (uint32_t n = 0; n < 4U; n++) {
        result.epoch += 100U;
        davar_monitor_update(&monitor, &result, &misfit);
    }
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 2.0 * misfit.tau[0].deviation, misfit.tau[0].mean_deviation);
}

/* The same result again and again adds no information. */
static void test_overlap_weighs_as_much_as_it_brings(void)
{
    set_tau(0, 1U, 1.05, 50.0);
    davar_monitor_update(&monitor, &result, &misfit);
    const double first = misfit.tau[0].mean_deviation;
    for (uint32_t n = 0; n < 300U; n++) {
        result.epoch++;
        davar_monitor_update(&monitor, &result, &misfit);
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.02, 2.0, misfit.tau[0].mean_deviation / first);
}

/* (9.4) for a size of a cascade that looks back over `span` samples. */
static const uint32_t hop = 10U;

static void set_long(uint32_t span, double adev)
{
    set_tau(0, 40U, adev, 50.0);
    result.tau[0].hops = 4U;
    result.tau[0].differences = 1U + ((span - (2U * 40U)) / hop);
}

static void start_long(void)
{
    static const davar_model_tau_t one[1] = {{40U, 1.0, 0.0}};
    TEST_ASSERT_EQUAL(DAVAR_MONITOR_OK, davar_monitor_init(&monitor, one, 1U, 4.0));
    result.tau_count = 1U;
}

/* While it forgets nothing, the newest value contains the older ones. */
static void test_a_size_of_a_cascade_that_grows_is_one_window(void)
{
    start_long();
    for (uint32_t span = 1000U; span < 9000U; span += 50U) {
        set_long(span, 1.05 - (1e-5 * span));
        result.epoch += 53U; /* no multiple of the hop */
        davar_monitor_update(&monitor, &result, &misfit);
        TEST_ASSERT_EQUAL_DOUBLE(misfit.tau[0].deviation, misfit.tau[0].mean_deviation);
        result.epoch++;
        davar_monitor_update(&monitor, &result, &misfit); /* nothing new */
    }
}

/* Once it forgets, its span counts, not the window. */
static void test_a_size_of_a_cascade_counts_what_it_looks_back_over(void)
{
    start_long();
    set_long(2000U, 1.05);
    davar_monitor_update(&monitor, &result, &misfit);
    for (uint32_t n = 0U; n < 15U; n++) {
        set_long(2000U - (((n % 2U) == 0U) ? 400U : 0U), 1.05); /* drops 800, then grows by 400 */
        result.epoch += 400U;
        davar_monitor_update(&monitor, &result, &misfit);
    }
    /* 2000 + 15 * 400 samples are four windows, twice the deviation of one. */
    TEST_ASSERT_DOUBLE_WITHIN(0.15, 2.0, misfit.tau[0].mean_deviation / misfit.tau[0].deviation);
}

static void test_a_stream_that_starts_again_is_a_new_window(void)
{
    davar_monitor_update(&monitor, &result, &misfit);
    result.epoch = 5U;
    set_tau(0, 1U, 1.1, 50.0);
    davar_monitor_update(&monitor, &result, &misfit);
    TEST_ASSERT_TRUE(misfit.tau[0].mean_deviation > 0.4 * misfit.tau[0].deviation);
}

/* The entry is between two good ones. */
static void assert_refused(davar_monitor_status_t status, davar_model_tau_t entry, uint8_t count,
                           double memory)
{
    davar_model_tau_t model[3] = {{7U, 1.0, 0.0}, {0}, {9U, 1.0, 0.0}};
    model[1] = entry;
    TEST_ASSERT_EQUAL(status, davar_monitor_init(&monitor, model, count, memory));
}

static void test_an_impossible_table_is_rejected(void)
{
    const double nan = (double)NAN;
    const double inf = (double)INFINITY;
    assert_refused(DAVAR_MONITOR_ERR_ADEV, (davar_model_tau_t){8U, 0.0, 0.0}, 3U, 4.0);
    assert_refused(DAVAR_MONITOR_ERR_ADEV, (davar_model_tau_t){8U, nan, 0.0}, 3U, 4.0);
    assert_refused(DAVAR_MONITOR_ERR_ADEV, (davar_model_tau_t){8U, inf, 0.0}, 3U, 4.0);
    assert_refused(DAVAR_MONITOR_ERR_TOLERANCE, (davar_model_tau_t){8U, 1.0, -0.1}, 3U, 4.0);
    assert_refused(DAVAR_MONITOR_ERR_TOLERANCE, (davar_model_tau_t){8U, 1.0, inf}, 3U, 4.0);
    assert_refused(DAVAR_MONITOR_ERR_TWICE, (davar_model_tau_t){7U, 1.0, 0.0}, 3U, 4.0);
    assert_refused(DAVAR_MONITOR_ERR_EMPTY, (davar_model_tau_t){8U, 1.0, 0.0}, 0U, 4.0);
    assert_refused(DAVAR_MONITOR_ERR_MEMORY, (davar_model_tau_t){8U, 1.0, 0.0}, 3U, 0.5);
    assert_refused(DAVAR_MONITOR_ERR_MEMORY, (davar_model_tau_t){8U, 1.0, 0.0}, 3U, nan);
    assert_refused(DAVAR_MONITOR_ERR_MEMORY, (davar_model_tau_t){8U, 1.0, 0.0}, 3U, inf);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_deviation_is_the_normal_score_of_the_variance_ratio);
    RUN_TEST(test_a_deviation_meets_the_published_quantiles);
    RUN_TEST(test_the_limit_is_the_stated_share_for_every_number_of_taus);
    RUN_TEST(test_taus_are_matched_by_m_and_absent_ones_reported);
    RUN_TEST(test_without_comparisons_there_is_no_health);
    RUN_TEST(test_a_window_that_no_fit_explains_is_compared_too);
    RUN_TEST(test_bad_allan_deviations_are_skipped);
    RUN_TEST(test_health_is_the_largest_share_of_the_limit);
    RUN_TEST(test_the_mean_of_four_windows_deviates_twice_as_much);
    RUN_TEST(test_overlap_weighs_as_much_as_it_brings);
    RUN_TEST(test_a_size_of_a_cascade_that_grows_is_one_window);
    RUN_TEST(test_a_size_of_a_cascade_counts_what_it_looks_back_over);
    RUN_TEST(test_a_stream_that_starts_again_is_a_new_window);
    RUN_TEST(test_an_impossible_table_is_rejected);
    return UNITY_END();
}
