/* davar tests - centred windows of davar-sim (host_sim/centred): random configurations and records.
 * Every epoch is compared with brute force, integers bit for bit. */
#include "centred/centred.h"
#include "davar/davar.h"
#include "davar_law_id.h"
#include "trials.h"

#include <string.h>

void setUp(void) {}
void tearDown(void) {}

static davar_port_number_t port_number(const trial_t *trial)
{
    return (trial->number == NUMBER_Q15) ? DAVAR_PORT_Q15 : DAVAR_PORT_Q31;
}

static size_t push(centred_t *centred, const trial_t *trial, int64_t from, int64_t to)
{
    static int16_t narrow[SAMPLES_MAX];
    davar_port_samples_t samples = {.q31 = trial->sample};
    if (trial->number == NUMBER_Q15) {
        for (int64_t i = from; i < to; i++) {
            narrow[i] = (int16_t)trial->sample[i];
        }
        samples.q15 = narrow;
    }
    return centred_push(centred, samples, (size_t)from, (size_t)to);
}

/* Samples of the window that are images, by its definition. */
static uint32_t images(const trial_t *trial, const davar_result_t *result)
{
    const int64_t half = (int64_t)(result->window_samples / 2U);
    const int64_t before = half - (int64_t)result->epoch;
    const int64_t after = (int64_t)result->epoch + half - trial->count;
    return (uint32_t)(((before > 0) ? before : 0) + ((after > 0) ? after : 0));
}

/* The newest samples of the window that are equal, by their definition. */
static uint32_t equal(const trial_t *trial, const davar_result_t *result)
{
    const reference_record_t record = {trial->sample, trial->gap_before, trial->count};
    const int64_t head = (int64_t)result->epoch + (int64_t)(result->window_samples / 2U);
    uint32_t count = 1U;
    while ((count < result->window_samples) && (count < 1024U) &&
           (reference_sample(&record, head - 1 - (int64_t)count) ==
            reference_sample(&record, head - 1))) {
        count++;
    }
    return count;
}

static void take(const trial_t *trial, centred_t *centred, reference_t *reference, bool is_due)
{
    davar_result_t result;
    const bool is_taken = centred_take(centred, &result);
    TEST_ASSERT_TRUE(!is_due || is_taken);
    if (is_taken) {
        expect_next(trial, reference, &result);
        TEST_ASSERT_EQUAL_UINT32(images(trial, &result), result.mirrored_samples);
        TEST_ASSERT_EQUAL_UINT32(equal(trial, &result), result.equal_samples);
        TEST_ASSERT_FALSE(centred_take(centred, &result));
    }
}

static uint32_t gaps_of(const trial_t *trial)
{
    uint32_t gaps = 0U;
    for (int64_t i = 0; i < trial->count; i++) {
        gaps += trial->gap_before[i] ? 1U : 0U;
    }
    return gaps;
}

static void run_record(const trial_t *trial, random_t *random)
{
    reference_t reference;
    centred_t *const centred = centred_open(&trial->config, port_number(trial));
    const reference_record_t record = {trial->sample, trial->gap_before, trial->count};
    TEST_ASSERT_NOT_NULL(centred);
    reference_start(&reference, &trial->config, true, record);
    for (int64_t i = 0; i < trial->count;) {
        if (trial->gap_before[i]) {
            centred_gap(centred, 3U);
        }
        for (const int64_t end = end_of_run(trial, i, between(random, 1U, 70U)); i < end;) {
            i += (int64_t)push(centred, trial, i, end);
            take(trial, centred, &reference, i < end);
        }
    }
    const davar_health_t health = centred_health(centred);
    TEST_ASSERT_EQUAL_UINT32(gaps_of(trial), health.gaps);
    TEST_ASSERT_EQUAL_UINT32(3U * gaps_of(trial), health.missing);
    if ((random_next(random) % 2U) == 0U) {
        centred_gap(centred, 1U); /* after the last sample: no boundary */
    }
    while (centred_flush(centred)) {
        take(trial, centred, &reference, true);
    }
    TEST_ASSERT_FALSE(centred_flush(centred));
    expect_end(trial, &reference);
    centred_close(centred);
}

static void run_random(trial_t *trial, random_t *random)
{
    davar_config_t *const config = &trial->config;
    *config = davar_default_config;
    config->rate_hz = 100.0;
    config->unit_per_count = 1.0;
    config->law = davar_law_of_id((davar_law_id_t)between(random, 0U, 3U), false);
    config->window.longest = 2U * between(random, 4U, 60U);
    config->window.shortest = 2U * between(random, 2U, config->window.longest / 2U);
    config->window.shrink = 2U * between(random, 0U, 1U);
    config->window.grow = 2U * between(random, 0U, 1U);
    choose_rest(random, trial);
    choose_samples(random, trial);
    run_record(trial, random);
}

static void test_every_epoch_equals_brute_force_for_random_configurations_and_chunks(void)
{
    static trial_t trial;
    run_seeds(&trial, run_random);
}

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
    run_record(trial, &random);
    trial->seed++;
}

/* With every law, segment and stride. */
static void run_small_window(trial_t *trial)
{
    davar_config_t *const config = &trial->config;
    for (uint32_t segment = 0U; segment < config->window.shortest; segment++) {
        for (uint32_t each = 0U; each < (4U * config->window.longest); each++) {
            config->law = davar_law_of_id((davar_law_id_t)(each % 4U), false);
            config->moments.segment = segment;
            config->stride = 1U + (each / 4U);
            if ((config->law == NULL) || (segment > 0U)) {
                run_small(trial);
            }
        }
    }
}

static void test_every_epoch_equals_brute_force_for_small_configurations_one_by_one(void)
{
    static trial_t trial;
    davar_config_t *const config = &trial.config;
    *config = davar_default_config;
    config->rate_hz = 100.0;
    config->unit_per_count = 1.0;
    config->window.grow = 2U;
    config->window.shrink = 2U;
    config->moments.contribution_high = 0.16; /* not a round value, as in choose_rest */
    config->moments.kurtosis_low = 1.5137;
    config->moments.kurtosis_high = 4.0137;
    config->taus = trial.taus;
    config->tau_count = 2U;
    trial.taus[0] = 1U;
    trial.taus[1] = 2U;
    trial.number = NUMBER_Q15;
    trial.seed = 1U;
    for (config->window.longest = 4U; config->window.longest <= 8U; config->window.longest += 2U) {
        for (config->window.shortest = 2U; config->window.shortest <= config->window.longest;
             config->window.shortest += 2U) {
            run_small_window(&trial);
        }
    }
}

/* The same counts as int16, int32 and float give the same bits. A count is saturated at either end
 * of its width, a float at its full scale. */
static void test_number_types_agree_and_count_saturated_samples(void)
{
    static int16_t narrow[300];
    static int32_t wide[300];
    static float floats[300];
    static const uint32_t taus[] = {1U, 2U, 5U};
    random_t random = random_seeded(7U);
    davar_config_t config = davar_default_config;
    config.rate_hz = 100.0;
    config.unit_per_count = 1.0;
    config.full_scale = 32767.0;
    config.sample_bits = 16U;
    config.window.grow = 2U;
    config.window.longest = 60U;
    config.window.shortest = 40U;
    config.moments.segment = 10U;
    config.taus = taus;
    config.tau_count = 3U;
    for (size_t i = 0; i < 300U; i++) {
        wide[i] = (int32_t)between(&random, 0U, 400U) - 200;
        wide[i] = (i == 40U) ? 32767 : ((i == 41U) ? -32767 : wide[i]);
        narrow[i] = (int16_t)wide[i];
        floats[i] = (float)wide[i];
    }
    centred_t *const q15 = centred_open(&config, DAVAR_PORT_Q15);
    centred_t *const q31 = centred_open(&config, DAVAR_PORT_Q31);
    centred_t *const f32 = centred_open(&config, DAVAR_PORT_F32);
    const davar_port_samples_t counts = {.q15 = narrow};
    const davar_port_samples_t longs = {.q31 = wide};
    const davar_port_samples_t rates = {.f32 = floats};
    TEST_ASSERT_TRUE((q15 != NULL) && (q31 != NULL) && (f32 != NULL));
    uint32_t results = 0U;
    for (size_t i = 0; i < 300U; results++) {
        static davar_result_t result[3];
        const size_t taken = centred_push(q15, counts, i, 300U);
        TEST_ASSERT_EQUAL(taken, centred_push(q31, longs, i, 300U));
        TEST_ASSERT_EQUAL(taken, centred_push(f32, rates, i, 300U));
        i += taken;
        memset(result, 0, sizeof result);
        TEST_ASSERT_TRUE(centred_take(q15, &result[0]) && centred_take(q31, &result[1]) &&
                         centred_take(f32, &result[2]));
        TEST_ASSERT_EQUAL_MEMORY(&result[0], &result[1], sizeof result[0]);
        TEST_ASSERT_EQUAL_DOUBLE(0.0, result[2].unit_per_count);
        result[2].unit_per_count = 1.0;
        TEST_ASSERT_EQUAL_MEMORY(&result[0], &result[2], sizeof result[0]);
    }
    TEST_ASSERT_EQUAL_UINT32(271U, results);
    TEST_ASSERT_EQUAL_UINT32(1U, centred_health(q15).saturated);
    TEST_ASSERT_EQUAL_UINT32(1U, centred_health(q31).saturated);
    TEST_ASSERT_EQUAL_UINT32(2U, centred_health(f32).saturated);
    centred_close(q15);
    centred_close(q31);
    centred_close(f32);
}

int main(void)
{
    UNITY_BEGIN();
    if (getenv("DAVAR_TEST_SEED") == NULL) { /* a seed is one of the random trials */
        RUN_TEST(test_every_epoch_equals_brute_force_for_small_configurations_one_by_one);
        RUN_TEST(test_number_types_agree_and_count_saturated_samples);
    }
    RUN_TEST(test_every_epoch_equals_brute_force_for_random_configurations_and_chunks);
    return UNITY_END();
}
