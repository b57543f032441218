/* davar - the number type of int16 counts: 32-bit differences, 64-bit sums of squares, 128-bit moments.
 * One of the two headers that give the pipeline its types; see DESIGN 2.1 for the widths. */
#ifndef DAVAR_SRC_NUMBER_H
#define DAVAR_SRC_NUMBER_H

#include "change/stationarity.h"
#include "number/ieee.h"

#include <stddef.h>

#define NUMBER(name) davar_q15_##name
#define NUMBER_SAMPLE_BITS_DEFAULT 16U
#define NUMBER_SAMPLE_BITS_MAX 16U
#define NUMBER_SUM_BITS 64U
#define NUMBER_WINDOW_MAX 65536U

typedef int16_t sample_t;
typedef int32_t difference_t;
typedef uint64_t sum_t;

/* Sums of x, x^2, x^3, x^4, running modulo their widths (32, 64, 64, 96 bits): what a window adds to each fits. */
typedef struct {
    uint32_t first;
    uint32_t fourth_high;
    uint64_t second;
    uint64_t third;
    uint64_t fourth_low;
} powers_t;

/* What the detector wants to know of a block of at most 64 samples. */
typedef struct {
    int32_t sum;
    uint64_t squares;
} block_t;

static inline void block_copy(block_t *to, const block_t *from)
{
    to->sum = from->sum;
    to->squares = from->squares;
}

static inline void block_clear(block_t *block)
{
    block->sum = 0;
    block->squares = 0U;
}

static inline void block_add(block_t *block, sample_t sample)
{
    block->sum += sample;
    block->squares += (uint64_t)((int32_t)sample * sample);
}

static inline void sum_add_square(sum_t *sum, difference_t difference)
{
    *sum += davar_square_i32(difference);
}

/* D runs on over n samples that follow one another in memory, as do their taps (2.1), and every D^2 is added; returns D. */
static inline difference_t sum_add_run_at_once(sum_t *sum, difference_t head, const sample_t *newest,
                                               const sample_t *middle, const sample_t *oldest, uint32_t n)
{
    sum_t total = *sum;
    for (const sample_t *const end = newest + n; newest != end; newest++, middle++, oldest++) {
        head += *newest - (2 * (difference_t)*middle) + *oldest;
        sum_add_square(&total, head);
    }
    *sum = total;
    return head;
}

#define SMALL_RUN 15U /* squares of D below 2^14 that 32 bits hold the sum of */

/* The same, in 32 bits: a loop that fits the low registers of a Cortex-M0. False, and nothing done: some D is too large. */
DAVAR_APART static bool sum_add_small_run(sum_t *sum, difference_t *head, const sample_t *newest,
                                          const sample_t *middle, const sample_t *oldest, uint32_t n)
{
    difference_t difference = *head;
    uint32_t squares = 0U;
    uint32_t sizes = 0U;
    for (uint32_t i = 0U; i < n; i++) {
        difference += newest[i] - (2 * (difference_t)middle[i]) + oldest[i];
        sizes |= davar_size_i32(difference);
        squares += (uint32_t)difference * (uint32_t)difference;
    }
    if (sizes >= (1U << 14U)) {
        return false;
    }
    *sum += squares;
    *head = difference;
    return true;
}

/* The same, a few samples at a time, most of which are small. */
static inline difference_t sum_add_run_by_parts(sum_t *sum, difference_t head, const sample_t *newest,
                                                const sample_t *middle, const sample_t *oldest, uint32_t n)
{
    while (n > 0U) {
        const uint32_t few = (n < SMALL_RUN) ? n : SMALL_RUN;
        if (!sum_add_small_run(sum, &head, newest, middle, oldest, few)) {
            head = sum_add_run_at_once(sum, head, newest, middle, oldest, few);
        }
        newest += few;
        middle += few;
        oldest += few;
        n -= few;
    }
    return head;
}

static inline difference_t sum_add_run(sum_t *sum, difference_t head, const sample_t *newest, const sample_t *middle,
                                       const sample_t *oldest, uint32_t n)
{
#ifdef DAVAR_NARROW_PRODUCT
    return sum_add_run_by_parts(sum, head, newest, middle, oldest, n);
#else
    return sum_add_run_at_once(sum, head, newest, middle, oldest, n);
#endif
}

static inline void sum_subtract_square(sum_t *sum, difference_t difference)
{
    *sum -= davar_square_i32(difference);
}

/* head^2 - tail^2 as one product; neither factor can leave 32 bits, since window_max m^2 < 2^32 for samples of 16 bits (2.4). */
static inline void sum_slide(sum_t *sum, difference_t head, difference_t tail)
{
    *sum += davar_multiply_i32(head - tail, head + tail);
}

static inline void sum_copy(sum_t *to, const sum_t *from)
{
    *to = *from;
}

static inline sum_t sum_between(sum_t later, sum_t earlier)
{
    return later - earlier;
}

static inline double sum_to_double(sum_t sum)
{
    return davar_double_of_u64(sum);
}

static inline void powers_add(powers_t *powers, sample_t sample)
{
    const int32_t value = sample;
    const int32_t square = value * value;
    const uint64_t fourth = davar_square_i32(square);
    powers->first += (uint32_t)value;
    powers->second += (uint64_t)square;
    powers->third += davar_multiply_by_i16(square, sample);
    powers->fourth_low += fourth;
    powers->fourth_high += (powers->fourth_low < fourth) ? 1U : 0U;
}

/* One sample in, one out: differences of squares as products, and no fourth power by itself. */
static inline void powers_slide(powers_t *powers, sample_t in, sample_t out)
{
    const int32_t square_in = (int32_t)in * in;
    const int32_t square_out = (int32_t)out * out;
    const int32_t squares = square_in - square_out;
    const uint32_t both = (uint32_t)square_in + (uint32_t)square_out; /* 2^31 at most, and then squares is 0 */
    const int64_t fourths = (int64_t)davar_multiply_i32(squares, (int32_t)both);
    powers->first += (uint32_t)((int32_t)in - out);
    powers->second += (uint64_t)(int64_t)squares;
    powers->third += davar_multiply_by_i16(square_in, in) - davar_multiply_by_i16(square_out, out);
    powers->fourth_low += (uint64_t)fourths;
    powers->fourth_high += ((powers->fourth_low < (uint64_t)fourths) ? 1U : 0U) - ((fourths < 0) ? 1U : 0U);
}

static inline void powers_add_fourth(powers_t *powers, uint64_t fourth)
{
    powers->fourth_low += fourth;
    powers->fourth_high += (powers->fourth_low < fourth) ? 1U : 0U;
}

#define POWERS_RUN 15U /* values of x^4 <= 2^60 that 64 bits hold the sum of */

/* Samples that follow one another in memory: sums that stay in registers, only x^4 carries now and then. */
static inline void powers_add_run_at_once(powers_t *powers, const sample_t *sample, uint32_t count)
{
    uint32_t first = powers->first;
    uint64_t second = powers->second;
    uint64_t third = powers->third;
    for (const sample_t *const end = sample + count; sample != end;) {
        const sample_t *const stop = ((end - sample) > (ptrdiff_t)POWERS_RUN) ? (sample + POWERS_RUN) : end;
        uint64_t fourth = 0U;
        DAVAR_UNROLLED
        for (; sample != stop; sample++) {
            const int32_t value = *sample;
            const int32_t square = value * value;
            first += (uint32_t)value;
            second += davar_square_i16(*sample);
            third += davar_multiply_by_i16(square, *sample);
            fourth += davar_square_i32(square);
        }
        powers_add_fourth(powers, fourth);
    }
    powers->first = first;
    powers->second = second;
    powers->third = third;
}

/* At most POWERS_RUN samples below 2^13, in 32 bits: with x^2 = 2^13 a + b all sums of x a, x b, a^2, a b and b^2 fit. False,
 * and nothing done: some sample is too large. */
DAVAR_APART static bool powers_add_small_run(powers_t *powers, const sample_t *sample, uint32_t count)
{
    uint32_t first = 0U;
    uint32_t second = 0U;
    uint32_t third[2] = {0U, 0U};
    uint32_t fourth[3] = {0U, 0U, 0U};
    uint32_t sizes = 0U;
    for (const sample_t *const end = sample + count; sample != end; sample++) {
        const uint32_t value = (uint32_t)*sample;
        const uint32_t square = value * value;
        const uint32_t a = square >> 13U;
        const uint32_t b = square & 0x1FFFU;
        sizes |= davar_size_i32(*sample);
        first += value;
        second += square;
        third[0] += value * a;
        third[1] += value * b;
        fourth[0] += a * a;
        fourth[1] += a * b;
        fourth[2] += b * b;
    }
    if (sizes >= (1U << 13U)) {
        return false;
    }
    powers->first += first;
    powers->second += second;
    powers->third += ((uint64_t)(int64_t)(int32_t)third[0] << 13U) + (uint64_t)(int64_t)(int32_t)third[1];
    powers_add_fourth(powers, ((uint64_t)fourth[0] << 26U) + ((uint64_t)fourth[1] << 14U) + fourth[2]);
    return true;
}

/* The same as at once, a few samples at a time, most of which are small. */
static inline void powers_add_run_by_parts(powers_t *powers, const sample_t *sample, uint32_t count)
{
    while (count > 0U) {
        const uint32_t few = (count < POWERS_RUN) ? count : POWERS_RUN;
        if (!powers_add_small_run(powers, sample, few)) {
            powers_add_run_at_once(powers, sample, few);
        }
        sample += few;
        count -= few;
    }
}

static void powers_add_run(powers_t *powers, const sample_t *sample, uint32_t count)
{
#ifdef DAVAR_NARROW_PRODUCT
    powers_add_run_by_parts(powers, sample, count);
#else
    powers_add_run_at_once(powers, sample, count);
#endif
}

/* Field by field: a struct this large would be copied by a library call on some targets. */
static inline void powers_copy(powers_t *to, const powers_t *from)
{
    to->first = from->first;
    to->second = from->second;
    to->third = from->third;
    to->fourth_low = from->fourth_low;
    to->fourth_high = from->fourth_high;
}

static inline void powers_between(powers_t *between, const powers_t *later, const powers_t *earlier)
{
    between->first = later->first - earlier->first;
    between->second = later->second - earlier->second;
    between->third = later->third - earlier->third;
    const uint32_t borrow = (later->fourth_low < earlier->fourth_low) ? 1U : 0U;
    between->fourth_low = later->fourth_low - earlier->fourth_low;
    between->fourth_high = later->fourth_high - earlier->fourth_high - borrow;
}

/* n^2 s^2 and n^4 m4 of n samples: exact (3.3). With n <= 2^16 and |x| <= 2^15 all of |P1| <= 2^31, n P2 <= 2^62,
 * |P3| <= 2^61 and n P4 <= 2^92 hold, so the first of the two and 3 P1^2 fit 64 bits; so does 4 P3, except when every
 * sample is the lowest, and then there is no variance that the other could be set against. */
static void powers_central(const powers_t *powers, uint32_t n, davar_central_t *central)
{
    const int32_t first = (int32_t)powers->first;
    const uint32_t size = (first < 0) ? (0U - powers->first) : powers->first;
    const uint64_t square = davar_multiply_u32(size, size);
    const uint64_t second = davar_scale_u64(powers->second, n) - square;
    const uint64_t cube = (first < 0) ? (0U - powers->third) : powers->third;
    const davar_u128_t raw = {powers->fourth_low, powers->fourth_high};
    const davar_u128_t cubes = davar_u128_scale(davar_u128_of_i64((int64_t)(cube << 2U)), size);
    davar_u128_t fourth = davar_u128_subtract(davar_u128_scale(raw, n), cubes);
    fourth = davar_u128_scale(davar_u128_scale(fourth, n), n);
    fourth = davar_u128_add(fourth, davar_multiply_u64(square + (square << 1U), (second << 1U) + square));
    davar_magnitude_u64(&central->second, second);
    davar_magnitude(&central->fourth, fourth.low, fourth.high, 0);
}

#endif
