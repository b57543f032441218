/* davar tests - random configurations and records. Every epoch is compared with brute force,
 * integers bit for bit. */
#include "davar/davar.h"
#include "davar_law_id.h"
#include "fitted.h"
#include "trials.h"

#include <string.h>

#define MEMORY_WORDS 65536

static uint64_t memory[MEMORY_WORDS];

void setUp(void) {}
void tearDown(void) {}

static void choose_config(random_t *random, trial_t *trial)
{
    davar_config_t *const config = &trial->config;
    *config = davar_default_config;
    config->rate_hz = 100.0;
    config->unit_per_count = 1.0;
    config->law = davar_law_of_id((davar_law_id_t)between(random, 0U, 3U), false);
    config->window.longest = between(random, 8U, 121U);
    config->window.shortest = between(random, 4U, config->window.longest);
    config->window.shrink = between(random, 0U, 5U);
    config->window.grow = between(random, 0U, 3U);
    choose_rest(random, trial);
    config->engine = davar_grid_of((random_next(random) % 2U) != 0U, trial->number != NUMBER_Q15);
    /* The gaps of two windows and of the samples between them: the maximum. */
    config->window.gaps_max = (uint16_t)((2U * config->window.longest) + config->stride + 2U);
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
    reference_start(&reference, &trial->config, false, record);
    int64_t i = 0;
    while (i < trial->count) {
        if (trial->gap_before[i]) {
            davar_gap(&davar, 1U);
        }
        const int64_t end = end_of_run(trial, i, between(random, 1U, 70U));
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
    expect_end(trial, &reference);
}

static void run_random(trial_t *trial, random_t *random)
{
    choose_config(random, trial);
    choose_samples(random, trial);
    run_trial(trial, random);
}

static void test_every_epoch_equals_brute_force_for_random_configurations_and_chunks(void)
{
    static trial_t trial;
    run_seeds(&trial, run_random);
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_every_epoch_equals_brute_force_for_random_configurations_and_chunks);
    return UNITY_END();
}
