/* davar - where kurtosis and contribution are in 32 bits: it decides nearly every case at a
 * fraction of the cost (3.5). */
#ifndef DAVAR_SRC_SONG_H
#define DAVAR_SRC_SONG_H

#include "number/moments.h"

typedef enum { ROUGH_INSIDE = 0, ROUGH_OUTSIDE, ROUGH_UNSURE } davar_place_t;

/* The bounds, cut to 28 digits for K and 32 for S; UINT32_MAX if too large. */
typedef struct {
    uint32_t low;
    uint32_t high;
} davar_range_t;

typedef struct {
    davar_range_t kurtosis;
    davar_range_t contribution;
} davar_song_bounds_t;

void davar_song_bounds(davar_song_bounds_t *bounds, const davar_config_t *config);

#define DAVAR_ROUGH_ERROR 16U /* two compared values are wrong by less */

/* Where value / of is between two bounds with as many digits as the value has. */
static inline davar_place_t davar_rough_place(uint32_t value, uint32_t of,
                                              const davar_range_t *range)
{
    const uint32_t least = davar_upper_product(range->low, of);
    const uint32_t most = davar_upper_product(range->high, of);
    if (value > most) {
        return (((value - most) > DAVAR_ROUGH_ERROR) && (range->high != UINT32_MAX)) ? ROUGH_OUTSIDE
                                                                                     : ROUGH_UNSURE;
    }
    if (value < least) {
        return ((least - value) > DAVAR_ROUGH_ERROR) ? ROUGH_OUTSIDE : ROUGH_UNSURE;
    }
    const bool inside =
        ((most - value) > DAVAR_ROUGH_ERROR) && ((value - least) > DAVAR_ROUGH_ERROR);
    return inside ? ROUGH_INSIDE : ROUGH_UNSURE;
}

/* Where K and S are, from the kurtosis of the whole window and of its first part. Unsure: within
 * 2^-18 of a bound, or above what 32 bits hold. S needs a K that is not unsure. */
static inline davar_place_t davar_rough_kurtosis(const davar_song_bounds_t *bounds,
                                                 const davar_rough_t *whole)
{
    if (whole->under == 0U) {
        return (whole->over == 0U) ? ROUGH_INSIDE : ROUGH_UNSURE;
    }
    return davar_rough_place(whole->over, whole->under, &bounds->kurtosis);
}

/* S = |x - y| / x (3.2) */
static inline davar_place_t davar_rough_contribution(const davar_song_bounds_t *bounds,
                                                     const davar_rough_t *whole,
                                                     const davar_rough_t *first)
{
    if (first->under == 0U) {
        return (first->over == 0U) ? ROUGH_INSIDE : ROUGH_UNSURE;
    }
    if ((whole->over == UINT32_MAX) || (first->over == UINT32_MAX)) {
        return ROUGH_UNSURE;
    }
    const uint32_t x = davar_upper_product(whole->over, first->under);
    const uint32_t y = davar_upper_product(first->over, whole->under);
    return davar_rough_place((x > y) ? (x - y) : (y - x), x, &bounds->contribution);
}

#endif
