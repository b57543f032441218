/* davar - one writer (an interrupt, say), one reader that it may interrupt: an odd `sequence` says that a change is going on,
 * and whoever finds it changed after reading reads again. The writer never waits. */
#ifndef DAVAR_SRC_SEQUENCE_H
#define DAVAR_SRC_SEQUENCE_H

#include "davar/instance.h"

#include <stdatomic.h>

static inline void davar_change_begin(davar_t *davar)
{
    davar->sequence = davar->sequence + 1U;
    atomic_thread_fence(memory_order_release);
}

static inline void davar_change_end(davar_t *davar)
{
    atomic_thread_fence(memory_order_release);
    davar->sequence = davar->sequence + 1U;
}

static inline uint32_t davar_read_begin(const davar_t *davar)
{
    const uint32_t before = davar->sequence;
    atomic_thread_fence(memory_order_acquire);
    return before;
}

/* What was read so far is not read again from where a push may change it. */
static inline void davar_read_apart(void)
{
    atomic_thread_fence(memory_order_acquire);
}

/* Did a push come between, or was one at work on another core? */
static inline bool davar_read_torn(const davar_t *davar, uint32_t before)
{
    atomic_thread_fence(memory_order_acquire);
    return ((before % 2U) != 0U) || (before != davar->sequence);
}

static inline bool davar_result_waits(const davar_t *davar)
{
    return davar->ready && (davar->produced != davar->seen);
}

/* Results up to `produced` that were, or will be, lost; `waits`: not the last of them. */
static inline uint32_t davar_missed(const davar_t *davar, uint32_t produced, bool waits)
{
    const uint32_t more = (produced - davar->seen) - (waits ? 1U : 0U);
    const uint32_t room = UINT32_MAX - davar->health.missed;
    return davar->health.missed + ((more < room) ? more : room);
}

#endif
