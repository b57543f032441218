/* davar - jobs and results as words. Encoding and decoding list the fields in the same order, one a word. */
#include "davar_job.h"

#include <string.h>

#define MAGIC UINT64_C(0x32424F4A52564144) /* "DAVRJOB2" */
#define HEALTH UINT64_MAX                  /* in the place of a channel */

static uint64_t bits_of(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static double double_of(uint64_t bits)
{
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

void davar_job_encode(const davar_config_t *config, davar_port_number_t number, uint32_t channels,
                      uint64_t words[DAVAR_JOB_WORDS])
{
    const uint64_t fields[DAVAR_JOB_SETTINGS] = {MAGIC,
                                                 (uint64_t)number,
                                                 channels,
                                                 bits_of(config->rate_hz),
                                                 bits_of(config->unit_per_count),
                                                 bits_of(config->full_scale),
                                                 config->sample_bits,
                                                 (uint64_t)config->mode,
                                                 (uint64_t)davar_law_id(config),
                                                 config->window_max,
                                                 config->window_min,
                                                 config->segment,
                                                 bits_of(config->kurtosis_low),
                                                 bits_of(config->kurtosis_high),
                                                 bits_of(config->contribution_low),
                                                 bits_of(config->contribution_high),
                                                 config->grow,
                                                 config->shrink,
                                                 config->stride,
                                                 config->gaps_max,
                                                 config->mirrored_end ? 1U : 0U,
                                                 config->tau_count,
                                                 (uint64_t)config->engine,
                                                 bits_of(config->false_alarms_per_hour),
                                                 bits_of(config->cut_interval_s),
                                                 config->block,
                                                 config->shock_blocks,
                                                 config->long_cluster};
    memcpy(words, fields, sizeof fields);
    for (uint32_t t = 0U; t < DAVAR_JOB_TAUS; t++) {
        words[DAVAR_JOB_SETTINGS + t] = (t < config->tau_count) ? config->taus[t] : 0U;
    }
}

bool davar_job_decode(davar_job_t *job, const uint64_t words[DAVAR_JOB_WORDS])
{
    if ((words[0] != MAGIC) || (words[21] > DAVAR_TAUS_MAX)) {
        return false;
    }
    job->number = (davar_port_number_t)words[1];
    job->channels = (uint32_t)words[2];
    const davar_config_t config = {.rate_hz = double_of(words[3]),
                                   .unit_per_count = double_of(words[4]),
                                   .full_scale = double_of(words[5]),
                                   .sample_bits = (uint8_t)words[6],
                                   .mode = (davar_mode_t)words[7],
                                   .law = davar_policy_law((davar_policy_t)words[8], job->number != DAVAR_PORT_Q15),
                                   .window_max = (uint32_t)words[9],
                                   .window_min = (uint32_t)words[10],
                                   .segment = (uint32_t)words[11],
                                   .kurtosis_low = double_of(words[12]),
                                   .kurtosis_high = double_of(words[13]),
                                   .contribution_low = double_of(words[14]),
                                   .contribution_high = double_of(words[15]),
                                   .grow = (uint32_t)words[16],
                                   .shrink = (uint32_t)words[17],
                                   .stride = (uint32_t)words[18],
                                   .engine = (davar_engine_t)words[22],
                                   .false_alarms_per_hour = double_of(words[23]),
                                   .cut_interval_s = double_of(words[24]),
                                   .block = (uint32_t)words[25],
                                   .shock_blocks = (uint32_t)words[26],
                                   .long_cluster = (uint32_t)words[27],
                                   .gaps_max = (uint16_t)words[19],
                                   .mirrored_end = words[20] != 0U,
                                   .tau_count = (uint8_t)words[21],
                                   .taus = job->taus};
    job->config = config;
    for (uint32_t t = 0U; t < job->config.tau_count; t++) {
        job->taus[t] = (uint32_t)words[DAVAR_JOB_SETTINGS + t];
    }
    return true;
}

size_t davar_job_encode_result(size_t channel, const davar_result_t *result, uint64_t words[DAVAR_JOB_RESULT_WORDS])
{
    const uint64_t head[DAVAR_JOB_HEAD] = {channel,
                                           result->epoch,
                                           result->window_samples,
                                           result->gaps_in_window,
                                           result->mirrored_samples,
                                           result->unstable ? 1U : 0U,
                                           bits_of(result->kurtosis),
                                           bits_of(result->contribution),
                                           result->tau_count,
                                           result->alarm ? 1U : 0U,
                                           result->young ? 1U : 0U,
                                           result->cut_age_samples,
                                           bits_of(result->dispersion),
                                           result->change.m,
                                           bits_of(result->change.older),
                                           bits_of(result->change.newer),
                                           bits_of(result->change.gain),
                                           (uint64_t)result->noise};
    memcpy(words, head, sizeof head);
    uint64_t *word = &words[DAVAR_JOB_HEAD];
    for (uint32_t t = 0U; t < result->tau_count; t++, word += 6) {
        const davar_adev_t *const tau = &result->tau[t];
        const uint64_t fields[6] = {
            tau->m, tau->differences, bits_of(tau->adev), bits_of(tau->low), bits_of(tau->high), bits_of(tau->edf)};
        memcpy(word, fields, sizeof fields);
    }
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++, word += 4) {
        const davar_coefficient_t *const one = &result->coefficient[k];
        const uint64_t fields[4] = {one->present ? 1U : 0U, bits_of(one->value), bits_of(one->low), bits_of(one->high)};
        memcpy(word, fields, sizeof fields);
    }
    return (size_t)(word - words);
}

void davar_job_encode_health(size_t channel, const davar_health_t *health, uint64_t head[DAVAR_JOB_HEAD])
{
    const uint64_t fields[DAVAR_JOB_HEAD] = {
        HEALTH,           channel,        health->gaps, health->missing, health->saturated, health->not_finite,
        health->restarts, health->missed, health->cuts, health->alarms,  health->shocks};
    memcpy(head, fields, sizeof fields);
}

bool davar_job_decode_health(size_t *channel, davar_health_t *health, const uint64_t head[DAVAR_JOB_HEAD])
{
    *channel = (size_t)head[1];
    *health = (davar_health_t){.gaps = (uint32_t)head[2],
                               .missing = (uint32_t)head[3],
                               .saturated = (uint32_t)head[4],
                               .not_finite = (uint32_t)head[5],
                               .restarts = (uint32_t)head[6],
                               .missed = (uint32_t)head[7],
                               .cuts = (uint32_t)head[8],
                               .alarms = (uint32_t)head[9],
                               .shocks = (uint32_t)head[10]};
    return head[0] == HEALTH;
}

size_t davar_job_result_rest(const uint64_t head[DAVAR_JOB_HEAD])
{
    const uint64_t taus = head[8];
    return ((taus >= 1U) && (taus <= DAVAR_TAUS_MAX)) ? ((6U * (size_t)taus) + ((size_t)4U * DAVAR_COEFFICIENT_COUNT))
                                                      : 0U;
}

void davar_job_decode_result(size_t *channel, davar_result_t *result, const uint64_t words[DAVAR_JOB_RESULT_WORDS])
{
    *channel = (size_t)words[0];
    result->epoch = words[1];
    result->window_samples = (uint32_t)words[2];
    result->gaps_in_window = (uint32_t)words[3];
    result->mirrored_samples = (uint32_t)words[4];
    result->unstable = words[5] != 0U;
    result->kurtosis = double_of(words[6]);
    result->contribution = double_of(words[7]);
    result->tau_count = (uint8_t)words[8];
    result->alarm = words[9] != 0U;
    result->young = words[10] != 0U;
    result->cut_age_samples = (uint32_t)words[11];
    result->dispersion = double_of(words[12]);
    result->change =
        (davar_change_t){(uint32_t)words[13], double_of(words[14]), double_of(words[15]), double_of(words[16])};
    result->noise = (davar_noise_t)words[17];
    result->unit_per_count = 0.0; /* fitted already */
    const uint64_t *word = &words[DAVAR_JOB_HEAD];
    for (uint32_t t = 0U; t < result->tau_count; t++, word += 6) {
        const davar_adev_t tau = {(uint32_t)word[0],  (uint32_t)word[1],  double_of(word[2]),
                                  double_of(word[3]), double_of(word[4]), double_of(word[5])};
        result->tau[t] = tau;
    }
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++, word += 4) {
        const davar_coefficient_t one = {word[0] != 0U, double_of(word[1]), double_of(word[2]), double_of(word[3])};
        result->coefficient[k] = one;
    }
}
