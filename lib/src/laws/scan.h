/* davar - one variance or two? The likelihood ratio of a section of the recording that is split
 * into an older and a newer part, and the scan for the best split. */
#ifndef DAVAR_SRC_SCAN_H
#define DAVAR_SRC_SCAN_H

#include "laws/glr.h"

/* The section that is split, with the quantities that all of its splits share. */
typedef struct {
    const davar_spread_t *from; /* running sums at its ends */
    const davar_spread_t *to;
    uint32_t blocks;
    int32_t exponent;  /* where the upper 32 bits of its sum begin */
    uint32_t begin;    /* the bits of `from` there */
    uint32_t sum;      /* the upper 21 bits of its sum */
    uint32_t weight;   /* f / nu times its sum */
    int32_t logarithm; /* of its mean block; INT32_MIN until needed */
    uint32_t degrees;  /* nu */
} davar_stretch_t;

/* The section has 1 to 1023 blocks, and its sum is not 0. `f` has GAIN_DIGITS. */
void davar_stretch(davar_stretch_t *stretch, const davar_spread_t *from, const davar_spread_t *to,
                   const davar_glr_config_t *config, uint32_t f);

/* A bound without a logarithm: false only if the gain of a split at this running sum cannot reach f
 * times `limit` (6 digits; f limit / nu below 2^10). */
bool davar_likelihood_may_reach(const davar_stretch_t *stretch, const davar_spread_t *split,
                                uint32_t limit);

/* G = nu/2 (N_t ln(S_t/N_t) - N_o ln(S_o/N_o) - N_n ln(S_n/N_n)). Both parts have a block, and no
 * sum is 0. */
int32_t davar_likelihood_gain(davar_stretch_t *stretch, const davar_spread_t *split);

/* The split at a recorded place that most exceeds one threshold. */
typedef struct {
    uint32_t threshold; /* h, 16 digits */
    int32_t excess;     /* of the gain over the threshold at the n of the split; GAIN_DIGITS */
    int32_t gain;
    uint32_t age; /* of the split, blocks; 0: no split exceeds the threshold */
    uint32_t level;
} davar_split_t;

/* Scans from `begin` to now, with the lower threshold first. Of equal splits the newest one
 * wins. */
void davar_glr_scan(const davar_glr_t *state, const davar_glr_config_t *config,
                    const davar_glr_place_t *begin, davar_split_t *split, uint32_t count);

/* The recorded sum at a place that 2^level divides. */
static inline const davar_spread_t *glr_record(const davar_glr_t *state, uint32_t level,
                                               uint32_t at)
{
    return &state->record[level][(at >> level) % GLR_RECORDS];
}

static inline void glr_move_to_record(const davar_glr_t *state, davar_glr_place_t *place,
                                      uint32_t level, uint32_t at)
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
