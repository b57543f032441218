/* Keeps the state of an instance over a brown-out: see brown_out.c. */
#ifndef BROWN_OUT_H
#define BROWN_OUT_H

#include "davar/davar.h"
#include "davar/state.h"

#define BROWN_OUT_SLOT                                                                             \
    4096U /* bytes of each slot: at least davar_state_bytes(), and a whole number of flash pages */

/* Call it before the interrupt is enabled. Returns DAVAR_OK, or the cause. *is_restored: it
 * continues from the newest saved image. */
davar_status_t brown_out_start(bool *is_restored);

/* Call it each minute and when the supply falls, with no push or take in progress. False: not
 * saved; the previous image remains. */
bool brown_out_save(void);

/* The instance, for push and take. */
davar_t *brown_out_gyro(void);

/* --- provided by you --- */

/* Transfers `bytes` at `offset`, within 2 BROWN_OUT_SLOT. False: it failed. */
bool storage_read(size_t offset, void *data, size_t bytes);
bool storage_write(size_t offset, const void *data, size_t bytes);

/* Samples missed since the image was saved; at least 1. */
uint32_t brown_out_missed(void);

#endif
