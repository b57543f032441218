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

#define CASCADE_CLUSTER 8U /* hops whose power is summed: the longer cluster size of a stage */
_Static_assert(CASCADE_CLUSTER == (CASCADE_OVERLAP << (CASCADE_TAUS - 1U)), "the longer size");

/* Work on a hop, a turn per sample. Only the first hop after a cluster has the turns before
 * SERVE. */
enum {
    CASCADE_END = 0,                             /* stage 0: the power of the cluster */
    CASCADE_COUNT,                               /* it is added to each cluster size */
    CASCADE_PASS = CASCADE_COUNT + CASCADE_TAUS, /* and to the next stage */
    CASCADE_SERVE,                               /* a difference of each cluster size */
    CASCADE_DONE = CASCADE_SERVE + CASCADE_TAUS
};

/* A positive number (compact.h). */
typedef uint32_t compact_t;

typedef struct {
    uint64_t pending; /* running sum at the hop that is served */
    uint32_t age;     /* of that hop: hops of this stage since the newest gap */
    uint32_t hop;     /* its number modulo 2^32 */
    uint32_t turn;    /* of that hop, next */
    /* Power of the noise (11.9): of the present cluster; then, for each cluster size and
     * generation, the sum over its clusters and the sum of their squares. */
    compact_t cluster;
    compact_t power[2U * CASCADE_TAUS];
    compact_t power_squares[2U * CASCADE_TAUS];
    /* Differences of each cluster size, in two generations (11.5). */
    uint16_t count[2U * CASCADE_TAUS];
    davar_u128_t squares[2U * CASCADE_TAUS];
    uint32_t low[CASCADE_HOPS]; /* lower bits of the running sums at the last hops, by number */
} cascade_stage_t;

/* Has stage k a hop with turns before SERVE? */
static inline bool cascade_waits(const davar_cascade_t *cascade, uint32_t k)
{
    const cascade_stage_t *const stage = &((const cascade_stage_t *)cascade->stages)[k];
    return (((cascade->ready >> k) & 1U) != 0U) && (stage->turn < (uint32_t)CASCADE_SERVE);
}

/* Hops of stage k before the newest one that is past those turns. Clusters and generations end with
 * the hops whose numbers are multiples of their lengths. */
static inline uint32_t cascade_earlier(const davar_cascade_t *cascade, uint32_t k)
{
    const cascade_stage_t *const stage = &((const cascade_stage_t *)cascade->stages)[k];
    return stage->hop - (cascade_waits(cascade, k) ? 2U : 1U);
}

/* Squares of the shortest size since its newest cluster ended. */
static inline davar_u128_t cascade_unseen(const davar_cascade_t *cascade,
                                          const davar_u128_t *squares)
{
    return davar_u128_subtract(*squares, (davar_u128_t){cascade->seen[0], cascade->seen[1]});
}

/* Index, in the arrays of a stage, of the generation of a size that contains the hop after
 * `earlier`. */
static inline uint32_t cascade_slot(const davar_cascade_t *cascade, uint32_t size, uint32_t earlier)
{
    const uint32_t generation = (CASCADE_OVERLAP << size) << cascade->shift;
    return (2U * size) + (((earlier & generation) != 0U) ? 1U : 0U);
}

#endif
