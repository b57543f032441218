/* davar - an engine: an object that computes the sums of the windows of a stride above 1. A
 * configuration names it. Without one, sums follow both edges of the window (core/slide.inc).
 *
 * It advances the ring, D and the sums in davar->stages, and counts the samples in
 * davar->window.received. */
#ifndef DAVAR_SRC_ENGINE_H
#define DAVAR_SRC_ENGINE_H

#include "davar/types.h"

#include "core/arena.h"

struct davar;
struct davar_number;

struct davar_engine {
    const struct davar_number *number; /* the type of its samples and sums */
    uint32_t block;                    /* samples that it stores together, at most */
    /* Takes the first of `count` samples and more, none after the epoch that is due; returns how
     * many. No gap is near, and no span reaches before the start. */
    uint32_t (*step)(struct davar *davar, const void *samples, size_t count);
    /* Takes one sample, which is already in the ring. */
    void (*step_carefully)(struct davar *davar);
    /* Takes its own state from the arena; null if that only counts. */
    void *(*carve)(davar_arena_t *arena, const davar_config_t *config);
    /* At the start of a stream, after the stages. */
    void (*start)(struct davar *davar);
    /* At an epoch: moves the window to it, and keeps length, sums and moments for the reader. */
    void (*complete)(struct davar *davar);
};

#endif
