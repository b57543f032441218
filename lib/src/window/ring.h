/* davar - stage [1]: samples in caller memory, looked back at by age. The first `repeated` of them stand behind the last once
 * more, so that whatever is near an edge follows it in memory, in both directions (2.10).
 *
 *      oldest ............. newest   repeated
 *   [  3  4  5 | 6  7  .  .  1  2  ][  3  4  5 ]      next = index of the slot that the next sample takes
 *              ^ next
 */
#ifndef DAVAR_SRC_RING_H
#define DAVAR_SRC_RING_H

typedef struct {
    sample_t *sample; /* capacity + repeated of them */
    uint32_t capacity;
    uint32_t next;
    uint32_t reach;    /* how far back from an edge anything looks: the longest span */
    uint32_t repeated; /* at least the reach, and at most the capacity */
} ring_t;

static inline uint32_t smaller(uint32_t a, uint32_t b)
{
    return (a < b) ? a : b;
}

/* Index of the sample that is `age` samples old; 1 is the newest, capacity the oldest. */
static inline uint32_t ring_index(const ring_t *ring, uint32_t age)
{
    return ring->next + ((ring->next < age) ? ring->capacity : 0U) - age;
}

/* Samples that go in one behind the other from `next` on, and again at the place that ring_again tells. */
static inline uint32_t ring_stretch(const ring_t *ring)
{
    return ((ring->next < ring->repeated) ? ring->repeated : ring->capacity) - ring->next;
}

/* How far behind its own place a sample stands once more; 0 where it does not. */
static inline uint32_t ring_again(const ring_t *ring)
{
    return (ring->next < ring->repeated) ? ring->capacity : 0U;
}

static inline void ring_advance(ring_t *ring, uint32_t count)
{
    const uint32_t end = ring->next + count;
    ring->next = (end == ring->capacity) ? 0U : end;
}

static inline void ring_set(ring_t *ring, uint32_t index, sample_t sample)
{
    ring->sample[index] = sample;
    if (index < ring->repeated) {
        ring->sample[ring->capacity + index] = sample;
    }
}

static inline void ring_put(ring_t *ring, sample_t sample)
{
    ring_set(ring, ring->next, sample);
    ring_advance(ring, 1U);
}

/* The sample of that age, where as many as the reach lie in front of it in memory, for a leading edge. */
static inline const sample_t *ring_leading(const ring_t *ring, uint32_t age)
{
    return ring->sample + ring->next + ((ring->next < (age + ring->reach)) ? ring->capacity : 0U) - age;
}

/* ... where as many follow it, for a trailing one. */
static inline const sample_t *ring_trailing(const ring_t *ring, uint32_t age)
{
    return ring->sample + ring_index(ring, age);
}

#endif
