/* davar - which window follows from the cuts: as long as the likelihood ratio finds one variance in it. */
#ifndef DAVAR_SRC_TRACKED_WINDOW_H
#define DAVAR_SRC_TRACKED_WINDOW_H

#include "track/glr.h"

/* Blocks [begin, end), modulo 2^32, as davar_glr_place_t counts them. */
typedef struct {
    uint32_t begin;
    uint32_t end;
    uint32_t blocks; /* of them that were accepted */
} davar_glr_window_t;

/* The window that ends with the newest accepted block. At most ten tests, six with 600 blocks; nearly always no logarithm. */
void davar_glr_trailing(const davar_glr_t *state, const davar_glr_config_t *config, davar_glr_window_t *window);

/* The window about the block `half` before that. False, and the blocks there are, while none was there. */
bool davar_glr_centred(const davar_glr_t *state, const davar_glr_config_t *config, davar_glr_window_t *window);

/* For glr.c: no cut but the beginning; the next block, before now counts it; after each block, is there a new cut, and the turn
 * of one cut to be judged. */
void davar_glr_forget(davar_glr_t *state);
void davar_glr_remember(davar_glr_t *state, const davar_spread_t *block);
void davar_glr_note(davar_glr_t *state, const davar_glr_config_t *config, bool is_cut);

#endif
