/* davar - the front door: checks, then hands over to the pipeline of the number type. The story of a sample is told in
 * pipeline.h. Hazard: davar_take reads while a push may interrupt it (sequence.h). */
#include "davar/davar.h"

#include "common/choice.h"
#include "common/sequence.h"
#include "config.h"
#include "number/machine.h"
#include "pipeline/door.h"
#include "pipeline/pipelines.h"

#include <string.h>

/* --- init -------------------------------------------------------------------------------------------------------- */

DAVAR_RARE static davar_status_t check(const davar_t *davar, const davar_config_t *config, const void *memory,
                                       const davar_number_t *number, bool is_float)
{
    const bool built = (DAVAR_Q31 || !number->wide) && (DAVAR_Q15 || number->wide);
    if ((davar == NULL) || (memory == NULL)) {
        return DAVAR_ERR_NULL;
    }
    return built ? davar_config_check(config, number, is_float) : DAVAR_ERR_BUILD;
}

DAVAR_RARE static davar_status_t check_memory(const void *memory, size_t bytes, size_t needed)
{
    if (bytes < needed) {
        return DAVAR_ERR_MEMORY_SIZE;
    }
    return (((uintptr_t)memory % 8U) != 0U) ? DAVAR_ERR_MEMORY_ALIGN : DAVAR_OK;
}

DAVAR_RARE static void place(davar_t *davar, const davar_config_t *config, const davar_number_t *number)
{
    memset(davar, 0, sizeof *davar);
    davar->config = config;
    davar->number = number;
}

DAVAR_RARE static davar_status_t init_wide(davar_t *davar, const davar_config_t *config, void *memory, size_t bytes,
                                           bool is_float)
{
    davar_status_t status = check(davar, config, memory, &davar_number_q31, is_float);
    if (status == DAVAR_OK) {
        status = check_memory(memory, bytes, davar_q31_memory_size(config));
    }
    if (status == DAVAR_OK) {
        place(davar, config, &davar_number_q31);
        davar->is_float = is_float;
        davar->counts_per_unit = is_float ? (float)(1.0 / door_quantum(config->full_scale)) : 0.0F;
        davar_q31_start(davar, memory);
    }
    return status;
}

size_t davar_memory_size_q15(const davar_config_t *config)
{
    const bool good = DAVAR_Q15 && (davar_config_check(config, &davar_number_q15, false) == DAVAR_OK);
    return good ? davar_q15_memory_size(config) : 0U;
}

size_t davar_memory_size_q31(const davar_config_t *config)
{
    const bool good = DAVAR_Q31 && (davar_config_check(config, &davar_number_q31, false) == DAVAR_OK);
    return good ? davar_q31_memory_size(config) : 0U;
}

size_t davar_memory_size_f32(const davar_config_t *config)
{
    const bool good = DAVAR_Q31 && (davar_config_check(config, &davar_number_q31, true) == DAVAR_OK);
    return good ? davar_q31_memory_size(config) : 0U;
}

davar_status_t davar_init_q15(davar_t *davar, const davar_config_t *config, void *memory, size_t bytes)
{
    davar_status_t status = check(davar, config, memory, &davar_number_q15, false);
    if (status == DAVAR_OK) {
        status = check_memory(memory, bytes, davar_q15_memory_size(config));
    }
    if (status == DAVAR_OK) {
        place(davar, config, &davar_number_q15);
        davar_q15_start(davar, memory);
    }
    return status;
}

davar_status_t davar_init_q31(davar_t *davar, const davar_config_t *config, void *memory, size_t bytes)
{
    return init_wide(davar, config, memory, bytes, false);
}

davar_status_t davar_init_f32(davar_t *davar, const davar_config_t *config, void *memory, size_t bytes)
{
    return init_wide(davar, config, memory, bytes, true);
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

/* --- samples in -------------------------------------------------------------------------------------------------- */

DAVAR_RARE static void gap(davar_t *davar, uint32_t missing)
{
    davar_count_missing(davar, missing);
    davar_count(&davar->health.gaps);
    if (is_wide(davar)) {
        davar_q31_gap(davar);
    } else {
        davar_q15_gap(davar);
    }
}

/* NaN and inf are left out; a run of them is one gap. */
static void float_missing(davar_t *davar)
{
    davar_count(&davar->health.not_finite);
    if (davar->in_gap) {
        davar_count(&davar->health.missing);
    } else {
        gap(davar, 1U);
    }
    davar->in_gap = true;
}

/* Floats that go in together, so that a grid has more than one at a time. */
#define FLOATS 32U

/* Of `count` samples those that can go in together: none is behind the next epoch. */
static size_t together(const davar_window_t *window, size_t count)
{
    const uint32_t wait = (window->skip > 0U) ? window->skip : window->wait;
    const uint32_t room = (count < FLOATS) ? (uint32_t)count : FLOATS;
    return (wait > room) ? room : wait;
}

/* Samples from the first that are finite, `most` at most, as counts; returns how many. */
static size_t float_run(davar_t *davar, const float *rates, size_t most, int32_t *counts)
{
    size_t run = 0U;
    while ((run < most) && door_admits(rates[run])) {
        counts[run] = door_counts(davar, rates[run]);
        run++;
    }
    return run;
}

/* Takes samples that go in together, or leaves one out. */
static size_t float_step(davar_t *davar, const float *rates, size_t count)
{
    int32_t counts[FLOATS];
    const size_t most = has_tracker(davar->config) ? 1U : together(&davar->window, count);
    const size_t run = float_run(davar, rates, most, counts);
    if (run == 0U) {
        float_missing(davar);
        return 1U;
    }
    davar->in_gap = false;
    return davar_q31_push(davar, counts, run);
}

size_t davar_push_until_result_f32(davar_t *davar, const float *rates, size_t count)
{
    if (!davar_accepts(davar, ACCEPTS_F32, count)) {
        return count;
    }
    davar_change_begin(davar);
    const uint32_t produced = davar->produced;
    size_t taken = 0U;
    while ((taken < count) && (davar->produced == produced)) {
        const size_t n = float_step(davar, &rates[taken], count - taken);
        DAVAR_ASSERT((n > 0U) && (n <= (count - taken)));
        taken += n;
    }
    davar_change_end(davar);
    return taken;
}

void davar_push_f32(davar_t *davar, const float *rates, size_t count)
{
    if (davar_accepts(davar, ACCEPTS_F32, count)) {
        davar_change_begin(davar);
        for (size_t taken = 0U; taken < count;) {
            const size_t n = float_step(davar, &rates[taken], count - taken);
            DAVAR_ASSERT((n > 0U) && (n <= (count - taken)));
            taken += n;
        }
        davar_change_end(davar);
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
    gap(davar, missing);
    davar_change_end(davar);
}

/* --- results out ------------------------------------------------------------------------------------------------- */

bool davar_take(davar_t *davar, davar_result_t *result)
{
    return davar->number->collect(davar, result);
}

DAVAR_RARE bool davar_flush(davar_t *davar)
{
    const davar_config_t *const config = davar->config;
    const bool kept = !has_grid(config) || config->mirrored_end;
    const davar_window_t *const window = &davar->window; /* `received` wraps long after `at_start` has become false */
    const bool begun = window->finished || !window->at_start || (window->received >= (config->window_max / 2U));
    if (!has_tracker(config) && (!is_centred(config) || !kept || !begun)) {
        return false;
    }
    return is_wide(davar) ? davar_q31_flush(davar) : davar_q15_flush(davar);
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
