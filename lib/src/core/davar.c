/* davar - the public functions: checks, then a call of the number type's pipeline
 * (core/push.inc). Hazard: a push may interrupt davar_take (core/instance.h). */
#include "davar/davar.h"

#include "core/instance.h"
#include "core/window.h"
#include "number/machine.h"

#include <string.h>

/* --- init ------------------------------------------------------------------------------------- */

DAVAR_RARE static davar_status_t check(const davar_t *davar, const davar_config_t *config,
                                       const void *memory, const davar_number_t *number,
                                       bool is_float)
{
    if ((davar == NULL) || (memory == NULL)) {
        return DAVAR_ERR_NULL;
    }
    return davar_config_check(config, number, is_float);
}

DAVAR_RARE static davar_status_t check_memory(const void *memory, size_t bytes, size_t needed)
{
    if (bytes < needed) {
        return DAVAR_ERR_MEMORY_SIZE;
    }
    return (((uintptr_t)memory % 8U) != 0U) ? DAVAR_ERR_MEMORY_ALIGN : DAVAR_OK;
}

DAVAR_RARE static void place(davar_t *davar, const davar_config_t *config,
                             const davar_number_t *number)
{
    memset(davar, 0, sizeof *davar);
    davar->config = config;
    davar->number = number;
}

size_t davar_memory_size_q15(const davar_config_t *config)
{
    const bool good =
        DAVAR_Q15 && (davar_config_check(config, &davar_number_q15, false) == DAVAR_OK);
    return good ? davar_q15_memory_size(config) : 0U;
}

size_t davar_memory_size_q31(const davar_config_t *config)
{
    const bool good =
        DAVAR_Q31 && (davar_config_check(config, &davar_number_q31, false) == DAVAR_OK);
    return good ? davar_q31_memory_size(config) : 0U;
}

size_t davar_memory_size_f32(const davar_config_t *config)
{
    const bool good =
        DAVAR_Q31 && (davar_config_check(config, &davar_number_q31, true) == DAVAR_OK);
    return good ? davar_q31_memory_size(config) : 0U;
}

davar_status_t davar_init_q15(davar_t *davar, const davar_config_t *config, void *memory,
                              size_t bytes)
{
    davar_status_t status =
        DAVAR_Q15 ? check(davar, config, memory, &davar_number_q15, false) : DAVAR_ERR_BUILD;
    if (status == DAVAR_OK) {
        status = check_memory(memory, bytes, davar_q15_memory_size(config));
    }
    if (status == DAVAR_OK) {
        place(davar, config, &davar_number_q15);
        davar_q15_start(davar, memory);
    }
    return status;
}

DAVAR_RARE davar_status_t davar_init_wide(davar_t *davar, const davar_config_t *config,
                                          void *memory, size_t bytes, bool is_float)
{
    davar_status_t status =
        DAVAR_Q31 ? check(davar, config, memory, &davar_number_q31, is_float) : DAVAR_ERR_BUILD;
    if (status == DAVAR_OK) {
        status = check_memory(memory, bytes, davar_q31_memory_size(config));
    }
    if (status == DAVAR_OK) {
        place(davar, config, &davar_number_q31);
        davar->is_float = is_float;
        davar_q31_start(davar, memory);
    }
    return status;
}

davar_status_t davar_init_q31(davar_t *davar, const davar_config_t *config, void *memory,
                              size_t bytes)
{
    return davar_init_wide(davar, config, memory, bytes, false);
}

DAVAR_RARE void davar_reset(davar_t *davar)
{
    const davar_health_t quiet = {0};
    davar->health = quiet;
    davar->ready = false;
    davar->in_gap = false;
    davar->produced = 0U;
    davar->seen = 0U;
    davar->alarms_seen = 0U;
    if (is_wide(davar)) {
        davar_q31_start(davar, davar->stages);
    } else {
        davar_q15_start(davar, davar->stages);
    }
}

/* --- samples in ------------------------------------------------------------------------------- */

DAVAR_RARE void davar_gap_now(davar_t *davar, uint32_t missing)
{
    davar_count_missing(davar, missing);
    davar_count(&davar->health.gaps);
    if (has_queue(davar->config)) {
        davar->config->law->gap(davar, davar->law_state);
    } else if (is_wide(davar)) {
        davar_q31_gap(davar);
    } else {
        davar_q15_gap(davar);
    }
}

DAVAR_RARE void davar_gap(davar_t *davar, uint32_t missing)
{
    const bool ended = (davar->accepts == ACCEPTS_NONE);
    DAVAR_ASSERT(!ended);
    if (ended) {
        davar_count_missing(davar, missing);
        return;
    }
    davar_change_begin(davar);
    davar_gap_now(davar, missing);
    davar_change_end(davar);
}

/* --- results out ------------------------------------------------------------------------------ */

bool davar_take(davar_t *davar, davar_result_t *result)
{
    return davar->number->collect(davar, result);
}

DAVAR_RARE bool davar_flush(davar_t *davar)
{
    const davar_config_t *const config = davar->config;
    return has_queue(config) && config->law->flush(davar, davar->law_state);
}

davar_health_t davar_health(const davar_t *davar)
{
    davar_health_t health;
    uint32_t before;
    do {
        before = davar_read_begin(davar);
        health = davar->health;
        health.missed = davar_missed(davar, davar->produced, davar_result_waits(davar));
    } while (davar_read_torn(davar, before));
    return health;
}
