/* davar for Python - what the package davar calls through ctypes: davar-sim's stages behind the
 * recording, one signal at a time. Options are davar-sim's own, by name and text, so that both
 * accept the same and answer with the same bits. */
#ifndef DAVAR_PYTHON_H
#define DAVAR_PYTHON_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#if defined(_WIN32)
#define DAVAR_PYTHON_API __declspec(dllexport)
#else
#define DAVAR_PYTHON_API __attribute__((visibility("default")))
#endif

/* One run. In the order of the calls: new, option ..., configure, admit, start, then gap and push,
 * at the end flush; free. Functions that answer false leave the reason in davar_python_error(). One
 * thread at a time: the caller's business (davar.Stream has a lock). */
typedef struct davar_python davar_python_t;

/* Null: no memory. */
DAVAR_PYTHON_API davar_python_t *davar_python_new(void);
DAVAR_PYTHON_API void davar_python_free(davar_python_t *run);

/* The reason in one line, "--option: what"; lives as long as the run. */
DAVAR_PYTHON_API const char *davar_python_error(const davar_python_t *run);

/* Sets one option of davar-sim, by its name without dashes; those that take no value ignore the
 * text. */
DAVAR_PYTHON_API bool davar_python_option(davar_python_t *run, const char *name, const char *text);

/* Asks the library whether it accepts the options. `needed`: samples of the shortest record that
 * gives an epoch. */
DAVAR_PYTHON_API bool davar_python_configure(davar_python_t *run, uint64_t *needed);

/* Turns `count` finite values into what push takes, in place: counts (whole numbers, where
 * `counted`) or deg/s. False: the value at *bad cannot be taken. */
DAVAR_PYTHON_API bool davar_python_admit(davar_python_t *run, bool counted, double *values,
                                         size_t count, size_t *bad);

/* Compares every result with an error model (davar/monitor.h): columns model_health,
 * model_deviation_M. count (1..64) cluster sizes m, each once, their deviations above 0 and
 * relative tolerances from 0 on. Before start. */
DAVAR_PYTHON_API bool davar_python_model(davar_python_t *run, const uint32_t *m,
                                         const double *adev_dps, const double *tolerance,
                                         size_t count);

/* Starts the instance. low, high: of all values that will come, as admitted; they choose the scale
 * where no option does. */
DAVAR_PYTHON_API bool davar_python_start(davar_python_t *run, double rate_hz, double low,
                                         double high);

/* Columns of a row; name of column i, which lives as long as the run. */
DAVAR_PYTHON_API size_t davar_python_columns(const davar_python_t *run);
DAVAR_PYTHON_API const char *davar_python_column(const davar_python_t *run, size_t i);

/* So many samples were lost before the next one. */
DAVAR_PYTHON_API void davar_python_gap(davar_python_t *run, uint32_t missing);

/* Takes admitted values in until they are done or the table (columns x capacity, one column after
 * the other) is full. *taken: values that went in. Returns the rows written; absent values are
 * NaN. */
DAVAR_PYTHON_API size_t davar_python_push(davar_python_t *run, const double *values, size_t count,
                                          double *table, size_t capacity, size_t *taken);

/* The epochs that are left at the end of the record (centred); fewer rows than `capacity`: there
 * are no more. */
DAVAR_PYTHON_API size_t davar_python_flush(davar_python_t *run, double *table, size_t capacity);

/* The nine counters of davar_health_t, in its order. */
DAVAR_PYTHON_API void davar_python_health(const davar_python_t *run, uint32_t *counters);

/* The overlapping Allan deviation of a whole record, without a run. values: `count` finite samples
 * (at most 2^31), rounded to whole steps from `centre`; n m^2 (range / step)^2 < 2^128. ends: of
 * each of the `runs` without a gap inside, ascending, the last is `count`. m: `taus` cluster sizes.
 * rows: 2 x taus: deviation (unit of the values; NaN: absent), number of differences. False: no
 * memory. O(count taus). */
DAVAR_PYTHON_API bool davar_python_adev(const double *values, size_t count, double centre,
                                        double step, const size_t *ends, size_t runs,
                                        const uint32_t *m, size_t taus, double *rows);

/* The limits of these deviations of one record of `count` samples, from the noise mix that they
 * show together. unit_per_count: what the samples are rounded to; 0: not known. m: `taus` (1..32)
 * strictly ascending cluster sizes. rows: as davar_python_adev writes them. limits: 2 x taus: low,
 * high (95 %; NaN: absent). False: no memory. */
DAVAR_PYTHON_API bool davar_python_intervals(const uint32_t *m, const double *rows, uint8_t taus,
                                             uint32_t count, double rate_hz, double unit_per_count,
                                             double *limits);

/* Cluster sizes for a window: octaves, or `wanted` (1..32) on a log scale. m has room for 32.
 * Returns how many. */
DAVAR_PYTHON_API uint8_t davar_python_taus(uint32_t window, uint8_t wanted, uint32_t *m);

#endif
