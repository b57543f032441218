/* davar - converts jobs and results to words and back, one field per word. */
#include "davar_job.h"
#include "davar/filter.h"

#include <string.h>

#define MAGIC UINT64_C(0x41424F4A52564144) /* "DAVRJOBA" */
#define FILTER_WORDS 2U
#define HEALTH UINT64_MAX /* instead of a channel */

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

/* Converts a field of the configuration to a word, and back. */
#define WORD_OF_F64(value) bits_of(value)
#define WORD_OF_U32(value) (uint64_t)(value)
#define WORD_OF_U16(value) (uint64_t)(value)
#define WORD_OF_I16(value) (uint64_t)(value)
#define WORD_OF_U8(value) (uint64_t)(value)
#define WORD_OF_ENGINE(value) (((value) != NULL) ? 1U : 0U)
#define OF_WORD_F64(word) double_of(word)
#define OF_WORD_U32(word) (uint32_t)(word)
#define OF_WORD_U16(word) (uint16_t)(word)
#define OF_WORD_I16(word) (int16_t)(word)
#define OF_WORD_U8(word) (uint8_t)(word)
#define OF_WORD_ENGINE(word) davar_grid_of((word) != 0U, is_wide)

/* The i-th double of a filter, below DAVAR_JOB_FILTER. */
static double *filter_number(davar_filter_t *filter, uint32_t i)
{
    double *const more[] = {&filter->uncertainty, &filter->level, &filter->count_variance,
                            &filter->count_step};
    if (i <= DAVAR_FILTER_ZEROS) {
        return &filter->b[i];
    }
    const uint32_t after_b = i - (DAVAR_FILTER_ZEROS + 1U);
    return (after_b <= DAVAR_FILTER_POLES) ? &filter->a[after_b]
                                           : more[after_b - (DAVAR_FILTER_POLES + 1U)];
}

void davar_job_encode(const davar_config_t *config, uint8_t cascade_taus,
                      davar_port_number_t number, uint32_t channels, const davar_filter_t *filter,
                      uint64_t words[DAVAR_JOB_WORDS])
{
    const davar_filter_t none = {0};
    const davar_filter_t *const known = (filter != NULL) ? filter : &none;
    const uint64_t is_declared = (filter != NULL) ? 1U : 0U;
    const uint64_t fields[DAVAR_JOB_SETTINGS] = {
        MAGIC,
        (uint64_t)number,
        channels,
        (uint64_t)davar_law_id(config),
#define FIELD(member, kind) WORD_OF_##kind(config->member),
#include "davar/config_fields.inc"
        is_declared,
        ((uint64_t)known->summed << 32U) | ((uint64_t)known->length << 16U) | known->averages,
        cascade_taus,
    };
    memcpy(words, fields, sizeof fields);
    for (uint32_t t = 0U; t < DAVAR_JOB_TAUS; t++) {
        words[DAVAR_JOB_SETTINGS + t] = (t < config->tau_count) ? config->taus[t] : 0U;
    }
    for (uint32_t i = 0U; i < DAVAR_JOB_FILTER; i++) {
        davar_filter_t copy = *known;
        words[DAVAR_JOB_SETTINGS + DAVAR_JOB_TAUS + i] = bits_of(*filter_number(&copy, i));
    }
}

/* Reads every field; returns the word after the last. */
static const uint64_t *decode_fields(davar_config_t *config, const uint64_t *word, bool is_wide)
{
#define FIELD(member, kind)                                                                        \
    config->member = OF_WORD_##kind(*word);                                                        \
    word++;
#include "davar/config_fields.inc"
    return word;
}

bool davar_job_decode(davar_job_t *job, const uint64_t words[DAVAR_JOB_WORDS])
{
    davar_config_t *const config = &job->config;
    uint32_t taus[DAVAR_TAUS_MAX];
    job->number = (davar_port_number_t)words[1];
    job->channels = (uint32_t)words[2];
    const bool is_wide = (job->number != DAVAR_PORT_Q15);
    config->law = davar_law_of_id((davar_law_id_t)words[3], is_wide);
    const uint64_t *const filter = decode_fields(config, &words[4], is_wide);
    const uint64_t *const cascade_taus = filter + FILTER_WORDS;
    if ((words[0] != MAGIC) || ((cascade_taus + 1) != &words[DAVAR_JOB_SETTINGS]) ||
        (config->tau_count == 0U) || (*cascade_taus > DAVAR_TAUS_MAX) ||
        ((config->tau_count + *cascade_taus) > DAVAR_TAUS_MAX)) {
        return false;
    }
    job->declared = (filter[0] != 0U);
    job->filter = (davar_filter_t){.averages = (uint8_t)filter[1],
                                   .length = (uint16_t)(filter[1] >> 16U),
                                   .summed = (uint16_t)(filter[1] >> 32U)};
    for (uint32_t i = 0U; i < DAVAR_JOB_FILTER; i++) {
        *filter_number(&job->filter, i) = double_of(words[DAVAR_JOB_SETTINGS + DAVAR_JOB_TAUS + i]);
    }
    for (uint32_t t = 0U; t < config->tau_count; t++) {
        taus[t] = (uint32_t)words[DAVAR_JOB_SETTINGS + t];
    }
    config->taus = taus;
    davar_curve_make(&job->curve, config, (uint8_t)*cascade_taus);
    config->taus = job->curve.taus;
    return true;
}

size_t davar_job_encode_result(size_t channel, const davar_result_t *result,
                               const davar_glr_report_t *report,
                               uint64_t words[DAVAR_JOB_RESULT_WORDS])
{
    const uint64_t head[DAVAR_JOB_HEAD] = {channel,
                                           result->epoch,
                                           result->window_samples,
                                           result->gaps_in_window,
                                           result->mirrored_samples,
                                           (result->unstable ? 1U : 0U) |
                                               (result->chosen ? 2U : 0U),
                                           bits_of(result->kurtosis),
                                           bits_of(result->contribution),
                                           result->tau_count,
                                           report->alarm ? 1U : 0U,
                                           report->young ? 1U : 0U,
                                           report->cut_age_samples,
                                           bits_of(result->dispersion),
                                           report->change.m,
                                           bits_of(report->change.older),
                                           bits_of(report->change.newer),
                                           bits_of(report->change.gain),
                                           (uint64_t)result->noise,
                                           report->steady.samples,
                                           bits_of(report->steady.level),
                                           bits_of(report->steady.low),
                                           bits_of(report->steady.high),
                                           ((uint64_t)result->flat_to << 32U) | result->flat_from};
    memcpy(words, head, sizeof head);
    uint64_t *word = &words[DAVAR_JOB_HEAD];
    for (uint32_t t = 0U; t < result->tau_count; t++, word += 6) {
        const davar_adev_t *const tau = &result->tau[t];
        const uint64_t fields[6] = {((uint64_t)tau->hops << 32U) | tau->m,
                                    tau->differences,
                                    bits_of(tau->adev),
                                    bits_of(tau->low),
                                    bits_of(tau->high),
                                    bits_of(tau->edf)};
        memcpy(word, fields, sizeof fields);
    }
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++, word += 4) {
        const davar_coefficient_t *const one = &result->coefficient[k];
        const uint64_t fields[4] = {one->present ? 1U : 0U, bits_of(one->value), bits_of(one->low),
                                    bits_of(one->high)};
        memcpy(word, fields, sizeof fields);
    }
    return (size_t)(word - words);
}

void davar_job_encode_health(size_t channel, const davar_health_t *health,
                             uint64_t head[DAVAR_JOB_HEAD])
{
    const uint64_t fields[DAVAR_JOB_HEAD] = {
        HEALTH,           channel,           health->gaps,
        health->missing,  health->saturated, health->not_finite,
        health->restarts, health->missed,    health->cuts,
        health->alarms,   health->shocks};
    memcpy(head, fields, sizeof fields);
}

bool davar_job_decode_health(size_t *channel, davar_health_t *health,
                             const uint64_t head[DAVAR_JOB_HEAD])
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
    return ((taus >= 1U) && (taus <= DAVAR_TAUS_MAX))
               ? ((6U * (size_t)taus) + ((size_t)4U * DAVAR_COEFFICIENT_COUNT))
               : 0U;
}

void davar_job_decode_result(size_t *channel, davar_result_t *result, davar_glr_report_t *report,
                             const uint64_t words[DAVAR_JOB_RESULT_WORDS])
{
    *channel = (size_t)words[0];
    result->epoch = words[1];
    result->window_samples = (uint32_t)words[2];
    result->gaps_in_window = (uint32_t)words[3];
    result->mirrored_samples = (uint32_t)words[4];
    result->unstable = (words[5] & 1U) != 0U;
    result->chosen = (words[5] & 2U) != 0U;
    result->kurtosis = double_of(words[6]);
    result->contribution = double_of(words[7]);
    result->tau_count = (uint8_t)words[8];
    result->dispersion = double_of(words[12]);
    result->noise = (davar_noise_t)words[17];
    result->flat_from = (uint32_t)words[22];
    result->flat_to = (uint32_t)(words[22] >> 32U);
    *report = (davar_glr_report_t){
        .epoch = result->epoch,
        .alarm = words[9] != 0U,
        .young = words[10] != 0U,
        .cut_age_samples = (uint32_t)words[11],
        .change = {(uint32_t)words[13], double_of(words[14]), double_of(words[15]),
                   double_of(words[16])},
        .steady = {words[18], double_of(words[19]), double_of(words[20]), double_of(words[21])}};
    result->unit_per_count = 0.0; /* the result is already fitted */
    const uint64_t *word = &words[DAVAR_JOB_HEAD];
    for (uint32_t t = 0U; t < result->tau_count; t++, word += 6) {
        result->tau[t] = (davar_adev_t){.m = (uint32_t)word[0],
                                        .differences = (uint32_t)word[1],
                                        .hops = (uint8_t)(word[0] >> 32U),
                                        .power = 1.0F,
                                        .uneven = DAVAR_EVEN,
                                        .adev = double_of(word[2]),
                                        .low = double_of(word[3]),
                                        .high = double_of(word[4]),
                                        .edf = double_of(word[5])};
    }
    for (int k = 0; k < (int)DAVAR_COEFFICIENT_COUNT; k++, word += 4) {
        const davar_coefficient_t one = {word[0] != 0U, double_of(word[1]), double_of(word[2]),
                                         double_of(word[3])};
        result->coefficient[k] = one;
    }
}
