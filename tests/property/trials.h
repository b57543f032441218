/* davar tests - a random record and how each of its epochs is compared with brute force
 * (reference.h). */
#ifndef DAVAR_TESTS_TRIALS_H
#define DAVAR_TESTS_TRIALS_H

#include "davar/content.h"
#include "random.h"
#include "reference.h"
#include "unity.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define SAMPLES_MAX 1200

typedef enum { NUMBER_Q15, NUMBER_Q31, NUMBER_COUNT } number_t;

typedef struct {
    davar_config_t config;
    uint32_t taus[DAVAR_TAUS_MAX];
    number_t number;
    int32_t sample[SAMPLES_MAX];
    bool gap_before[SAMPLES_MAX];
    int64_t count;
    uint64_t seed;
} trial_t;

static uint32_t between(random_t *random, uint32_t low, uint32_t high)
{
    return low + (uint32_t)(random_next(random) % (uint64_t)(high - low + 1U));
}

static void choose_taus(random_t *random, trial_t *trial)
{
    const uint32_t largest = trial->config.window.longest / 2U;
    uint32_t m = between(random, 1U, 3U);
    const bool octaves = (random_next(random) % 2U) == 0U;
    trial->config.tau_count = 0U;
    while ((m <= largest) && (trial->config.tau_count < 9U)) {
        trial->taus[trial->config.tau_count] = m;
        trial->config.tau_count++;
        m = octaves ? (2U * m) : (m + between(random, 1U, m));
    }
    if (trial->config.tau_count == 0U) {
        trial->taus[0] = 1U;
        trial->config.tau_count = 1U;
    }
    trial->config.taus = trial->taus;
}

/* For lengths that are chosen already: everything else. */
static void choose_rest(random_t *random, trial_t *trial)
{
    davar_config_t *const config = &trial->config;
    config->moments.segment = between(random, 1U, config->window.shortest - 1U);
    if ((config->law == NULL) && ((random_next(random) % 2U) == 0U)) {
        config->moments.segment = 0U; /* no moments: the plain step */
    }
    config->moments.contribution_high = 0.02 * (double)between(random, 1U, 10U);
    /* Different from the round values that rails can hit exactly, where the reference's own
     * rounding would decide. */
    config->moments.kurtosis_high = 2.0137 + (0.2 * (double)between(random, 1U, 10U));
    config->moments.kurtosis_low = 0.0137 + (0.5 * (double)between(random, 0U, 4U));
    config->stride = (random_next(random) % 2U) ? 1U : between(random, 1U, 20U);
    config->stride =
        ((random_next(random) % 16U) == 0U) ? between(random, 20U, 300U) : config->stride;
    config->stride =
        (config->stride < config->window.longest) ? config->stride : config->window.longest;
    trial->number = (number_t)(random_next(random) % NUMBER_COUNT);
    config->sample_bits = ((trial->number == NUMBER_Q31) && (random_next(random) % 2U)) ? 32U : 0U;
    choose_taus(random, trial);
}

/* Quiet noise, full-scale bursts, constant rails: any content of a stream. */
static void choose_samples(random_t *random, trial_t *trial)
{
    const bool widest = (trial->config.sample_bits == 32U);
    const int32_t full = widest ? INT32_MAX : ((trial->number == NUMBER_Q15) ? 32767 : 8388607);
    const uint32_t gaps_per_thousand = (random_next(random) % 2U) ? between(random, 0U, 60U) : 0U;
    int32_t noise = 20;
    int32_t offset = 0;
    uint32_t kind = 0U;
    trial->count = (int64_t)between(random, 1U, SAMPLES_MAX);
    for (int64_t i = 0; i < trial->count; i++) {
        if ((random_next(random) % 50U) == 0U) {
            kind = between(random, 0U, 4U);
            noise = (int32_t)between(random, 1U, 300U);
            offset = (int32_t)between(random, 0U, 2000U) - 1000;
            offset *= widest ? 2000000 : 1;
        }
        int32_t sample = offset + (int32_t)lrint(random_gauss(random) * (double)noise);
        if (kind == 3U) {
            sample = (random_next(random) % 2U) ? full : (-full - 1);
        }
        if (kind == 4U) {
            sample = full;
        }
        trial->sample[i] = sample;
        trial->gap_before[i] = (random_next(random) % 1000U) < gaps_per_thousand;
    }
}

/* Where a run of at most `most` samples from sample i on ends, at the next gap at the latest. */
static int64_t end_of_run(const trial_t *trial, int64_t i, uint32_t most)
{
    int64_t end = i + (int64_t)most;
    for (int64_t j = i + 1; (j < end) && (j < trial->count); j++) {
        end = trial->gap_before[j] ? j : end;
    }
    return (end > trial->count) ? trial->count : end;
}

/* --- comparison ------------------------------------------------------------------------------- */

static const char *context(const trial_t *trial, const reference_epoch_t *epoch, const char *what)
{
    static char message[512];
    const davar_config_t *const c = &trial->config;
    snprintf(message, sizeof message,
             "%s: seed %" PRIu64 " number %d law %d W %u..%u l %u grow %u shrink %u K "
             "%u engine %d N %lld epoch %lld "
             "[%lld, %lld)",
             what, trial->seed, (int)trial->number, (int)davar_law_id(c), c->window.shortest,
             c->window.longest, c->moments.segment, c->window.grow, c->window.shrink, c->stride,
             (c->engine != NULL) ? 1 : 0, (long long)trial->count, (long long)epoch->epoch,
             (long long)epoch->tail, (long long)epoch->head);
    return message;
}

static void same_number(double expected, double actual, double tolerance, const char *text)
{
    if (isnan(expected)) {
        TEST_ASSERT_TRUE_MESSAGE(isnan(actual), text);
        return;
    }
    if (!(fabs(actual - expected) <= (tolerance * (1.0 + fabs(expected))))) {
        char longer[640];
        snprintf(longer, sizeof longer, "%s: expected %.17g, got %.17g", text, expected, actual);
        TEST_FAIL_MESSAGE(longer);
    }
}

static void same_tau(const trial_t *trial, const reference_t *reference,
                     const reference_epoch_t *epoch, const davar_adev_t *tau)
{
    uint32_t differences = 0U;
    const reference_real_t sum = reference_sum(reference, epoch, tau->m, &differences);
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(differences, tau->differences,
                                     context(trial, epoch, "differences"));
    const double m = (double)tau->m;
    const double expected =
        (differences == 0U) ? (double)NAN : sqrt((double)sum / (2.0 * m * m * (double)differences));
    /* One rounding of a 128-bit sum may differ; q15 sums convert exactly alike. */
    same_number(expected, tau->adev, (trial->number == NUMBER_Q15) ? 0.0 : 3e-16,
                context(trial, epoch, "adev"));
}

static void same_epoch(const trial_t *trial, const reference_t *reference,
                       const reference_epoch_t *epoch, const davar_result_t *result)
{
    TEST_ASSERT_EQUAL_INT64_MESSAGE(epoch->epoch, (int64_t)result->epoch,
                                    context(trial, epoch, "epoch"));
    TEST_ASSERT_EQUAL_UINT32_MESSAGE(epoch->head - epoch->tail, result->window_samples,
                                     context(trial, epoch, "window"));
    for (uint32_t t = 0U; t < result->tau_count; t++) {
        same_tau(trial, reference, epoch, &result->tau[t]);
    }
    same_number(epoch->kurtosis, result->kurtosis, 1e-14, context(trial, epoch, "kurtosis"));
    same_number(epoch->contribution, result->contribution, 1e-13,
                context(trial, epoch, "contribution"));
    TEST_ASSERT_EQUAL_MESSAGE(epoch->unstable, result->unstable, context(trial, epoch, "unstable"));
}

static void expect_next(const trial_t *trial, reference_t *reference, const davar_result_t *result)
{
    reference_epoch_t epoch = {0};
    const bool more = reference_next(reference, &epoch);
    if (!more) {
        epoch.epoch = (int64_t)result->epoch;
        TEST_FAIL_MESSAGE(context(trial, &epoch, "an epoch too many"));
    }
    same_epoch(trial, reference, &epoch, result);
}

static void expect_end(const trial_t *trial, reference_t *reference)
{
    reference_epoch_t left = {0};
    TEST_ASSERT_FALSE_MESSAGE(reference_next(reference, &left),
                              context(trial, &left, "an epoch too few"));
}

/* PROPERTY_TRIALS trials from PROPERTY_FIRST on, or the one of DAVAR_TEST_SEED. */
static void run_seeds(trial_t *trial, void (*run)(trial_t *trial, random_t *random))
{
    const char *const one = getenv("DAVAR_TEST_SEED");
    const uint64_t first = (one == NULL) ? PROPERTY_FIRST : strtoull(one, NULL, 10);
    const uint64_t trials = (one == NULL) ? PROPERTY_TRIALS : 1U;
    for (uint64_t seed = first; seed < (first + trials); seed++) {
        random_t random = random_seeded(seed);
        trial->seed = seed;
        run(trial, &random);
    }
}

#endif
