/* davar tests - random configurations and records. Every epoch is compared with brute force,
 * integers bit for bit. */
#include "davar/davar.h"
#include "davar_law_id.h"
#include "fitted.h"
#include "random.h"
#include "reference.h"
#include "unity.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SAMPLES_MAX 1200
#define MEMORY_WORDS 65536

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

static uint64_t memory[MEMORY_WORDS];
static char message[512];

void setUp(void) {}
void tearDown(void) {}

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

static void choose_config(random_t *random, trial_t *trial)
{
    davar_config_t *const config = &trial->config;
    *config = davar_default_config;
    config->window.mode = DAVAR_MODE_CENTRED;
    config->rate_hz = 100.0;
    config->unit_per_count = 1.0;
    config->window.mode = (random_next(random) % 2U) ? DAVAR_MODE_CENTRED : DAVAR_MODE_TRAILING;
    config->law = davar_law_of_id((davar_law_id_t)between(random, 0U, 3U), false);
    config->window.longest = 2U * between(random, 4U, 60U);
    config->window.shortest = 2U * between(random, 2U, config->window.longest / 2U);
    if (config->window.mode == DAVAR_MODE_TRAILING) {
        config->window.longest += between(random, 0U, 1U);
        config->window.shrink = between(random, 0U, 5U);
        config->window.grow = between(random, 0U, 3U);
    } else {
        config->window.shrink = 2U * between(random, 0U, 1U);
        config->window.grow = 2U * between(random, 0U, 1U);
    }
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
    config->engine = (random_next(random) % 2U) ? DAVAR_ENGINE_GRID : DAVAR_ENGINE_AUTO;
    /* The gaps of two windows and of the samples between them: the maximum. */
    config->window.gaps_max = (uint16_t)((2U * config->window.longest) + config->stride + 2U);
    config->window.mirrored_end = true;
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

static davar_status_t start(davar_t *davar, const trial_t *trial)
{
    const bool is_q15 = (trial->number == NUMBER_Q15);
    const size_t bytes =
        is_q15 ? davar_memory_size_q15(&trial->config) : davar_memory_size_q31(&trial->config);
    TEST_ASSERT_TRUE(bytes <= sizeof memory);
    memset(memory, 0xA5, bytes);
    return is_q15 ? davar_init_q15(davar, &trial->config, memory, bytes)
                  : davar_init_q31(davar, &trial->config, memory, bytes);
}

static size_t push(davar_t *davar, const trial_t *trial, int64_t from, int64_t to)
{
    int16_t narrow[SAMPLES_MAX];
    if (trial->number == NUMBER_Q31) {
        return davar_push_until_result_q31(davar, &trial->sample[from], (size_t)(to - from));
    }
    for (int64_t i = from; i < to; i++) {
        narrow[i - from] = (int16_t)trial->sample[i];
    }
    return davar_push_until_result_q15(davar, narrow, (size_t)(to - from));
}

static const char *context(const trial_t *trial, const reference_epoch_t *epoch, const char *what)
{
    const davar_config_t *const c = &trial->config;
    snprintf(message, sizeof message,
             "%s: seed %" PRIu64 " number %d mode %d law %d W %u..%u l %u grow %u shrink %u K "
             "%u engine %d N %lld epoch %lld "
             "[%lld, %lld)",
             what, trial->seed, (int)trial->number, (int)c->window.mode, (int)davar_law_id(c),
             c->window.shortest, c->window.longest, c->moments.segment, c->window.grow,
             c->window.shrink, c->stride, (int)c->engine, (long long)trial->count,
             (long long)epoch->epoch, (long long)epoch->tail, (long long)epoch->head);
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

/* Part of the record, and a reset: later results must not depend on it, in any state of the
 * instance. */
static void push_and_reset(davar_t *davar, const trial_t *trial)
{
    davar_result_t result;
    random_t random = random_seeded(~trial->seed);
    for (uint32_t resets = between(&random, 0U, 1U); resets > 0U; resets--) {
        const int64_t end = between(&random, 0U, (uint32_t)trial->count);
        for (int64_t i = 0; i < end;) {
            if (trial->gap_before[i]) {
                davar_gap(davar, 1U);
            }
            i += (int64_t)push(davar, trial, i, i + 1);
            (void)take_fitted(davar, &result);
        }
        if ((random_next(&random) % 4U) == 0U) {
            (void)davar_flush(davar);
        }
        davar_reset(davar);
    }
}

/* Pushes samples after a result that waits, fewer than complete the next; returns where it ends. */
static int64_t push_on(davar_t *davar, const trial_t *trial, int64_t from, uint32_t count)
{
    int64_t i = from;
    for (uint32_t more = count; (more > 0U) && (i < trial->count); more--) {
        if (trial->gap_before[i]) {
            davar_gap(davar, 1U);
        }
        i += (int64_t)push(davar, trial, i, i + 1);
    }
    return i;
}

static void run_trial(const trial_t *trial, random_t *random)
{
    davar_t davar;
    davar_result_t result;
    reference_t reference;
    reference_epoch_t left = {0};
    TEST_ASSERT_EQUAL_MESSAGE(DAVAR_OK, start(&davar, trial), context(trial, &left, "init"));
    push_and_reset(&davar, trial);
    const reference_record_t record = {trial->sample, trial->gap_before, trial->count};
    reference_start(&reference, &trial->config, record);
    int64_t i = 0;
    while (i < trial->count) {
        if (trial->gap_before[i]) {
            davar_gap(&davar, 1U);
        }
        int64_t end = i + (int64_t)between(random, 1U, 70U);
        for (int64_t j = i + 1; (j < end) && (j < trial->count); j++) {
            end = trial->gap_before[j] ? j : end;
        }
        end = (end > trial->count) ? trial->count : end;
        while (i < end) {
            i += (int64_t)push(&davar, trial, i, end);
            if (i < end) { /* at a result: taken now or later */
                i = push_on(&davar, trial, i, between(random, 0U, trial->config.stride - 1U));
            }
            if (take_fitted(&davar, &result)) {
                expect_next(trial, &reference, &result);
            }
        }
    }
    while (davar_flush(&davar)) {
        TEST_ASSERT_TRUE(take_fitted(&davar, &result));
        expect_next(trial, &reference, &result);
    }
    if (trial->config.window.mode == DAVAR_MODE_CENTRED || trial->count > 0) {
        TEST_ASSERT_FALSE_MESSAGE(reference_next(&reference, &left),
                                  context(trial, &left, "an epoch too few"));
    }
}

static void test_every_epoch_equals_brute_force_for_random_configurations_and_chunks(void)
{
    static trial_t trial;
    const char *const one = getenv("DAVAR_TEST_SEED");
    const uint64_t first = (one == NULL) ? PROPERTY_FIRST : strtoull(one, NULL, 10);
    const uint64_t trials = (one == NULL) ? PROPERTY_TRIALS : 1U;
    for (uint64_t seed = first; seed < (first + trials); seed++) {
        random_t random = random_seeded(seed);
        trial.seed = seed;
        choose_config(&random, &trial);
        choose_samples(&random, &trial);
        run_trial(&trial, &random);
    }
}

#define SMALL_WINDOW 9U
#define SMALL_STRIDE 10U
#define SMALL_COUNT 60

/* Quiet and loud sections, at times a gap. */
static void choose_few_samples(random_t *random, trial_t *trial)
{
    int32_t loud = 1;
    const bool with_gaps = (random_next(random) % 4U) == 0U;
    trial->count = SMALL_COUNT;
    for (int64_t i = 0; i < trial->count; i++) {
        loud = ((random_next(random) % 12U) == 0U) ? (1001 - loud) : loud;
        trial->sample[i] = loud * ((int32_t)between(random, 0U, 8U) - 4);
        trial->gap_before[i] = with_gaps && ((random_next(random) % 20U) == 0U);
    }
}

static void run_small(trial_t *trial)
{
    random_t random = random_seeded(trial->seed);
    choose_few_samples(&random, trial);
    run_trial(trial, &random);
    trial->seed++;
}

/* With every law of the paper's law, stride and engine. */
static void run_small_window(trial_t *trial)
{
    davar_config_t *const config = &trial->config;
    const uint32_t longest =
        (SMALL_STRIDE < config->window.longest) ? SMALL_STRIDE : config->window.longest;
    for (uint32_t each = 0U; each < (8U * longest); each++) {
        config->law = davar_law_of_id((davar_law_id_t)(each % 4U), false);
        if ((config->law != NULL) && (config->moments.segment == 0U)) {
            continue;
        }
        config->engine = ((each / 4U) % 2U) ? DAVAR_ENGINE_AUTO : DAVAR_ENGINE_GRID;
        config->stride = 1U + (each / 8U);
        run_small(trial);
    }
}

static void run_small_windows(trial_t *trial, davar_mode_t mode, uint32_t step)
{
    davar_config_t *const config = &trial->config;
    config->window.mode = mode;
    config->window.grow = step;
    config->window.shrink = step;
    for (config->window.longest = 4U; config->window.longest <= SMALL_WINDOW;
         config->window.longest += step) {
        for (config->window.shortest = 2U; config->window.shortest <= config->window.longest;
             config->window.shortest += step) {
            for (config->moments.segment = 0U; config->moments.segment < config->window.shortest;
                 config->moments.segment++) {
                run_small_window(trial);
            }
        }
    }
}

static void test_every_epoch_equals_brute_force_for_small_configurations_one_by_one(void)
{
    static trial_t trial;
    trial.config = davar_default_config;
    trial.config.window.mode = DAVAR_MODE_CENTRED;
    trial.config.rate_hz = 100.0;
    trial.config.unit_per_count = 1.0;
    trial.config.window.gaps_max = (2U * SMALL_WINDOW) + SMALL_STRIDE + 2U;
    trial.config.window.mirrored_end = true;
    trial.config.moments.contribution_high = 0.16; /* not a round value, as in choose_config */
    trial.config.moments.kurtosis_low = 1.5137;
    trial.config.moments.kurtosis_high = 4.0137;
    trial.config.taus = trial.taus;
    trial.config.tau_count = 2U;
    trial.taus[0] = 1U;
    trial.taus[1] = 2U;
    trial.number = NUMBER_Q15;
    trial.seed = 1U;
    run_small_windows(&trial, DAVAR_MODE_TRAILING, 1U);
    run_small_windows(&trial, DAVAR_MODE_CENTRED, 2U);
}

int main(void)
{
    UNITY_BEGIN();
    if (getenv("DAVAR_TEST_SEED") == NULL) { /* a seed is one of the random trials */
        RUN_TEST(test_every_epoch_equals_brute_force_for_small_configurations_one_by_one);
    }
    RUN_TEST(test_every_epoch_equals_brute_force_for_random_configurations_and_chunks);
    return UNITY_END();
}
