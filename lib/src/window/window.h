/* davar - positions of the window's edges, and what time it is. */
#ifndef DAVAR_SRC_WINDOW_H
#define DAVAR_SRC_WINDOW_H

#include "davar/instance.h"

/* One past the leading edge. */
static inline uint32_t window_head(const davar_window_t *window)
{
    return window->received - window->lag;
}

static inline uint32_t window_tail(const davar_window_t *window)
{
    return window->received - window->lag - window->length;
}

/* `count` samples more; the window stays where it is. */
static inline void window_receive(davar_window_t *window, uint32_t count)
{
    window->received += count;
    window->lag += count;
    if (window->received < count) {
        window->origin += UINT64_C(1) << 32U;
    }
}

/* One sample more, and the window moves on with it. */
static inline void window_glide(davar_window_t *window)
{
    window->received++;
    if (window->received == 0U) {
        window->origin += UINT64_C(1) << 32U;
    }
}

/* Samples since init. */
static inline uint64_t window_now(const davar_window_t *window)
{
    return window->origin + window->received;
}

#endif
