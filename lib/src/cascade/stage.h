/* davar - the memory of a cascade (11.7): what a stage remembers, and where. */
#ifndef DAVAR_SRC_STAGE_H
#define DAVAR_SRC_STAGE_H

#include "davar/cascade.h"
#include "number/compact.h"

#define CASCADE_OVERLAP 4U                 /* Q: hops in the shortest cluster of a stage */
#define CASCADE_TAUS 2U                    /* cluster sizes of a stage */
#define CASCADE_RATIO (1U << CASCADE_TAUS) /* R: hops of a stage in a hop of the next */
#define CASCADE_HOPS 16U                   /* that a stage remembers */
_Static_assert(CASCADE_HOPS == (CASCADE_RATIO * CASCADE_OVERLAP), "the longest span");

typedef struct {
    uint64_t pending; /* running sum at the hop that is served */
    uint32_t age;     /* of that hop: hops of this stage since the newest gap */
    uint32_t hop;     /* its number modulo 2^32 */
    uint32_t size;    /* the cluster size that it is served to next */
    uint32_t turn;    /* of the hop at that size: 0, 1 begin a generation, then the last one */
    /* Differences of each cluster size, in two generations (11.5). */
    uint16_t count[2U * CASCADE_TAUS];
    davar_u128_t squares[2U * CASCADE_TAUS];
    /* In the same generations: sum of the power of the samples, and of its squares (11.9). */
    compact_t power[2U * CASCADE_TAUS];
    compact_t power_squares[2U * CASCADE_TAUS];
    uint32_t low[CASCADE_HOPS]; /* lower bits of the running sums at the last hops, by number */
} cascade_stage_t;

static inline cascade_stage_t *cascade_stage_of(const davar_cascade_t *cascade, uint32_t tau)
{
    return &((cascade_stage_t *)cascade->stages)[tau / CASCADE_TAUS];
}

static inline uint32_t cascade_sizes(const davar_cascade_t *cascade)
{
    return CASCADE_TAUS * (uint32_t)cascade->stage_count;
}

/* log2 of the hops of a generation of a cluster size (11.5). */
static inline uint32_t cascade_generation_bits(const davar_cascade_t *cascade, uint32_t tau)
{
    return 2U + (tau % CASCADE_TAUS) + cascade->shift;
}

/* The newest hop of a cluster size whose generation has begun. */
static inline uint32_t cascade_newest_hop(const davar_cascade_t *cascade, uint32_t tau)
{
    const cascade_stage_t *const stage = cascade_stage_of(cascade, tau);
    const bool ready = ((cascade->ready >> (tau / CASCADE_TAUS)) & 1U) != 0U;
    const uint32_t size = tau % CASCADE_TAUS;
    const bool waits =
        ready && ((stage->size < size) || ((stage->size == size) && (stage->turn < 2U)));
    return stage->hop - (waits ? 1U : 0U);
}

/* The number of the present generation of a cluster size. */
static inline uint32_t cascade_generation(const davar_cascade_t *cascade, uint32_t tau)
{
    return (cascade_newest_hop(cascade, tau) - 1U) >> cascade_generation_bits(cascade, tau);
}

/* Its place in the arrays of a stage. */
static inline uint32_t cascade_present(const davar_cascade_t *cascade, uint32_t tau)
{
    return (2U * (tau % CASCADE_TAUS)) + (cascade_generation(cascade, tau) & 1U);
}

#endif
