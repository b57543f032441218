/* davar - the pipeline of the number type q15, and the door of its samples. */
#include "window/number_q15.h"

#include "davar/davar.h"
#include "track/glr.h"

static inline void block_tell(const block_t *block, davar_glr_t *detector, const davar_glr_config_t *config,
                              davar_glr_event_t *event)
{
    davar_glr_push_q15(detector, config, block->sum, block->squares, event);
}

static inline void clusters_tell(difference_t difference, davar_glr_t *detector, const davar_glr_config_t *config,
                                 davar_glr_event_t *event)
{
    davar_glr_push_clusters_q15(detector, config, difference, event);
}

#include "pipeline/pipeline.h"

_Static_assert(sizeof(stages_t) <= DAVAR_STAGES_BYTES_Q15, "DAVAR_STAGES_BYTES_Q15 is too small");
_Static_assert(sizeof(tau_t) <= 16U, "DAVAR_MEMORY_Q15 counts too little per tau");

_Static_assert(sizeof(grid_t) <= DAVAR_GRID_BYTES, "DAVAR_GRID_BYTES is too small");

const davar_number_t davar_number_q15 = PIPELINE_NUMBER(false);

size_t davar_push_until_result_q15(davar_t *davar, const int16_t *counts, size_t count)
{
    if (!davar_accepts(davar, ACCEPTS_Q15, count)) {
        return count;
    }
    davar_change_begin(davar);
    const size_t taken = pipeline_push(davar, counts, count);
    davar_change_end(davar);
    return taken;
}

void davar_push_q15(davar_t *davar, const int16_t *counts, size_t count)
{
    if (davar_accepts(davar, ACCEPTS_Q15, count)) {
        davar_change_begin(davar);
        pipeline_push_all(davar, counts, count);
        davar_change_end(davar);
    }
}
