/* davar tests - which of several gyros to trust: error rates, delays, fused noise and faults over
 * simulated flights, beside simple rules. Prints the tables of lib/src/select/DESIGN.md; fixed
 * seeds, other ones than those that the constants were chosen with. */
#include "davar/select.h"
#include "flight.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>

#define BLOCK 10U
#define MINUTES_20 12000U /* blocks */
#define SEED UINT64_C(0x6A70C0DE)
#define AHEAD 20U /* blocks; a switch that a change overtook within 2 s is not wrong */

static davar_select_config_t config;
static davar_select_t selection;
static davar_select_gyro_t gyro[DAVAR_SELECT_GYROS];
static davar_select_pair_t pair[DAVAR_SELECT_PAIRS(DAVAR_SELECT_GYROS)];
static davar_select_verdict_t verdict;
static flight_t flight;
static float square[DAVAR_SELECT_GYROS]; /* of the newest block */
static uint64_t flights;                 /* so far */
static uint32_t effort = 1U;             /* 10: the flights of the tables */

void setUp(void)
{
    config = (davar_select_config_t){
        .gyros = 3U, .axes = 1U, .block = BLOCK, .rate_hz = 100.0F, DAVAR_SELECT_DEFAULTS};
}
void tearDown(void) {}

static void assert_below(double most, double value)
{
    TEST_ASSERT_TRUE(value < most);
}

static void take_off(flight_noise_t kind)
{
    TEST_ASSERT_TRUE(davar_select_init(&selection, &config, gyro, pair));
    flight_start(&flight, SEED + flights, &config, kind);
    flights++;
}

/* One block. Of `stuck` and `absent` the bits are gyros. */
static void fly(uint32_t stuck, uint32_t absent)
{
    static float rates[DAVAR_SELECT_GYROS * DAVAR_SELECT_AXES];
    float before[DAVAR_SELECT_GYROS * DAVAR_SELECT_AXES];
    for (uint32_t k = 0U; k < config.block; k++) {
        memcpy(before, rates, sizeof before);
        flight_sample(&flight, rates);
        for (uint32_t i = 0U; i < (uint32_t)config.gyros * config.axes; i++) {
            rates[i] = (((stuck >> (i / config.axes)) & 1U) != 0U) ? before[i] : rates[i];
            rates[i] = (((absent >> (i / config.axes)) & 1U) != 0U) ? NAN : rates[i];
        }
        const bool full = davar_select_add(&selection, rates);
        TEST_ASSERT_EQUAL(k + 1U == config.block, full);
    }
    for (uint32_t i = 0U; i < config.gyros; i++) {
        square[i] = gyro[i].square[0] + gyro[i].square[1] + gyro[i].square[2];
    }
    davar_select_update(&selection, &verdict);
}

/* --- wrong switches --- */

typedef struct {
    const char *name;
    flight_noise_t kind;
    double shake;
    double vibration;
    double tone; /* at 23 Hz */
} ride_t;

/* Between gyros of equal noise, per 1000 hours, with `config`. A high stated rate makes short
 * flights a strict test. */
static void check_rate(const ride_t *ride, double hours)
{
    const double stated = (double)config.errors_per_1000_h;
    const uint32_t gyros = config.gyros;
    double excess = 0.0;
    uint32_t hidden = 0U;
    uint32_t switches = 0U;
    uint32_t alarms = 0U;
    const uint32_t count = (uint32_t)((3.0 * hours) + 0.5);
    for (uint32_t f = 0U; f < count; f++) {
        bool alarm = false;
        take_off(ride->kind);
        flight.tone_hz = 23.0;
        for (uint32_t t = 0U; t < MINUTES_20; t++) {
            const bool before = alarm;
            if (t == 600U) {
                flight.shake = ride->shake;
                flight.vibration = ride->vibration;
                flight.tone = ride->tone;
            }
            fly(0U, 0U);
            switches += verdict.switched ? 1U : 0U;
            hidden += verdict.hidden ? 1U : 0U;
            alarm = verdict.disagree;
            double fused = 0.0;
            for (uint32_t i = 0U; i < gyros; i++) {
                fused += (double)verdict.weight[i] * (double)verdict.weight[i] * gyros;
                alarm = alarm || (verdict.fault[i] != 0U);
            }
            excess += (fused > 0.0) ? (sqrt(fused) - 1.0) : 0.0;
            alarms += (alarm && !before) ? 1U : 0U;
        }
    }
    const double percent = 100.0 / (36000.0 * hours);
    printf("equal, %s, %u gyros, %u axes: stated %.0f per 1000 h, %.0f switches and %.0f alarms "
           "(%u, %u in %.1f h); fused %.2f %%, hidden %.0f %%\n",
           ride->name, gyros, config.axes, stated, 1000.0 * switches / hours,
           1000.0 * alarms / hours, switches, alarms, hours, percent * excess, percent * hidden);
    if ((ride->shake + ride->vibration + ride->tone) > 0.0) {
        assert_below(2.0, percent * excess);
    }
    TEST_ASSERT_LESS_OR_EQUAL(0.001 * stated * hours, switches);
    if (ride->kind != NOISE_MARKOV_STEP) { /* there the means wander, and alarms are right */
        TEST_ASSERT_LESS_OR_EQUAL(0.001 * stated * hours, alarms);
    }
}

static void test_gyros_of_equal_noise_switch_no_more_often_than_stated(void)
{
    static const ride_t noises[] = {{.name = "Gauss", .kind = NOISE_GAUSS},
                                    {.name = "Laplace", .kind = NOISE_LAPLACE},
                                    {.name = "Student t5", .kind = NOISE_STUDENT_5},
                                    {.name = "AR(1) 0.7", .kind = NOISE_MARKOV},
                                    {.name = "steps AR(1) 0.7", .kind = NOISE_MARKOV_STEP},
                                    {.name = "each sample three times", .kind = NOISE_HELD}};
    for (uint32_t n = 0U; n < 6U; n++) {
        config.gyros = 2U;
        config.axes = 1U;
        config.errors_per_1000_h = (effort > 1U) ? 100.0F : 10000.0F;
        check_rate(&noises[n], (effort > 1U) ? (20.0 * effort) : 2.0);
        config.errors_per_1000_h = 10000.0F;
        config.gyros = 4U;
        check_rate(&noises[n], effort);
        config.gyros = 3U;
        config.axes = 3U;
        check_rate(&noises[n], effort);
    }
}

/* At the default rate: a single switch fails. Mismatch of scale and time, within the tolerances,
 * makes gyros of equal noise look different. */
static void test_mismatch_in_motion_and_vibration_causes_no_switch(void)
{
    static const ride_t rides[] = {
        {.name = "shake 150", .shake = 150.0},   {.name = "shake 600", .shake = 600.0},
        {.name = "shake 1500", .shake = 1500.0}, {.name = "vibration", .vibration = 5.0},
        {.name = "tone 0.3", .tone = 0.3},       {.name = "tone 1", .tone = 1.0},
        {.name = "tone 5", .tone = 5.0}};
    for (uint32_t n = 0U; n < 7U; n++) {
        config.gyros = (uint8_t)(3U + (n % 2U));
        config.axes = 1U;
        config.time_tolerance_s = 0.0005F;
        check_rate(&rides[n], (effort > 1U) ? (double)effort : (1.0 / 3.0));
        if (effort > 1U) {
            config.axes = 3U;
            check_rate(&rides[n], effort);
            config.time_tolerance_s = 0.0012F;
            check_rate(&rides[n], effort);
            config.gyros = 2U;
            check_rate(&rides[n], effort);
        }
    }
}

/* --- delays --- */

/* Mean seconds until a chosen gyro whose noise grows is left. */
static double delay_of(uint8_t gyros, uint8_t axes, double ratio, double shake, uint32_t trials)
{
    config.gyros = gyros;
    config.axes = axes;
    config.errors_per_1000_h = 1.0F;
    double sum = 0.0;
    for (uint32_t f = 0U; f < trials; f++) {
        take_off(NOISE_GAUSS);
        flight.shake = shake;
        for (uint32_t t = 0U; t < 600U; t++) {
            fly(0U, 0U);
        }
        const uint32_t loud = verdict.chosen;
        flight.own[loud] = ratio;
        uint32_t blocks = 0U;
        while ((verdict.chosen == loud) && (blocks < 1200U)) {
            fly(0U, 0U);
            blocks++;
        }
        sum += 0.1 * blocks;
    }
    printf("x%.2f, %u gyros, %u axes, %s: %.2f s\n", ratio, gyros, axes,
           (shake > 0.0) ? "in motion" : "at rest", sum / trials);
    return sum / trials;
}

static void test_a_gyro_that_grows_louder_is_left_in_time(void)
{
    assert_below(20.0, delay_of(3U, 1U, 1.25, 0.0, 100U));
    assert_below(4.0, delay_of(3U, 1U, 1.5, 0.0, 400U));
    assert_below(4.3, delay_of(2U, 1U, 1.5, 0.0, 400U)); /* 3.9, and 8 standard errors */
    assert_below(4.0, delay_of(4U, 1U, 1.5, 0.0, 200U));
    assert_below(2.0, delay_of(3U, 3U, 1.5, 0.0, 200U));
    assert_below(2.2, delay_of(3U, 1U, 2.0, 0.0, 200U));
    assert_below(1.5, delay_of(3U, 3U, 5.0, 0.0, 200U));
    assert_below(5.0, delay_of(3U, 1U, 2.0, 150.0, 100U));
}

/* --- fused noise, and simple rules --- */

typedef struct {
    double equal; /* fused own noise over the optimum, sums over blocks */
    double fused;
    double single; /* of the chosen gyro over the quietest one */
    double least;
    double average;
    uint32_t switches;
    uint32_t least_switches;
    uint32_t average_switches;
    uint32_t wrong;
    uint32_t blocks;
} score_t;

typedef struct {
    float totals[BLOCK][DAVAR_SELECT_GYROS];
    double average[DAVAR_SELECT_GYROS]; /* of the noise, over 2 s */
    double past[AHEAD][DAVAR_SELECT_GYROS];
    uint32_t least;
    uint32_t smooth;
} rules_t;

/* The gyro with the least variance of 1 s; the gyro that an average of 2 s shows 10 % quieter. */
static void apply_rules(rules_t *rules, uint32_t t, score_t *score)
{
    uint32_t least = rules->least;
    uint32_t smooth = rules->smooth;
    double totals[DAVAR_SELECT_GYROS] = {0.0};
    for (uint32_t i = 0U; i < config.gyros; i++) {
        rules->totals[t % BLOCK][i] = square[i];
        const double noise = sqrt((double)square[i]);
        rules->average[i] += (noise - rules->average[i]) * ((t == 0U) ? 1.0 : 0.05);
        for (uint32_t k = 0U; k < BLOCK; k++) {
            totals[i] += (double)rules->totals[k][i];
        }
    }
    for (uint32_t i = 0U; i < config.gyros; i++) {
        least = (totals[i] < totals[least]) ? i : least;
        smooth = ((rules->average[i] < 0.9 * rules->average[rules->smooth]) &&
                  (rules->average[i] < rules->average[smooth]))
                     ? i
                     : smooth;
    }
    score->least_switches += (least != rules->least) ? 1U : 0U;
    score->average_switches += (smooth != rules->smooth) ? 1U : 0U;
    rules->least = least;
    rules->smooth = smooth;
}

static double excess_of(uint32_t i, double best)
{
    const double common = flight.vibration * flight.vibration;
    return sqrt(((flight.own[i] * flight.own[i]) + common) / (best + common)) - 1.0;
}

static void rate_block(const rules_t *rules, score_t *score)
{
    double inverse = 0.0;
    double equal = 0.0;
    double fused = 0.0;
    double best = 1e9;
    const double n = config.gyros;
    for (uint32_t i = 0U; i < config.gyros; i++) {
        const double own = flight.own[i] * flight.own[i];
        inverse += 1.0 / own;
        equal += own / (n * n);
        fused += (double)verdict.weight[i] * (double)verdict.weight[i] * own;
        best = (own < best) ? own : best;
    }
    score->equal += sqrt(equal * inverse) - 1.0;
    score->fused += sqrt(fused * inverse) - 1.0;
    score->single += excess_of(verdict.chosen, best);
    score->least += excess_of(rules->least, best);
    score->average += excess_of(rules->smooth, best);
    score->blocks++;
}

/* Was the new gyro not quieter than the old one at any time in the last 2 s? */
static bool is_wrong(const rules_t *rules, uint32_t before)
{
    bool wrong = true;
    for (uint32_t k = 0U; k < AHEAD; k++) {
        wrong = wrong && (rules->past[k][verdict.chosen] >= rules->past[k][before]);
    }
    return wrong;
}

static double wait_of(double mean_s)
{
    return -mean_s * log(random_uniform(&flight.random));
}

static uint32_t pick(uint32_t count)
{
    return (uint32_t)(random_uniform(&flight.random) * count);
}

typedef enum { EQUAL, STEPS, REGIMES } scene_t;

/* Changes of the truth: a gyro at a time that is louder; or vibration and noise of all. */
static void change(scene_t scene, double ratio, double motion, double now, double *due)
{
    static const double levels[] = {1.0, 1.1, 1.25, 1.5, 2.0};
    static const double vibrations[] = {0.0, 1.0, 2.0, 5.0};
    static uint32_t loud;
    if ((scene == STEPS) && (now >= due[0])) {
        flight.own[loud % config.gyros] = 1.0;
        loud = (loud + 1U + pick(config.gyros - 1U)) % config.gyros;
        flight.own[loud] = ratio;
        due[0] = now + 12.0 + wait_of(20.0);
    }
    for (uint32_t i = 0U; (scene == REGIMES) && (i < config.gyros); i++) {
        if (now >= due[i]) {
            flight.own[i] = levels[pick(5U)];
            due[i] = now + wait_of(30.0);
        }
    }
    if ((scene == REGIMES) && (now >= due[4])) {
        flight.vibration = vibrations[pick(4U)];
        due[4] = now + wait_of(10.0);
    }
    if (now >= due[5]) {
        flight.shake = (random_uniform(&flight.random) < motion) ? 150.0 : 3.0;
        due[5] = now + wait_of(10.0);
    }
}

static score_t score_of(const char *name, scene_t scene, double ratio, double motion,
                        uint32_t count)
{
    score_t score = {0};
    for (uint32_t f = 0U; f < count; f++) {
        rules_t rules = {.least = 0U};
        double due[6] = {5.0, 0.0, 0.0, 0.0, 0.0, 0.0};
        take_off(NOISE_GAUSS);
        for (uint32_t t = 0U; t < MINUTES_20; t++) {
            const uint32_t before = selection.chosen;
            change(scene, ratio, motion, 0.1 * t, due);
            memcpy(rules.past[t % AHEAD], flight.own, sizeof flight.own);
            fly(0U, 0U);
            apply_rules(&rules, t, &score);
            rate_block(&rules, &score);
            score.switches += verdict.switched ? 1U : 0U;
            score.wrong += (verdict.switched && is_wrong(&rules, before)) ? 1U : 0U;
        }
    }
    const double hours = score.blocks / 36000.0;
    const double percent = 100.0 / score.blocks;
    printf("%s, %u gyros, %u axes: fused %.2f %% (equal weights %.1f); one gyro %.1f %% with %.1f "
           "switches/h, %u wrong in %.0f h (least variance %.1f %%, %.0f; average %.1f %%, %.0f)\n",
           name, config.gyros, config.axes, percent * score.fused, percent * score.equal,
           percent * score.single, score.switches / hours, score.wrong, hours,
           percent * score.least, score.least_switches / hours, percent * score.average,
           score.average_switches / hours);
    return score;
}

static void check_fused(const char *name, scene_t scene, double ratio, double motion, double most)
{
    const score_t score = score_of(name, scene, ratio, motion, 3U * effort);
    assert_below(most, 100.0 * score.fused / score.blocks);
    TEST_ASSERT_LESS_OR_EQUAL(1U, score.wrong);
}

static void test_three_and_four_gyros_fuse_within_2_percent_of_the_optimum(void)
{
    for (uint8_t gyros = 3U; gyros <= 4U; gyros++) {
        config.gyros = gyros;
        config.axes = 1U;
        check_fused("equal", EQUAL, 1.0, 0.0, 0.5);
        check_fused("steps x1.5", STEPS, 1.5, 0.0, 2.0);
        check_fused("regimes", REGIMES, 1.0, 0.0, 2.0);
        check_fused("regimes, half in motion", REGIMES, 1.0, 0.5, 2.0);
        check_fused("steps x2, always in motion", STEPS, 2.0, 1.0, 2.0);
        config.axes = 3U;
        check_fused("regimes, half in motion", REGIMES, 1.0, 0.5, 2.0);
        check_fused("steps x2, always in motion", STEPS, 2.0, 1.0, 2.0);
    }
    config.gyros = 2U;
    config.axes = 1U;
    check_fused("regimes, half in motion", REGIMES, 1.0, 0.5, 8.0);
}

static void test_two_gyros_of_1_to_5_need_weights_and_three_the_same(void)
{
    for (uint8_t gyros = 2U; gyros <= 3U; gyros++) {
        config.gyros = gyros;
        score_t score = {0};
        const rules_t rules = {.least = 0U};
        take_off(NOISE_GAUSS);
        flight.own[1] = 5.0;
        flight.own[2] = 5.0;
        for (uint32_t t = 0U; t < MINUTES_20; t++) {
            fly(0U, 0U);
            rate_block(&rules, &score);
        }
        printf("constant 1:5, %u gyros: fused %.2f %%, equal weights %.0f %%\n", gyros,
               100.0 * score.fused / score.blocks, 100.0 * score.equal / score.blocks);
        assert_below(0.5, 100.0 * score.fused / score.blocks);
        TEST_ASSERT_DOUBLE_WITHIN(20.0, 155.0, 100.0 * score.equal / score.blocks);
    }
}

/* --- faults --- */

typedef enum { STUCK, DROPOUT, MEAN, NOISE } fault_t;

typedef struct {
    uint32_t found;
    uint32_t named;        /* the right gyro, and no other */
    uint32_t other;        /* another gyro was named */
    uint32_t chosen;       /* the selection stayed on the faulty gyro */
    uint32_t false_alarms; /* before the fault */
    double delay_s;
} found_t;

static uint32_t named_gyros(uint8_t bits)
{
    uint32_t named = 0U;
    for (uint32_t i = 0U; i < config.gyros; i++) {
        named |= ((verdict.fault[i] & bits) != 0U) ? (1U << i) : 0U;
    }
    return named;
}

static found_t faults_of(const char *name, fault_t fault, double size, double motion,
                         uint32_t trials)
{
    static const uint8_t bits[] = {DAVAR_SELECT_STUCK, DAVAR_SELECT_ABSENT, DAVAR_SELECT_MEAN,
                                   DAVAR_SELECT_NOISE};
    found_t result = {0};
    for (uint32_t f = 0U; f < trials; f++) {
        double due[6] = {0.0};
        take_off(NOISE_GAUSS);
        const uint32_t bad = 1U << pick(config.gyros);
        const uint32_t start = 2000U + pick(1000U);
        uint32_t found = 0U;
        for (uint32_t t = 0U; (t < start + 600U) && (found == 0U); t++) {
            const bool on = (t >= start);
            change(REGIMES, 1.0, motion, 0.1 * t, due);
            for (uint32_t i = 0U; on && (i < config.gyros) && (fault == NOISE); i++) {
                flight.own[i] = (bad == (1U << i)) ? size : 1.0;
            }
            if ((t == start) && (fault == MEAN)) {
                flight.bias[(bad == 1U) ? 0 : ((bad == 2U) ? 1 : ((bad == 4U) ? 2 : 3))][0] += size;
            }
            fly((on && (fault == STUCK)) ? bad : 0U, (on && (fault == DROPOUT)) ? bad : 0U);
            const uint32_t named = named_gyros(bits[fault]);
            const bool seen = (named != 0U) || ((fault == MEAN) && verdict.disagree);
            const bool enough = (fault == MEAN) && (config.gyros > 2U) ? (named != 0U) : seen;
            result.false_alarms += (seen && !on) ? 1U : 0U;
            if (enough && on) {
                found = t + 1U - start;
                result.named += (named == bad) ? 1U : 0U;
                result.other += ((named & ~bad) != 0U) ? 1U : 0U;
                result.chosen +=
                    ((fault != NOISE) && (config.gyros > 2U) && (bad == (1U << verdict.chosen)))
                        ? 1U
                        : 0U;
            }
        }
        result.found += (found > 0U) ? 1U : 0U;
        result.delay_s += 0.1 * found;
    }
    printf("%s, motion %.1f, %u gyros: found %.0f %%, mean %.1f s, named %u, others %u, false %u\n",
           name, motion, config.gyros, 100.0 * result.found / trials,
           result.delay_s / ((result.found > 0U) ? result.found : 1U), result.named, result.other,
           result.false_alarms);
    TEST_ASSERT_EQUAL(0U, result.other);
    TEST_ASSERT_EQUAL(0U, result.chosen);
    TEST_ASSERT_EQUAL(0U, result.false_alarms);
    return result;
}

static void test_faults_are_found_and_the_right_gyro_is_named(void)
{
    const uint32_t trials = 6U * effort;
    const uint32_t least = trials - ((effort < 5U) ? 1U : (effort / 5U));
    for (uint8_t gyros = 2U; gyros <= 4U; gyros++) {
        config.gyros = gyros;
        TEST_ASSERT_EQUAL(trials, faults_of("stuck", STUCK, 0.0, 0.3, trials).named);
        TEST_ASSERT_EQUAL(trials, faults_of("dropout", DROPOUT, 0.0, 0.3, trials).named);
        TEST_ASSERT_GREATER_OR_EQUAL(least, faults_of("mean 5", MEAN, 5.0, 0.8, trials).found);
        TEST_ASSERT_GREATER_OR_EQUAL(least, faults_of("mean 1", MEAN, 1.0, 0.2, trials).found);
        TEST_ASSERT_GREATER_OR_EQUAL(least - (trials / 10U),
                                     faults_of("mean 1", MEAN, 1.0, 0.8, trials).found);
        TEST_ASSERT_GREATER_OR_EQUAL(least, faults_of("mean 0.3", MEAN, 0.3, 0.2, trials).found);
        /* is never found, because the past has a ratio of 2; but no other gyro is named */
        (void)faults_of("noise x3", NOISE, 3.0, 0.3, trials);
        const found_t found = faults_of("noise x10", NOISE, 10.0, 0.3, trials);
        if (gyros > 2U) {
            TEST_ASSERT_EQUAL(trials, found.named);
        }
    }
}

/* --- two gyros --- */

static void test_two_gyros_in_motion_are_reported_as_hidden(void)
{
    config.gyros = 2U;
    take_off(NOISE_GAUSS);
    for (uint32_t t = 0U; t < 600U; t++) {
        fly(0U, 0U);
        TEST_ASSERT_FALSE(verdict.hidden);
    }
    flight.shake = 150.0;
    flight.own[0] = 2.0;
    uint32_t hidden = 0U;
    for (uint32_t t = 0U; t < 600U; t++) {
        fly(0U, 0U);
        hidden += verdict.hidden ? 1U : 0U;
    }
    TEST_ASSERT_GREATER_THAN(570U, hidden);
    TEST_ASSERT_EQUAL(0U, verdict.chosen);
}

/* Its argument is the effort; 1 takes seconds. */
int main(int count, char **arguments)
{
    effort = (count > 1) ? (uint32_t)strtoul(arguments[1], NULL, 10) : 1U;
    UNITY_BEGIN();
    RUN_TEST(test_two_gyros_in_motion_are_reported_as_hidden);
    RUN_TEST(test_two_gyros_of_1_to_5_need_weights_and_three_the_same);
    RUN_TEST(test_faults_are_found_and_the_right_gyro_is_named);
    RUN_TEST(test_a_gyro_that_grows_louder_is_left_in_time);
    RUN_TEST(test_three_and_four_gyros_fuse_within_2_percent_of_the_optimum);
    RUN_TEST(test_mismatch_in_motion_and_vibration_causes_no_switch);
    RUN_TEST(test_gyros_of_equal_noise_switch_no_more_often_than_stated);
    return UNITY_END();
}
