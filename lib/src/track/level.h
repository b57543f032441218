/* davar - the level of a stretch: the root of its mean square, in samples' counts. */
#ifndef DAVAR_SRC_LEVEL_H
#define DAVAR_SRC_LEVEL_H

#include "track/spread.h"

/* Root of (sum - blocks * floor) / (blocks * unit), to 32 bits; floor is what rounding adds to each block. At least one block. */
double davar_level(const davar_spread_t *sum, uint32_t floor, uint32_t unit);

#endif
