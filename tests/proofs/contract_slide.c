/* Statement: one step of the sliding sums (lib/src/core/slide.inc) gives, for each cluster size
 * m, the D of the next spans and the sum of the squares of every D between them, as computed anew
 * from the samples. Bound: none on the samples, the history or the number of steps before; 1 to 32
 * cluster sizes; m up to 1290 (q15), up to 2^23 (q31, -DWIDE=1). contract_slide.patch has the
 * assertions inside the functions. WP of Frama-C proves them with Z3 and CVC4. */
#if WIDE
#include "number/q31.inc"
#define LARGEST 0x800000
#define LONGEST 0x2000000
#define JUMP 0x100000000 /* at most from one sample to another */
#define VALUE(sum) value((sum).low, (sum).high)
#else
#include "number/q15.inc"
#define LARGEST 1290
#define LONGEST 70000
#define JUMP 65535
#define VALUE(sum) (sum)
#endif
#include "core/window.h"

#include "core/allan.inc"

/* --- definitions (DESIGN 1.1) ----------------------------------------------------------------- */

/* The samples in order of time. The step removes spans that start at the oldest and adds spans that
 * end at the newest. */
const sample_t *samples;
uint32_t tail_at;
uint32_t head_at;

/* total: of the samples before i. squares: of the square of every D that starts before i. */
/*@ axiomatic Totals {
      logic integer total(sample_t *x, integer i) reads x[..];
      logic integer squares(sample_t *x, integer m, integer i) reads x[..];
    }
    logic integer D(sample_t *x, integer m, integer i) =
        total(x, i + 2 * m) - 2 * total(x, i + m) + total(x, i);
    logic integer square(integer d) = d * d;
    logic integer fresh(sample_t *x, integer m, integer from, integer to) =
        squares(x, m, to) - squares(x, m, from);
    predicate adds_sample(integer i) = total(samples, i + 1) == total(samples, i) + samples[i];
    predicate adds_square(integer m, integer i) =
        squares(samples, m, i + 1) == squares(samples, m, i) + square(D(samples, m, i)); */

/* Modulo the width of a sum. */
#if WIDE
/*@ axiomatic Width {
      logic integer value(integer low, integer high);
      logic integer wrapped(integer v);
    } */
#else
//@ logic integer wrapped(integer v) = (uint64_t)v;
#endif

/* k is 0 before the step and 1 after it. */
/*@ predicate is_right(integer tail, integer head, integer sum, integer m, integer k) =
        tail == D(samples, m, tail_at + k) && head == D(samples, m, head_at - 2 * m + k) &&
        sum == wrapped(fresh(samples, m, tail_at + k, head_at - 2 * m + 1 + k));
    predicate is_bounded(integer m, integer i) =
        -JUMP * m <= D(samples, m, i) <= JUMP * m; */

/* --- what contract_slide.patch asserts -------------------------------------------------------- */

/* ACSL in macros. */
/* clang-format off */
#define SIZES(t) 0 <= t < allan->count
#define IS_RIGHT(t, k)                                                                             \
    is_right(allan->tau[t].tail, allan->tau[t].head, VALUE(allan->tau[t].sum), allan->m[t], k)

/* The conversion is exact, which the provers do not see by themselves. */
#define IS_SMALL(m)                                                                                \
    1 <= m <= LARGEST && tail_at + 2 * m <= head_at && (uint64_t)m == m &&                         \
        (uint64_t)(2 * m) == 2 * m

/* The two samples that the spans of m and of 2 m share. */
#define TAPS(m) before == samples[head_at - (m)] && after == samples[tail_at + (m)]

/* The first `done` cluster sizes are done. */
#define LOOP(...)                                                                                  \
    loop invariant 0 <= done <= allan->count && tau == allan->tau + done;                          \
    loop invariant \forall integer t; 0 <= t < done ==> IS_RIGHT(t, 1);                            \
    loop invariant \forall integer t; done <= t < allan->count ==> IS_RIGHT(t, 0);                 \
    loop assigns done, tau, __VA_ARGS__, allan->tau[0 .. allan->count - 1];                        \
    loop variant allan->count - done;

#define OLD_DIFFERENCES(m)                                                                         \
    tau->tail == D(samples, m, tail_at) && tau->head == D(samples, m, head_at - 2 * m)
#define OLD_SUM(m) fresh(samples, m, tail_at, head_at - 2 * m + 1)
#define NEW_SUM(m) fresh(samples, m, tail_at + 1, head_at - 2 * m + 2)
#define GAIN square(leading) - square(trailing)
#define LEADING(m)                                                                                 \
    squares(samples, m, head_at - 2 * m + 2) ==                                                    \
        squares(samples, m, head_at - 2 * m + 1) + square(leading)
#define TRAILING(m)                                                                                \
    squares(samples, m, tail_at + 1) == squares(samples, m, tail_at) + square(trailing)
#define UNCHANGED(range)                                                                           \
    \forall integer t; range ==>                                                                   \
        allan->tau[t].tail == \at(allan->tau[t].tail, LoopCurrent) &&                              \
        allan->tau[t].head == \at(allan->tau[t].head, LoopCurrent) &&                              \
        VALUE(allan->tau[t].sum) == \at(VALUE(allan->tau[t].sum), LoopCurrent)
/* clang-format on */

/* The definitions at the places of the step. The bound of D follows from its definition. Wrapping
 * twice is wrapping once, because a conversion to an unsigned type is modulo its width. */
/*@ ghost
    /@ assigns \nothing;
       ensures adds_sample(tail_at) && adds_sample(tail_at + m) && adds_sample(tail_at + 2 * m);
       ensures adds_sample(head_at) && adds_sample(head_at - m) && adds_sample(head_at - 2 * m);
       ensures adds_square(m, tail_at) && adds_square(m, head_at - 2 * m + 1);
       ensures is_bounded(m, tail_at) && is_bounded(m, tail_at + 1);
       ensures is_bounded(m, head_at - 2 * m) && is_bounded(m, head_at - 2 * m + 1); @/
    void definitions(size_t m);

    /@ assigns \nothing;
       ensures wrapped(wrapped(OLD_SUM(m)) + wrapped(GAIN)) == wrapped(OLD_SUM(m) + (GAIN)); @/
    void wraps_once(size_t m, difference_t leading, difference_t trailing); */

/* --- contracts -------------------------------------------------------------------------------- */

#if WIDE
/*@ assigns \nothing; ensures VALUE(\result) == wrapped(a * b); */
static inline davar_u128_t davar_multiply_i64(int64_t a, int64_t b);

/*@ assigns \nothing; ensures VALUE(\result) == wrapped(VALUE(a) + VALUE(b)); */
static inline davar_u128_t davar_u128_add(davar_u128_t a, davar_u128_t b);

#define DIFFERENCE_MAX 0x7FFFFFFFFFFFFFFF
#else
/*@ assigns \nothing; ensures \result == (uint64_t)(a * b); */
static inline uint64_t davar_multiply_i32(int32_t a, int32_t b);

#define DIFFERENCE_MAX 0x7FFFFFFF
#endif

/*@ requires \valid(sum);
    requires -DIFFERENCE_MAX <= head - tail <= DIFFERENCE_MAX;
    requires -DIFFERENCE_MAX <= head + tail <= DIFFERENCE_MAX;
    assigns *sum;
    ensures VALUE(*sum) ==
        wrapped(VALUE(\old(*sum)) + wrapped(square(head) - square(tail))); */
static inline void sum_slide(sum_t *sum, difference_t head, difference_t tail);

#include "core/slide.inc"

/* clang-format off */
#define STEP                                                                                       \
    requires 1 <= allan->count <= DAVAR_TAUS_MAX;                                                  \
    requires \valid(allan->tau + (0 .. allan->count - 1)) && \valid_read(allan);                   \
    requires \valid_read(allan->m + (0 .. allan->count - 1));                                      \
    requires \valid_read(samples + (tail_at .. head_at));                                          \
    requires \separated(allan->tau + (0 .. allan->count - 1), allan);                              \
    requires \separated(allan->tau + (0 .. allan->count - 1), allan->m + (0 .. allan->count - 1)); \
    requires \separated(allan->tau + (0 .. allan->count - 1), samples + (tail_at .. head_at));     \
    requires \separated(allan->tau + (0 .. allan->count - 1), &samples, &tail_at, &head_at);       \
    requires head == samples + head_at && tail == samples + tail_at;                               \
    requires 0 <= tail_at <= head_at <= LONGEST;                                                   \
    requires \forall integer t; SIZES(t) ==> IS_SMALL(allan->m[t]) && IS_RIGHT(t, 0);              \
    assigns allan->tau[0 .. allan->count - 1];                                                     \
    ensures \forall integer t; SIZES(t) ==> IS_RIGHT(t, 1);
/* clang-format on */

/*@ STEP */
static void slide_any(allan_t *allan, const sample_t *head, const sample_t *tail);

/*@ requires \forall integer t; 0 <= t < allan->count - 1 ==> allan->m[t + 1] == 2 * allan->m[t];
    STEP */
static void slide_octaves(allan_t *allan, const sample_t *head, const sample_t *tail);
