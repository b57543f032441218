/* davar - the nouns: configuration in, result and health out, one status per cause.
 * Units are in the names; numbers in brackets cite the formulas of lib/DESIGN.md. */
#ifndef DAVAR_TYPES_H
#define DAVAR_TYPES_H

#include "davar/options.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Functions that fill a davar_result_t carry its size in their names: a library and a user that disagree about
 * DAVAR_TAUS_MAX do not link. */
#define DAVAR_JOIN(name, count) name##_##count##_taus
#define DAVAR_EXPAND(name, count) DAVAR_JOIN(name, count)
#define DAVAR_SIZED(name) DAVAR_EXPAND(name, DAVAR_TAUS_MAX)

/* Why init (or restoring a state) refused. One code per cause; davar_status_text() says it in words. */
typedef enum {
    DAVAR_OK = 0,
    DAVAR_ERR_NULL,         /* a pointer that must not be null is null */
    DAVAR_ERR_BUILD,        /* left out of this build (options.h) */
    DAVAR_ERR_MEMORY_SIZE,  /* memory smaller than davar_memory_size_*() */
    DAVAR_ERR_MEMORY_ALIGN, /* memory not aligned to 8 bytes */
    DAVAR_ERR_RATE,         /* rate_hz not a positive finite number */
    DAVAR_ERR_SCALE,        /* unit_per_count (or full_scale for f32) not a positive finite number */
    DAVAR_ERR_SAMPLE_BITS,  /* sample_bits outside 2..16 (q15) or 2..32 (q31) */
    DAVAR_ERR_MODE,         /* mode not in davar_mode_t */
    DAVAR_ERR_LAW,          /* law of another number type */
    DAVAR_ERR_WINDOW_MAX,   /* window_max outside 4..65536 (q15) or 4..2^24 (q31, f32) */
    DAVAR_ERR_WINDOW_MIN,   /* window_min outside 1..window_max */
    DAVAR_ERR_WINDOW_ODD,   /* window_max or window_min odd in centred mode */
    DAVAR_ERR_SEGMENT,      /* segment not smaller than window_min, or 0 with a policy other than fixed and glr */
    DAVAR_ERR_KURTOSIS,     /* kurtosis bounds not finite, negative, or low > high */
    DAVAR_ERR_CONTRIBUTION, /* contribution bounds not finite, negative, or low > high */
    DAVAR_ERR_STEP,         /* grow or shrink moves an edge backwards (centred: 0 or 2) */
    DAVAR_ERR_SHRINK,       /* shrink * stride beyond 2^31 - 1 */
    DAVAR_ERR_STRIDE,       /* stride 0 or above 2^24 */
    DAVAR_ERR_STRIDE_LONG,  /* stride above window_max: the samples between two windows would never count */
    DAVAR_ERR_ENGINE,       /* engine not in davar_engine_t; or EDGES for policy glr with a stride above 1 */
    DAVAR_ERR_TRACKING, /* policy glr: block outside 5..64; shock_blocks above 2; long_cluster no multiple of four blocks, or above 512;
                                window_max below 8 or above 768 blocks; on a grid, no window of whole
                                blocks from window_min to window_max (one that ends within a block: window_max - block + 1); a rate
                                or interval outside 1e-9 .. 1e9; centred: two halves (see mode) above window_max */
    DAVAR_ERR_TAU_COUNT,     /* no cluster size, or more than DAVAR_TAUS_MAX */
    DAVAR_ERR_TAU_ORDER,     /* cluster sizes not strictly ascending */
    DAVAR_ERR_TAU_ZERO,      /* cluster size 0 */
    DAVAR_ERR_TAU_LONG,      /* twice the longest cluster size is above window_max */
    DAVAR_ERR_TAU_OVERFLOW,  /* window_max * m^2 beyond the exact accumulators of this type (q15: take q31) */
    DAVAR_ERR_STATE_STORAGE, /* state: a slot is too small, or the storage failed */
    DAVAR_ERR_STATE_NONE,    /* state: no whole image */
    DAVAR_ERR_STATE_FOREIGN  /* state: an image of another version, number type, configuration or machine */
} davar_status_t;

/* What decides the length of the window (davar/law.h). */
typedef struct davar_law davar_law_t;

/* Where the epoch sits in its window. DESIGN (4.2). */
typedef enum {
    DAVAR_MODE_CENTRED =
        0, /* epoch in the middle, ends mirrored, latency window_max / 2; glr: 30 blocks, at most 300 samples */
    DAVAR_MODE_TRAILING /* epoch is the newest sample, no latency */
} davar_mode_t;

/* How a stride above 1 is served: the same results, bit for bit, at another price (docs/COST.md). DESIGN (2.7), (2.9). */
typedef enum {
    DAVAR_ENGINE_GRID =
        0,             /* running sums, recorded where an edge can be: the least work; memory falls with the stride */
    DAVAR_ENGINE_EDGES /* sums that follow both edges, as at stride 1, when a result is due: the least memory for a short stride */
} davar_engine_t;

/* Settings. Must outlive the instance (it may live in flash). Start from davar_default_config. */
typedef struct {
    double rate_hz;        /* samples per second, 1e-50 .. 1e50; no default */
    double unit_per_count; /* q15, q31: deg/s per count, 1e-50 .. 1e50; no default */
    double full_scale;   /* f32: largest |rate| expected, deg/s, 1e-20 .. 1e20; from it on samples saturate (counted) */
    uint8_t sample_bits; /* q15: 2..16, q31: 2..32: width of a count; beyond it samples saturate. 0: 16 or 24 */
    davar_mode_t mode;   /* default centred */
    const davar_law_t *law;   /* null: window_max always. Default davar_law_or (A-DAVAR) */
    uint32_t window_max;      /* samples; default 600. Longer: better confidence, slower to see a change */
    uint32_t window_min;      /* samples; default 400. Shorter: sharper in a disturbance, wider intervals */
    uint32_t segment;         /* samples of the short segment l; default 100. 0 (policies fixed, glr): no moments */
    double kurtosis_low;      /* K1; default 2.5 */
    double kurtosis_high;     /* K2; default 3.3 */
    double contribution_low;  /* S1; default 0 */
    double contribution_high; /* S2; default 0.07 */
    uint32_t grow;            /* samples the window grows per sample when stable; default 2 (trailing: at most 1) */
    uint32_t
        shrink; /* samples the window shrinks per sample when unstable; default 2. glr: values below 64 act as 64 */
    uint32_t stride; /* K: 1 = a value at every sample, K = a result every K samples, at most window_max; default 1 */
    davar_engine_t engine;        /* what serves a stride above 1; default grid */
    double false_alarms_per_hour; /* glr: that you accept in noise that does not change; default 0.01 (10.6) */
    double cut_interval_s;        /* glr: between windows cut in vain; default 300 */
    uint32_t block;               /* glr: K, samples of a block, 5..64; default 10. Longer: cheaper, later */
    uint32_t shock_blocks;        /* glr: blocks that a shock may last, which are left out as a gap, 0..2; default 2 */
    /* glr: a second channel sees changes of clusters of so many samples: 4 block times 1, 2, 3 .., up to 512. Default 0: none, and
     * no memory for it. */
    uint32_t long_cluster;
    const uint32_t *taus; /* cluster sizes m in samples, strictly ascending; tau = m / rate_hz */
    uint8_t tau_count;    /* 1..DAVAR_TAUS_MAX */
    /* Gaps that a window can remember; one more restarts it (counted). glr: shocks too, for window_max samples; one more is joined.
     * Default 4. */
    uint16_t gaps_max;
    bool mirrored_end; /* keep what davar_flush needs; only a grid pays for it: window_max - 2 m_max samples */
} davar_config_t;

/* Weather: things the world did, counted, never fatal. Saturating counters. */
typedef struct {
    uint32_t gaps;       /* davar_gap calls, and runs of NaN or inf */
    uint32_t missing;    /* samples lost in those gaps, or refused: of another type than init's, or after davar_flush */
    uint32_t saturated;  /* samples at or beyond the limit of their type, bits or full scale (used, clamped) */
    uint32_t not_finite; /* NaN or inf in float input (left out: a gap) */
    uint32_t restarts;   /* windows thrown away because gaps_max was exceeded; with them up to stride - 1 samples */
    uint32_t missed;     /* results overwritten before they were taken */
    uint32_t cuts;       /* glr: windows cut */
    uint32_t alarms;     /* glr: alarms raised */
    uint32_t shocks;     /* glr: shocks left out */
} davar_health_t;

/* One cluster size of a result. */
typedef struct {
    uint32_t m;           /* cluster size, samples */
    uint32_t differences; /* differences D that the estimate rests on; 0: the window cannot support this tau */
    double
        adev; /* overlapping Allan deviation, unit of the rate (deg/s); NaN when differences is 0 (1.1). Of the samples as
                             they are: rounding to counts is in it, unlike in the coefficients (5.15) */
    double low; /* 95 % interval from chi-square and edf (5.2); NaN when absent, and until davar_fit */
    double high;
    double edf; /* equivalent degrees of freedom (5.1); NaN until davar_fit */
} davar_adev_t;

/* The five noise coefficients, in the order of the powers of tau. */
typedef enum {
    DAVAR_QUANTIZATION = 0,  /* Q, deg */
    DAVAR_ANGLE_RANDOM_WALK, /* N, deg/sqrt(h) */
    DAVAR_BIAS_INSTABILITY,  /* B, deg/h */
    DAVAR_RATE_RANDOM_WALK,  /* K, deg/h/sqrt(h) */
    DAVAR_RATE_RAMP,         /* R, deg/h^2 */
    DAVAR_COEFFICIENT_COUNT
} davar_coefficient_kind_t;

/* A coefficient: resolved with a 95 % interval, or absent with an upper bound. */
typedef struct {
    bool present; /* false: the window cannot resolve this term; value and low are NaN, high is the 95 % upper bound */
    double value; /* in the unit of its kind */
    double low;
    double high;
} davar_coefficient_t;

/* glr: what the newest alarm told apart (10.12). Both levels are Allan deviations at m samples, in the unit of the rate: for m = 1 the
 * standard deviation of a sample about the mean of its block. Times 60 / sqrt(rate_hz) that is ARW in deg/sqrt(h), where noise is white. */
typedef struct {
    uint32_t m;   /* 1; long_cluster where the second channel saw it; 0: no alarm yet, then the rest is NaN */
    double older; /* level from the change before to this one, at most the longest window */
    double newer; /* ... from this change up to now: better with every block */
    double gain;  /* logarithm of the likelihood ratio that raised the alarm */
} davar_change_t;

/* What a fit found in the window. */
typedef enum {
    DAVAR_NOISE_UNKNOWN = 0, /* not fitted yet, or no cluster size of the plan has a difference in this window */
    DAVAR_NOISE_WHITE,       /* white noise explains the window: the angle random walk is present */
    DAVAR_NOISE_MIXED, /* white noise alone does not. davar_fit_white then gives the angle random walk an upper limit;
                                davar_fit separates the terms */
    DAVAR_NOISE_CONSTANT, /* every difference is 0: the noise is below one count, or the sensor is stuck */
    DAVAR_NOISE_COARSE /* the noise is below about half a count: rounding hides it (5.15). Every coefficient is absent; the angle
                             random walk has an upper limit. Use a finer count (a smaller range of the sensor, or more of its bits) */
} davar_noise_t;

/* One epoch. */
typedef struct {
    uint64_t epoch;          /* sample index from 0: window centre (centred) or newest sample (trailing) */
    uint32_t window_samples; /* L */
    uint32_t
        mirrored_samples; /* of these mirror images of others in the window (4.2), which are no new evidence (5.13) */
    uint32_t gaps_in_window; /* gaps inside this window */
    uint32_t
        cut_age_samples;   /* glr: at least so many samples of one noise, up to the newest one at the epoch; else 0 */
    davar_change_t change; /* glr: the newest one; m is 0 for other policies */
    bool unstable;         /* the policy's flag f (fixed: f1 OR f2, for information; glr: cut since the epoch before) */
    /* glr: the window was cut at most eight blocks ago, or is to be (centred: a change is beside it): the estimate leans to what made the
     * cut, or holds older noise still. Its intervals are wider, and hold less often (10.14). */
    bool young;
    bool alarm; /* glr: an alarm since the result taken before; false for every other policy */
    uint8_t tau_count;
    davar_noise_t noise;   /* what davar_fit or davar_fit_white found */
    double unit_per_count; /* q15, q31: size of a count, whose rounding the fit takes off (5.15). f32: 0, not known */
    double kurtosis;       /* of the whole window; NaN when its variance is 0 (3.1) */
    double contribution;   /* |K - Km| / K; NaN when K or Km is undefined (3.2) */
    double dispersion;     /* glr: by how much the thresholds are widened, f >= 1; NaN for other policies (10.3) */
    davar_adev_t tau[DAVAR_TAUS_MAX];
    davar_coefficient_t coefficient[DAVAR_COEFFICIENT_COUNT]; /* of davar_fit or davar_fit_white; absent until then */
} davar_result_t;

#ifdef __cplusplus
}
#endif

#endif
