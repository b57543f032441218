/** @file
 * davar - select: which of two to four redundant gyros to trust.
 *
 * It reports the weights that fuse the gyros with the least noise, the one gyro to use if only one
 * can be used, and the gyros that are faulty. The configuration sets the error rates, whatever the
 * distribution of the noise. docs/GYROS.md shows how to use it; formulas: addons/select/DESIGN.md.
 *
 * The gyros must be sampled together, at a common rate: common motion cancels in differences of
 * simultaneous samples only.
 *
 * Arithmetic: IEEE float with + - * / and sqrt only, so every target computes the same bits. No
 * function allocates memory, blocks or reads a clock.
 *
 * Threads: a selection belongs to one thread or interrupt. */
#ifndef DAVAR_SELECT_H
#define DAVAR_SELECT_H

#include "davar/options.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Most gyros of one selection. */
#define DAVAR_SELECT_GYROS 4U
/** Most axes of each gyro. */
#define DAVAR_SELECT_AXES 3U

/** Number of pairs of `gyros` gyros. */
#define DAVAR_SELECT_PAIRS(gyros) ((gyros) * ((gyros)-1U) / 2U)

/** Settings. They may be const in flash and must outlive the selection. Start from
 * DAVAR_SELECT_DEFAULTS. */
typedef struct {
    uint8_t gyros;  /**< 2 to 4; no default */
    uint8_t axes;   /**< of each gyro, 1 to 3; no default. More axes: faster decisions */
    uint16_t block; /**< samples from one verdict to the next, 4 to 1000; no default */
    float rate_hz;  /**< samples per second; block / rate_hz must be 0.04 to 0.25 s, best 0.1 s */
    /** wrong switches accepted in 1000 hours between gyros of equal noise, and false alarms of the
     * means and of the noise, 0.001 to 1e6. Fewer: later decisions */
    float errors_per_1000_h;
    /** @{ */
    /** What two healthy gyros may differ by: scale factor and misalignment as a part of the rate,
     * time of a sample in s, and drift of the bias in deg/s per s. Above 0, at most 1. The stated
     * rate of errors holds for gyros well within these tolerances (docs/GYROS.md). Smaller
     * ones: the noise of three gyros remains visible in more violent motion */
    float scale_tolerance;
    float time_tolerance_s;
    float drift_tolerance_dps_per_s;
    /** @} */
} davar_select_config_t;

/** The last part of an initialiser of davar_select_config_t, after the fields without a default
 * (docs/GYROS.md has an example). */
#define DAVAR_SELECT_DEFAULTS                                                                      \
    .errors_per_1000_h = 1.0F, .scale_tolerance = 0.02F, .time_tolerance_s = 0.0005F,              \
    .drift_tolerance_dps_per_s = 0.002F

/** Why davar_select_init failed: one code per cause, with a value that never changes. */
typedef enum {
    DAVAR_SELECT_OK = 0,           /**< no error */
    DAVAR_SELECT_ERR_NULL = 1,     /**< a required pointer is null */
    DAVAR_SELECT_ERR_GYROS = 2,    /**< gyros outside 2..4 */
    DAVAR_SELECT_ERR_AXES = 3,     /**< axes outside 1..3 */
    DAVAR_SELECT_ERR_BLOCK = 4,    /**< block outside 4..1000 */
    DAVAR_SELECT_ERR_RATE = 5,     /**< block / rate_hz outside 0.04..0.25 s, or not a number */
    DAVAR_SELECT_ERR_ERRORS = 6,   /**< errors_per_1000_h outside 0.001..1e6, or not a number */
    DAVAR_SELECT_ERR_TOLERANCE = 7 /**< a tolerance outside 1e-9..1, or not a number */
} davar_select_status_t;

/** Describes a status in English.
 * @return A text that is never null and must not be changed. Threads: any. Cost: O(1). */
const char *davar_select_status_text(davar_select_status_t status);

/** @{ */
/** Faults of a gyro, as bits. */
#define DAVAR_SELECT_ABSENT 1U /**< samples were missing in the last 20 blocks */
#define DAVAR_SELECT_STUCK 2U  /**< an axis repeated one value in all samples of 3 blocks */
#define DAVAR_SELECT_MEAN 4U   /**< its mean disagrees with all others; three gyros or more */
#define DAVAR_SELECT_NOISE 8U  /**< its own noise is above 2.2 times its past; a warning only */
/** @} */

/** The verdict after a block. Gyros are counted from 0; elements of others are not written. */
typedef struct {
    /** weights of the fusion with the least noise; their sum is 1. Absent, stuck and disagreeing
     * gyros have 0. All are 0 if no gyro is left */
    float weight[DAVAR_SELECT_GYROS];
    uint8_t fault[DAVAR_SELECT_GYROS]; /**< DAVAR_SELECT_* bits of each gyro */
    uint8_t chosen;                    /**< the gyro to use if only one can be used */
    bool switched;                     /**< chosen changed in this block */
    bool usable;                       /**< false: every gyro is absent, stuck or disagrees */
    /** two means differ by more than noise and tolerances. With two gyros, nothing shows which is
     * wrong */
    bool disagree;
    /** common motion or vibration hides the noise. With two gyros left, nothing shows which is
     * quieter. With three or more, differences of scale and time within the tolerances could be
     * half as large as the noise. weight rests on the time before. So does chosen, unless the
     * noise differs by more than the tolerances explain */
    bool hidden;
} davar_select_verdict_t;

/** One gyro. The caller owns it. Fields are private. */
typedef struct {
    /** @privatesection */
    float square[DAVAR_SELECT_AXES]; /* sum of the squared steps of the block (13.1) */
    float sum[DAVAR_SELECT_AXES];    /* of its rates */
    float last[DAVAR_SELECT_AXES];   /* rate */
    float first[DAVAR_SELECT_AXES];  /* the last rate before the block */
    float step[DAVAR_SELECT_AXES];   /* from the last rate but one to the last */
    float bend;                      /* sum of the squared steps of the steps of the block */
    float evidence;                  /* that it is quieter than the chosen one (13.2) */
    float spread;                    /* variance of the contrast with the chosen one (13.3) */
    float recent;                    /* mean of square, over axes, of the last blocks */
    float own;                       /* variance of the gyro's noise, same unit (13.5) */
    float known;                     /* blocks that `own` is worth */
    float usual;                     /* long-term mean of own */
    uint8_t fault;
    uint8_t wait;  /* blocks until the fault is over */
    uint8_t still; /* blocks in which an axis did not move */
    uint8_t loud;  /* evidence of too much noise (13.8) */
} davar_select_gyro_t;

/** One pair of gyros. The caller owns it. Fields are private. */
typedef struct {
    /** @privatesection */
    float apart;                     /* sum of the squared steps of the difference, of the block */
    float recent;                    /* mean of apart over the last blocks */
    float offset[DAVAR_SELECT_AXES]; /* difference of the biases, times the samples of a block */
    float noise;                     /* mean deviation from it, over the root of `recent` (13.7) */
    float known;                     /* blocks that they are worth */
    float age;                       /* blocks since they were last seen well */
    float evidence;                  /* of a jump */
} davar_select_pair_t;

/** A selection. The caller owns it. Fields are private. */
typedef struct {
    /** @privatesection */
    const davar_select_config_t *config;
    davar_select_gyro_t *gyro;
    davar_select_pair_t *pair;
    float threshold; /* of evidence (13.4) */
    float freedom;   /* of a block of white noise (13.1) */
    float drift;     /* tolerance of a block, times its samples */
    float mismatch;  /* of the last blocks (13.2) */
    uint16_t count;  /* samples of the block */
    uint16_t blocks; /* since the start, at most 4096 */
    uint8_t chosen;
    bool hidden;
} davar_select_t;

/** Starts a selection with gyro 0 as the chosen one.
 * `gyro` has config->gyros elements and `pair` DAVAR_SELECT_PAIRS(config->gyros); they and the
 * configuration must outlive the selection.
 * @return DAVAR_SELECT_OK, or the first error found. On error nothing is written, and *select must
 *         not be used.
 *
 * Cost: O(gyros^2). */
DAVAR_NODISCARD davar_select_status_t davar_select_init(davar_select_t *select,
                                                        const davar_select_config_t *config,
                                                        davar_select_gyro_t *gyro,
                                                        davar_select_pair_t *pair);

/** Adds one sample of every gyro: rates_dps[gyro * axes + axis] in deg/s, at most 1e4 without sign.
 * A rate that is not finite marks a missing sample: pass NAN for a gyro that delivered none. A jump
 * by more than 1e6 does so too, but a rate that stays that large does not. If no gyro delivered a
 * sample, do not call it.
 * @return True if it completes a block: call davar_select_update before the next sample.
 *
 * Cost: O(axes gyros^2), without a division. */
bool davar_select_add(davar_select_t *select, const float *rates_dps);

/** Evaluates a complete block and fills *verdict.
 * Cost: O(gyros^2 (gyros + axes)), without a loop that depends on the data. Formulas (13.1) to
 * (13.8). */
void davar_select_update(davar_select_t *select, davar_select_verdict_t *verdict);

#ifdef __cplusplus
}
#endif

#endif
