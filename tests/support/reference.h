/* davar tests - the algorithm by brute force, directly from its definition: the complete record in
 * memory, every window summed again, ends mirrored by index, moments about the mean in 113-bit
 * floating point. Shares no code with lib/. */
#ifndef DAVAR_TESTS_REFERENCE_H
#define DAVAR_TESTS_REFERENCE_H

#include "davar/types.h"

/* Quadruple precision represents every integer sum of the tests exactly. */
__extension__ typedef __float128 reference_real_t;

typedef struct {
    const int32_t *sample;
    /* gap_before[i]: samples are missing before sample i; may be null */
    const bool *gap_before;
    int64_t count;
} reference_record_t;

typedef struct {
    int64_t epoch;
    int64_t head;
    int64_t tail;
    bool filling;
    bool unstable;
    double kurtosis;     /* NaN: undefined */
    double contribution; /* NaN: undefined */
} reference_epoch_t;

/* The first epoch of a record; call next until it returns false (no more epochs). `next_length` is
 * kept between calls. */
typedef struct {
    const davar_config_t *config;
    bool is_centred; /* the epoch is the middle of its window, otherwise its newest sample */
    reference_record_t record;
    int64_t due_epoch;
    int64_t length;
    bool filling;
    double level[2]; /* of two windows half a window apart, the newest first (4.5) */
    int64_t wait;    /* samples until the next of them */
} reference_t;

/* The sample at a position, or the one that its mirror image has before or after the record. */
int64_t reference_sample(const reference_record_t *record, int64_t position);

void reference_start(reference_t *reference, const davar_config_t *config, bool is_centred,
                     reference_record_t record);
bool reference_next(reference_t *reference, reference_epoch_t *epoch);

/* Sum of D^2 and number of spans without a gap in the epoch's window. */
reference_real_t reference_sum(const reference_t *reference, const reference_epoch_t *epoch,
                               uint32_t m, uint32_t *differences);

#endif
