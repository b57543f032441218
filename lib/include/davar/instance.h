/** @file
 * davar - the instance and the size of its memory. The types are complete so that instances and
 * their memory can be static; their fields are private. */
#ifndef DAVAR_INSTANCE_H
#define DAVAR_INSTANCE_H

#include "davar/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Which samples are in the window. Fields are private.
 * Positions count samples modulo 2^32 from the start (or the last restart). The window is
 * [received - length, received) (4.2). */
typedef struct {
    /** @privatesection */
    uint64_t origin;      /* sample index of position 0 */
    uint32_t received;    /* samples in since the start: the position of the next one */
    uint32_t length;      /* of the window */
    uint32_t next_length; /* of the next window, as the law decided */
    uint32_t wait;        /* samples until the next epoch is complete */
    uint32_t skip;        /* samples to omit until the grid of epochs after a restart */
    uint8_t phase;        /* how far it is from the start: a window_phase_t of the core */
} davar_window_t;

/** Boundaries that differences must not span, ascending. Fields are private.
 * A boundary g lies between the samples g - 1 and g. */
typedef struct {
    /** @privatesection */
    uint32_t *position;
    uint16_t capacity;
    uint16_t count;
} davar_gaps_t;

/** What a window remembers of the past. Fields are private. */
typedef struct {
    /** @privatesection */
    uint32_t level[2]; /* of the first sum of two windows, half a window apart (4.5); 0: none */
    uint32_t wait;     /* samples until the next one is kept */
    uint32_t equal;    /* with a stride: equal samples up to the newest epoch */
} davar_past_t;

struct davar_number;

/** One stream of one sensor axis. The caller owns it. Fields are private. */
typedef struct davar {
    /** @privatesection */
    const davar_config_t *config;
    const struct davar_number *number; /* the pipeline of its number type */
    void *stages;    /* that pipeline's state, at the start of the caller's memory */
    void *law_state; /* state of the window law, after it; null: none */
    davar_gaps_t gaps;
    float counts_per_unit; /* f32 only: a power of two */
    davar_window_t window;
    davar_health_t health;
    davar_past_t past;          /* fixed windows */
    volatile uint32_t sequence; /* odd while a push is at work */
    volatile uint32_t produced; /* results completed */
    volatile uint32_t seen;     /* the value of `produced` at the last take */
    bool ready;                 /* the sums match the newest result */
    uint32_t alarms_seen;       /* health.alarms at the last davar_glr_report */
    bool unstable;              /* the law's flag for that result */
    bool is_float;              /* f32: samples pass the input conversion of DESIGN 2.3 */
    uint8_t accepts; /* ACCEPTS_*: the one type that may be pushed; none after davar_flush */
    bool in_gap;     /* f32: inside a run of NaN or inf */
} davar_t;

/** @{ */
/** Bytes of memory for an instance, as a constant. DAVAR_MEMORY: configured by DAVAR_SONG (shortest
 * below longest) or DAVAR_FIXED (equal). DAVAR_MEMORY_GRID: the same on the grid.
 * Law glr: DAVAR_MEMORY_GLR (davar/glr.h). A wrong name or order of the arguments does not compile.
 * ```c
 * static uint64_t memory[DAVAR_MEMORY(Q15, longest(600), shortest(400), stride(60),
 *                                     largest(128), taus(8)) / 8];
 * ```
 * type: Q15, Q31 or F32. largest: the largest cluster size. Other settings: davar_memory_size_*,
 * which is exact. Source: DESIGN 6. */
#define DAVAR_MEMORY(type, a_longest, a_shortest, a_stride, a_largest, a_taus)                     \
    DAVAR_MEMORY_SLIDING(DAVAR_WORDS_##type, DAVAR_LONGEST_##a_longest,                            \
                         DAVAR_SEGMENT(a_longest, a_shortest), DAVAR_STRIDE_##a_stride,            \
                         DAVAR_LARGEST_##a_largest, DAVAR_TAUS_##a_taus, 4U)
#define DAVAR_MEMORY_GRID(type, a_longest, a_shortest, a_stride, a_largest, a_taus)                \
    DAVAR_MEMORY_ON_GRID(DAVAR_WORDS_##type, DAVAR_LONGEST_##a_longest,                            \
                         DAVAR_SHORTEST_##a_shortest, DAVAR_SEGMENT(a_longest, a_shortest),        \
                         DAVAR_STRIDE_##a_stride, DAVAR_LARGEST_##a_largest, DAVAR_TAUS_##a_taus,  \
                         4U)
/** @} */

/** @cond */
#define DAVAR_LONGEST_longest(samples) (samples)
#define DAVAR_SHORTEST_shortest(samples) (samples)
#define DAVAR_STRIDE_stride(samples) (samples)
#define DAVAR_LARGEST_largest(samples) (samples)
#define DAVAR_TAUS_taus(count) (count)
#define DAVAR_SEGMENT(a_longest, a_shortest)                                                       \
    ((DAVAR_LONGEST_##a_longest == DAVAR_SHORTEST_##a_shortest)                                    \
         ? 0U                                                                                      \
         : (DAVAR_SHORTEST_##a_shortest / 4U))

/* n: the words of a sample, 2 bytes each. W: longest. w: shortest. S: segment, 0 without moments.
 * K: stride. m: largest. T: taus. G: gaps. */
#define DAVAR_WORDS_Q15 1U
#define DAVAR_WORDS_Q31 2U
#define DAVAR_WORDS_F32 2U
#define DAVAR_ROUND8(bytes) (((bytes) + 7U) / 8U * 8U)
#define DAVAR_STAGES_BYTES(n) DAVAR_ROUND8(24U + ((size_t)72U * (n)) + (7U * sizeof(void *)))
#define DAVAR_SONG_BYTES 16U
#define DAVAR_GRID_BYTES DAVAR_ROUND8((size_t)76U + (16U * sizeof(void *)))
#define DAVAR_SUMS(n, T) ((size_t)8U * (n) * (T))
#define DAVAR_POWERS(n, S) ((((S) == 0U) ? (size_t)0U : (size_t)32U) * (n))
#define DAVAR_DUES(T) (2U * DAVAR_ROUND8((size_t)4U * (T)))
#define DAVAR_KEPT(n, S, K, T)                                                                     \
    (((K) == 1U) ? 0U : (8U + (2U * sizeof(void *)) + DAVAR_SUMS(n, T) + (2U * DAVAR_POWERS(n, S))))
#define DAVAR_COMMON(n, samples, S, K, T, G)                                                       \
    (DAVAR_STAGES_BYTES(n) + ((size_t)16U * (n) * (T)) +                                           \
     DAVAR_ROUND8((size_t)2U * (n) * (samples)) + DAVAR_ROUND8((size_t)4U * (G)) +                 \
     DAVAR_KEPT(n, S, K, T))
#define DAVAR_TAILS(W, w, K)                                                                       \
    (1U + (((((W) % (K)) != 0U) && ((W) != (w))) ? (size_t)1U : (size_t)0U) +                      \
     ((((w) % (K)) != 0U) && (((w) % (K)) != ((W) % (K))) ? (size_t)1U : (size_t)0U))
#define DAVAR_MEMORY_SLIDING(n, W, S, K, m, T, G)                                                  \
    (DAVAR_COMMON(n, (W) + (2U * (m)) + 1U, S, K, T, G) + DAVAR_SONG_BYTES)
#define DAVAR_MEMORY_ON_GRID(n, W, w, S, K, m, T, G)                                               \
    (DAVAR_COMMON(n, (4U * (m)) + 127U, S, K, T, G) + DAVAR_SONG_BYTES + DAVAR_GRID_BYTES +        \
     (DAVAR_TAILS(W, w, K) *                                                                       \
      ((((size_t)(W) / (K)) + 1U) * (DAVAR_SUMS(n, T) + DAVAR_POWERS(n, S)) + DAVAR_DUES(T))) +    \
     ((((size_t)(S) / (K)) + 1U) * DAVAR_POWERS(n, S)))
/** @endcond */

#ifdef __cplusplus
}
#endif

#endif
