/* davar - a recording as a job for a device, and its results, as words for a file or a serial line.
 *
 * A job: header (DAVAR_JOB_WORDS), then blocks: missing and count (32 bits each), the samples of
 * channel 0, 1, ..; a block without samples ends the job.
 * Results: DAVAR_JOB_HEAD words, 6 for each cluster size, 4 for each coefficient; after the last
 * result the health of each channel, DAVAR_JOB_HEAD words. A file without it is incomplete.
 *
 * Little endian. Doubles are sent as their IEEE bits, so results arrive bit for bit. */
#ifndef DAVAR_JOB_H
#define DAVAR_JOB_H

#include "davar/davar.h"
#include "davar/filter.h"
#include "davar/glr.h"
#include "davar_curve.h"
#include "davar_law_id.h"
#include "davar_port.h"

#ifdef __cplusplus
extern "C" {
#endif

#define DAVAR_JOB_TAUS 32U
#define DAVAR_JOB_SETTINGS 32U
#define DAVAR_JOB_FILTER                                                                           \
    (DAVAR_FILTER_ZEROS + DAVAR_FILTER_POLES + 6U) /* the doubles of a filter */
#define DAVAR_JOB_WORDS (DAVAR_JOB_SETTINGS + DAVAR_JOB_TAUS + DAVAR_JOB_FILTER)
#define DAVAR_JOB_HEAD 23U
#define DAVAR_JOB_RESULT_WORDS                                                                     \
    (DAVAR_JOB_HEAD + (6U * DAVAR_TAUS_MAX) + (4U * DAVAR_COEFFICIENT_COUNT))

typedef struct {
    davar_config_t config; /* its taus point to curve.taus */
    davar_curve_t curve;
    davar_port_number_t number;
    uint32_t channels;
    bool declared; /* the filter is known */
    davar_filter_t filter;
} davar_job_t;

/* `config` may point to taus anywhere. `cascade_taus`: number of sizes of the cascade, or 0.
 * `filter` null: unknown. */
void davar_job_encode(const davar_config_t *config, uint8_t cascade_taus,
                      davar_port_number_t number, uint32_t channels, const davar_filter_t *filter,
                      uint64_t words[DAVAR_JOB_WORDS]);

/* False: not a job, or more cluster sizes than this build supports. The job must not be moved. */
bool davar_job_decode(davar_job_t *job, const uint64_t words[DAVAR_JOB_WORDS]);

/* Returns the number of words written. */
size_t davar_job_encode_result(size_t channel, const davar_result_t *result,
                               const davar_glr_report_t *report,
                               uint64_t words[DAVAR_JOB_RESULT_WORDS]);

/* Writes the head with the health of a channel. */
void davar_job_encode_health(size_t channel, const davar_health_t *health,
                             uint64_t head[DAVAR_JOB_HEAD]);

/* True if the head is a health record. */
bool davar_job_decode_health(size_t *channel, davar_health_t *health,
                             const uint64_t head[DAVAR_JOB_HEAD]);

/* Words that follow the head of a result. 0: not the head of a result that this build supports. */
size_t davar_job_result_rest(const uint64_t head[DAVAR_JOB_HEAD]);

void davar_job_decode_result(size_t *channel, davar_result_t *result, davar_glr_report_t *report,
                             const uint64_t words[DAVAR_JOB_RESULT_WORDS]);

#ifdef __cplusplus
}
#endif

#endif
