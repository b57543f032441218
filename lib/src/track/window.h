/* davar - which window follows from the cuts: as long as the likelihood ratio finds one variance in it. */
#ifndef DAVAR_SRC_TRACKED_WINDOW_H
#define DAVAR_SRC_TRACKED_WINDOW_H

#include "track/glr.h"

/* Blocks [begin, end), modulo 2^32, as davar_glr_place_t counts them. */
typedef struct {
    uint32_t begin;
    uint32_t end;
    uint32_t blocks; /* of them that were accepted */
    uint32_t after;  /* accepted behind the end */
} davar_glr_window_t;

/* The window that ends with the newest accepted block. At most ten tests, six with 600 blocks; nearly always no logarithm. */
void davar_glr_trailing(const davar_glr_t *state, const davar_glr_config_t *config, davar_glr_window_t *window);

/* The window about the place `age` blocks before that. False, and the blocks there are, while none was there. O(GLR_RECENT). */
bool davar_glr_centred(const davar_glr_t *state, const davar_glr_config_t *config, uint32_t age,
                       davar_glr_window_t *window);

/* How many blocks ago so many accepted ones began, GLR_RECENT at most. */
uint32_t davar_glr_age_of(const davar_glr_t *state, uint32_t accepted);

/* For glr.c: no cut but the beginning; the next block, before now counts it; after each block, is there a new cut, and the turn
 * of one cut to be judged. */
void davar_glr_forget(davar_glr_t *state);
void davar_glr_remember(davar_glr_t *state, const davar_spread_t *block);
void davar_glr_note(davar_glr_t *state, const davar_glr_config_t *config, bool is_cut);

#endif
