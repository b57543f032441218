/* davar tests - the level since the last alarm: how often all intervals of a record contain the
 * true level. Fixed seed. Prints the tables of DESIGN (10.18). With
 * arguments, `test_steady RUNS SEED`, it is the long run. */
#include "davar/davar.h"
#include "davar/fit.h"
#include "heavy_noise.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>

#define RATE_HZ 100.0
#define SECOND 100U /* samples; a result each */
#define HOUR (3600U * SECOND)
#define DAY (24U * HOUR)

static unsigned runs = 12U;
static uint64_t seed = UINT64_C(20261128);

void setUp(void) {}

void tearDown(void) {}

static const davar_filter_t no_filter = {.poles = 0U};
static const davar_filter_t one_pole = {.cutoff = 0.1, .poles = 1U};
static const davar_filter_t two_poles = {.cutoff = 0.1, .poles = 2U};
static const davar_filter_t narrow = {.cutoff = 0.05, .poles = 2U};

static uint64_t memory[16384];
static davar_t davar;
static davar_result_t result;
static davar_plan_t plan;

/* A record: its noise, and how its level changes. */
typedef struct {
    double (*next)(source_t *source);
    const davar_filter_t *filter; /* declared */
    double counts;                /* per standard deviation of the noise before it */
    uint32_t samples;
    double (*level)(uint32_t sample); /* null: 1 */
    uint32_t gap_every;               /* samples from one gap to the next; 0: none */
} record_t;

/* What a record showed, at each result from the first with an interval on. */
typedef struct {
    uint32_t results;
    uint32_t missed;   /* intervals without the true level */
    double worst;      /* largest distance of the level from its interval, relative */
    double width[2];   /* high over low after 10 min and at the end; 0: none was shown */
    uint32_t restarts; /* without an alarm */
    uint32_t alarms;
} shown_t;

static void start(const record_t *record)
{
    static const uint32_t taus[] = {1U, 2U, 4U};
    static davar_config_t config; /* the instance keeps its address */
    config = davar_default_config;
    config.law = &davar_law_glr_q15;
    config.window.mode = DAVAR_MODE_TRAILING;
    config.window.longest = 6000U;
    config.window.shortest = 20U;
    config.moments.segment = 0U;
    config.rate_hz = RATE_HZ;
    config.unit_per_count = 1.0 / record->counts;
    config.stride = SECOND;
    config.taus = taus;
    config.tau_count = 3U;
    if (record->filter->poles > 0U) {
        davar_whiten(&config, record->filter);
    }
    TEST_ASSERT_EQUAL(DAVAR_OK, davar_init_q15(&davar, &config, memory, sizeof memory));
    davar_plan_init_filtered(&plan, taus, 3U, record->filter);
}

static void note(shown_t *shown, double truth, uint64_t before, uint32_t second)
{
    const davar_steady_t *const steady = &result.steady;
    shown->alarms += result.alarm ? 1U : 0U;
    shown->restarts += (!result.alarm && (steady->samples < before)) ? 1U : 0U;
    if (steady->samples == 0U) {
        TEST_ASSERT_TRUE(isnan(steady->low) && isnan(steady->high) && isnan(steady->level));
        return;
    }
    TEST_ASSERT_TRUE((steady->low <= steady->level) && (steady->level <= steady->high));
    shown->results++;
    shown->missed += ((truth < steady->low) || (truth > steady->high)) ? 1U : 0U;
    const double distance = fmax(steady->low / truth, truth / steady->high) - 1.0;
    shown->worst = fmax(shown->worst, distance);
    const double width = steady->high / steady->low;
    if (second <= 600U) {
        shown->width[0] = width;
    }
    shown->width[1] = width;
}

static shown_t show(const record_t *record, uint64_t number)
{
    source_t source = source_seeded(number);
    low_pass_t low_pass = low_pass_of(record->filter, 1.0);
    shown_t shown = {.results = 0U};
    uint64_t before = 0U;
    start(record);
    const double gain = sqrt((double)plan.sample);
    for (uint32_t i = 0U; i < record->samples; i++) {
        const double level = (record->level == NULL) ? 1.0 : record->level(i);
        double x = level * record->next(&source);
        if (record->filter->poles > 0U) {
            x = gain * low_pass_advance(&low_pass, 0.0, x, level * record->next(&source));
        }
        const double counts = floor((record->counts * x) + 0.5);
        const int16_t sample = (int16_t)fmax(-32768.0, fmin(32767.0, counts));
        davar_push_q15(&davar, &sample, 1U);
        if ((record->gap_every > 0U) && ((i % record->gap_every) == 0U)) {
            davar_gap(&davar, 1U);
        }
        if (davar_take(&davar, &result)) {
            note(&shown, level, before, (i + 1U) / SECOND);
            before = result.steady.samples;
        }
    }
    return shown;
}

/* ---- noise that does not change ---- */

/* Of n days, each with a probability of 95 %: four standard errors fewer than expected. */
static unsigned least_of(unsigned n)
{
    const double least = (0.95 * n) - (4.0 * sqrt(0.95 * 0.05 * n));
    return (unsigned)fmax(0.0, floor(least));
}

static void check_quiet(const char *name, const record_t *record)
{
    unsigned contained = 0U;
    double width[2] = {0.0};
    unsigned with[2] = {0U};
    double alarms = 0.0;
    double restarts = 0.0;
    double shown_of = 0.0;
    for (unsigned run = 0U; run < runs; run++) {
        const shown_t shown = show(record, seed + run);
        contained += (shown.missed == 0U) ? 1U : 0U;
        alarms += shown.alarms;
        restarts += shown.restarts;
        shown_of += shown.results;
        for (int i = 0; i < 2; i++) {
            width[i] += shown.width[i];
            with[i] += (shown.width[i] > 0.0) ? 1U : 0U;
        }
    }
    const double hours = (double)runs * record->samples / HOUR;
    const double present = shown_of * SECOND / ((double)runs * record->samples);
    printf("| %s | %.1f | %.1f | %.3f | %.4f | %.4f | %.4f |\n", name, 100.0 * present,
           100.0 * contained / runs, width[0] / with[0], width[1] / with[1], alarms / hours,
           restarts / hours);
    const bool heavy = (record->next == noise_student3) || (record->next == noise_mixed);
    TEST_ASSERT_TRUE_MESSAGE(heavy ? (present < 0.01) : (present > 0.98), name);
    TEST_ASSERT_TRUE_MESSAGE(heavy || (contained >= least_of(runs)), name);
}

static void test_all_intervals_of_a_day_contain_unchanged_noise(void)
{
    printf("| noise, 24 h | present, %% | days contained, %% | 10 min | 24 h | alarms/h | "
           "restarts/h |\n");
    for (size_t k = 0U; k < NOISE_WHITE_KINDS; k++) {
        const record_t record = {noise_kinds[k].next, &no_filter, 100.0, DAY, NULL, 0U};
        check_quiet(noise_kinds[k].name, &record);
    }
}

/* The first 25 minutes, while the dispersion is learned. */
static void test_heavy_tails_show_no_wrong_interval(void)
{
    static const struct {
        const char *name;
        double (*next)(source_t *source);
    } rows[] = {{"student4", noise_student4},
                {"student3", noise_student3},
                {"mixed", noise_mixed},
                {"rare10", noise_rare10},
                {"rare20", noise_rare20}};
    const unsigned records = 10U * runs;
    printf("| noise, 25 min | present, %% | records without a wrong interval, %% |\n");
    for (size_t i = 0U; i < sizeof rows / sizeof rows[0]; i++) {
        const record_t record = {rows[i].next, &no_filter, 100.0, 1500U * SECOND, NULL, 0U};
        unsigned contained = 0U;
        double present = 0.0;
        for (unsigned run = 0U; run < records; run++) {
            const shown_t shown = show(&record, seed + run);
            contained += (shown.missed == 0U) ? 1U : 0U;
            present += shown.results / (1500.0 * records);
        }
        printf("| %s | %.1f | %.1f |\n", rows[i].name, 100.0 * present,
               100.0 * contained / records);
        TEST_ASSERT_TRUE_MESSAGE(contained >= least_of(records), rows[i].name);
    }
}

static void test_filters_and_coarse_counts_shift_no_interval(void)
{
    static const struct {
        const char *name;
        const davar_filter_t *filter;
        double counts;
    } rows[] = {{"one pole at 0.1", &one_pole, 100.0},   {"one pole at 0.1", &one_pole, 5.0},
                {"two poles at 0.1", &two_poles, 100.0}, {"two poles at 0.05", &narrow, 1000.0},
                {"two poles at 0.05", &narrow, 50.0},    {"two poles at 0.05", &narrow, 15.0},
                {"no filter", &no_filter, 5.0},          {"no filter", &no_filter, 0.75}};
    char name[64];
    for (size_t i = 0U; i < sizeof rows / sizeof rows[0]; i++) {
        const record_t record = {noise_gauss, rows[i].filter, rows[i].counts, DAY, NULL, 0U};
        (void)snprintf(name, sizeof name, "gauss, %s, %g counts", rows[i].name, rows[i].counts);
        check_quiet(name, &record);
    }
}

/* ---- noise that changes ---- */

static double rising(uint32_t sample)
{
    return 1.0 + (0.1 * sample / HOUR);
}

/* A change every four minutes, up and down. */
#define TURN (240U * SECOND)

static double steps_of(uint32_t sample, double ratio)
{
    return (((sample / TURN) % 2U) == 0U) ? 1.0 : ratio;
}

static double quarter(uint32_t sample)
{
    return steps_of(sample, 1.25);
}

static double half(uint32_t sample)
{
    return steps_of(sample, 1.5);
}

static double twice(uint32_t sample)
{
    return steps_of(sample, 2.0);
}

static double thrice(uint32_t sample)
{
    return steps_of(sample, 3.0);
}

static shown_t show_all(const record_t *record)
{
    shown_t all = {.results = 0U};
    for (unsigned run = 0U; run < runs; run++) {
        const shown_t shown = show(record, seed + run);
        all.missed += shown.missed;
        all.results += shown.results;
        all.restarts += shown.restarts;
        all.worst = fmax(all.worst, shown.worst);
    }
    return all;
}

static void print_changing(const char *name, const shown_t *shown)
{
    const double changes = runs * 6.0 * HOUR / TURN;
    printf("| %s | %.2f | %.2f | %.1f | %.2f |\n", name, 100.0 * shown->missed / shown->results,
           shown->missed / changes, 100.0 * shown->worst, shown->restarts / (6.0 * runs));
}

static void test_changing_noise_is_missed_until_its_alarm(void)
{
    static const struct {
        const char *name;
        double (*level)(uint32_t sample);
        double most; /* percent of the results without the true level */
    } rows[] = {
        {"x1.25", quarter, 4.0}, {"x1.5", half, 1.5}, {"x2", twice, 0.7}, {"x3", thrice, 0.5}};
    printf("| noise, 6 h | missed, %% | s per change | farthest, %% | restarts/h |\n");
    for (size_t i = 0U; i < sizeof rows / sizeof rows[0]; i++) {
        const record_t record = {noise_gauss, &no_filter, 100.0, 6U * HOUR, rows[i].level, 0U};
        const shown_t shown = show_all(&record);
        print_changing(rows[i].name, &shown);
        TEST_ASSERT_TRUE(100.0 * shown.missed <= rows[i].most * shown.results);
    }
}

/* Gaps of one sample in half a block before each place where the parts are compared. */
static void test_slowly_rising_noise_begins_new_sections(void)
{
    for (int gaps = 0; gaps < 2; gaps++) {
        const record_t record = {noise_gauss, &no_filter, 100.0,
                                 6U * HOUR,   rising,     (gaps > 0) ? 635U : 0U};
        const shown_t shown = show_all(&record);
        print_changing((gaps > 0) ? "+10 % per hour, with gaps" : "+10 % per hour", &shown);
        TEST_ASSERT_TRUE(shown.worst < 0.04);
        TEST_ASSERT_TRUE(shown.restarts >= 6U * runs);
    }
}

int main(int argc, char **argv)
{
    if (argc == 3) {
        runs = (unsigned)strtoul(argv[1], NULL, 10);
        seed = strtoull(argv[2], NULL, 10);
    }
    UNITY_BEGIN();
    RUN_TEST(test_all_intervals_of_a_day_contain_unchanged_noise);
    RUN_TEST(test_heavy_tails_show_no_wrong_interval);
    RUN_TEST(test_filters_and_coarse_counts_shift_no_interval);
    RUN_TEST(test_changing_noise_is_missed_until_its_alarm);
    RUN_TEST(test_slowly_rising_noise_begins_new_sections);
    return UNITY_END();
}
