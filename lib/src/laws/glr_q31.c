/* davar - the detector as a window law of the number type q31. */
#include "core/instance.h"
#include "laws/glr.h"

#define NUMBER(name) davar_q31_##name
typedef int32_t sample_t;

/* The sums of a block of at most 64 samples. */
typedef struct {
    int64_t sum;
    davar_u128_t squares;
} block_t;

static inline void block_copy(block_t *to, const block_t *from)
{
    to->sum = from->sum;
    davar_u128_copy(&to->squares, &from->squares);
}

static inline void block_clear(block_t *block)
{
    block->sum = 0;
    block->squares.low = 0U;
    block->squares.high = 0U;
}

static inline void block_add(block_t *block, sample_t sample)
{
    const davar_u128_t square = {davar_multiply_i32(sample, sample), 0U};
    block->sum += sample;
    block->squares = davar_u128_add(block->squares, square);
}

static inline void block_detect(const block_t *block, davar_glr_t *detector,
                                const davar_glr_config_t *config, davar_glr_event_t *event)
{
    davar_glr_push_q31(detector, config, block->sum, &block->squares, event);
}

/* The part of a sample that the two before it do not predict (10.16), within the range of a
 * sample. */
static inline sample_t whitened(int32_t first, int32_t second, sample_t sample, sample_t before,
                                sample_t earlier)
{
    const uint64_t sum = davar_multiply_i32(first, before) + davar_multiply_i32(second, earlier);
    const int64_t rest = sample - ((int64_t)(sum + (UINT64_C(1) << 13U)) >> 14U);
    return (sample_t)((rest > INT32_MAX) ? INT32_MAX : ((rest < INT32_MIN) ? INT32_MIN : rest));
}

#define DETECTOR_NUMBER davar_number_q31
#define DETECTOR_ENGINE davar_engine_grid_q31
#define DETECTOR_LAW davar_law_glr_q31

#include "laws/glr_queue.inc"

_Static_assert(sizeof(glr_queue_t) <= DAVAR_GLR_BYTES(2U), "DAVAR_GLR_BYTES is too small");
