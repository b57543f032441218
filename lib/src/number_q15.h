/* davar - the number type of int16 counts: 32-bit differences, 64-bit sums of squares, 128-bit moments.
 * One of the two headers that give the pipeline its types; see DESIGN 2.1 for the widths. */
#ifndef DAVAR_SRC_NUMBER_H
#define DAVAR_SRC_NUMBER_H

#include "davar/types.h"
#include "machine.h"

#define NUMBER(name) davar_q15_##name
#define NUMBER_SAMPLE_BITS_DEFAULT 16U
#define NUMBER_SAMPLE_BITS_MAX 16U
#define NUMBER_MOMENT_BITS 16U
#define NUMBER_SUM_BITS 64U
#define NUMBER_WINDOW_MAX 65536U
#define WIDE_LIMBS 2U

typedef int16_t sample_t;
typedef int32_t difference_t;
typedef uint64_t sum_t;

/* Sums of x^k over a window, or running since the start modulo their width. */
typedef struct {
    int64_t first;
    uint64_t second;
    int64_t third;
    davar_u128_t fourth;
} powers_t;

static inline void sum_add_square(sum_t *sum, difference_t difference)
{
    *sum += (uint64_t)((int64_t)difference * difference);
}

static inline void sum_subtract_square(sum_t *sum, difference_t difference)
{
    *sum -= (uint64_t)((int64_t)difference * difference);
}

/* head^2 - tail^2 as one product; neither factor can leave 32 bits, since window_max m^2 < 2^32 (2.4). */
static inline void sum_slide(sum_t *sum, difference_t head, difference_t tail)
{
    *sum += (uint64_t)((int64_t)(head - tail) * (head + tail));
}

static inline sum_t sum_between(sum_t later, sum_t earlier)
{
    return later - earlier;
}

static inline sum_t sum_negated(sum_t sum)
{
    return 0U - sum;
}

static inline double sum_to_double(sum_t sum)
{
    return (double)sum;
}

static inline powers_t powers_of(sample_t sample, unsigned shift)
{
    const int64_t value = sample;
    const int64_t square = value * value;
    const powers_t powers = {value, (uint64_t)square, value * square, {(uint64_t)(square * square), 0U}};
    (void)shift;
    return powers;
}

static inline void powers_add(powers_t *sums, const powers_t *powers)
{
    sums->first += powers->first;
    sums->second += powers->second;
    sums->third = (int64_t)((uint64_t)sums->third + (uint64_t)powers->third);
    davar_u128_add(&sums->fourth, powers->fourth);
}

static inline void powers_subtract(powers_t *sums, const powers_t *powers)
{
    sums->first -= powers->first;
    sums->second -= powers->second;
    sums->third = (int64_t)((uint64_t)sums->third - (uint64_t)powers->third);
    davar_u128_subtract(&sums->fourth, powers->fourth);
}

#define POWERS_THIRD_WIDE(powers) wide_from_i64((powers)->third)

#endif
