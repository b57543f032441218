/* davar - stage [4]: the window law of [SONG18] section 4, pure functions (4.1), (4.2). */
#ifndef DAVAR_SRC_LAW_H
#define DAVAR_SRC_LAW_H

#include "common/choice.h"

static inline uint32_t law_shorter(const davar_config_t *config, uint32_t length)
{
    const uint32_t step = config->shrink * config->stride;
    return (length > (config->window_min + step)) ? (length - step) : config->window_min;
}

static inline uint32_t law_longer(const davar_config_t *config, uint32_t length, bool filling)
{
    /* Trailing: the head moves by one per sample, so growing faster would move the tail backwards. */
    const bool trailing = !is_centred(config);
    const uint32_t most = trailing ? 1U : 2U;
    const uint32_t grow = (filling || (config->grow > most)) ? most : config->grow;
    const uint32_t step = grow * config->stride;
    return ((length + step) < config->window_max) ? (length + step) : config->window_max;
}

/* Length of the next window after one of `length` samples whose flag is `unstable` (4.1). On a grid the window moves
 * `stride` times as far at once. O(1), no division. */
static inline uint32_t davar_law_next(const davar_config_t *config, uint32_t length, bool unstable, bool filling)
{
    return unstable ? law_shorter(config, length) : law_longer(config, length, filling);
}

/* Samples behind the leading edge of a window of `length` samples when its epoch completes (4.2): centred, the newest
 * sample is half of window_max ahead of the epoch, the edge half of the window. */
static inline uint32_t davar_law_lag(const davar_config_t *config, uint32_t length)
{
    return is_centred(config) ? ((config->window_max - length) >> 1U) : 0U;
}

#endif
