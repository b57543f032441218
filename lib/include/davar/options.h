/* davar - what a build may choose, one name each. All is there unless it is left out, with -DDAVAR_GRID=0 for example, for the
 * library and for whatever includes it. What is left out takes no flash and is refused by init (DAVAR_ERR_BUILD). */
#ifndef DAVAR_OPTIONS_H
#define DAVAR_OPTIONS_H

/* Most cluster sizes one instance can carry, 1 to 32. Sizes davar_result_t and davar_plan_t. */
#ifndef DAVAR_TAUS_MAX
#define DAVAR_TAUS_MAX 32
#endif

/* int16 counts. */
#ifndef DAVAR_Q15
#define DAVAR_Q15 1
#endif

/* int32 counts, and floats. */
#ifndef DAVAR_Q31
#define DAVAR_Q31 1
#endif

/* Engine grid, for a stride above 1. */
#ifndef DAVAR_GRID
#define DAVAR_GRID 1
#endif

/* Windows whose length a law decides (davar/law.h); kurtosis and contribution (segment above 0). */
#ifndef DAVAR_LAWS
#define DAVAR_LAWS 1
#endif

/* Centred windows with mirrored ends, and davar_flush. */
#ifndef DAVAR_CENTRED
#define DAVAR_CENTRED 1
#endif

/* Caller bugs. Yours may log or reset; ((void)0) leaves them out. Where there is an operating system, assert; on a bare machine
 * a trap, for the C library's assert brings stdio and malloc with it. */
#ifndef DAVAR_ASSERT
#if defined(NDEBUG)
#define DAVAR_ASSERT(condition) ((void)0)
#elif defined(__GNUC__) && !defined(__unix__) && !defined(__APPLE__) && !defined(_WIN32)
#define DAVAR_ASSERT(condition) ((condition) ? (void)0 : __builtin_trap())
#else
#include <assert.h>
#define DAVAR_ASSERT(condition) assert(condition)
#endif
#endif

/* A return value that the caller must use. */
#ifndef DAVAR_NODISCARD
#if defined(__GNUC__)
#define DAVAR_NODISCARD __attribute__((warn_unused_result))
#else
#define DAVAR_NODISCARD
#endif
#endif

#if (DAVAR_TAUS_MAX < 1) || (DAVAR_TAUS_MAX > 32)
#error "DAVAR_TAUS_MAX: 1 to 32"
#endif
#if !DAVAR_Q15 && !DAVAR_Q31
#error "DAVAR_Q15, DAVAR_Q31: one number type must be there"
#endif
#if defined(__SIZEOF_DOUBLE__) && (__SIZEOF_DOUBLE__ != 8)
#error "davar needs a double of 64 bits (avr-gcc: -mdouble=64; RX, rl78: -m64bit-doubles)"
#endif

#endif
