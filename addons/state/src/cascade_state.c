/* davar - saves and restores a cascade: its fields without the pointers, then its memory. */
#include "davar/cascade.h"

#include "image.h"
#include "number/machine.h"

#include "davar/version.h"

#define FORMAT_CASCADE 0x10001U /* an image of an instance has a smaller one */

/* Covers everything that an image depends on. */
DAVAR_RARE static uint32_t fingerprint_of_cascade(const davar_cascade_t *cascade)
{
    const davar_cascade_config_t *const config = cascade->config;
    const uint32_t fields[] = {FORMAT_CASCADE,           DAVAR_VERSION_MAJOR,
                               DAVAR_VERSION_MINOR,      DAVAR_VERSION_PATCH,
                               (uint32_t)sizeof(void *), (uint32_t)sizeof(davar_cascade_t),
                               cascade->accepts,         config->shortest,
                               config->tau_count,        config->clusters};
    uint32_t check = 0U;
    for (size_t i = 0U; i < (sizeof fields / sizeof fields[0]); i++) {
        check = davar_image_check_u32(check, fields[i]);
    }
    check = davar_image_check_f64(check, &config->rate_hz);
    check = davar_image_check_f64(check, &config->unit_per_count);
    return davar_image_check_f64(check, &config->full_scale);
}

static davar_image_t image_of_cascade(const davar_cascade_t *cascade, davar_cascade_t *saved)
{
    return (davar_image_t){fingerprint_of_cascade(cascade), saved, sizeof *saved, cascade->stages,
                           cascade->memory_bytes};
}

DAVAR_RARE size_t davar_cascade_state_bytes(const davar_cascade_t *cascade)
{
    return davar_image_bytes(sizeof *cascade, cascade->memory_bytes);
}

DAVAR_RARE davar_state_status_t davar_cascade_save(const davar_cascade_t *cascade,
                                                   const davar_storage_t *storage)
{
    davar_cascade_t saved = *cascade;
    saved.config = NULL;
    saved.stages = NULL;
    saved.tops = NULL;
    const davar_image_t image = image_of_cascade(cascade, &saved);
    return davar_image_save(&image, storage);
}

DAVAR_RARE davar_state_status_t davar_cascade_restore(davar_cascade_t *cascade,
                                                      const davar_storage_t *storage)
{
    davar_cascade_t saved;
    const davar_image_t image = image_of_cascade(cascade, &saved);
    const davar_state_status_t status = davar_image_restore(&image, storage);
    if (status != DAVAR_STATE_OK) {
        davar_cascade_reset(cascade);
        return status;
    }
    saved.config = cascade->config;
    saved.stages = cascade->stages;
    saved.tops = cascade->tops;
    *cascade = saved;
    return DAVAR_STATE_OK;
}
