/* davar - cluster sizes: octaves and the log-spaced series. */
#ifndef DAVAR_TAUS_H
#define DAVAR_TAUS_H

#include "davar/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Octaves 1, 2, 4 ... while 9 m <= window: the 25 % rule of [FAST] (1.3). At least m = 1 when window >= 2.
 * Writes at most `capacity` sizes to taus, returns how many were written (0: window < 2). O(capacity). */
uint8_t davar_taus_octave(uint32_t window, uint32_t *taus, uint8_t capacity);

/* Geometric series of at most `wanted` sizes from 1 to window / 9, rounded, distinct: the "relevant times" of [FAST]
 * with its 25 % rule (1.4). Writes at most `capacity` sizes, returns how many. O(capacity). */
uint8_t davar_taus_geometric(uint32_t window, uint8_t wanted, uint32_t *taus, uint8_t capacity);

#ifdef __cplusplus
}
#endif

#endif
