/* davar - cluster sizes of a result that come from a cascade: their differences are some samples
 * apart. */
#ifndef DAVAR_SRC_HOP_H
#define DAVAR_SRC_HOP_H

#include "davar/types.h"

/* Does a cascade give this cluster size? */
static inline bool davar_hops(const davar_adev_t *tau)
{
    return tau->hops > 0U;
}

/* Samples that the differences of such a size look back over (11.5). At least one difference. */
static inline double davar_hop_span(const davar_adev_t *tau)
{
    return (2.0 + (double)(tau->differences - 1U) / (double)tau->hops) * (double)tau->m;
}

#endif
