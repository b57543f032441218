/** @file
 * davar - state: saves a running instance and restores it after a loss of power.
 *
 * ```
 * storage:  | slot 0: header, payload | slot 1: header, payload |
 * ```
 *
 * A save overwrites the slot that does not hold the newest image: first the payload, then the
 * header. If power fails during a save, the other slot still holds a complete image. Formats and
 * checks: addons/state/DESIGN.md (section 8).
 *
 * Threads: stopped. No push, take, gap or flush of the instance may run at the same time. */
#ifndef DAVAR_STATE_H
#define DAVAR_STATE_H

#include "davar/instance.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Why a save or a restore failed: one code per cause, with a value that never changes. */
typedef enum {
    DAVAR_STATE_OK = 0,          /**< no error */
    DAVAR_STATE_ERR_STORAGE = 1, /**< a slot is too small, or the storage failed */
    DAVAR_STATE_ERR_NONE = 2,    /**< no intact image */
    /** an image of another version, number type, configuration or machine */
    DAVAR_STATE_ERR_FOREIGN = 3
} davar_state_status_t;

/** Describes a status in English.
 * @return A text that is never null and must not be changed. Threads: any. Cost: O(1). */
const char *davar_state_status_text(davar_state_status_t status);

/** Memory that keeps its content without power: flash with an erase layer, FRAM, or a file.
 * Both functions move `bytes` bytes at `offset`, within 0 .. 2 slot_bytes, and return true on
 * success. The structure and the functions belong to the caller. */
typedef struct {
    /** Reads from the storage into `data`. */
    bool (*read)(void *context, size_t offset, void *data, size_t bytes);
    /** Writes `data`. The bytes must be in the storage, not in a buffer, when it returns. */
    bool (*write)(void *context, size_t offset, const void *data, size_t bytes);
    void *context;     /**< passed unchanged to both functions */
    size_t slot_bytes; /**< at least davar_state_bytes(); for flash, rounded up to whole pages */
} davar_storage_t;

/** Returns the size of one slot for this instance, in bytes: its memory and at most 200 more.
 * Cost: O(1). */
size_t davar_state_bytes(const davar_t *davar);

/** Saves the instance to the slot that does not hold the newest image.
 * @return DAVAR_STATE_OK, or DAVAR_STATE_ERR_STORAGE: a slot is too small, neither slot can be read, or
 *         writing failed. After an error the older image is still there.
 *
 * Cost: reads both slots once and writes the state once. */
davar_state_status_t davar_state_save(const davar_t *davar, const davar_storage_t *storage);

/** Restores the newest complete image. The stream then continues with the same results, bit for
 * bit; call davar_gap for the samples that were lost.
 * The instance must have just been initialised with the same number type, configuration and size of
 * memory. After an error it is as after init. The check detects accidents, not forgery.
 * @return DAVAR_STATE_OK, or one of these:
 * - DAVAR_STATE_ERR_STORAGE: a slot is too small, neither slot can be read, or a complete image
 *   could not be read a second time or had changed;
 * - DAVAR_STATE_ERR_NONE: there is no complete image;
 * - DAVAR_STATE_ERR_FOREIGN: the only complete images have another version, number type,
 *   configuration, pointer size or byte order.
 *
 * Cost: reads both slots once and the image a second time; O(T) to set up the memory. */
davar_state_status_t davar_state_restore(davar_t *davar, const davar_storage_t *storage);

struct davar_cascade; /* davar/cascade.h */

/** @{ */
/** The same for a cascade (davar/cascade.h), with a separate storage. After restoring, call
 * davar_cascade_gap for the samples that were lost. The slot needs the memory of the cascade and at
 * most 200 bytes more. */
size_t davar_cascade_state_bytes(const struct davar_cascade *cascade);
davar_state_status_t davar_cascade_save(const struct davar_cascade *cascade,
                                        const davar_storage_t *storage);
davar_state_status_t davar_cascade_restore(struct davar_cascade *cascade,
                                           const davar_storage_t *storage);
/** @} */

#ifdef __cplusplus
}
#endif

#endif
