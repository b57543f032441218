/* davar tests - noise with light and heavy tails: how often the intervals of davar_fit contain the
 * true value. Fixed seed. Prints the tables of DESIGN (5.19). With other arguments, `test_tails
 * WINDOWS SEED`, it is the long run. */
#include "davar/davar.h"
#include "davar/fit.h"
#include "heavy_noise.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>

#define COUNTS 100.0 /* per standard deviation of the noise */
#define LONGEST 2000U
#define MISSED 7.0 /* percent of the intervals, at most; one exception */

static unsigned windows = 1500U;
static uint64_t seed = UINT64_C(20261127);

void setUp(void) {}

void tearDown(void) {}

/* ---- intervals ---- */

static const davar_filter_t no_filter = {.poles = 0U};
static const davar_filter_t low_pass = {.cutoff = 0.1, .poles = 2U};

typedef struct {
    const noise_kind_t *kind;
    const davar_filter_t *filter; /* declared */
    uint32_t window;
    bool has_kurtosis;
} scenario_t;

/* Percent. */
typedef struct {
    double adev[DAVAR_TAUS_MAX];
    double arw;
    double extra; /* windows with a term that is not there */
    double width; /* median of high over low of the ARW */
} held_t;

static uint64_t memory[4096];
static uint64_t law_memory[16384];
static davar_t davar;
static davar_plan_t plan;
static davar_result_t result;
static uint32_t taus[DAVAR_TAUS_MAX];

static davar_config_t config_of(const scenario_t *scenario)
{
    davar_config_t config = davar_default_config;
    config.law = NULL;
    config.window.mode = DAVAR_MODE_TRAILING;
    config.window.longest = scenario->window;
    config.window.shortest = scenario->window;
    config.moments.segment = scenario->has_kurtosis ? 100U : 0U;
    config.stride = scenario->window;
    config.rate_hz = 1.0;
    config.unit_per_count = 1.0 / COUNTS;
    config.taus = taus;
    config.tau_count = davar_taus_octave(scenario->window, taus, DAVAR_TAUS_MAX);
    return config;
}

/* The next sample of noise of N = 1; both states of the low-pass get noise of the kind. */
static double next_sample(const scenario_t *scenario, source_t *source, low_pass_t *state)
{
    const double first = scenario->kind->next(source);
    if (scenario->filter->poles == 0U) {
        return first;
    }
    const double second = scenario->kind->next(source);
    return sqrt((double)plan.sample) * low_pass_advance(state, 0.0, first, second);
}

static bool contains(double low, double high, double truth)
{
    return !(truth < low) && (truth <= high); /* low: NaN if the term is absent */
}

static void count_window(held_t *held)
{
    const davar_coefficient_t *const arw = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
    held->arw += contains(arw->low, arw->high, 60.0) ? 1.0 : 0.0;
    bool extra = false;
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++) {
        extra = extra || ((k != (int)DAVAR_ANGLE_RANDOM_WALK) && result.coefficient[k].present);
    }
    held->extra += extra ? 1.0 : 0.0;
    for (int t = 0; t < result.tau_count; t++) {
        const double truth = sqrt((double)plan.gain[t] / result.tau[t].m);
        held->adev[t] += contains(result.tau[t].low, result.tau[t].high, truth) ? 1.0 : 0.0;
    }
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

static held_t observe(const scenario_t *scenario)
{
    const davar_config_t config = config_of(scenario);
    source_t source = source_seeded(seed + scenario->window);
    low_pass_t state = low_pass_of(scenario->filter, 1.0);
    held_t held = {.arw = 0.0};
    double *const width = malloc(windows * sizeof *width);
    TEST_ASSERT_NOT_NULL(width);
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q31(&davar, &config, memory, sizeof memory));
    davar_plan_init_filtered(&plan, taus, config.tau_count, scenario->filter);
    for (unsigned i = 0U; i < windows; i++) {
        for (uint32_t k = 0U; k < scenario->window; k++) {
            const int32_t sample = (int32_t)lround(COUNTS * next_sample(scenario, &source, &state));
            davar_push_q31(&davar, &sample, 1U);
        }
        TEST_ASSERT_TRUE(davar_take(&davar, &result));
        davar_fit(&plan, config.rate_hz, &result);
        count_window(&held);
        const davar_coefficient_t *const arw = &result.coefficient[DAVAR_ANGLE_RANDOM_WALK];
        width[i] = (arw->present && (arw->low > 0.0)) ? arw->high / arw->low : (double)INFINITY;
    }
    qsort(width, windows, sizeof *width, ascending);
    held.width = width[windows / 2U];
    free(width);
    return held;
}

/* Returns the median width. */
static double check_intervals(const scenario_t *scenario, double missed)
{
    const held_t held = observe(scenario);
    const double percent = 100.0 / windows;
    double least = held.arw;
    printf("| %s%s | %u | %.1f | %.3f | %.1f |", scenario->kind->name,
           (scenario->filter->poles > 0U) ? ", low-pass" : "", (unsigned)scenario->window,
           percent * held.arw, held.width, percent * held.extra);
    for (int t = 0; t < result.tau_count; t++) {
        printf(" %.1f", percent * held.adev[t]);
        least = fmin(least, held.adev[t]);
    }
    printf(" |\n");
    const double error = sqrt(missed * (100.0 - missed) / windows); /* of a share, percent */
    TEST_ASSERT_TRUE(percent * least >= 100.0 - missed - (2.0 * error));
    TEST_ASSERT_TRUE(percent * held.extra <= 3.0);
    return held.width;
}

static void test_intervals_hold_whatever_the_tails_are(void)
{
    static const uint32_t lengths[] = {300U, 600U, LONGEST};
    printf("| noise | L | ARW | median high/low | a term that is not there | ADEV |\n");
    for (size_t i = 0U; i < (sizeof lengths / sizeof lengths[0]); i++) {
        for (size_t k = 0U; k < NOISE_WHITE_KINDS; k++) {
            const scenario_t scenario = {&noise_kinds[k], &no_filter, lengths[i], true};
            (void)check_intervals(&scenario, MISSED);
        }
    }
}

/* A filter hides tails without a fourth moment: Student's t with three degrees may miss (DESIGN,
 * 5.19). */
static void test_they_hold_after_a_filter(void)
{
    for (size_t k = 0U; k < NOISE_WHITE_KINDS; k++) {
        const scenario_t scenario = {&noise_kinds[k], &low_pass, 600U, true};
        (void)check_intervals(&scenario, (noise_kinds[k].next == noise_student3) ? 14.0 : MISSED);
    }
}

/* Without moments a window has no kurtosis, and tails are unknown. */
static void test_gaussian_intervals_are_hardly_wider(void)
{
    const scenario_t with = {&noise_kinds[0], &no_filter, 600U, true};
    const scenario_t without = {&noise_kinds[0], &no_filter, 600U, false};
    const double width = check_intervals(&with, MISSED);
    TEST_ASSERT_TRUE(width <= 1.02 * check_intervals(&without, MISSED));
}

/* ---- windows that a law chooses ---- */

typedef struct {
    const davar_law_t *law;
    const davar_filter_t *filter;
    uint32_t shortest;
    uint32_t longest;
    uint32_t segment; /* 0: no moments, so the scatter of the law's blocks counts */
    uint32_t every;   /* samples */
} chosen_t;

static void observe_law(const noise_kind_t *kind, const chosen_t *chosen)
{
    const scenario_t scenario = {kind, chosen->filter, 600U, false};
    davar_config_t config = config_of(&scenario);
    source_t source = source_seeded(seed);
    low_pass_t state = low_pass_of(chosen->filter, 1.0);
    held_t held = {.arw = 0.0};
    unsigned count = 0U;
    config.law = chosen->law;
    config.window.longest = chosen->longest;
    config.window.shortest = chosen->shortest;
    config.moments.segment = chosen->segment;
    config.window.grow = 1U;
    config.stride = 100U;
    config.rate_hz = 100.0;
    if (chosen->law == &davar_law_glr_q31) {
        davar_whiten(&config, chosen->filter);
    }
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q31(&davar, &config, law_memory, sizeof law_memory));
    davar_plan_init_filtered(&plan, taus, config.tau_count, chosen->filter);
    for (uint32_t i = 0U; i < (windows + 10U) * chosen->every; i++) {
        const int32_t sample = (int32_t)lround(COUNTS * next_sample(&scenario, &source, &state));
        davar_push_q31(&davar, &sample, 1U);
        if (((i % chosen->every) == 0U) && (i >= 10U * chosen->every) &&
            davar_take(&davar, &result) && !result.young) {
            davar_fit(&plan, 1.0, &result);
            count_window(&held);
            count++;
        }
    }
    printf(" %.1f, %.1f |", 100.0 * held.arw / count, 100.0 * held.adev[0] / count);
    TEST_ASSERT_TRUE(count >= (windows * 9U) / 10U);
    const double error = sqrt(MISSED * (100.0 - MISSED) / count);
    TEST_ASSERT_TRUE(100.0 * held.arw / count >= 100.0 - MISSED - (2.0 * error));
}

static void test_windows_that_a_law_chooses_hold(void)
{
    static const chosen_t chosen[] = {
        {&davar_law_glr_q31, &no_filter, 20U, 600U, 0U, 600U},
        {&davar_law_glr_q31, &no_filter, 20U, 6000U, 0U, 6000U},
        {&davar_law_glr_q31, &low_pass, 20U, 600U, 0U, 600U},
        {&davar_law_glr_q31, &low_pass, 20U, 6000U, 0U, 6000U},
        {&davar_law_or, &no_filter, 400U, 600U, 100U, 1200U},
    };
    printf(
        "| noise | ARW and ADEV(1), glr, to 600 | to 6000 | low-pass, to 600 | to 6000 | or |\n");
    for (size_t k = 0U; k < NOISE_WHITE_KINDS; k++) {
        printf("| %s |", noise_kinds[k].name);
        for (size_t c = 0U; c < (sizeof chosen / sizeof chosen[0]); c++) {
            observe_law(&noise_kinds[k], &chosen[c]);
        }
        printf("\n");
    }
}

/* ---- every number type decides the same ---- */

static void test_every_number_type_widens_as_much(void)
{
    static davar_t other[2];
    static uint64_t room[2][4096];
    const scenario_t scenario = {&noise_kinds[4], &no_filter, 300U, true};
    davar_config_t config = config_of(&scenario);
    source_t source = source_seeded(seed);
    config.full_scale = 32768.0 / COUNTS;
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q31(&davar, &config, memory, sizeof memory));
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&other[0], &config, room[0], sizeof room[0]));
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_f32(&other[1], &config, room[1], sizeof room[1]));
    davar_plan_init_white(&plan, taus, config.tau_count);
    unsigned taken = 0U;
    unsigned widened = 0U;
    for (uint32_t i = 0U; i < 40U * scenario.window; i++) {
        const double x = fmax(-300.0, fmin(300.0, scenario.kind->next(&source)));
        const int32_t wide = (int32_t)lround(COUNTS * x);
        const int16_t narrow = (int16_t)wide;
        const float rate = (float)(wide / COUNTS);
        davar_push_q31(&davar, &wide, 1U);
        davar_push_q15(&other[0], &narrow, 1U);
        davar_push_f32(&other[1], &rate, 1U);
        if (!davar_take(&davar, &result)) {
            continue;
        }
        davar_fit(&plan, config.rate_hz, &result);
        const double edf = result.tau[0].edf;
        taken++;
        widened += (edf < 0.5 * scenario.window) ? 1U : 0U;
        TEST_ASSERT_TRUE(davar_take(&other[0], &result));
        davar_fit(&plan, config.rate_hz, &result);
        TEST_ASSERT_EQUAL_DOUBLE(edf, result.tau[0].edf);
        TEST_ASSERT_TRUE(davar_take(&other[1], &result));
        davar_fit(&plan, config.rate_hz, &result);
        TEST_ASSERT_DOUBLE_WITHIN(1e-4 * edf, edf, result.tau[0].edf); /* a finer count */
    }
    TEST_ASSERT_EQUAL_UINT(40U, taken);
    TEST_ASSERT_TRUE(widened >= 30U);
}

/* ---- (5.19): the variance that tails add, in brute force ---- */

#define LENGTH 100U
#define TRIALS 20000U

/* sum over j of A_jj^2, where x'Ax is the Allan variance times m */
static double squared_diagonal(uint32_t m)
{
    const double n = LENGTH - (2.0 * m) + 1.0;
    double sum = 0.0;
    for (uint32_t j = 0U; j < LENGTH; j++) {
        double covering = 0.0;
        for (uint32_t i = 0U; i + (2U * m) <= LENGTH; i++) {
            covering += ((j >= i) && (j < i + (2U * m))) ? 1.0 : 0.0;
        }
        sum += pow(covering / (2.0 * m * n), 2.0);
    }
    return sum;
}

static double variance_of(const noise_kind_t *kind, uint32_t m)
{
    source_t source = source_seeded(seed);
    double x[LENGTH];
    double sum = 0.0;
    double squares = 0.0;
    for (unsigned trial = 0U; trial < TRIALS; trial++) {
        double y = 0.0;
        for (uint32_t j = 0U; j < LENGTH; j++) {
            x[j] = kind->next(&source);
        }
        for (uint32_t i = 0U; i + (2U * m) <= LENGTH; i++) {
            double d = 0.0;
            for (uint32_t j = 0U; j < m; j++) {
                d += x[i + m + j] - x[i + j];
            }
            y += d * d / (2.0 * m * (LENGTH - (2.0 * m) + 1.0));
        }
        sum += y;
        squares += y * y;
    }
    return (squares - (sum * sum / TRIALS)) / TRIALS;
}

static void test_the_variance_that_tails_add_is_that_of_brute_force(void)
{
    static const uint32_t sizes[] = {1U, 4U, 10U, 25U, 50U};
    static const double ratios[] = {1.0, 1.013, 1.029, 1.193, 3.846}; /* of the term used */
    for (size_t i = 0U; i < (sizeof sizes / sizeof sizes[0]); i++) {
        const double m = sizes[i];
        const double n = LENGTH - (2.0 * m) + 1.0;
        const double diagonal = squared_diagonal(sizes[i]);
        if (n >= (2.0 * m) - 1.0) {
            const double exact = n - (2.0 * m / 3.0) + (1.0 / (6.0 * m));
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, 1.0, exact / (n * n * diagonal));
        }
        TEST_ASSERT_DOUBLE_WITHIN(0.01, ratios[i], 1.0 / ((n + (0.5 * m)) * diagonal));
        if ((10U * sizes[i]) > LENGTH) {
            continue; /* too few differences for the variance of their mean square */
        }
        const double gauss = variance_of(&noise_kinds[0], sizes[i]);
        const double laplace = variance_of(&noise_kinds[2], sizes[i]); /* kurtosis 6 */
        TEST_ASSERT_DOUBLE_WITHIN(0.06, 1.0, (gauss + (3.0 * diagonal)) / laplace);
    }
}

int main(int argc, char **argv)
{
    if (argc == 3) {
        windows = (unsigned)strtoul(argv[1], NULL, 10);
        seed = strtoull(argv[2], NULL, 10);
    }
    UNITY_BEGIN();
    RUN_TEST(test_intervals_hold_whatever_the_tails_are);
    RUN_TEST(test_they_hold_after_a_filter);
    RUN_TEST(test_gaussian_intervals_are_hardly_wider);
    RUN_TEST(test_windows_that_a_law_chooses_hold);
    RUN_TEST(test_every_number_type_widens_as_much);
    RUN_TEST(test_the_variance_that_tails_add_is_that_of_brute_force);
    return UNITY_END();
}
