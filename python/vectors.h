/* davar for Python - loops for the vectors of this machine. The same C is compiled several times,
 * so the bits are the same. */
#ifndef VECTORS_H
#define VECTORS_H

#if defined(__x86_64__) && defined(__GNUC__)
#define FOR_AVX2 __attribute__((target("avx2"), flatten))
#define FOR_AVX512 __attribute__((target("avx512f,avx512dq"), flatten))
#define HAS_AVX2 __builtin_cpu_supports("avx2")
#define HAS_AVX512 __builtin_cpu_supports("avx512dq")
#else
#define FOR_AVX2
#define FOR_AVX512
#define HAS_AVX2 0
#define HAS_AVX512 0
#endif

#endif
