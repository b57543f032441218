/** @file
 * davar - options of a build.
 *
 * Every feature is on by default. -DDAVAR_LAWS=0 removes one; define it for the library and for
 * every source that includes a header of davar. A removed feature takes no flash, and init rejects
 * a configuration that needs it (DAVAR_ERR_BUILD). The other results keep their bits. */
#ifndef DAVAR_OPTIONS_H
#define DAVAR_OPTIONS_H

/** Largest number of cluster sizes of an instance, 1 to 32. It sizes davar_result_t and
 * davar_plan_t; a library and a user with different values do not link. */
#ifndef DAVAR_TAUS_MAX
#define DAVAR_TAUS_MAX 32
#endif

/** Number type _q15: int16 counts. */
#ifndef DAVAR_Q15
#define DAVAR_Q15 1
#endif

/** Number types _q31 and _f32: int32 counts and floats. */
#ifndef DAVAR_Q31
#define DAVAR_Q31 1
#endif

/** Windows whose length a law decides; kurtosis and contribution (segment
 * above 0). */
#ifndef DAVAR_LAWS
#define DAVAR_LAWS 1
#endif

/** Checks for bugs of the caller. The default is assert on an operating system and a trap on a bare
 * machine, where the C library's assert would link stdio and malloc. NDEBUG removes them. Your own
 * definition may log or reset. */
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

/** Marks a return value that the caller must use. */
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
