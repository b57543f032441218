/* davar - saves and restores an instance. The caller's memory is saved as it is, pointers included;
 * restoring lays it out again, which overwrites every pointer. */
#include "davar/state.h"

#include "core/instance.h"
#include "number/machine.h"
#include "state/image.h"

#include "davar/davar.h"
#include "davar/version.h"

#include <string.h>

#define FORMAT 9U

/* The instance without its pointers. */
typedef struct {
    davar_window_t window;
    davar_health_t health;
    uint32_t produced;
    uint32_t seen;
    uint16_t gaps;
    bool ready;
    bool in_gap;
    bool unstable;
    uint32_t alarms_seen;
} saved_t;

/* Adds a field to the fingerprint, by its kind. */
#define CHECK_F64(check, value) davar_image_check_f64(check, &(value))
#define CHECK_U32(check, value) davar_image_check_u32(check, value)
#define CHECK_U16(check, value) davar_image_check_u32(check, value)
#define CHECK_I16(check, value) davar_image_check_u32(check, (uint32_t)(value))
#define CHECK_U8(check, value) davar_image_check_u32(check, value)
#define CHECK_ENGINE(check, value) davar_image_check_u32(check, (uint32_t)(value))

/* Covers everything that an image depends on. Field by field, because padding is undefined. */
DAVAR_RARE static uint32_t fingerprint(const davar_t *davar)
{
    const davar_config_t *const config = davar->config;
    const uint32_t build[] = {FORMAT,
                              DAVAR_VERSION_MAJOR,
                              DAVAR_VERSION_MINOR,
                              DAVAR_VERSION_PATCH,
                              (uint32_t)sizeof(void *),
                              (uint32_t)sizeof(saved_t),
                              davar->number->sum_bits,
                              davar->is_float ? 1U : 0U,
                              davar_law_id(config)};
    uint32_t check = 0U;
    for (size_t i = 0U; i < (sizeof build / sizeof build[0]); i++) {
        check = davar_image_check_u32(check, build[i]);
    }
#define FIELD(member, kind, low, high, usual, status, option, unit, help)                          \
    check = CHECK_##kind(check, config->member);
#include "davar/config_fields.inc"
    return davar_image_check(check, config->taus, config->tau_count * sizeof config->taus[0]);
}

DAVAR_RARE static size_t memory_bytes(const davar_t *davar)
{
    return is_wide(davar) ? davar_q31_memory_size(davar->config)
                          : davar_q15_memory_size(davar->config);
}

static davar_image_t image_of(const davar_t *davar, saved_t *saved)
{
    return (davar_image_t){fingerprint(davar), saved, sizeof *saved, davar->stages,
                           memory_bytes(davar)};
}

DAVAR_RARE size_t davar_state_bytes(const davar_t *davar)
{
    return davar_image_bytes(sizeof(saved_t), memory_bytes(davar));
}

DAVAR_RARE davar_status_t davar_state_restore(davar_t *davar, const davar_storage_t *storage)
{
    saved_t saved = {0};
    const davar_image_t image = image_of(davar, &saved);
    const davar_status_t status = davar_image_restore(&image, storage);
    if (status != DAVAR_OK) {
        davar_reset(davar);
        return status;
    }
    davar->window = saved.window;
    davar->health = saved.health;
    davar->produced = saved.produced;
    davar->seen = saved.seen;
    davar->ready = saved.ready;
    davar->in_gap = saved.in_gap;
    davar->unstable = saved.unstable;
    davar->alarms_seen = saved.alarms_seen;
    if (is_wide(davar)) {
        davar_q31_resume(davar);
    } else {
        davar_q15_resume(davar);
    }
    davar->gaps.count = saved.gaps;
    return DAVAR_OK;
}

DAVAR_RARE davar_status_t davar_state_save(const davar_t *davar, const davar_storage_t *storage)
{
    saved_t saved;
    memset(&saved, 0, sizeof saved); /* its padding is saved too */
    saved.window = davar->window;
    saved.health = davar->health;
    saved.produced = davar->produced;
    saved.seen = davar->seen;
    saved.gaps = davar->gaps.count;
    saved.ready = davar->ready;
    saved.in_gap = davar->in_gap;
    saved.unstable = davar->unstable;
    saved.alarms_seen = davar->alarms_seen;
    const davar_image_t image = image_of(davar, &saved);
    return davar_image_save(&image, storage);
}
