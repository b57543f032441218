/* davar - the whole state of an instance, through a brown-out and back.
 *
 *   storage:  | slot 0: header, payload | slot 1: header, payload |
 *
 * A save goes into the slot that does not hold the newest image, payload first, header last: wherever the power is cut,
 * the other slot still holds a whole image. Formats and checks: DESIGN 8. */
#ifndef DAVAR_STATE_H
#define DAVAR_STATE_H

#include "davar/instance.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Memory that outlives the power: flash behind an erase layer, FRAM, a file. Both functions move `bytes` bytes at `offset`
 * (0 .. 2 slot_bytes), return true when done, and belong to the caller. */
typedef struct {
    bool (*read)(void *context, size_t offset, void *data, size_t bytes);
    bool (*write)(void *context, size_t offset, const void *data, size_t bytes);
    void *context;
    size_t slot_bytes; /* at least davar_state_bytes(); for flash rounded up to whole pages */
} davar_storage_t;

/* Bytes of one slot for this instance: its memory and 200 more at most. */
size_t davar_state_bytes(const davar_t *davar);

/* Saves. DAVAR_OK; DAVAR_ERR_STATE_STORAGE: a slot is too small, neither can be read, or writing failed (the older image
 * is still there). Needs push and take quiet. Cost: two passes over the older image's header, one over the state. */
davar_status_t davar_state_save(const davar_t *davar, const davar_storage_t *storage);

/* Puts the newest whole image into an instance that init has just started with the same number type, configuration and
 * size of memory; the stream then goes on bit for bit (say davar_gap for what was lost meanwhile). DAVAR_OK;
 * DAVAR_ERR_STATE_STORAGE: a slot is too small, neither can be read, or a whole image failed or differed when it was read
 * again; DAVAR_ERR_STATE_NONE: no whole image; DAVAR_ERR_STATE_FOREIGN: the only whole images are of another version,
 * number type, configuration or machine (another byte order included). On refusal the instance is as after init. What lands in the instance is checked
 * before it is used: against accidents, not against forgery. Needs push and take quiet. */
davar_status_t davar_state_restore(davar_t *davar, const davar_storage_t *storage);

#ifdef __cplusplus
}
#endif

#endif
