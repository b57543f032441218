/* davar tests - calls of the library compared with brute force. The bytes select a configuration,
 * then samples in pieces, gaps, results that are not taken, saves and restores. Every taken result
 * equals the one computed from the complete record. */
#include "davar_law_id.h"
#include "reference.h"

#include <math.h>

#define SAMPLES_MAX 160
#define MEMORY_WORDS 8192
#include "pair.h"

typedef struct {
    davar_config_t config;
    uint32_t taus[5];
    bool is_q31;
    int32_t sample[SAMPLES_MAX];
    bool gap_before[SAMPLES_MAX];
    uint8_t act[SAMPLES_MAX]; /* after this sample */
    int64_t count;
} trial_t;

enum { ACT_CUT = 1, ACT_LEAVE = 2, ACT_SAVE = 4 };

static unsigned left; /* pushes without a take since */

/* Any configuration that brute force supports; kurtosis limits differ from the values that rails
 * hit exactly. */
static void choose_config(trial_t *trial, bytes_t *bytes)
{
    davar_config_t *const config = &trial->config;
    *config = davar_default_config;
    config->rate_hz = 100.0;
    config->unit_per_count = 1.0;
    config->law = davar_law_of_id((davar_law_id_t)between(bytes, 0U, 3U), false);
    config->window.longest = 2U * between(bytes, 4U, 24U);
    config->window.shortest = 2U * between(bytes, 2U, config->window.longest / 2U);
    config->window.shrink = 2U * between(bytes, 0U, 2U);
    config->window.grow = 2U * between(bytes, 0U, 1U);
    config->moments.segment = between(bytes, 1U, config->window.shortest - 1U);
    if ((config->law == NULL) && ((config->moments.segment % 2U) == 0U)) {
        config->moments.segment = 0U;
    }
    config->moments.contribution_high = 0.02 * (double)between(bytes, 1U, 10U);
    config->moments.kurtosis_high = 2.0137 + (0.2 * (double)between(bytes, 1U, 10U));
    config->moments.kurtosis_low = 0.0137 + (0.5 * (double)between(bytes, 0U, 4U));
    config->stride = between(bytes, 1U, 70U);
    config->stride = (config->stride > 35U) ? 1U : config->stride;
    config->stride =
        (config->stride < config->window.longest) ? config->stride : config->window.longest;
    const bool is_grid = (between(bytes, 0U, 1U) == 0U);
    config->window.gaps_max = (uint16_t)((2U * config->window.longest) + config->stride + 2U);
    trial->is_q31 = byte(bytes) % 2U != 0U;
    config->engine = davar_engine_of(is_grid, trial->is_q31);
    uint32_t m = 0U;
    config->taus = trial->taus;
    config->tau_count = 0U;
    for (unsigned t = 0U; t < 5U; t++) {
        m += between(bytes, 1U, 8U);
        if (m <= (config->window.longest / 2U)) {
            trial->taus[t] = m;
            config->tau_count++;
        }
    }
}

static void choose_samples(trial_t *trial, bytes_t *bytes)
{
    const int32_t full = trial->is_q31 ? 8388607 : 32767;
    memset(trial->gap_before, 0, sizeof trial->gap_before);
    trial->count = 0;
    while ((bytes->next < bytes->end) && (trial->count < SAMPLES_MAX)) {
        const uint8_t what = byte(bytes);
        const int32_t value = (int32_t)byte(bytes) - 128;
        const int32_t wide = value * (full / 128);
        const int64_t i = trial->count++;
        trial->sample[i] = ((what & 8U) != 0U) ? wide : value;
        if ((what & 0xF0U) == 0xF0U) {
            trial->sample[i] = (value < 0) ? (-full - 1) : full;
        }
        trial->gap_before[i] = (what & 0x70U) == 0x20U;
        trial->act[i] = what & 7U;
    }
}

static bool alike(double expected, double actual, double tolerance)
{
    return isnan(expected) ? (isnan(actual) != 0)
                           : (fabs(actual - expected) <= (tolerance * (1.0 + fabs(expected))));
}

static void same(const trial_t *trial, const reference_t *reference, const reference_epoch_t *epoch,
                 const davar_result_t *result)
{
    REQUIRE(epoch->epoch == (int64_t)result->epoch);
    REQUIRE((epoch->head - epoch->tail) == (int64_t)result->window_samples);
    REQUIRE(epoch->unstable == result->unstable);
    REQUIRE(alike(epoch->kurtosis, result->kurtosis, 1e-14));
    REQUIRE(alike(epoch->contribution, result->contribution, 1e-13));
    for (uint32_t t = 0U; t < result->tau_count; t++) {
        uint32_t differences = 0U;
        const double m = (double)result->tau[t].m;
        const double sum = (double)reference_sum(reference, epoch, result->tau[t].m, &differences);
        const double adev =
            (differences == 0U) ? (double)NAN : sqrt(sum / (2.0 * m * m * (double)differences));
        REQUIRE(differences == result->tau[t].differences);
        REQUIRE(alike(adev, result->tau[t].adev, trial->is_q31 ? 3e-16 : 0.0));
    }
}

/* Takes the waiting result. Only earlier results may be missing. */
static void take(const trial_t *trial, reference_t *reference)
{
    davar_result_t result;
    reference_epoch_t epoch = {0};
    if (davar_take(&instances[current], &result)) {
        REQUIRE(reference_next(reference, &epoch));
        while (epoch.epoch < (int64_t)result.epoch) {
            REQUIRE(left > 0U);
            left--;
            REQUIRE(reference_next(reference, &epoch));
        }
        same(trial, reference, &epoch, &result);
    }
}

static int64_t piece_end(const trial_t *trial, int64_t from)
{
    int64_t end = from + 1;
    while ((end < trial->count) && !trial->gap_before[end] && (trial->act[end - 1] == 0U)) {
        end++;
    }
    return end;
}

static void run(const trial_t *trial, reference_t *reference)
{
    for (int64_t i = 0; i < trial->count;) {
        const int64_t end = piece_end(trial, i);
        if (trial->gap_before[i]) {
            davar_gap(&instances[current], 1U);
        }
        while (i < end) {
            i += (int64_t)push_until(trial->is_q31, &trial->sample[i], (size_t)(end - i));
            if ((trial->act[i - 1] & ACT_LEAVE) != 0U) {
                left++;
            } else {
                take(trial, reference);
            }
        }
        if ((trial->act[i - 1] & ACT_SAVE) != 0U) {
            change_over(&trial->config, trial->is_q31);
        }
    }
    take(trial, reference);
    REQUIRE(!davar_flush(&instances[current]));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static trial_t trial;
    bytes_t bytes = {data, data + size};
    reference_t reference;
    reference_epoch_t more = {0};
    choose_config(&trial, &bytes);
    choose_samples(&trial, &bytes);
    left = 0U;
    if ((trial.count == 0) || !start_first(&trial.config, trial.is_q31)) {
        return 0;
    }
    const reference_record_t record = {trial.sample, trial.gap_before, trial.count};
    reference_start(&reference, &trial.config, false, record);
    run(&trial, &reference);
    REQUIRE(!reference_next(&reference, &more));
    return 0;
}
