/* davar - the sequence lock between one writer (for example an interrupt) and one reader that it
 * may interrupt. The number is odd while the writer is at work. A reader that finds it changed
 * repeats its reads. The writer never waits. */
#ifndef DAVAR_SRC_SEQUENCE_H
#define DAVAR_SRC_SEQUENCE_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

static inline void davar_sequence_begin(volatile uint32_t *sequence)
{
    *sequence = *sequence + 1U;
    atomic_thread_fence(memory_order_release);
}

static inline void davar_sequence_end(volatile uint32_t *sequence)
{
    atomic_thread_fence(memory_order_release);
    *sequence = *sequence + 1U;
}

static inline uint32_t davar_sequence_read(const volatile uint32_t *sequence)
{
    const uint32_t before = *sequence;
    atomic_thread_fence(memory_order_acquire);
    return before;
}

/* The compiler keeps the copies made so far: it does not read the originals again. */
static inline void davar_read_apart(void)
{
    atomic_thread_fence(memory_order_acquire);
}

/* True if a push came between, or was active on another core. */
static inline bool davar_sequence_torn(const volatile uint32_t *sequence, uint32_t before)
{
    atomic_thread_fence(memory_order_acquire);
    return ((before % 2U) != 0U) || (before != *sequence);
}

#endif
