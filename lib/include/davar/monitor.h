/* davar - monitor: is the sensor still what its error model says?
 * Compares each result with a table of Allan deviations that an error model expects (`tools/davarlab export` writes it).
 * IEEE double with + - * / and sqrt only: the same bits on every target. No heap; all memory is the caller's. */
#ifndef DAVAR_MONITOR_H
#define DAVAR_MONITOR_H

#include "davar/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One cluster size of the error model. */
typedef struct {
    uint32_t m;                /* cluster size, samples */
    double adev_dps;           /* the model's Allan deviation, deg/s, above 0 */
    double relative_tolerance; /* how far the model itself may be off: one standard deviation of adev_dps over it */
} davar_model_tau_t;

/* Why a cluster size of the result has a deviation, or has none. */
typedef enum {
    DAVAR_TAU_COMPARED = 0,
    DAVAR_TAU_NOT_IN_MODEL, /* no entry of the table has this m */
    DAVAR_TAU_NOT_IN_WINDOW /* the window cannot support this m */
} davar_tau_match_t;

typedef struct {
    davar_tau_match_t match;
    double deviation; /* this window: standard deviations above (+) or below (-) the model (9.2); NaN unless compared */
    double mean_deviation; /* the same of the mean over the last windows (9.4); NaN before it was ever compared */
} davar_misfit_tau_t;

/* A result against the model. */
typedef struct {
    double health;     /* larger of the next two. Above 1: not this model; by chance in at most 1 % of windows (9.3) */
    double fast;       /* this window alone: sees a large change at once; NaN: nothing to compare */
    double slow;       /* the last windows together: sees a small one that stays; NaN: nothing to compare */
    uint8_t worst;     /* index of the tau that decides health; tau_count when there is none */
    uint8_t compared;  /* taus with a deviation */
    uint8_t tau_count; /* of the result */
    davar_misfit_tau_t tau[DAVAR_TAUS_MAX];
} davar_misfit_t;

/* What one tau remembers. Private. */
typedef struct {
    double excess;   /* weighted mean of the numerator of (9.2) */
    double variance; /* of its own scatter */
    double windows;  /* how many windows the mean is worth */
    double share;    /* variance of the mean over that of one window */
} davar_monitor_tau_t;

/* One channel's memory of the last windows; belongs to the caller. Fields are private. About 32 bytes a tau. */
typedef struct {
    const davar_model_tau_t *model;
    uint8_t model_count;
    bool started;
    double memory;
    uint64_t epoch; /* of the newest result */
    davar_monitor_tau_t tau[DAVAR_TAUS_MAX];
} davar_monitor_t;

/* Windows that the slow health remembers unless there is a reason for another number. */
#define DAVAR_MONITOR_MEMORY 32.0

/* Starts a monitor for one channel. `model` (`count` entries, any order) must outlive it. `memory` >= 1: windows that
 * the slow health remembers. False, and nothing is touched: no entry, an adev_dps that is not positive and finite, a
 * tolerance that is negative or not finite, an m twice, or a memory below 1. O(count^2). */
#define davar_monitor_init DAVAR_SIZED(davar_monitor_init)
bool davar_monitor_init(davar_monitor_t *monitor, const davar_model_tau_t *model, uint8_t count, double memory);

/* Compares the next result of the channel with the model and fills *misfit. The result may come from davar_take alone, or from any fit
 * after it: without degrees of freedom from a fit the monitor takes the fewest that any noise has (davar_edf_least). Results may
 * overlap: each weighs as much as it brings of new samples. The result's cluster sizes must stay those of the first one. O(T count), about 60 double
 * operations a tau. */
#define davar_monitor_update DAVAR_SIZED(davar_monitor_update)
void davar_monitor_update(davar_monitor_t *monitor, const davar_result_t *result, davar_misfit_t *misfit);

/* The deviation of one Allan deviation alone, without a memory (9.2). edf >= 1, model adev > 0. O(1). */
double davar_deviation(double adev, double edf, const davar_model_tau_t *model);

#ifdef __cplusplus
}
#endif

#endif
