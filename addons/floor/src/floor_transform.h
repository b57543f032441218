/* davar - floor: the power of 64 differences at 31 frequencies. */
#ifndef DAVAR_FLOOR_TRANSFORM_H
#define DAVAR_FLOOR_TRANSFORM_H

#include "number/strict.h"

#include <stddef.h>
#include <stdint.h>

#define FLOOR_SEGMENT 64U
#define FLOOR_HOP (FLOOR_SEGMENT / 2U)
#define FLOOR_ENERGY 24.0F /* of the window: sum of its squares */

/* sin(2 pi k / 64), k = 0 to 52 */
extern const float davar_floor_sine[53];

static inline float floor_cosine(size_t k) /* 0 to 36 */
{
    return davar_floor_sine[k + 16U];
}

/* Twice the Hann window's transform, squared: power[k - 1] of k = 1 to 31, four times that of the
 * samples times the window. ring: the oldest sample is at `oldest`, 0 or FLOOR_HOP. */
void davar_floor_transform(const float ring[FLOOR_SEGMENT], size_t oldest, float power[31]);

#endif
