/** @file
 * davar - the types: configuration in, results and counters out, one status per cause.
 *
 * Units are part of the names. Numbers in brackets cite formulas of lib/DESIGN.md and the pages it
 * links. */
#ifndef DAVAR_TYPES_H
#define DAVAR_TYPES_H

#include "davar/options.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Functions that fill a davar_result_t carry its size in their names: a library and a user that
 * disagree about DAVAR_TAUS_MAX do not link. */
/** @cond */
#define DAVAR_JOIN(name, count) name##_##count##_taus
#define DAVAR_EXPAND(name, count) DAVAR_JOIN(name, count)
#define DAVAR_SIZED(name) DAVAR_EXPAND(name, DAVAR_TAUS_MAX)
/** @endcond */

/** Why davar_init_* failed: one code per cause, with a value that never
 * changes. davar_status_text() describes it. */
typedef enum {
    DAVAR_OK = 0,               /**< no error */
    DAVAR_ERR_NULL = 1,         /**< a required pointer is null */
    DAVAR_ERR_BUILD = 2,        /**< disabled in this build (options.h) */
    DAVAR_ERR_MEMORY_SIZE = 3,  /**< memory smaller than davar_memory_size_*() */
    DAVAR_ERR_MEMORY_ALIGN = 4, /**< memory not aligned to 8 bytes */
    DAVAR_ERR_RATE = 5,         /**< rate_hz not a positive finite number */
    DAVAR_ERR_SCALE = 6,       /**< unit_per_count (f32: full_scale) not a positive finite number */
    DAVAR_ERR_SAMPLE_BITS = 7, /**< sample_bits outside 2..16 (q15) or 2..32 (q31) */
    DAVAR_ERR_LAW = 9,         /**< law of another number type */
    DAVAR_ERR_WINDOW_MAX = 10, /**< window.longest outside 4..65536 (q15) or 4..2^24 (q31, f32) */
    DAVAR_ERR_WINDOW_MIN = 11, /**< window.shortest outside 1..window.longest */
    /** moments.segment not below window.shortest, or 0 with a law that needs moments */
    DAVAR_ERR_SEGMENT = 13,
    DAVAR_ERR_KURTOSIS = 14,     /**< kurtosis bounds not finite, negative, or low > high */
    DAVAR_ERR_CONTRIBUTION = 15, /**< contribution bounds not finite, negative, or low > high */
    DAVAR_ERR_SHRINK = 17,       /**< window.shrink * stride above 2^31 - 1 */
    DAVAR_ERR_STRIDE = 18,       /**< stride 0 or above 2^24 */
    /** stride above window.longest: samples between two windows would never count */
    DAVAR_ERR_STRIDE_LONG = 19,
    DAVAR_ERR_ENGINE = 20, /**< engine of another number type */
    /** law glr: a setting of glr out of range (davar_config_t.glr), or window.longest below 8 or
     * above 768 blocks, or no window of whole blocks between shortest and longest */
    DAVAR_ERR_TRACKING = 21,
    DAVAR_ERR_TAU_COUNT = 22, /**< no cluster size, or more than DAVAR_TAUS_MAX */
    DAVAR_ERR_TAU_ORDER = 23, /**< cluster sizes not strictly ascending */
    DAVAR_ERR_TAU_ZERO = 24,  /**< cluster size 0 */
    DAVAR_ERR_TAU_LONG = 25,  /**< twice the longest cluster size is above window.longest */
    /** window.longest * m^2 exceeds the exact sums of this type (q15: use q31) */
    DAVAR_ERR_TAU_OVERFLOW = 26
} davar_status_t;

/** A window law: what decides how long the window is. One that is not named is not linked. Law glr
 * is in davar/glr.h. */
typedef struct davar_law davar_law_t;

/** Kurtosis alone ("DAVAR-K"). As the next two, after [SONG18] section 4: the window shrinks while
 * kurtosis or sliding contribution leave their bounds, and grows otherwise (4.1). */
extern const davar_law_t davar_law_kurtosis;
extern const davar_law_t davar_law_or;  /**< Kurtosis OR contribution: A-DAVAR of [SONG18]. */
extern const davar_law_t davar_law_and; /**< Kurtosis AND contribution. */

/** What law glr adds to a result. */
typedef struct davar_glr_reported davar_glr_report_t;

/** An engine: how a stride above 1 is computed. */
typedef struct davar_engine davar_engine_t;

/** @{ */
/** The grid: running sums, recorded where an edge of a window can be (2.7). The results are the same
 * as without an engine: fewer instructions for samples in blocks, more for single ones, and memory
 * that falls as the stride rises (docs/COST.md). Q15 is for int16 counts, Q31 for int32 counts and
 * floats. */
extern const davar_engine_t davar_engine_grid_q15;
extern const davar_engine_t davar_engine_grid_q31;
/** @} */

/** Settings. They may be const in flash and must outlive the instance. Start from
 * davar_default_config, or from an initialiser with DAVAR_SONG, DAVAR_FIXED or DAVAR_GLR_Q15
 * (davar/glr.h). */
typedef struct {
    double rate_hz;        /**< samples per second, 1e-50 to 1e50; no default */
    double unit_per_count; /**< q15, q31: deg/s per count, 1e-50 to 1e50; no default */
    /** f32: largest |rate| expected, deg/s, 1e-20 to 1e20; from here on samples saturate */
    double full_scale;
    /** width of a count: q15 2 to 16, q31 2 to 32; 0: 16 or 24. Wider counts saturate */
    uint8_t sample_bits;
    /** what decides the window's length; null: always longest. Default davar_law_or */
    const davar_law_t *law;

    /** The window, in samples. */
    struct {
        uint32_t longest; /**< default 600. Longer: narrower intervals, slower to follow a change */
        uint32_t shortest; /**< default 400. Shorter: sharper in a disturbance, wider intervals */
        uint32_t grow;     /**< growth per sample while stable, 0 or 1 (above 1: as 1); default 1 */
        /** shrinkage per sample while unstable; default 2. Law glr: at least 64 */
        uint32_t shrink;
        /** gaps that a window stores; one more restarts it. Default 4. Law glr: shocks too */
        uint16_t gaps_max;
    } window;

    /** Kurtosis and sliding contribution ([SONG18]), for the laws that use them and for the
     * result. */
    struct {
        /** short segment l, samples; default 100. 0: no moments (fixed window, glr) */
        uint32_t segment;
        double kurtosis_low;      /**< K1; default 2.5 */
        double kurtosis_high;     /**< K2; default 3.3 */
        double contribution_low;  /**< S1; default 0 */
        double contribution_high; /**< S2; default 0.07 */
    } moments;

    /** Law glr only (10). */
    struct {
        /** accepted in unchanged noise, 1e-9 to 1e9; default 0.01 (10.6) */
        double false_alarms_per_hour;
        double cut_interval_s; /**< between windows cut without need, 1e-9 to 1e9; default 300 */
        uint32_t block; /**< samples of a block, 5 to 64; default 10. Longer: less work, later */
        /** a shock of up to that many blocks counts as a gap, 0 to 2; default 2 */
        uint32_t shock_blocks;
        /** @{ */
        /** whitening after a filter: the detector takes x[i] - (whiten_first x[i-1] +
         * whiten_second x[i-2]) / 2^14. |first| + |second| at most 49152. 0, 0 (default): the
         * samples. davar_whiten sets all four (10.16) */
        int16_t whiten_first;
        int16_t whiten_second;
        /** @} */
        /** with whitening: white noise before the filter over that of the whitened samples about
         * the mean of their block, 1e-9 to 1e9; levels are multiplied by it */
        double whiten_level;
        /** relative 95 % uncertainty of whiten_level, 0 to 100; the interval of the level since the
         * last alarm includes it */
        double whiten_tolerance;
    } glr;

    uint32_t stride; /**< samples from one result to the next, 1 to longest; default 1 */
    /** for a stride above 1. Null, the default: sums follow both edges of the window (2.9), at the
     * same cost for every sample. Law glr names the grid itself. An engine that is not named is not
     * linked */
    const davar_engine_t *engine;
    const uint32_t *taus; /**< cluster sizes m in samples, strictly ascending; tau = m / rate_hz */
    uint8_t tau_count;    /**< 1 to DAVAR_TAUS_MAX */
} davar_config_t;

/** Windows of up to `longest` samples that A-DAVAR ([SONG18]) shrinks to `shortest`; part of an
 * initialiser of davar_config_t:
 * ```c
 * static const uint32_t taus[] = {1, 2, 4, 8, 16, 32, 64, 128};
 * static const davar_config_t config = {
 *     .rate_hz = 100.0, .unit_per_count = 0.05, .stride = 60, DAVAR_SONG(600, 400),
 *     .taus = taus, .tau_count = 8};
 * ``` */
#define DAVAR_SONG(longest_samples, shortest_samples)                                              \
    .law = &davar_law_or,                                                                          \
    .window = {.longest = (longest_samples),                                                       \
               .shortest = (shortest_samples),                                                     \
               .grow = 1U,                                                                         \
               .shrink = 2U,                                                                       \
               .gaps_max = 4U},                                                                    \
    .moments = {.segment = (shortest_samples) / 4U,                                                \
                .kurtosis_low = 2.5,                                                               \
                .kurtosis_high = 3.3,                                                              \
                .contribution_high = 0.07}

/** A window that stays `longest` samples long. */
#define DAVAR_FIXED(longest_samples)                                                               \
    .law = NULL,                                                                                   \
    .window = {.longest = (longest_samples), .shortest = (longest_samples), .gaps_max = 4U}

/** Counts of input faults since the last reset, and of the detector's events. They stop at their
 * largest value. */
typedef struct {
    uint32_t gaps; /**< calls of davar_gap, and runs of NaN or inf */
    /** samples lost in those gaps, or rejected: pushed as another type, or after davar_flush */
    uint32_t missing;
    /** samples at or above the limit of their type, bits or full scale; they are used, clamped */
    uint32_t saturated;
    uint32_t not_finite; /**< NaN or inf in float input; each run is a gap */
    /** windows discarded because of more than gaps_max gaps, with up to stride - 1 samples each */
    uint32_t restarts;
    uint32_t missed; /**< results replaced before they were read */
    uint32_t cuts;   /**< law glr: windows cut */
    uint32_t alarms; /**< law glr: alarms raised */
    uint32_t shocks; /**< law glr: shocks treated as gaps */
} davar_health_t;

/** Unit of davar_adev_t.uneven: the noise was equally strong all the time. */
#define DAVAR_EVEN 256U

/** One cluster size of a result. */
typedef struct {
    uint32_t m;           /**< cluster size, samples */
    uint32_t differences; /**< number of differences D; 0: the window is too short for this tau */
    /** overlapping Allan deviation, deg/s; NaN if differences is 0 (1.1). It includes rounding to
     * counts, which the coefficients do not (5.15) */
    double adev;
    /** lower limit of the 95 % interval of white noise or powers of tau, deg/s (5.2); too narrow next
     * to lines and in motion (5.25). NaN if absent, and before davar_fit */
    double low;
    double high; /**< upper limit, as low; may be infinite */
    double edf;  /**< equivalent degrees of freedom (5.1); NaN before davar_fit */
    /** relative power of the noise over the time that this size of a cascade remembers; the longest
     * size has 1 (11.9). A cascade sets it, to 1 for the sizes of a window */
    float power;
    /** how unevenly that power was spread, set with it: DAVAR_EVEN if it was constant, n DAVAR_EVEN
     * if it came from 1 / n of the time; at most 65535 */
    uint16_t uneven;
    /** size of a cascade: its differences are m / hops samples apart, hops = 4 or 8, and look back
     * over 2 m + (differences - 1) m / hops samples (11.5). 0: size of a window, a difference for
     * every sample */
    uint8_t hops;
} davar_adev_t;

/** The five noise coefficients, in the order of the powers of tau. */
typedef enum {
    DAVAR_QUANTIZATION = 0,  /**< Q, deg */
    DAVAR_ANGLE_RANDOM_WALK, /**< N, deg/sqrt(h) */
    DAVAR_BIAS_INSTABILITY,  /**< B, deg/h */
    DAVAR_RATE_RANDOM_WALK,  /**< K, deg/h/sqrt(h) */
    DAVAR_RATE_RAMP,         /**< R, deg/h^2 */
    DAVAR_COEFFICIENT_COUNT  /**< number of coefficients */
} davar_coefficient_kind_t;

/** A coefficient: resolved with a 95 % interval, or absent with an upper bound. */
typedef struct {
    /** false: the window does not resolve this term; value and low are NaN, high is the 95 % upper
     * bound */
    bool present;
    double value; /**< in the unit of its kind */
    double low;   /**< lower limit of the 95 % interval, same unit */
    double high;  /**< upper limit, same unit */
} davar_coefficient_t;

/** What a fit found in the window. */
typedef enum {
    /** not fitted yet, or too few cluster sizes of the plan have a difference in this window */
    DAVAR_NOISE_UNKNOWN = 0,
    DAVAR_NOISE_WHITE, /**< white noise explains the window: the angle random walk is present */
    /** white noise alone does not. davar_fit_white gives an upper bound of the angle random walk,
     * davar_fit_flat perhaps its value; davar_fit separates the terms */
    DAVAR_NOISE_MIXED,
    /** every difference is 0, or more of the newest samples are equal than in noise (5.24): the noise
     * is below one count, or the sensor is stuck */
    DAVAR_NOISE_CONSTANT,
    /** the noise is below about half a count and hidden by rounding (5.15). Every coefficient is
     * absent; the angle random walk has an upper bound. Use a finer count: a smaller range, or more
     * bits */
    DAVAR_NOISE_COARSE,
    /** the short cluster sizes read low, as after a low-pass that is not declared (5.17), or
     * contradict the declared filter (5.16). Every coefficient is absent; the angle random walk has
     * an upper bound (davar_fit_flat). Declare the filter: davar_plan_init_filtered */
    DAVAR_NOISE_FILTERED
} davar_noise_t;

/** The result of one epoch. */
typedef struct {
    uint64_t epoch;          /**< the newest sample of the window: its index from 0 */
    uint32_t window_samples; /**< length L of the window */
    /** of these, mirror images of others in the window, which carry no information (5.13). 0; a
     * program that extends a record by its mirror image, as davar-sim does, sets it for davar_fit
     */
    uint32_t mirrored_samples;
    uint32_t gaps_in_window; /**< gaps inside this window */
    uint32_t equal_samples;  /**< newest samples that are equal; above 1024 perhaps more */
    /** the law's flag f. Fixed window: the noise has changed within the last two windows
     * (4.5), or f1 OR f2, for information. glr: cut since the previous epoch */
    bool unstable;
    /** the law chose this window by its data: law glr has just cut it, is about to, or excludes
     * more than half of the samples since the cut. The intervals are wider and cover less often
     * (10.14) */
    bool chosen;
    uint8_t tau_count;   /**< number of entries of tau, as configured */
    davar_noise_t noise; /**< what davar_fit or davar_fit_white found */
    uint32_t flat_from;  /**< shortest cluster size that ARW of davar_fit_flat is from; 0: of all */
    uint32_t flat_to;    /**< longest one */
    /** q15, q31: size of a count; the fit subtracts its rounding (5.15). f32: 0, unknown */
    double unit_per_count;
    double kurtosis;     /**< of the whole window; NaN if its variance is 0 (3.1) */
    double contribution; /**< |K - Km| / K; NaN if K or Km is undefined (3.2) */
    /** how much more the noise scatters than Gaussian noise, 1 to below 16, where the law measures
     * it: f of glr (10.3). Otherwise NaN */
    double dispersion;
    davar_adev_t tau[DAVAR_TAUS_MAX]; /**< the cluster sizes, ascending */
    /** by davar_coefficient_kind_t, from davar_fit or davar_fit_white; absent before */
    davar_coefficient_t coefficient[DAVAR_COEFFICIENT_COUNT];
} davar_result_t;

#ifdef __cplusplus
}
#endif

#endif
