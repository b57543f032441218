/* davar - the number type of int32 counts (and of float samples after the door): 64-bit differences, 128-bit sums of
 * squares, 256-bit moments of the top 24 bits. See DESIGN 2.1 for the widths. */
#ifndef DAVAR_SRC_NUMBER_H
#define DAVAR_SRC_NUMBER_H

#include "davar/types.h"
#include "machine.h"

#define NUMBER(name) davar_q31_##name
#define NUMBER_SAMPLE_BITS_DEFAULT 24U
#define NUMBER_SAMPLE_BITS_MAX 32U
#define NUMBER_MOMENT_BITS 24U
#define NUMBER_SUM_BITS 128U
#define NUMBER_WINDOW_MAX 16777216U
#define WIDE_LIMBS 4U

typedef int32_t sample_t;
typedef int64_t difference_t;
typedef davar_u128_t sum_t;

/* Sums of x^k over a window, or running since the start modulo their width. */
typedef struct {
    int64_t first;
    uint64_t second;
    davar_u128_t third;
    davar_u128_t fourth;
} powers_t;

static inline void sum_add_square(sum_t *sum, difference_t difference)
{
    davar_u128_add(sum, davar_multiply_i64(difference, difference));
}

static inline void sum_subtract_square(sum_t *sum, difference_t difference)
{
    davar_u128_subtract(sum, davar_multiply_i64(difference, difference));
}

/* head^2 - tail^2 as one product. */
static inline void sum_slide(sum_t *sum, difference_t head, difference_t tail)
{
    davar_u128_add(sum, davar_multiply_i64(head - tail, head + tail));
}

static inline sum_t sum_between(sum_t later, sum_t earlier)
{
    davar_u128_subtract(&later, earlier);
    return later;
}

static inline sum_t sum_negated(sum_t sum)
{
    const sum_t zero = {0U, 0U};
    return sum_between(zero, sum);
}

static inline double sum_to_double(sum_t sum)
{
    return ((double)sum.high * 18446744073709551616.0) + (double)sum.low;
}

static inline powers_t powers_of(sample_t sample, unsigned shift)
{
    const int64_t value = sample >> shift;
    const int64_t square = value * value;
    const powers_t powers = {value, (uint64_t)square, davar_multiply_i64(square, value),
                             davar_multiply_i64(square, square)};
    return powers;
}

static inline void powers_add(powers_t *sums, const powers_t *powers)
{
    sums->first += powers->first;
    sums->second += powers->second;
    davar_u128_add(&sums->third, powers->third);
    davar_u128_add(&sums->fourth, powers->fourth);
}

static inline void powers_subtract(powers_t *sums, const powers_t *powers)
{
    sums->first -= powers->first;
    sums->second -= powers->second;
    davar_u128_subtract(&sums->third, powers->third);
    davar_u128_subtract(&sums->fourth, powers->fourth);
}

#define POWERS_THIRD_WIDE(powers) wide_from_i128((powers)->third)

#endif
