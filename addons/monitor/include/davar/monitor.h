/** @file
 * davar - monitor: does the sensor still match its error model?
 *
 * The monitor compares each result with the Allan deviations that an error model expects.
 * `tools/davarlab export` writes that table. Formulas: addons/monitor/DESIGN.md (section 9).
 *
 * Arithmetic: IEEE double with + - * / and sqrt only, so every target computes the same bits. No
 * function allocates memory, blocks or reads a clock.
 *
 * Threads: one monitor belongs to one thread, usually the consumer of the results. */
#ifndef DAVAR_MONITOR_H
#define DAVAR_MONITOR_H

#include "davar/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/** Why davar_monitor_init failed: one code per cause, with a value that never changes. */
typedef enum {
    DAVAR_MONITOR_OK = 0,            /**< no error */
    DAVAR_MONITOR_ERR_EMPTY = 1,     /**< no cluster size */
    DAVAR_MONITOR_ERR_ADEV = 2,      /**< an adev_dps not positive and finite */
    DAVAR_MONITOR_ERR_TOLERANCE = 3, /**< a relative_tolerance negative or not finite */
    DAVAR_MONITOR_ERR_TWICE = 4,     /**< one m occurs twice */
    DAVAR_MONITOR_ERR_MEMORY = 5     /**< memory below 1 window, or not finite */
} davar_monitor_status_t;

/** Describes a status in English.
 * @return A text that is never null and must not be changed. Threads: any. Cost: O(1). */
const char *davar_monitor_status_text(davar_monitor_status_t status);

/** One cluster size of the error model. */
typedef struct {
    uint32_t m;      /**< cluster size, samples */
    double adev_dps; /**< Allan deviation of the model, deg/s; above 0 */
    /** standard deviation of adev_dps over adev_dps; 0: the model is exact */
    double relative_tolerance;
} davar_model_tau_t;

/** Whether a cluster size of the result was compared. */
typedef enum {
    DAVAR_TAU_COMPARED = 0, /**< the deviations are numbers */
    DAVAR_TAU_NOT_IN_MODEL, /**< no entry of the table has this m */
    DAVAR_TAU_NOT_IN_WINDOW /**< the window cannot support this m */
} davar_tau_match_t;

/** The comparison of one cluster size. */
typedef struct {
    davar_tau_match_t match; /**< whether it was compared */
    /** this window: standard deviations above (+) or below (-) the model (9.2); NaN unless
     * compared */
    double deviation;
    /** the same of the mean over the last windows (9.4); NaN before the first comparison */
    double mean_deviation;
} davar_misfit_tau_t;

/** The comparison of a result with the model. */
typedef struct {
    /** the larger of fast and slow. Above 1, the sensor does not match the model; a matching sensor
     * exceeds 1 in at most 1 % of windows (9.3) */
    double health;
    /** this window alone: reacts immediately to a large change. NaN: nothing to compare */
    double fast;
    /** the last windows together: detects a small lasting change. NaN: nothing to compare */
    double slow;
    uint8_t worst;     /**< index of the tau that decides health; tau_count if there is none */
    uint8_t compared;  /**< number of taus with a deviation */
    uint8_t tau_count; /**< number of taus of the result */
    davar_misfit_tau_t tau[DAVAR_TAUS_MAX]; /**< in the order of the result */
} davar_misfit_t;

/** The history of one tau. Fields are private. */
typedef struct {
    /** @privatesection */
    double excess;        /* weighted mean of the numerator of (9.2) */
    double variance;      /* of that mean, from the scatter of the noise */
    double samples;       /* that the mean is worth */
    uint32_t differences; /* of the newest comparison */
} davar_monitor_tau_t;

/** The history of one channel, about 32 bytes per tau. The caller owns it. Fields are private. */
typedef struct {
    /** @privatesection */
    const davar_model_tau_t *model;
    uint8_t model_count;
    bool started;
    double memory;
    uint64_t epoch; /* of the newest result */
    davar_monitor_tau_t tau[DAVAR_TAUS_MAX];
} davar_monitor_t;

/** A usual value for the parameter `memory` of davar_monitor_init, in windows. */
#define DAVAR_MONITOR_MEMORY 32.0

/** Starts the monitor of one channel.
 * `model` holds `count` entries in any order and must outlive the monitor. `memory` is the number
 * of windows that the slow comparison averages, at least 1.
 * @return DAVAR_MONITOR_OK, or the first error found; on error nothing is written.
 *
 * Cost: O(count^2). */
#define davar_monitor_init DAVAR_SIZED(davar_monitor_init)
DAVAR_NODISCARD davar_monitor_status_t davar_monitor_init(davar_monitor_t *monitor,
                                                          const davar_model_tau_t *model,
                                                          uint8_t count, double memory);

/** Compares the next result of the channel with the model and fills *misfit.
 * The result comes from davar_take, with or without the sizes of a cascade, and with or without a
 * fit. Without a fit the monitor assumes the smallest degrees of freedom (davar_edf_least). Results
 * may overlap: each cluster size weights a result by its new samples. The cluster sizes must stay
 * those of the first result. Cost: O(T count), about 60 double operations per tau. Formulas (9.1)
 * to (9.5). */
#define davar_monitor_update DAVAR_SIZED(davar_monitor_update)
void davar_monitor_update(davar_monitor_t *monitor, const davar_result_t *result,
                          davar_misfit_t *misfit);

/** Computes the deviation of one Allan deviation from the model, without a history.
 * edf >= 1 and model->adev_dps > 0 (asserted). @return Standard deviations above (+) or below (-)
 * the model. Cost: O(1). Formula (9.2). */
double davar_deviation(double adev, double edf, const davar_model_tau_t *model);

#ifdef __cplusplus
}
#endif

#endif
