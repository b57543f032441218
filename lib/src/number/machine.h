/* davar - products, 128-bit sums and leading zeros. All that depends on the machine is here, and
 * nothing here calls the compiler's library on any target. */
#ifndef DAVAR_SRC_MACHINE_H
#define DAVAR_SRC_MACHINE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Never inlined, so that a hot loop has the registers to itself. */
#ifdef __GNUC__
#define DAVAR_APART __attribute__((noinline))
#else
#define DAVAR_APART
#endif

/* Always inlined when optimising for speed, because it runs once per sample. */
#if defined(__GNUC__) && defined(__OPTIMIZE__) && !defined(__OPTIMIZE_SIZE__)
#define DAVAR_MERGED inline __attribute__((always_inline))
#else
#define DAVAR_MERGED inline
#endif

/* Runs at the start, at an event or for few results. It is compiled for size whatever the flags of
 * the user are, and laid out apart from the code of every sample, as are functions that only it
 * calls. */
#ifdef __GNUC__
#define DAVAR_RARE __attribute__((cold))
#else
#define DAVAR_RARE
#endif

/* Before a loop over samples: a core without post-increment loads pays for the pointer at every
 * turn. */
#if defined(__riscv) && defined(__GNUC__)
#define DAVAR_UNROLLED _Pragma("GCC unroll 2")
#else
#define DAVAR_UNROLLED
#endif

/* Before a loop over cluster sizes that copies one number each, where flash is not scarce. */
#if defined(__GNUC__) && defined(__OPTIMIZE__) && !defined(__OPTIMIZE_SIZE__)
#define DAVAR_UNROLLED_WIDELY _Pragma("GCC unroll 8")
#else
#define DAVAR_UNROLLED_WIDELY
#endif

/* Cortex-M0, M0+, M1 or M23: products have 32 bits, and most instructions reach eight registers. */
#if defined(__ARM_ARCH_ISA_THUMB) && (__ARM_ARCH_ISA_THUMB == 1) && (__ARM_ARCH_PROFILE == 'M')
#define DAVAR_NARROW_PRODUCT
#endif

/* The types that the floating-point unit lacks. */
#if (defined(__arm__) && !defined(__ARM_FP)) || (defined(__riscv) && !defined(__riscv_flen))
#define DAVAR_SOFT_FLOAT
#define DAVAR_SOFT_DOUBLE
#elif (defined(__arm__) && ((__ARM_FP & 8) == 0)) || (defined(__riscv) && (__riscv_flen < 64))
#define DAVAR_SOFT_DOUBLE
#endif

/* A 128-bit integer modulo 2^128; signed values are two's complement. */
typedef struct {
    uint64_t low;
    uint64_t high;
} davar_u128_t;

/* The product by 16-bit parts, for a Cortex-M0, whose products have 32 bits. */
uint64_t davar_multiply_u32_by_parts(uint32_t a, uint32_t b);

#if defined(DAVAR_NARROW_PRODUCT) && defined(__GNUC__) && !defined(DAVAR_PORTABLE)
/* The same in 17 instructions instead of 25: most of the time of a result goes into this
 * product. */
uint64_t davar_multiply_u32_v6m(uint32_t a, uint32_t b);
#endif

static inline uint64_t davar_multiply_u32(uint32_t a, uint32_t b)
{
#if defined(DAVAR_NARROW_PRODUCT) && defined(__GNUC__) && !defined(DAVAR_PORTABLE)
    return davar_multiply_u32_v6m(a, b);
#elif defined(DAVAR_NARROW_PRODUCT)
    return davar_multiply_u32_by_parts(a, b);
#else
    return (uint64_t)a * b;
#endif
}

/* The upper half of the product. */
static inline uint32_t davar_upper_product(uint32_t a, uint32_t b)
{
    return (uint32_t)(davar_multiply_u32(a, b) >> 32U);
}

static inline bool davar_fits_i16(int32_t a)
{
    return ((uint32_t)a + 0x8000U) < 0x10000U;
}

/* Signed, as the bits of an int64_t; mostly one product is enough. */
static inline uint64_t davar_multiply_i32_by_parts(int32_t a, int32_t b)
{
    if (davar_fits_i16(a) && davar_fits_i16(b)) {
        return (uint64_t)(int64_t)(a * b);
    }
    const uint32_t excess = ((a < 0) ? (uint32_t)b : 0U) + ((b < 0) ? (uint32_t)a : 0U);
    return davar_multiply_u32((uint32_t)a, (uint32_t)b) - ((uint64_t)excess << 32U);
}

static inline uint64_t davar_multiply_i32(int32_t a, int32_t b)
{
#ifdef DAVAR_NARROW_PRODUCT
    return davar_multiply_i32_by_parts(a, b);
#else
    return (uint64_t)((int64_t)a * b);
#endif
}

/* A square by 16-bit parts; one product if it fits 32 bits, like most differences. */
static inline uint64_t davar_square_i32_by_parts(int32_t a)
{
    const uint32_t bits = (uint32_t)a;
    const uint32_t square = bits * bits; /* modulo 2^32 */
    if ((bits + 0xFFFFU) < 0x1FFFFU) {   /* |a| < 2^16 */
        return square;
    }
    const uint32_t magnitude = (a < 0) ? (0U - bits) : bits;
    const uint32_t low = magnitude & 0xFFFFU;
    const uint32_t high = magnitude >> 16U;
    const uint32_t bottom = low * low;
    const uint32_t mixed = high * low;
    const uint32_t top = high * high;
    return bottom + ((uint64_t)mixed << 17U) + ((uint64_t)top << 32U);
}

static inline uint64_t davar_square_i32(int32_t a)
{
#ifdef DAVAR_NARROW_PRODUCT
    return davar_square_i32_by_parts(a);
#else
    return (uint64_t)((int64_t)a * a);
#endif
}

/* |a|, or |a| - 1 if a is negative: an OR of many bounds the largest. */
static inline uint32_t davar_size_i32(int32_t a)
{
    return (uint32_t)a ^ ((a < 0) ? UINT32_MAX : 0U);
}

/* At most 2^30: a 32-bit product, or the start of a multiply-accumulate of 64 bits. */
static inline uint64_t davar_square_i16(int16_t a)
{
#ifdef DAVAR_NARROW_PRODUCT
    return (uint32_t)(a * a);
#else
    return (uint64_t)((int64_t)a * a);
#endif
}

/* a >= 0; as the bits of an int64_t. */
static inline uint64_t davar_multiply_by_i16_by_parts(int32_t a, int16_t b)
{
    const int32_t high = (a >> 16U) * b;
    const int32_t low = (a & 0xFFFF) * b;
    return ((uint64_t)(int64_t)high << 16U) + (uint64_t)(int64_t)low;
}

/* Two products are enough if b < 2^16. */
static inline uint64_t davar_multiply_by_small_by_parts(uint32_t a, uint32_t b)
{
    if ((b >> 16U) != 0U) {
        return davar_multiply_u32(a, b);
    }
    const uint32_t high = (a >> 16U) * b;
    const uint32_t low = (a & 0xFFFFU) * b;
    return ((uint64_t)high << 16U) + low;
}

/* Any factors; b is mostly below 2^16. */
static inline uint64_t davar_multiply_by_small(uint32_t a, uint32_t b)
{
#ifdef DAVAR_NARROW_PRODUCT
    return davar_multiply_by_small_by_parts(a, b);
#else
    return (uint64_t)a * b;
#endif
}

static inline uint64_t davar_multiply_by_i16(int32_t a, int16_t b)
{
#ifdef DAVAR_NARROW_PRODUCT
    return davar_multiply_by_i16_by_parts(a, b);
#else
    return (uint64_t)((int64_t)a * b);
#endif
}

/* By 32-bit parts, for compilers without a 128-bit type. */
static inline davar_u128_t davar_multiply_u64_by_parts(uint64_t a, uint64_t b)
{
    const uint32_t a0 = (uint32_t)a;
    const uint32_t a1 = (uint32_t)(a >> 32U);
    const uint32_t b0 = (uint32_t)b;
    const uint32_t b1 = (uint32_t)(b >> 32U);
    const uint64_t p00 = davar_multiply_u32(a0, b0);
    const uint64_t p01 = davar_multiply_u32(a0, b1);
    const uint64_t p10 = davar_multiply_u32(a1, b0);
    const uint64_t middle = (p00 >> 32U) + (p01 & UINT32_MAX) + (p10 & UINT32_MAX);
    return (davar_u128_t){
        (middle << 32U) | (p00 & UINT32_MAX),
        davar_multiply_u32(a1, b1) + (p01 >> 32U) + (p10 >> 32U) + (middle >> 32U),
    };
}

static inline davar_u128_t davar_multiply_u64(uint64_t a, uint64_t b)
{
#ifdef __SIZEOF_INT128__
    __extension__ const unsigned __int128 product = (unsigned __int128)a * b;
    return (davar_u128_t){(uint64_t)product, (uint64_t)(product >> 64U)};
#else
    return davar_multiply_u64_by_parts(a, b);
#endif
}

/* Signed, modulo 2^128: the unsigned product less the sign of each operand times the other. */
static inline davar_u128_t davar_multiply_i64(int64_t a, int64_t b)
{
    davar_u128_t product = davar_multiply_u64((uint64_t)a, (uint64_t)b);
    product.high -= (a < 0) ? (uint64_t)b : 0U;
    product.high -= (b < 0) ? (uint64_t)a : 0U;
    return product;
}

static inline void davar_u128_copy(davar_u128_t *to, const davar_u128_t *from)
{
    to->low = from->low;
    to->high = from->high;
}

/* Modulo 2^128, signed or not; here and below. */
static inline davar_u128_t davar_u128_add(davar_u128_t a, davar_u128_t b)
{
    const uint64_t low = a.low + b.low;
    return (davar_u128_t){low, a.high + b.high + (uint64_t)(low < b.low)};
}

static inline davar_u128_t davar_u128_subtract(davar_u128_t a, davar_u128_t b)
{
    return (davar_u128_t){a.low - b.low, a.high - b.high - (uint64_t)(a.low < b.low)};
}

static inline davar_u128_t davar_u128_scale(davar_u128_t a, uint32_t factor)
{
#ifdef __SIZEOF_INT128__
    davar_u128_t product = davar_multiply_u64(a.low, factor);
    product.high += a.high * factor;
    return product;
#else
    const uint64_t p0 = davar_multiply_u32((uint32_t)a.low, factor);
    const uint64_t p1 = davar_multiply_u32((uint32_t)(a.low >> 32U), factor) + (p0 >> 32U);
    const uint64_t p2 = davar_multiply_u32((uint32_t)a.high, factor) + (p1 >> 32U);
    const uint32_t p3 = (uint32_t)(a.high >> 32U) * factor;
    return (davar_u128_t){(p1 << 32U) | (uint32_t)p0, p2 + ((uint64_t)p3 << 32U)};
#endif
}

static inline davar_u128_t davar_u128_of_i64(int64_t a)
{
    return (davar_u128_t){(uint64_t)a, (a < 0) ? UINT64_MAX : 0U};
}

/* Leading zeros of a value that is not 0, by halving. */
static inline uint32_t davar_leading_zeros_32_by_halving(uint32_t value)
{
    uint32_t zeros = 0U;
    if ((value >> 16U) == 0U) {
        zeros = 16U;
        value <<= 16U;
    }
    if ((value >> 24U) == 0U) {
        zeros += 8U;
        value <<= 8U;
    }
    if ((value >> 28U) == 0U) {
        zeros += 4U;
        value <<= 4U;
    }
    if ((value >> 30U) == 0U) {
        zeros += 2U;
        value <<= 2U;
    }
    return zeros + (((value >> 31U) == 0U) ? 1U : 0U);
}

#ifdef DAVAR_NARROW_PRODUCT
/* The same, called instead of inlined, because flash is scarce there. */
uint32_t davar_leading_zeros_32_shared(uint32_t value);
#endif

static inline uint32_t davar_leading_zeros_32(uint32_t value)
{
#if defined(__ARM_FEATURE_CLZ) || !(defined(__arm__) || defined(__riscv))
    return (uint32_t)__builtin_clz(value);
#elif defined(DAVAR_NARROW_PRODUCT)
    return davar_leading_zeros_32_shared(value);
#else
    return davar_leading_zeros_32_by_halving(value);
#endif
}

static inline uint32_t davar_leading_zeros(uint64_t value)
{
    const uint32_t high = (uint32_t)(value >> 32U);
    return (high != 0U) ? davar_leading_zeros_32(high)
                        : (32U + davar_leading_zeros_32((uint32_t)value | 1U));
}

/* Modulo 2^64. */
static inline uint64_t davar_scale_u64(uint64_t a, uint32_t factor)
{
    return davar_multiply_u32((uint32_t)a, factor) +
           ((uint64_t)((uint32_t)(a >> 32U) * factor) << 32U);
}

/* Counters of input faults stop at their largest value. */
static inline void davar_count(uint32_t *counter)
{
    if (*counter < UINT32_MAX) {
        (*counter)++;
    }
}

static inline void davar_count_many(uint32_t *counter, size_t more)
{
    const uint32_t room = UINT32_MAX - *counter;
    *counter += (more < room) ? (uint32_t)more : room;
}

#endif
