/* davar tests - how often the intervals of the cascade contain the true Allan deviation: Monte
 * Carlo over independent recordings, fixed seeds. Prints the figures of DESIGN (11.8); each has a
 * standard error of 0.35 % at 4000 recordings.
 *
 * The cascade reads a recording at its hops only. A hop of 16 samples is therefore one sample of
 * the noise, pushed 16 times. Its Allan variance at m samples is that of the noise at m / 16. */
#include "davar/cascade.h"
#include "davar/fit.h"
#include "gyro_noise.h"
#include "unity.h"

#include <stdio.h>
#include <stdlib.h>

#ifndef RECORDINGS
#define RECORDINGS 4000U
#endif
#ifndef SEED
#define SEED 20180773U
#endif

#define HOP 16U
#define HOPS_MAX 8192U
#define COUNTS 1048576.0 /* per unit of the noise */

typedef struct {
    gyro_noise_t noise;
    uint32_t hops; /* of a recording, at most: it ends anywhere in its last quarter */
    uint16_t clusters;
    uint8_t tau_count;
    uint32_t gap_every; /* hops; 0: none */
} scenario_t;

static davar_cascade_config_t config;
static davar_cascade_t cascade;
static davar_result_t result;
static davar_plan_t plan;
static uint64_t memory[DAVAR_CASCADE_MEMORY(Q31, DAVAR_CASCADE_TAUS_MAX) / 8U];
static double rate[HOPS_MAX];
static double holds[DAVAR_CASCADE_TAUS_MAX]; /* percent */
static double edf[DAVAR_CASCADE_TAUS_MAX];   /* mean */
static double taken[DAVAR_CASCADE_TAUS_MAX]; /* recordings with this size */
static double clusters[DAVAR_CASCADE_TAUS_MAX];

void setUp(void) {}
void tearDown(void) {}

static void push_hops(const scenario_t *scenario, random_t *random, uint32_t hops)
{
    int32_t block[HOP];
    for (uint32_t i = 0U; i < hops; i++) {
        if ((scenario->gap_every > 0U) && ((random_next(random) % scenario->gap_every) == 0U)) {
            davar_cascade_gap(&cascade, 1U);
        }
        for (uint32_t k = 0U; k < HOP; k++) {
            block[k] = (int32_t)lround(COUNTS * rate[i]);
        }
        davar_cascade_push_q31(&cascade, block, HOP);
    }
    davar_cascade_flush(&cascade);
}

static void count_recording(const double *truth)
{
    for (uint32_t t = 0U; t < config.tau_count; t++) {
        const davar_adev_t *const tau = &result.tau[t];
        if (tau->differences > 0U) {
            taken[t] += 1.0;
            holds[t] += ((tau->low <= truth[t]) && (truth[t] <= tau->high)) ? 100.0 : 0.0;
            edf[t] += tau->edf;
            clusters[t] += 2.0 + ((double)tau->differences - 1.0) / (double)tau->hops;
        }
    }
}

static void print(const char *name)
{
    printf("%-36s", name);
    for (uint32_t t = 0U; t < config.tau_count; t++) {
        printf(" %5.1f", holds[t]);
    }
    printf("\n%-36s", "  clusters");
    for (uint32_t t = 0U; t < config.tau_count; t++) {
        printf(" %5.0f", clusters[t]);
    }
    printf("\n");
}

static void run(const char *name, const scenario_t *scenario)
{
    double truth[DAVAR_CASCADE_TAUS_MAX] = {0.0};
    uint32_t sizes[DAVAR_CASCADE_TAUS_MAX];
    random_t random = random_seeded(SEED);
    config = (davar_cascade_config_t){.rate_hz = 1.0,
                                      .unit_per_count = 1.0 / COUNTS,
                                      .shortest = 4U * HOP,
                                      .tau_count = scenario->tau_count,
                                      .clusters = scenario->clusters};
    for (uint32_t t = 0U; t < config.tau_count; t++) {
        sizes[t] = config.shortest << t;
        truth[t] = sqrt(gyro_noise_avar(&scenario->noise, 4U << t));
        holds[t] = 0.0;
        edf[t] = 0.0;
        taken[t] = 0.0;
        clusters[t] = 0.0;
    }
    TEST_ASSERT_TRUE(scenario->hops <= HOPS_MAX);
    davar_plan_init_white(&plan, sizes, config.tau_count);
    for (uint32_t i = 0U; i < RECORDINGS; i++) {
        const uint32_t quarter = scenario->hops / 4U;
        const uint32_t hops = scenario->hops - (uint32_t)(random_next(&random) % quarter);
        gyro_noise_fill(&scenario->noise, &random, rate, hops);
        TEST_ASSERT_EQUAL(DAVAR_OK,
                          davar_cascade_init_q31(&cascade, &config, memory, sizeof memory));
        push_hops(scenario, &random, hops);
        result = (davar_result_t){0};
        TEST_ASSERT_TRUE(davar_cascade_append(&cascade, &result));
        davar_fit(&plan, config.rate_hz, &result);
        count_recording(truth);
    }
    for (uint32_t t = 0U; t < config.tau_count; t++) {
        holds[t] /= taken[t];
        edf[t] /= taken[t];
        clusters[t] /= taken[t];
    }
    print(name);
}

/* Sizes with at least four clusters in every recording. A few differences of white noise scatter
 * less than the chi-square of their degrees of freedom: the interval is safe, not tight. */
static void check(const char *name, const scenario_t *scenario, double most)
{
    run(name, scenario);
    for (uint32_t t = 0U; t < config.tau_count; t++) {
        TEST_ASSERT_TRUE_MESSAGE(holds[t] >= 93.0, name);
        TEST_ASSERT_TRUE_MESSAGE(holds[t] <= ((clusters[t] >= 10.0) ? most : 98.5), name);
    }
}

static const gyro_noise_t white = {.white = 1.0};
static const gyro_noise_t flicker = {.flicker = 1.0};
static const gyro_noise_t walk = {.walk = 1.0};
static const gyro_noise_t mixed = {.white = 1.0, .flicker = 0.1, .walk = 0.005};

/* 4 to 250 clusters, all of them remembered. */
static void test_a_young_recording(void)
{
    check("white, 1000 hops", &(scenario_t){white, 1000U, 2048U, 6U, 0U}, 97.0);
    check("flicker, 1000 hops", &(scenario_t){flicker, 1000U, 2048U, 6U, 0U}, 97.0);
    check("walk, 1000 hops", &(scenario_t){walk, 1000U, 2048U, 6U, 0U}, 97.0);
    check("mixed, 1000 hops", &(scenario_t){mixed, 1000U, 2048U, 6U, 0U}, 97.0);
}

static void test_a_recording_of_few_clusters(void)
{
    check("white, 180 hops", &(scenario_t){white, 180U, 32U, 4U, 0U}, 97.0);
    check("flicker, 180 hops", &(scenario_t){flicker, 180U, 32U, 4U, 0U}, 97.0);
    check("walk, 180 hops", &(scenario_t){walk, 180U, 32U, 4U, 0U}, 97.0);
}

/* Every size but the longest has forgotten the beginning. */
static void test_a_recording_that_is_partly_forgotten(void)
{
    check("white, 8 to 16 clusters", &(scenario_t){white, 4096U, 8U, 8U, 0U}, 97.0);
    check("flicker, 8 to 16 clusters", &(scenario_t){flicker, 4096U, 8U, 8U, 0U}, 97.0);
    check("walk, 8 to 16 clusters", &(scenario_t){walk, 4096U, 8U, 8U, 0U}, 97.0);
    check("white, 32 to 64 clusters", &(scenario_t){white, 4096U, 32U, 8U, 0U}, 97.0);
    check("flicker, 32 to 64 clusters", &(scenario_t){flicker, 4096U, 32U, 8U, 0U}, 97.0);
    check("walk, 32 to 64 clusters", &(scenario_t){walk, 4096U, 32U, 8U, 0U}, 97.0);
}

/* Differences beside gaps are less correlated than the neighbours that edf assumes: safe, not
 * tight. */
static void test_gaps(void)
{
    check("white, a gap in 200 hops", &(scenario_t){white, 2000U, 2048U, 5U, 200U}, 98.5);
    check("flicker, a gap in 200 hops", &(scenario_t){flicker, 2000U, 2048U, 5U, 200U}, 98.5);
    check("walk, a gap in 200 hops", &(scenario_t){walk, 2000U, 2048U, 5U, 200U}, 98.5);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_a_young_recording);
    RUN_TEST(test_a_recording_of_few_clusters);
    RUN_TEST(test_a_recording_that_is_partly_forgotten);
    RUN_TEST(test_gaps);
    return UNITY_END();
}
