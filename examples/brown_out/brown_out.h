/* The state of an instance over a brown-out: see brown_out.c. */
#ifndef BROWN_OUT_H
#define BROWN_OUT_H

#include "davar/davar.h"

#define BROWN_OUT_SLOT                                                                             \
    4096U /* bytes of each of the two slots: at least davar_state_bytes(), whole pages of flash */

/* Before the interrupt is enabled. DAVAR_OK, or why not; *is_restored: it goes on where the newest image was saved. */
davar_status_t brown_out_start(bool *is_restored);

/* Each minute and when the supply falls, while push and take are quiet. False: not saved, what was there is still there. */
bool brown_out_save(void);

/* The instance, to push and to take from. */
davar_t *brown_out_gyro(void);

/* --- yours ----------------------------------------------------------------------------------------------------------- */

/* `bytes` at `offset` of 2 BROWN_OUT_SLOT. False: it failed. */
bool storage_read(size_t offset, void *data, size_t bytes);
bool storage_write(size_t offset, const void *data, size_t bytes);

/* Samples that were missed since the image was saved; at least 1. */
uint32_t brown_out_missed(void);

#endif
