/* davar - the scan: of all splits of a stretch at recorded places, the one that most exceeds a threshold. */
#ifndef DAVAR_SRC_SCAN_H
#define DAVAR_SRC_SCAN_H

#include "track/glr.h"

/* The best split of one threshold. */
typedef struct {
    uint32_t threshold; /* h, 16 digits */
    int32_t excess;     /* of the gain over the threshold at the split's n; GAIN_DIGITS */
    int32_t gain;
    uint32_t age; /* of the split, blocks; 0: none exceeds */
    uint32_t level;
} davar_split_t;

/* Scans from `begin` to now; the lower threshold first. Where splits exceed alike, the newest. */
void davar_glr_scan(const davar_glr_t *state, const davar_glr_config_t *config, const davar_glr_place_t *begin,
                    davar_split_t *split, uint32_t count);

/* The recorded sum at a place that 2^level divides. */
static inline const davar_spread_t *glr_record(const davar_glr_t *state, uint32_t level, uint32_t at)
{
    return &state->record[level][(at >> level) % GLR_RECORDS];
}

static inline void glr_move_to_record(const davar_glr_t *state, davar_glr_place_t *place, uint32_t level, uint32_t at)
{
    place->at = at;
    spread_copy(&place->sum, glr_record(state, level, at));
}

/* Blocks from there to now. */
static inline uint32_t glr_age(const davar_glr_t *state, const davar_glr_place_t *place)
{
    return state->now.at - place->at;
}

#endif
