/* davar tests - the samples that a law accepts: of glr from the test's own detector, which receives
 * the raw samples (unit/test_glr.c checks it against the law). Sums over them are recomputed as
 * integers from cumulative sums, a different method than the library's. */
#ifndef DAVAR_TESTS_ACCEPTED_H
#define DAVAR_TESTS_ACCEPTED_H

#include "davar/davar.h"
#include "davar/glr.h"
#include "laws/glr.h"

#define ACCEPTED_RING 4096U /* stored samples; a power of two */

typedef struct {
    davar_glr_config_t config;
    davar_glr_t detector;
    int32_t waiting[GLR_BLOCK_MAX * (GLR_SHOCK_MAX + 2U)]; /* received and not accepted yet */
    int32_t rest[GLR_BLOCK_MAX]; /* of the newest block: the samples, whitened (10.16) */
    uint32_t waits;
    int32_t first; /* coefficients of whitening */
    int32_t second;
    int32_t before[2]; /* samples before the next one, the newer first */
    bool has_past;
    bool is_q31;
    bool has_detector; /* other laws accept every sample */
    uint64_t now;      /* samples received */
    uint32_t cuts;
    uint32_t alarms;
    uint32_t shocks;
    int64_t phase[ACCEPTED_RING];   /* cumulative sums up to accepted sample n */
    uint32_t run[ACCEPTED_RING];    /* samples without a boundary up to it */
    uint64_t moment[ACCEPTED_RING]; /* when it was received */
    uint64_t count;                 /* accepted */
    bool is_behind_boundary;        /* the next one is */
} accepted_t;

void accepted_start(accepted_t *accepted, const davar_config_t *config);

void accepted_hear(accepted_t *accepted, int32_t sample);

/* A gap drops the waiting samples. */
void accepted_gap(accepted_t *accepted);

/* The end of the record: waiting samples continue, unless a shock may have begun. */
void accepted_end(accepted_t *accepted);

/* One after the accepted sample received at `epoch`; 0: there is none. */
uint64_t accepted_head(const accepted_t *accepted, uint64_t epoch);

/* Sum of D^2 over the accepted samples [tail, head) and its count; none spans a boundary. D = P[i]
 * - 2 P[i - m] + P[i - 2 m]. Exact below 2^53, and to a rounding of each 64 bits above. */
double accepted_sum(const accepted_t *accepted, uint64_t tail, uint64_t head, uint32_t m,
                    uint32_t *differences);

#endif
