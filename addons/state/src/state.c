/* davar - saves and restores an instance. The caller's memory is saved as it is, pointers included;
 * restoring lays it out again, which overwrites every pointer. */
#include "davar/state.h"

#include "image.h"
#include "number/machine.h"

#include "davar/content.h"
#include "davar/davar.h"
#include "davar/version.h"

#define FORMAT 11U

/* Adds a field to the fingerprint, by its kind. */
#define CHECK_F64(check, value) davar_image_check_f64(check, &(value))
#define CHECK_U32(check, value) davar_image_check_u32(check, value)
#define CHECK_U16(check, value) davar_image_check_u32(check, value)
#define CHECK_I16(check, value) davar_image_check_u32(check, (uint32_t)(value))
#define CHECK_U8(check, value) davar_image_check_u32(check, value)
#define CHECK_ENGINE(check, value) davar_image_check_u32(check, ((value) != NULL) ? 1U : 0U)

/* Covers everything that an image depends on. Field by field, because padding is undefined. */
DAVAR_RARE static uint32_t fingerprint(const davar_layout_t *layout)
{
    const davar_config_t *const config = layout->config;
    const uint32_t build[] = {FORMAT,
                              DAVAR_VERSION_MAJOR,
                              DAVAR_VERSION_MINOR,
                              DAVAR_VERSION_PATCH,
                              (uint32_t)sizeof(void *),
                              (uint32_t)sizeof(davar_content_t),
                              layout->sum_bits,
                              layout->is_float ? 1U : 0U,
                              (uint32_t)davar_law_id(config)};
    uint32_t check = 0U;
    for (size_t i = 0U; i < (sizeof build / sizeof build[0]); i++) {
        check = davar_image_check_u32(check, build[i]);
    }
#define FIELD(member, kind) check = CHECK_##kind(check, config->member);
#include "davar/config_fields.inc"
    return davar_image_check(check, config->taus, config->tau_count * sizeof config->taus[0]);
}

static davar_image_t image_of(const davar_t *davar, davar_content_t *content)
{
    davar_layout_t layout;
    davar_content_layout(davar, &layout);
    return (davar_image_t){fingerprint(&layout), content, sizeof *content, layout.memory,
                           layout.bytes};
}

DAVAR_RARE size_t davar_state_bytes(const davar_t *davar)
{
    davar_layout_t layout;
    davar_content_layout(davar, &layout);
    return davar_image_bytes(sizeof(davar_content_t), layout.bytes);
}

DAVAR_RARE davar_state_status_t davar_state_restore(davar_t *davar, const davar_storage_t *storage)
{
    davar_content_t content = {0};
    const davar_image_t image = image_of(davar, &content);
    const davar_state_status_t status = davar_image_restore(&image, storage);
    if (status == DAVAR_STATE_OK) {
        davar_content_write(davar, &content);
    } else {
        davar_reset(davar);
    }
    return status;
}

DAVAR_RARE davar_state_status_t davar_state_save(const davar_t *davar,
                                                 const davar_storage_t *storage)
{
    davar_content_t content;
    davar_content_read(davar, &content);
    const davar_image_t image = image_of(davar, &content);
    return davar_image_save(&image, storage);
}
