/* davar - window laws: what decides how long the window is.
 *
 * A law is a const table of functions that the configuration names (4). */
#ifndef DAVAR_SRC_LAW_H
#define DAVAR_SRC_LAW_H

#include "davar/types.h"

struct davar;
struct davar_number;
struct davar_rough;

/* Why a law's state starts over. */
typedef enum {
    DAVAR_LAW_INIT, /* init or reset: the state is all zeros */
    /* more gaps than the window can store: positions count from 0 again, the window's are still
     * the old ones */
    DAVAR_LAW_RESTART,
    DAVAR_LAW_RESUME /* a saved state was read back: set every pointer again, keep the rest */
} davar_law_start_t;

/* A window law. Every function except bytes, start and judge may be null.
 * `state` is the law's part of the caller's memory, 8-byte aligned. read runs in the consumer's
 * context, all other functions in the producer's (push, gap, flush) or with both sides stopped. */
struct davar_law {
    uint8_t id;         /* davar_law_id_t */
    bool wants_moments; /* judge needs the moments: moments.segment must not be 0 */
    /* The engine for a stride above 1, where the configuration names none. Null: sums follow both
     * edges. */
    const davar_engine_t *engine;
    /* Runs after an epoch: returns the flag `unstable` and sets window.next_length. `whole` is the
     * kurtosis of the window; null unless wants_moments is set and the window has at least
     * window.shortest samples. */
    bool (*judge)(struct davar *davar, void *state, const struct davar_rough *whole);
    /* On a grid, at an epoch that is due: sets window.next_length of its window. Null: the length
     * that judge chose. */
    void (*place)(struct davar *davar, void *state);
    /* Returns the size of `state` in bytes. */
    size_t (*bytes)(const davar_config_t *config);
    /* Prepares `state` and everything that points into it. */
    void (*start)(struct davar *davar, void *state, davar_law_start_t why);
    /* Returns the samples between two places where windows can begin: multiples of it, from
     * position 0 on. Null: anywhere. */
    uint32_t (*block)(const davar_config_t *config);
    /* For davar_take: corrects the epoch and sets chosen and dispersion of a result whose window is
     * known. It runs under the sequence lock and is repeated if a push interrupts it. */
    void (*read)(const void *state, davar_result_t *result);
    /* For a law with a queue, which takes each sample first and feeds the pipeline itself. push,
     * gap and flush go together. Takes samples up to the one that completes a result and returns
     * how many. */
    size_t (*push)(struct davar *davar, void *state, const void *samples, size_t count);
    /* For a law with a queue: handles a gap that davar_gap has counted. */
    void (*gap)(struct davar *davar, void *state);
    /* For a law with a queue: handles davar_flush. Returns true if another result is complete. */
    bool (*flush)(struct davar *davar, void *state);
    /* Checks the settings of the law. Returns DAVAR_OK, or the error that init returns. */
    davar_status_t (*check)(const davar_config_t *config, const struct davar_number *number);
};

#endif
