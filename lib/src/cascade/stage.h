/* davar - the memory of a cascade (11.7): what a stage remembers, and where. */
#ifndef DAVAR_SRC_STAGE_H
#define DAVAR_SRC_STAGE_H

#include "davar/cascade.h"
#include "number/machine.h"

#define CASCADE_OVERLAP 4U                 /* Q: hops in the shortest cluster of a stage */
#define CASCADE_TAUS 2U                    /* cluster sizes of a stage */
#define CASCADE_RATIO (1U << CASCADE_TAUS) /* R: hops of a stage in a hop of the next */
#define CASCADE_HOPS 16U                   /* that a stage remembers */
_Static_assert(CASCADE_HOPS == (CASCADE_RATIO * CASCADE_OVERLAP), "the longest span");

typedef struct {
    uint64_t pending; /* running sum at the hop that is served */
    uint32_t age;     /* of that hop: hops of this stage since the newest gap */
    uint32_t hop;     /* its number modulo 2^32 */
    uint32_t turn;    /* the cluster size that it is served to next */
    uint32_t unused;  /* so that every machine has the same size */
    /* Differences of each cluster size, in two generations (11.5). */
    uint16_t count[2U * CASCADE_TAUS];
    davar_u128_t squares[2U * CASCADE_TAUS];
    uint32_t low[CASCADE_HOPS]; /* lower bits of the running sums at the last hops, by number */
} cascade_stage_t;

#endif
