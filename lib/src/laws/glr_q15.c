/* davar - the detector as a window law of the number type q15. */
#include "core/instance.h"
#include "laws/glr.h"

#define NUMBER(name) davar_q15_##name
typedef int16_t sample_t;

/* The sums of a block of at most 64 samples. */
typedef struct {
    int32_t sum;
    uint64_t squares;
} block_t;

static inline void block_copy(block_t *to, const block_t *from)
{
    to->sum = from->sum;
    to->squares = from->squares;
}

static inline void block_clear(block_t *block)
{
    block->sum = 0;
    block->squares = 0U;
}

static inline void block_add(block_t *block, sample_t sample)
{
    block->sum += sample;
    block->squares += (uint64_t)((int32_t)sample * sample);
}

static inline void block_detect(const block_t *block, davar_glr_t *detector,
                                const davar_glr_config_t *config, davar_glr_event_t *event)
{
    davar_glr_push_q15(detector, config, block->sum, block->squares, event);
}

/* The part of a sample that the two before it do not predict (10.16), within the range of a sample.
 * |first| + |second| <= GLR_WHITEN_MAX, so the sum is below 2^31. */
static inline sample_t whitened(int32_t first, int32_t second, sample_t sample, sample_t before,
                                sample_t earlier)
{
    const int32_t predicted = ((first * before) + (second * earlier) + (1 << 13U)) >> 14U;
    const int32_t rest = sample - predicted;
    return (sample_t)((rest > INT16_MAX) ? INT16_MAX : ((rest < INT16_MIN) ? INT16_MIN : rest));
}

#define DETECTOR_NUMBER davar_number_q15
#define DETECTOR_ENGINE davar_engine_grid_q15
#define DETECTOR_LAW davar_law_glr_q15

#include "laws/glr_queue.inc"

_Static_assert(sizeof(glr_queue_t) <= DAVAR_GLR_BYTES(1U), "DAVAR_GLR_BYTES is too small");
