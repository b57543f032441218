/* davar - images of a state in two slots (section 8): a header, then the payload. */
#ifndef DAVAR_SRC_IMAGE_H
#define DAVAR_SRC_IMAGE_H

#include "davar/state.h"

/* The payload: a few fields, then the caller's memory. */
typedef struct {
    uint32_t fingerprint; /* of everything that the payload depends on */
    void *saved;
    size_t saved_bytes;
    void *memory;
    size_t memory_bytes;
} davar_image_t;

/* Bytes of a slot. */
size_t davar_image_bytes(size_t saved_bytes, size_t memory_bytes);

/* DAVAR_STATE_OK or DAVAR_STATE_ERR_STORAGE. */
davar_state_status_t davar_image_save(const davar_image_t *image, const davar_storage_t *storage);

/* Reads the newest intact image with this fingerprint. Any other result than DAVAR_STATE_OK may have
 * overwritten the memory. */
davar_state_status_t davar_image_restore(const davar_image_t *image,
                                         const davar_storage_t *storage);

/* CRC-32 over more bytes, or over a number in any byte order, for checks and fingerprints. */
uint32_t davar_image_check(uint32_t check, const void *data, size_t bytes);
uint32_t davar_image_check_u32(uint32_t check, uint32_t value);
uint32_t davar_image_check_f64(uint32_t check, const double *value);

#endif
