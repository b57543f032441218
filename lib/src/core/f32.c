/* davar - float samples are quantised once, by a power of two (2.3).
 * After that they are exact integers. */
#include "davar/davar.h"

#include "core/instance.h"
#include "core/window.h"
#include "number/quantum.h"

davar_status_t davar_init_f32(davar_t *davar, const davar_config_t *config, void *memory,
                              size_t bytes)
{
    const davar_status_t status = davar_init_wide(davar, config, memory, bytes, true);
    if (status == DAVAR_OK) {
        davar->counts_per_unit = davar_counts_per_unit(config->full_scale);
    }
    return status;
}

/* Floats that are pushed together, so that a grid takes more than one at a time. */
#define FLOATS 32U

/* How many of `count` samples can be pushed together: none is after the next epoch. */
static size_t together(const davar_window_t *window, size_t count)
{
    const uint32_t wait = (window->skip > 0U) ? window->skip : window->wait;
    const uint32_t room = (count < FLOATS) ? (uint32_t)count : FLOATS;
    return (wait > room) ? room : wait;
}

/* Pushes the finite samples at the front of `rates`, or drops a NaN or inf; returns how many. A run
 * of dropped samples is one gap. */
static size_t float_step(davar_t *davar, const float *rates, size_t count)
{
    int32_t counts[FLOATS];
    const size_t most = has_queue(davar->config) ? 1U : together(&davar->window, count);
    const float limit = (float)davar->config->full_scale;
    size_t run = 0U;
    while ((run < most) && davar_is_finite(rates[run])) {
        counts[run] = davar_float_to_counts(rates[run], limit, davar->counts_per_unit,
                                            &davar->health.saturated);
        run++;
    }
    if (run > 0U) {
        davar->in_gap = false;
        return davar_q31_push(davar, counts, run);
    }
    davar_count(&davar->health.not_finite);
    if (davar->in_gap) {
        davar_count(&davar->health.missing);
    } else {
        davar_gap_now(davar, 1U);
    }
    davar->in_gap = true;
    return 1U;
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
