/* davar - IEEE arithmetic: compiler flags that change a result are errors here, or are switched
 * off. Every source that computes with float or double includes this
 * (tests/consumer/test_flags.py). */
#ifndef DAVAR_SRC_STRICT_H
#define DAVAR_SRC_STRICT_H

#if defined(__FAST_MATH__)
#error                                                                                             \
    "davar needs IEEE arithmetic: compile its sources without -ffast-math (-Ofast, -ffp-model=fast)"
#endif
#if defined(__FINITE_MATH_ONLY__)
#if __FINITE_MATH_ONLY__ > 0
#error "davar needs NaN and infinity: compile its sources without -ffinite-math-only"
#endif
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error                                                                                             \
    "davar needs IEEE arithmetic: compile its sources without -funsafe-math-optimizations or a part of it"
#endif
#if defined(__FLT_EVAL_METHOD__)
#if (__FLT_EVAL_METHOD__ != 0) && (__FLT_EVAL_METHOD__ != 16)
#error "davar needs doubles without excess precision: compile its sources with -msse2 -mfpmath=sse"
#endif
#endif
_Static_assert(sizeof(1.0) == sizeof(double), "davar needs constants of type double: compile its "
                                              "sources without -fsingle-precision-constant");

/* Hazard: a product that is fused with a sum rounds differently. */
#if defined(__clang__)
#if defined(__x86_64__) || defined(__i386__) || defined(__aarch64__)
#pragma float_control(precise, on) /* -fassociative-math and -freciprocal-math define no macro */
#pragma float_control(except, on)  /* -ffp-contract=fast overrules FP_CONTRACT OFF, but not this */
#else
#pragma clang fp reassociate(off)
#endif
#pragma STDC FP_CONTRACT OFF /* after float_control, which turns it on */
#elif defined(__GNUC__)
#if (__GNUC__ < 12) /* these define no macro there */
#pragma GCC optimize("no-associative-math", "no-reciprocal-math")
#endif
/* gcc ignores the standard's pragma; its vectoriser fuses complex products despite fp-contract */
#if defined(__FP_FAST_FMA) || defined(__FP_FAST_FMAF)
#pragma GCC optimize("fp-contract=off", "no-tree-slp-vectorize")
#endif
#else
#pragma STDC FP_CONTRACT OFF
#endif

#endif
