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
 * [received - lag - length, received - lag). DESIGN (4.2). */
typedef struct {
    /** @privatesection */
    uint64_t origin;      /* sample index of position 0 */
    uint32_t received;    /* samples in since the start: the position of the next one */
    uint32_t lag;         /* on a grid: samples since the end of the window; otherwise 0 */
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
    volatile uint32_t sequence; /* odd while a push is at work */
    volatile uint32_t produced; /* results completed */
    volatile uint32_t seen;     /* the value of `produced` at the last take */
    bool ready;                 /* the sums match the newest result */
    uint32_t alarms_seen;       /* health.alarms at the last take */
    bool unstable;              /* the law's flag for that result */
    bool is_float;              /* f32: samples pass the input conversion of DESIGN 2.3 */
    uint8_t accepts; /* ACCEPTS_*: the one type that may be pushed; none after davar_flush */
    bool in_gap;     /* f32: inside a run of NaN or inf */
} davar_t;

/** Bytes of memory for an instance configured by DAVAR_SONG or DAVAR_FIXED, as a constant.
 * The arguments are the settings by name, in this order; a wrong name or order does not compile.
 * ```c
 * static uint64_t memory[DAVAR_MEMORY(Q15, longest(600), shortest(400), stride(60),
 *                                     largest(128), taus(8)) / 8];
 * ```
 * type: Q15, Q31 or F32. largest: the largest cluster size. A fixed window has shortest equal to
 * longest, and no moments. For DAVAR_ENGINE_GRID, use DAVAR_MEMORY_GRID_*. Source: DESIGN 6. */
#define DAVAR_MEMORY(type, a_longest, a_shortest, a_stride, a_largest, a_taus)                     \
    DAVAR_MEMORY_NUMBERS(type, DAVAR_NUMBER_OF_LONGEST_##a_longest,                                \
                         DAVAR_NUMBER_OF_SHORTEST_##a_shortest, DAVAR_NUMBER_OF_STRIDE_##a_stride, \
                         DAVAR_NUMBER_OF_LARGEST_##a_largest, DAVAR_NUMBER_OF_TAUS_##a_taus)
/** @cond */
#define DAVAR_NUMBER_OF_LONGEST_longest(samples) samples
#define DAVAR_NUMBER_OF_SHORTEST_shortest(samples) samples
#define DAVAR_NUMBER_OF_STRIDE_stride(samples) samples
#define DAVAR_NUMBER_OF_LARGEST_largest(samples) samples
#define DAVAR_NUMBER_OF_TAUS_taus(count) count
#define DAVAR_MEMORY_NUMBERS(type, W, w, K, m, T)                                                  \
    DAVAR_ROUND8(DAVAR_MEMORY_##type(W, m, T, 4U) +                                                \
                 (((K) == 1) ? 0U : DAVAR_MEMORY_STRIDE_##type((W) - (w), T)))
#define DAVAR_ROUND8(bytes) (((bytes) + 7U) / 8U * 8U)
#define DAVAR_STAGES_BYTES_Q15 ((size_t)96U + (6U * sizeof(void *)))
#define DAVAR_STAGES_BYTES_Q31 ((size_t)168U + (6U * sizeof(void *)))
#define DAVAR_SONG_BYTES 16U
/** @endcond */

/** @{ */
/** The formulas of DAVAR_MEMORY, for other settings, in bytes.
 * They hold for a result at every sample (stride 1). For a stride above 1, add DAVAR_MEMORY_STRIDE_*. For DAVAR_ENGINE_GRID,
 * use DAVAR_MEMORY_GRID_*, for law glr with a stride above 1 DAVAR_MEMORY_GLR_*. Otherwise call
 * davar_memory_size_*. Every sample of the window and of the longest span takes 2 bytes (q15) or 4
 * (q31, f32). Source: DESIGN 6. */
#define DAVAR_MEMORY_Q15(window_max, m_max, taus, gaps)                                            \
    (DAVAR_STAGES_BYTES_Q15 + DAVAR_SONG_BYTES + ((size_t)16U * (taus)) +                          \
     DAVAR_ROUND8((size_t)2U * ((window_max) + (2U * (m_max)) + 1U)) +                             \
     DAVAR_ROUND8((size_t)4U * (gaps)))
#define DAVAR_MEMORY_Q31(window_max, m_max, taus, gaps)                                            \
    (DAVAR_STAGES_BYTES_Q31 + DAVAR_SONG_BYTES + ((size_t)32U * (taus)) +                          \
     DAVAR_ROUND8((size_t)4U * ((window_max) + (2U * (m_max)) + 1U)) +                             \
     DAVAR_ROUND8((size_t)4U * (gaps)))
#define DAVAR_MEMORY_F32(window_max, m_max, taus, gaps)                                            \
    DAVAR_MEMORY_Q31(window_max, m_max, taus, gaps)
/** @} */

/** @{ */
/** What a stride above 1 adds to DAVAR_MEMORY_*, in bytes: the sums of the newest result and,
 * unless moments.segment is 0, its moments. Source: DESIGN 2.9. */
#define DAVAR_MEMORY_STRIDE_Q15(segment, taus)                                                     \
    ((size_t)8U + (2U * sizeof(void *)) + ((size_t)8U * (taus)) + (((segment) == 0U) ? 0U : 64U))
#define DAVAR_MEMORY_STRIDE_Q31(segment, taus)                                                     \
    ((size_t)8U + (2U * sizeof(void *)) + ((size_t)16U * (taus)) + (((segment) == 0U) ? 0U : 128U))
#define DAVAR_MEMORY_STRIDE_F32(segment, taus) DAVAR_MEMORY_STRIDE_Q31(segment, taus)
/** @} */

/** @cond */
#define DAVAR_GRID_BYTES DAVAR_ROUND8((size_t)92U + (25U * sizeof(void *)))
#define DAVAR_GRID_TAILS(window_max, window_min, stride)                                           \
    ((((window_min) == 0U) || (((window_max) % (stride)) == 0U) ? 1U : 2U) +                       \
     ((((window_min) != 0U) && (((window_min) % (stride)) != 0U) &&                                \
       (((window_min) % (stride)) != ((window_max) % (stride))))                                   \
          ? (size_t)1U                                                                             \
          : (size_t)0U))
#define DAVAR_GRID_RECORDS(window_max, window_min, segment, stride, sums, powers, dues)            \
    ((DAVAR_GRID_TAILS(window_max, window_min, stride) *                                           \
      (((((size_t)(window_max) / (stride)) + 2U) * ((sums) + (powers))) + (dues))) +               \
     ((size_t)2U * ((sums) + (powers))) + ((((size_t)(segment) / (stride)) + 2U) * (powers)))
/** @endcond */

/** @{ */
/** The same for DAVAR_ENGINE_GRID (stride above 1), in bytes.
 * window_min 0: a fixed window. The fewest records are needed where the stride divides both lengths.
 * Source: DESIGN 2.7. */
#define DAVAR_MEMORY_GRID_Q15(window_max, window_min, segment, stride, m_max, taus, gaps)          \
    (DAVAR_STAGES_BYTES_Q15 + DAVAR_SONG_BYTES + ((size_t)16U * (taus)) +                          \
     DAVAR_ROUND8((size_t)2U * ((4U * (m_max)) + 127U)) + DAVAR_ROUND8((size_t)4U * (gaps)) +      \
     DAVAR_GRID_BYTES +                                                                            \
     DAVAR_GRID_RECORDS(window_max, window_min, segment, stride, (size_t)8U * (taus), 32U,         \
                        2U * DAVAR_ROUND8((size_t)4U * (taus))))
#define DAVAR_MEMORY_GRID_Q31(window_max, window_min, segment, stride, m_max, taus, gaps)          \
    (DAVAR_STAGES_BYTES_Q31 + DAVAR_SONG_BYTES + ((size_t)32U * (taus)) +                          \
     DAVAR_ROUND8((size_t)4U * ((4U * (m_max)) + 127U)) + DAVAR_ROUND8((size_t)4U * (gaps)) +      \
     DAVAR_GRID_BYTES +                                                                            \
     DAVAR_GRID_RECORDS(window_max, window_min, segment, stride, (size_t)16U * (taus), 64U,        \
                        2U * DAVAR_ROUND8((size_t)4U * (taus))))
#define DAVAR_MEMORY_GRID_F32(window_max, window_min, segment, stride, m_max, taus, gaps)          \
    DAVAR_MEMORY_GRID_Q31(window_max, window_min, segment, stride, m_max, taus, gaps)
/** @} */

/** @cond */
#define DAVAR_GLR_BYTES_Q15 ((size_t)1032U)
#define DAVAR_GLR_BYTES_Q31 ((size_t)1032U + (2U * sizeof(void *)))
#define DAVAR_GLR_RECORDS(window_max, stride, block)                                               \
    (((((size_t)(window_max) + (stride)) / (block)) + 2U) + 2U)
/** @endcond */

/** @{ */
/** The same for law glr with a stride above 1 and no moments (moments.segment 0),
 * in bytes. Such a grid records at every block of `block` samples. Source: DESIGN 6. */
#define DAVAR_MEMORY_GLR_Q15(window_max, stride, block, m_max, taus, gaps)                         \
    (DAVAR_STAGES_BYTES_Q15 + ((size_t)16U * (taus)) +                                             \
     DAVAR_ROUND8((size_t)2U * ((4U * (m_max)) + 127U)) + DAVAR_ROUND8((size_t)4U * (gaps)) +      \
     DAVAR_GRID_BYTES + (2U * DAVAR_ROUND8((size_t)4U * (taus))) +                                 \
     (DAVAR_GLR_RECORDS(window_max, stride, block) * (size_t)8U * (taus)) + DAVAR_GLR_BYTES_Q15 +  \
     DAVAR_ROUND8((size_t)2U * 5U * (block)))
#define DAVAR_MEMORY_GLR_Q31(window_max, stride, block, m_max, taus, gaps)                         \
    (DAVAR_STAGES_BYTES_Q31 + ((size_t)32U * (taus)) +                                             \
     DAVAR_ROUND8((size_t)4U * ((4U * (m_max)) + 127U)) + DAVAR_ROUND8((size_t)4U * (gaps)) +      \
     DAVAR_GRID_BYTES + (2U * DAVAR_ROUND8((size_t)4U * (taus))) +                                 \
     (DAVAR_GLR_RECORDS(window_max, stride, block) * (size_t)16U * (taus)) + DAVAR_GLR_BYTES_Q31 + \
     DAVAR_ROUND8((size_t)4U * 5U * (block)))
#define DAVAR_MEMORY_GLR_F32(window_max, stride, block, m_max, taus, gaps)                         \
    DAVAR_MEMORY_GLR_Q31(window_max, stride, block, m_max, taus, gaps)
/** @} */

#ifdef __cplusplus
}
#endif

#endif
