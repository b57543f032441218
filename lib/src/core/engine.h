/* davar - an engine: an object that computes the sums of the windows of a stride above 1. A
 * configuration names it. Without one, sums follow both edges of the window (core/slide.inc).
 *
 * `stages` is the state of the pipeline, whose ring, D and running sums the engine advances. It
 * counts the samples in davar->window.received. */
#ifndef DAVAR_SRC_ENGINE_H
#define DAVAR_SRC_ENGINE_H

#include "core/arena.h"
#include "core/instance.h"

struct davar_engine {
    const davar_number_t *number; /* the type of its samples and sums */
    uint32_t block;               /* samples that it stores together, at most */
    /* Takes its own state from the arena; null if that only counts. */
    void *(*carve)(davar_arena_t *arena, const davar_config_t *config);
    /* At the start of a stream, after the stages. */
    void (*start)(davar_t *davar);
    /* Takes the first of `count` samples and more, none after the epoch that is due; returns how many.
     * No gap is near, and no span reaches before the start. */
    uint32_t (*step)(davar_t *davar, const void *samples, size_t count);
    /* Takes one sample, which is already in the ring. */
    void (*step_carefully)(davar_t *davar);
    /* At an epoch: moves the window to it, and keeps its length, sums and moments for the reader. */
    void (*complete)(davar_t *davar);
};

#endif
