/* davar - the window law of [SONG18] section 4, DESIGN (4.1) and (4.2). */
#include "law.h"

static uint32_t shorter(const davar_config_t *config, uint32_t length)
{
    const uint32_t step = config->shrink * config->stride;
    return (length > (config->window_min + step)) ? (length - step) : config->window_min;
}

static uint32_t longer(const davar_config_t *config, uint32_t length, bool filling)
{
    /* Trailing: the head moves by one per sample, so growing faster would move the tail backwards. */
    const bool trailing = (config->mode == DAVAR_MODE_TRAILING);
    const uint32_t most = trailing ? 1U : 2U;
    const bool free_growth = filling || (config->policy == DAVAR_POLICY_FIXED);
    const uint32_t grow = (free_growth || (config->grow > most)) ? most : config->grow;
    const uint32_t step = grow * config->stride;
    return ((length + step) < config->window_max) ? (length + step) : config->window_max;
}

uint32_t davar_law_next(const davar_config_t *config, uint32_t length, bool unstable, bool filling)
{
    if (unstable && (config->policy != DAVAR_POLICY_FIXED)) {
        return shorter(config, length);
    }
    return longer(config, length, filling);
}

uint32_t davar_law_latency(const davar_config_t *config)
{
    return (config->mode == DAVAR_MODE_CENTRED) ? (config->window_max >> 1U) : 0U;
}

void davar_law_place(const davar_config_t *config, davar_window_t *window, uint32_t length)
{
    const uint32_t epoch = window->due - davar_law_latency(config);
    window->head = epoch + ((config->mode == DAVAR_MODE_CENTRED) ? (length >> 1U) : 0U);
    window->tail = window->head - length;
}
