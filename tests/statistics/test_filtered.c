/* davar tests - the angle random walk after a filter: how often its interval contains the true
 * value, and its error over the Cramer-Rao bound. Monte Carlo over independent windows, fixed
 * seeds. Prints the tables of DESIGN (5.16) and (5.17). */
#include "autocovariance.h"
#include "davar/average.h"
#include "davar/fit.h"
#include "filter_cases.h"
#include "gyro_noise.h"
#include "low_pass.h"
#include "observed.h"
#include "unity.h"

#include <stdio.h>

#define WINDOWS 2000U
#define LONGEST 2000U
#define SLACK 0.7 /* standard error of a share near 95 % is 0.5 */

/* Filters that are hard to notice, undeclared only. */
static const case_t wide[] = {
    {"1 pole 0.4", {.cutoff = 0.4, .poles = 1U}},
    {"2 poles 0.4", {.cutoff = 0.4, .poles = 2U}},
};

/* ---- noise ---- */

static autocovariance_t of_noise;
static random_t rng;
static double samples[LONGEST];

/* Samples of white noise of N = 1 after the filter. */
static void make_noise(const davar_filter_t *filter, uint32_t window)
{
    static double fine[(4U * LONGEST) + 16U];
    double h[16];
    low_pass_t low_pass = low_pass_of(filter, filter_decimation(filter));
    const uint32_t taps = (uint32_t)impulse_response(filter, h);
    const uint32_t step = (uint32_t)filter_decimation(filter);
    low_pass.state[0] = random_gauss(&rng);
    low_pass.state[1] = (filter->poles == 2U) ? random_gauss(&rng) : 0.0;
    for (uint32_t i = 0U; i < (step * window) + taps; i++) {
        const double first = random_gauss(&rng);
        fine[i] = low_pass_advance(&low_pass, 0.0, first,
                                   (filter->poles == 2U) ? random_gauss(&rng) : 0.0);
    }
    const double size = 1.0 / sqrt(of_noise.sum);
    for (uint32_t i = 0U; i < window; i++) {
        samples[i] = 0.0;
        for (uint32_t j = 0U; j < taps; j++) {
            samples[i] += size * h[j] * fine[(i * step) + j];
        }
    }
}

/* Sums of rounded counts of a gyro that is faster: davar_average makes each of `length` counts. The
 * noise has N = 1 at the rate of the sums. */
static void make_sums(const davar_filter_t *fast, uint16_t length, uint32_t window, double count)
{
    low_pass_t low_pass = low_pass_of(fast, 1.0);
    const double size = sqrt((double)length / of_noise.sum) / count;
    const double mean = 100.0 * random_uniform(&rng);
    davar_average_t average;
    davar_average_init(&average, length);
    low_pass.state[0] = random_gauss(&rng);
    low_pass.state[1] = (fast->poles == 2U) ? random_gauss(&rng) : 0.0;
    for (uint32_t i = 0U; i < window;) {
        const double first = random_gauss(&rng);
        const double rate =
            low_pass_advance(&low_pass, 0.0, first, (fast->poles == 2U) ? random_gauss(&rng) : 0.0);
        int32_t sum = 0;
        if (davar_average_push(&average, (int32_t)lround(mean + (size * rate)), &sum)) {
            samples[i] = (count / length) * (double)sum;
            i++;
        }
    }
}

/* Drifts at 8 times the sample rate, made once: they pass the low-pass of each case. */
#define FASTER 8U
#define DRIFT_WINDOW 600U
#define SETTLING 60U
#define DRIFT_LENGTH ((size_t)FASTER * (DRIFT_WINDOW + SETTLING))
#define DRIFTS 500U

typedef struct {
    const char *name;
    int kind; /* of `drift` */
    double size;
} drift_t;

static float drift[3][DRIFTS][DRIFT_LENGTH]; /* B = 1, K = 1, R = 1 */

static void make_drifts(void)
{
    static double rate[DRIFT_LENGTH];
    const gyro_noise_t noise[] = {
        {.flicker = 1.0}, {.walk = 1.0 / sqrt((double)FASTER)}, {.ramp = 1.0 / (double)FASTER}};
    rng = random_seeded(952U);
    for (size_t k = 0U; k < 3U; k++) {
        for (uint32_t i = 0U; i < DRIFTS; i++) {
            gyro_noise_fill(&noise[k], &rng, rate, DRIFT_LENGTH);
            for (uint32_t n = 0U; n < DRIFT_LENGTH; n++) {
                drift[k][i][n] = (float)rate[n];
            }
        }
    }
}

/* Without a low-pass, a sample is the mean over its time. Moving averages are left out: they would
 * lower short sizes further. */
static void add_drift(const davar_filter_t *filter, const drift_t *which, uint32_t trial)
{
    low_pass_t low_pass = low_pass_of(filter, (double)FASTER);
    const float *const rate = drift[which->kind][trial % DRIFTS];
    double mean = 0.0;
    low_pass.state[0] = (double)rate[0];
    for (uint32_t n = 0U; n < DRIFT_LENGTH; n++) {
        const uint32_t at = n / FASTER;
        const double passed = low_pass_advance(&low_pass, (double)rate[n], 0.0, 0.0);
        mean += passed / (double)FASTER;
        if (n % FASTER == FASTER - 1U) {
            if (at >= SETTLING) {
                samples[at - SETTLING] += which->size * ((filter->poles > 0U) ? passed : mean);
            }
            mean = 0.0;
        }
    }
}

/* ---- windows ---- */

static davar_plan_t plan;
static davar_result_t result;

static void round_to_counts(uint32_t window, double count)
{
    const double mean = 100.0 * random_uniform(&rng);
    for (uint32_t i = 0U; i < window; i++) {
        samples[i] = count * round((samples[i] / count) + mean);
    }
}

static void observe(uint32_t window)
{
    static double phase[LONGEST + 1U];
    observe_window(samples, window, phase, &result);
}

static uint8_t set_taus(uint32_t window, uint32_t taus[])
{
    const uint8_t count = davar_taus_octave(window, taus, DAVAR_TAUS_MAX);
    result = (davar_result_t){.window_samples = window, .tau_count = count};
    for (int t = 0; t < count; t++) {
        result.tau[t].m = taus[t];
        result.tau[t].differences = window + 1U - (2U * taus[t]);
    }
    return count;
}

/* Root of the Cramer-Rao bound of ln N, with rounding as white noise. */
static double bound(uint32_t window, double count)
{
    double sum = 0.0;
    for (int i = 0; i < 256; i++) {
        double s = of_noise.r[0];
        for (int k = 1; k < of_noise.count; k++) {
            s += 2.0 * of_noise.r[k] * cos(AUTOCOVARIANCE_PI * k * (i + 0.5) / 256.0);
        }
        sum += pow(s / (s + (count * count / 12.0)), 2.0) / 256.0;
    }
    return 1.0 / sqrt(2.0 * window * sum);
}

typedef struct {
    double present; /* percent of windows with an interval */
    double within;  /* percent of these that contain the true value */
    double held;    /* percent of windows whose interval or upper limit contains it */
    double bias;    /* of the values, percent */
    double rms;     /* their error over the Cramer-Rao bound */
} score_t;

static void count_window(score_t *score)
{
    const davar_coefficient_t *const walk = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
    const bool holds = (!walk->present || (walk->low <= 60.0)) && (walk->high >= 60.0);
    score->held += holds ? 1.0 : 0.0;
    if (walk->present) {
        const double error = (walk->value / 60.0) - 1.0;
        score->present += 1.0;
        score->within += holds ? 1.0 : 0.0;
        score->bias += error;
        score->rms += error * error;
    }
}

static void to_percent(score_t *score, double error)
{
    const double present = (score->present > 0.0) ? score->present : 1.0;
    score->rms = sqrt(score->rms / present) / error;
    score->bias *= 100.0 / present;
    score->within *= 100.0 / present;
    score->held *= 100.0 / WINDOWS;
    score->present *= 100.0 / WINDOWS;
}

typedef enum { DECLARED, UNDECLARED, WHITE } knowledge_t;

static void init_plan(knowledge_t knowledge, const davar_filter_t *filter, uint32_t window)
{
    uint32_t taus[DAVAR_TAUS_MAX];
    const uint8_t count = set_taus(window, taus);
    if (knowledge == DECLARED) {
        davar_plan_init_filtered(&plan, taus, count, filter);
    } else if (knowledge == UNDECLARED) {
        davar_plan_init(&plan, taus, count);
    } else {
        davar_plan_init_white(&plan, taus, count);
    }
}

static const drift_t no_drift = {"", 0, 0.0};

/* `real`: the filter of the noise; `declared`: that of the plan. */
static score_t measured(const case_t *real, knowledge_t knowledge, const davar_filter_t *declared,
                        uint32_t window, double sigma, const drift_t *added)
{
    score_t score = {0};
    rng = random_seeded(20260733U);
    autocovariance_of(&real->filter, &of_noise);
    init_plan(knowledge, declared, window);
    const double count = sqrt(of_noise.r[0]) / sigma;
    for (uint32_t i = 0U; i < WINDOWS; i++) {
        make_noise(&real->filter, window);
        if (added->size > 0.0) {
            add_drift(&real->filter, added, i);
        }
        round_to_counts(window, count);
        observe(window);
        result.unit_per_count = count;
        davar_fit(&plan, 1.0, &result);
        count_window(&score);
    }
    to_percent(&score, bound(window, count));
    printf("%-12s | %5u | %4.1f | %-7s | %5.1f | %5.1f | %5.1f | %+5.1f | %4.2f\n", real->name,
           (unsigned)window, sigma, added->name, score.present, score.within, score.held,
           score.bias, score.rms);
    return score;
}

/* ---- sums of a fast gyro ---- */

/* `sums`: the filter of the plan, DAVAR_SUM included; sigma: of a sample of the fast gyro. */
static score_t measured_sums(const case_t *sums, uint32_t window, double sigma)
{
    score_t score = {0};
    const uint16_t length = sums->filter.summed;
    const davar_filter_t fast = {.cutoff = sums->filter.cutoff / length,
                                 .poles = sums->filter.poles};
    rng = random_seeded(20260734U);
    init_plan(DECLARED, &sums->filter, window);
    autocovariance_of(&fast, &of_noise);
    const double count = sqrt(length * of_noise.r[0] / of_noise.sum) / sigma;
    for (uint32_t i = 0U; i < WINDOWS; i++) {
        make_sums(&fast, length, window, count);
        observe(window);
        result.unit_per_count = count / length;
        davar_fit(&plan, 1.0, &result);
        count_window(&score);
    }
    autocovariance_of(&sums->filter, &of_noise);
    to_percent(&score, bound(window, count / sqrt((double)length)));
    printf("%-12s | %5u | %4.1f | %-7s | %5.1f | %5.1f | %5.1f | %+5.1f | %4.2f\n", sums->name,
           (unsigned)window, sigma, "", score.present, score.within, score.held, score.bias,
           score.rms);
    return score;
}

static void test_sums_of_a_fast_gyro(void)
{
    static const case_t fast[] = {
        {"white, sum of 8", {DAVAR_SUM(8U)}},
        {"8 kHz to 1 kHz, 250 Hz", {DAVAR_LOW_PASS(250, 1000, 2), DAVAR_SUM(8U)}},
        {"1 kHz to 100 Hz, 41 Hz", {DAVAR_LOW_PASS(41, 100, 2), DAVAR_SUM(10U)}},
        {"1 kHz to 100 Hz, 92 Hz", {DAVAR_LOW_PASS(92, 100, 1), DAVAR_SUM(10U)}},
    };
    static const double sigmas[] = {30.0, 3.0, 1.0, 0.6};
    printf("sums of a fast gyro; sigma of a sample before the sum\n");
    for (size_t c = 0U; c < 4U; c++) {
        case_t known = fast[c];
        known.filter.uncertainty = 0.0;
        for (size_t i = 0U; i < 4U; i++) {
            const score_t score = measured_sums(&known, 600U, sigmas[i]);
            TEST_ASSERT_TRUE((score.present < 1.0) || (score.within >= 94.0 - SLACK));
            TEST_ASSERT_TRUE((sigmas[i] < 3.0) || (score.present >= 99.0));
            TEST_ASSERT_TRUE((sigmas[i] < 3.0) || (score.rms <= 1.25));
            TEST_ASSERT_TRUE(fabs(score.bias) <= 2.0);
        }
    }
}

/* ---- a known filter ---- */

static const uint32_t windows[] = {300U, 600U, 2000U};

static void check_known(double sigma)
{
    printf("known filter\n");
    for (size_t c = 0U; c < CASES; c++) {
        for (size_t w = 0U; w < 3U; w++) {
            const score_t score =
                measured(&cases[c], DECLARED, &cases[c].filter, windows[w], sigma, &no_drift);
            TEST_ASSERT_TRUE(score.present >= 99.0);
            TEST_ASSERT_TRUE(score.within >= 94.0 - SLACK);
            TEST_ASSERT_TRUE(score.within <= 98.5 + SLACK);
            TEST_ASSERT_TRUE(score.rms <= 1.25);
        }
    }
}

static void test_a_known_filter(void)
{
    check_known(30.0);
}

static void test_a_known_filter_and_large_counts(void)
{
    check_known(3.0);
}

static void test_a_cutoff_that_is_off_by_its_uncertainty(void)
{
    printf("cutoff declared with 10 %%, 10 %% too high, then too low\n");
    for (size_t c = 0U; c < CASES; c++) {
        for (int way = 0; (cases[c].filter.poles > 0U) && (way < 2); way++) {
            davar_filter_t declared = cases[c].filter;
            declared.uncertainty = 0.1;
            declared.cutoff *= (way == 0) ? 1.1 : 0.9;
            const score_t half = measured(&cases[c], DECLARED, &declared, 600U, 30.0, &no_drift);
            const score_t full = measured(&cases[c], DECLARED, &declared, 2000U, 30.0, &no_drift);
            TEST_ASSERT_TRUE(half.within >= 94.0 - SLACK);
            TEST_ASSERT_TRUE(full.within >= 92.0 - SLACK);
        }
    }
}

static void test_white_noise_of_about_one_count(void)
{
    const case_t *const white = &cases[WHITE_CASE];
    printf("white noise of few counts\n");
    for (size_t w = 0U; w < 3U; w++) {
        for (int i = 0; i < 2; i++) {
            const double sigma = (i == 0) ? 1.0 : 0.5;
            const score_t score =
                measured(white, DECLARED, &white->filter, windows[w], sigma, &no_drift);
            TEST_ASSERT_TRUE(score.within >= 94.0 - SLACK);
            TEST_ASSERT_TRUE(fabs(score.bias) <= 2.0);
        }
    }
}

static const drift_t drifts[] = {{"B 0.1", 0, 0.1},   {"B 0.3", 0, 0.3},     {"K 0.02", 1, 0.02},
                                 {"K 0.05", 1, 0.05}, {"R 0.001", 2, 0.001}, {"R 0.003", 2, 0.003}};
#define DRIFT_KINDS (sizeof drifts / sizeof drifts[0])

static void test_drifts_that_pass_a_narrow_filter(void)
{
    const case_t *const narrow = &cases[NARROW_CASE];
    printf("drifts that pass the filter\n");
    for (size_t d = 0U; d < DRIFT_KINDS; d++) {
        const score_t score =
            measured(narrow, DECLARED, &narrow->filter, DRIFT_WINDOW, 30.0, &drifts[d]);
        TEST_ASSERT_TRUE(score.within >= 90.0);
        TEST_ASSERT_TRUE(score.held >= 90.0);
    }
}

/* ---- an unknown filter ---- */

static void check_reported(const score_t *score)
{
    TEST_ASSERT_TRUE((score->present * WINDOWS < 30.0 * 100.0) || (score->within >= 90.0));
}

static void check_unknown(const case_t *real)
{
    for (size_t w = 0U; w < 3U; w++) {
        const score_t score = measured(real, UNDECLARED, NULL, windows[w], 30.0, &no_drift);
        check_reported(&score);
    }
    for (size_t d = 0U; d < DRIFT_KINDS; d++) {
        const score_t score = measured(real, UNDECLARED, NULL, DRIFT_WINDOW, 30.0, &drifts[d]);
        check_reported(&score);
    }
}

static void test_an_unknown_filter(void)
{
    printf("unknown filter\n");
    for (size_t c = 0U; c < CASES; c++) {
        check_unknown(&cases[c]);
    }
    check_unknown(&wide[0]);
    check_unknown(&wide[1]);
}

static void test_white_noise_is_estimated_as_if_it_were_declared(void)
{
    const case_t *const white = &cases[WHITE_CASE];
    printf("white noise, unknown and known\n");
    for (size_t w = 0U; w < 3U; w++) {
        const score_t unknown = measured(white, UNDECLARED, NULL, windows[w], 30.0, &no_drift);
        const score_t known = measured(white, WHITE, NULL, windows[w], 30.0, &no_drift);
        TEST_ASSERT_TRUE(unknown.rms <= 1.02 * known.rms);
        TEST_ASSERT_TRUE(unknown.within >= known.within - SLACK);
    }
}

void setUp(void) {}

void tearDown(void) {}

int main(void)
{
    make_drifts();
    printf("filter | window | sigma / count | drift | with an interval %% | of these hold %% | "
           "statements that hold %% | bias %% | rms over the bound\n");
    UNITY_BEGIN();
    RUN_TEST(test_sums_of_a_fast_gyro);
    RUN_TEST(test_a_known_filter);
    RUN_TEST(test_a_known_filter_and_large_counts);
    RUN_TEST(test_a_cutoff_that_is_off_by_its_uncertainty);
    RUN_TEST(test_white_noise_of_about_one_count);
    RUN_TEST(test_drifts_that_pass_a_narrow_filter);
    RUN_TEST(test_an_unknown_filter);
    RUN_TEST(test_white_noise_is_estimated_as_if_it_were_declared);
    return UNITY_END();
}
