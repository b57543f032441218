/* davar - the number type of int32 counts (and of float samples after the door): 64-bit differences, 128-bit sums of
 * squares, 256-bit moments. See DESIGN 2.1 for the widths. */
#ifndef DAVAR_SRC_NUMBER_H
#define DAVAR_SRC_NUMBER_H

#include "change/stationarity.h"
#include "window/wide.h"

#define NUMBER(name) davar_q31_##name
#define NUMBER_SAMPLE_BITS_DEFAULT 24U
#define NUMBER_SAMPLE_BITS_MAX 32U
#define NUMBER_SUM_BITS 128U
#define NUMBER_WINDOW_MAX 16777216U

typedef int32_t sample_t;
typedef int64_t difference_t;
typedef davar_u128_t sum_t;

/* Sums of x, x^2, x^3, x^4, running modulo their widths (64, 128, 128, 160 bits): what a window adds to each fits. */
typedef struct {
    uint64_t first;
    davar_u128_t second;
    davar_u128_t third;
    davar_u128_t fourth_low;
    uint32_t fourth_high;
} powers_t;

/* What the detector wants to know of a block of at most 64 samples. */
typedef struct {
    int64_t sum;
    davar_u128_t squares;
} block_t;

static inline void block_copy(block_t *to, const block_t *from)
{
    to->sum = from->sum;
    davar_u128_copy(&to->squares, &from->squares);
}

static inline void block_clear(block_t *block)
{
    block->sum = 0;
    block->squares.low = 0U;
    block->squares.high = 0U;
}

static inline void block_add(block_t *block, sample_t sample)
{
    const davar_u128_t square = {davar_multiply_i32(sample, sample), 0U};
    block->sum += sample;
    block->squares = davar_u128_add(block->squares, square);
}

static inline void sum_add_square(sum_t *sum, difference_t difference)
{
    *sum = davar_u128_add(*sum, davar_multiply_i64(difference, difference));
}

/* D runs on over n samples that follow one another in memory, as do their taps (2.1), and every D^2 is added; returns D. */
static inline difference_t sum_add_run(sum_t *sum, difference_t head, const sample_t *newest, const sample_t *middle,
                                       const sample_t *oldest, uint32_t n)
{
    for (const sample_t *const end = newest + n; newest != end; newest++, middle++, oldest++) {
        head += *newest - (2 * (difference_t)*middle) + *oldest;
        sum_add_square(sum, head);
    }
    return head;
}

static inline void sum_subtract_square(sum_t *sum, difference_t difference)
{
    *sum = davar_u128_subtract(*sum, davar_multiply_i64(difference, difference));
}

/* head^2 - tail^2 as one product. */
static inline void sum_slide(sum_t *sum, difference_t head, difference_t tail)
{
    *sum = davar_u128_add(*sum, davar_multiply_i64(head - tail, head + tail));
}

static inline void sum_copy(sum_t *to, const sum_t *from)
{
    davar_u128_copy(to, from);
}

static inline sum_t sum_between(sum_t later, sum_t earlier)
{
    return davar_u128_subtract(later, earlier);
}

static inline double sum_to_double(sum_t sum)
{
    return ((double)sum.high * 18446744073709551616.0) + (double)sum.low;
}

static inline bool u128_less(davar_u128_t a, davar_u128_t b)
{
    return (a.high < b.high) || ((a.high == b.high) && (a.low < b.low));
}

static inline void powers_add(powers_t *powers, sample_t value)
{
    const uint64_t square = davar_multiply_i32(value, value);
    const davar_u128_t second = {square, 0U};
    powers->first += (uint64_t)(int64_t)value;
    powers->second = davar_u128_add(powers->second, second);
    powers->third = davar_u128_add(powers->third, davar_multiply_i64((int64_t)square, value));
    const davar_u128_t fourth = davar_multiply_u64(square, square);
    powers->fourth_low = davar_u128_add(powers->fourth_low, fourth);
    powers->fourth_high += u128_less(powers->fourth_low, fourth) ? 1U : 0U;
}

static void powers_add_run(powers_t *powers, const sample_t *sample, uint32_t count)
{
    for (const sample_t *const end = sample + count; sample != end; sample++) {
        powers_add(powers, *sample);
    }
}

/* Field by field: a struct this large would be copied by a library call on some targets. */
static inline void powers_copy(powers_t *to, const powers_t *from)
{
    to->first = from->first;
    davar_u128_copy(&to->second, &from->second);
    davar_u128_copy(&to->third, &from->third);
    davar_u128_copy(&to->fourth_low, &from->fourth_low);
    to->fourth_high = from->fourth_high;
}

static inline void powers_between(powers_t *between, const powers_t *later, const powers_t *earlier)
{
    between->first = later->first - earlier->first;
    between->second = davar_u128_subtract(later->second, earlier->second);
    between->third = davar_u128_subtract(later->third, earlier->third);
    const uint32_t borrow = u128_less(later->fourth_low, earlier->fourth_low) ? 1U : 0U;
    between->fourth_low = davar_u128_subtract(later->fourth_low, earlier->fourth_low);
    between->fourth_high = later->fourth_high - earlier->fourth_high - borrow;
}

static inline void powers_remove(powers_t *powers, sample_t value)
{
    const uint64_t square = davar_multiply_i32(value, value);
    const davar_u128_t second = {square, 0U};
    const davar_u128_t fourth = davar_multiply_u64(square, square);
    powers->first -= (uint64_t)(int64_t)value;
    powers->second = davar_u128_subtract(powers->second, second);
    powers->third = davar_u128_subtract(powers->third, davar_multiply_i64((int64_t)square, value));
    powers->fourth_high -= u128_less(powers->fourth_low, fourth) ? 1U : 0U;
    powers->fourth_low = davar_u128_subtract(powers->fourth_low, fourth);
}

/* One sample in, one out. */
static inline void powers_slide(powers_t *powers, sample_t in, sample_t out)
{
    powers_add(powers, in);
    powers_remove(powers, out);
}

/* n^2 s^2 and n^4 m4 of n samples: exact (3.3). */
static void powers_central(const powers_t *powers, uint32_t n, davar_central_t *central)
{
    wide_t first;
    wide_t second;
    wide_t square;
    wide_t fourth;
    wide_t part;
    wide_from_i64(&first, (int64_t)powers->first);
    wide_from_u128(&second, &powers->second);
    wide_multiply(&square, &first, &first);
    wide_from_i128(&part, &powers->third);
    wide_multiply(&part, &first, &part);
    wide_from_u128(&fourth, &powers->fourth_low);
    fourth.limb[2] = powers->fourth_high;
    wide_scale(&fourth, n);
    wide_scale(&part, 4U);
    wide_subtract(&fourth, &part);
    wide_scale(&fourth, n);
    wide_multiply(&part, &square, &second);
    wide_scale(&part, 6U);
    wide_add(&fourth, &part);
    wide_scale(&fourth, n);
    wide_multiply(&part, &square, &square);
    wide_scale(&part, 3U);
    wide_subtract(&fourth, &part);
    wide_scale(&second, n);
    wide_subtract(&second, &square);
    wide_magnitude(&second, &central->second);
    wide_magnitude(&fourth, &central->fourth);
}

#endif
