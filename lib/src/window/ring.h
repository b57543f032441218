/* davar - stage [1]: samples in caller memory, looked back at by age.
 *
 *      oldest ............. newest
 *   [  3  4  5 | 6  7  .  .  1  2  ]      next = index of the slot that the next sample takes
 *              ^ next
 */
#ifndef DAVAR_SRC_RING_H
#define DAVAR_SRC_RING_H

typedef struct {
    sample_t *sample;
    uint32_t capacity;
    uint32_t next;
} ring_t;

static inline uint32_t ring_before(const ring_t *ring, uint32_t index, uint32_t lag)
{
    return (index >= lag) ? (index - lag) : (index + ring->capacity - lag);
}

static inline uint32_t ring_behind(const ring_t *ring, uint32_t index, uint32_t lag)
{
    const uint32_t ahead = index + lag;
    return (ahead >= ring->capacity) ? (ahead - ring->capacity) : ahead;
}

static inline void ring_put(ring_t *ring, sample_t sample)
{
    ring->sample[ring->next] = sample;
    ring->next = ring_behind(ring, ring->next, 1U);
}

/* Index of the sample that is `age` samples old; 1 is the newest, capacity the oldest. */
static inline uint32_t ring_index(const ring_t *ring, uint32_t age)
{
    return ring_before(ring, ring->next, age);
}

static inline uint32_t smaller(uint32_t a, uint32_t b)
{
    return (a < b) ? a : b;
}

/* Samples that follow one another in memory from `index` on. */
static inline uint32_t ring_stretch(const ring_t *ring, uint32_t index)
{
    return ring->capacity - index;
}

#endif
