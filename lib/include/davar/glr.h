/** @file
 * davar - law glr: a likelihood ratio lets the window begin where the noise last changed (10), and
 * reports the change.
 *
 * Its settings are davar_config_t.glr. A program links the law only if it names it, and the report
 * only if it calls davar_glr_report. */
#ifndef DAVAR_GLR_H
#define DAVAR_GLR_H

#include "davar/instance.h"

#ifdef __cplusplus
extern "C" {
#endif

/** @{ */
/** The law. Q15 is for davar_init_q15, Q31 for davar_init_q31 and davar_init_f32. */
extern const davar_law_t davar_law_glr_q15;
extern const davar_law_t davar_law_glr_q31;
/** @} */

/** @{ */
/** Windows of up to `blocks` blocks of 10 samples that begin where the noise last changed; part of
 * an initialiser of davar_config_t, as DAVAR_SONG. For other settings of davar_config_t.glr, change
 * the configuration before init. */
#define DAVAR_GLR_Q15(blocks) .law = &davar_law_glr_q15, DAVAR_GLR_SETTINGS(blocks)
#define DAVAR_GLR_Q31(blocks) .law = &davar_law_glr_q31, DAVAR_GLR_SETTINGS(blocks)
/** @} */

/** Bytes of memory for an instance configured by DAVAR_GLR_*, stride above 1, as DAVAR_MEMORY.
 * longest: samples, ten for each block. */
#define DAVAR_MEMORY_GLR(type, a_longest, a_largest, a_taus)                                       \
    DAVAR_MEMORY_OF_GLR(DAVAR_WORDS_##type, DAVAR_LONGEST_##a_longest, 10U,                        \
                        DAVAR_LARGEST_##a_largest, DAVAR_TAUS_##a_taus, 4U)

/** @cond */
#define DAVAR_GLR_SETTINGS(blocks)                                                                 \
    .window = {.longest = 10U * (blocks),                                                          \
               .shortest = 20U,                                                                    \
               .grow = 1U,                                                                         \
               .shrink = 64U,                                                                      \
               .gaps_max = 4U},                                                                    \
    .glr = {                                                                                       \
        .false_alarms_per_hour = 0.01, .cut_interval_s = 300.0, .block = 10U, .shock_blocks = 2U}

/* b: block. The other letters: instance.h. */
#define DAVAR_GLR_BYTES(n) DAVAR_ROUND8(1032U + (((size_t)(n)-1U) * 2U * sizeof(void *)))
#define DAVAR_MEMORY_OF_GLR(n, W, b, m, T, G)                                                      \
    (DAVAR_COMMON(n, (4U * (m)) + 127U, 0U, 2U, T, G) + DAVAR_GRID_BYTES +                         \
     ((((size_t)(W) / (b)) + 1U) * DAVAR_SUMS(n, T)) + DAVAR_DUES(T) + DAVAR_GLR_BYTES(n) +        \
     DAVAR_ROUND8((size_t)10U * (n) * (b)))
/** @endcond */

/** The two levels that the newest alarm distinguished (10.12), in deg/s: standard deviations of a
 * sample about the mean of its block. If the noise is white, a level is the Allan deviation at
 * m = 1, and times 60 / sqrt(rate_hz) it is ARW in deg/sqrt(h). With whitening, the levels are
 * those before the filter (10.16). */
typedef struct {
    uint32_t m; /**< 1; 0: no alarm yet, the rest is NaN */
    /** level between the previous change and this one, over at most the longest window */
    double older;
    double newer; /**< level since this change; it improves with every block */
    double gain;  /**< logarithm of the likelihood ratio that raised the alarm */
} davar_change_t;

/** The noise since the last alarm, with a confidence sequence: an interval for every moment
 * (10.18). A 95 % interval of a window misses the truth in one window of twenty. If the noise does
 * not change, all intervals of a section contain it, with a probability of 95 %. A section ends at
 * an alarm, or without one if its noise has changed slowly. Between a change and its alarm, the
 * intervals may miss the new level.
 * Levels are in deg/s as in davar_change_t, but without rounding to counts. */
typedef struct {
    /** accepted samples of the section; 0: too few, counts too coarse, or dispersion above 5 now or
     * in the last 2^14 blocks, and the rest is NaN */
    uint64_t samples;
    double level; /**< of the section */
    double low;   /**< lower limit */
    double high;  /**< upper limit; it includes shocks, because they may be noise */
} davar_steady_t;

/** What the law adds to a result. The tag is not the name of a function (MISRA 5.7). */
struct davar_glr_reported {
    /** that of the newest result, which a push may have completed after davar_take */
    uint64_t epoch;
    uint32_t cut_age_samples; /**< samples since the newest change, at that epoch */
    /** the window was cut at most eight blocks ago, or is about to be. The estimate is biased
     * towards the data that triggered the cut, or still contains older noise (10.14) */
    bool young;
    bool alarm;            /**< an alarm since the previous report */
    davar_change_t change; /**< the newest change */
    davar_steady_t steady; /**< the level since the last alarm */
};

/** Reports on the newest result and the noise so far. Call it once for a result, directly after
 * davar_take: `alarm` is true in one report. With another law, everything is absent (0, false,
 * NaN).
 *
 * Threads: consumer, as davar_take; if a push interrupts it, it re-reads until its copy is
 * consistent, so that from time to time a few hundred instructions must pass without a push. Cost:
 * O(1). */
void davar_glr_report(davar_t *davar, davar_glr_report_t *report);

#ifdef __cplusplus
}
#endif

#endif
