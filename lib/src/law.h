/* davar - stage [4]: the window law, a pure function. */
#ifndef DAVAR_SRC_LAW_H
#define DAVAR_SRC_LAW_H

#include "davar/instance.h"

/* Length of the next window after one of `length` samples whose flag is `unstable` (4.1). On a grid the window moves
 * `stride` times as far at once. O(1), no division. */
uint32_t davar_law_next(const davar_config_t *config, uint32_t length, bool unstable, bool filling);

/* Half of window_max in centred mode, 0 in trailing: how far the newest sample is ahead of the epoch. */
uint32_t davar_law_latency(const davar_config_t *config);

/* Moves the window to its next epoch: head and tail for a window of `length` samples (4.2). */
void davar_law_place(const davar_config_t *config, davar_window_t *window, uint32_t length);

#endif
