/* davar for Python - the functions that the package davar calls through ctypes: the stages of
 * davar-sim after the recording, for one signal at a time. Options have the names and texts of
 * davar-sim, so both accept the same options and give the same bits. */
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

/* One run. The order of the calls is: new, option ..., configure, admit, start, then gap and push,
 * at the end flush; free. If a function returns false, davar_python_error() has the reason. Only
 * one thread may use a run at a time; the caller ensures it (davar.Stream has a lock). */
typedef struct davar_python davar_python_t;

/* Null: out of memory. */
DAVAR_PYTHON_API davar_python_t *davar_python_new(void);
DAVAR_PYTHON_API void davar_python_free(davar_python_t *run);

/* The reason in one line, "--option: what". It is valid as long as the run. */
DAVAR_PYTHON_API const char *davar_python_error(const davar_python_t *run);

/* Sets one option of davar-sim, by its name without dashes. Options without a value ignore the
 * text. One more is "fit-every": N: fit every N-th epoch only, 0: no epoch, no columns of the
 * fit. */
DAVAR_PYTHON_API bool davar_python_option(davar_python_t *run, const char *name, const char *text);

/* Checks the options with the library. `needed`: samples of the shortest record that gives an
 * epoch. */
DAVAR_PYTHON_API bool davar_python_configure(davar_python_t *run, uint64_t *needed);

/* Converts `count` finite values in place to the input of push: counts (whole numbers, if
 * `counted`) or deg/s. False: the value at *bad is not valid. */
DAVAR_PYTHON_API bool davar_python_admit(davar_python_t *run, bool counted, double *values,
                                         size_t count, size_t *bad);

/* Marks the torn register reads among all admitted counts of a record (davar/torn.h). ends: the
 * ascending ends of the runs without a gap inside; the last is `count`. Returns their number. */
DAVAR_PYTHON_API size_t davar_python_torn(const double *counts, size_t count, const size_t *ends,
                                          bool *torn);

/* Compares every result with an error model (davar/monitor.h): columns model_health,
 * model_deviation_M. count (1..64) distinct cluster sizes m, their deviations (above 0) and
 * relative tolerances (at least 0). Call it before start. */
DAVAR_PYTHON_API bool davar_python_model(davar_python_t *run, const uint32_t *m,
                                         const double *adev_dps, const double *tolerance,
                                         size_t count);

/* Learns the filter from all admitted values of a record, for the option --bandwidth auto, which
 * start() otherwise takes as an unknown filter. ends: the ascending ends of the runs without a gap
 * inside; the last is `count`. option: what was found as a value of --bandwidth, "" if unknown,
 * with room for `size` bytes (512). Call it before start. False: out of memory. */
DAVAR_PYTHON_API bool davar_python_learn(davar_python_t *run, const double *values, size_t count,
                                         const size_t *ends, char *option, size_t size);

/* Starts the instance. low, high: range of all admitted values of the run. They set the scale if no
 * option does. */
DAVAR_PYTHON_API bool davar_python_start(davar_python_t *run, double rate_hz, double low,
                                         double high);

/* Number of columns of a row, and the name of column i. The name is valid as long as the run. */
DAVAR_PYTHON_API size_t davar_python_columns(const davar_python_t *run);
DAVAR_PYTHON_API const char *davar_python_column(const davar_python_t *run, size_t i);

/* Reports `missing` lost samples before the next one. */
DAVAR_PYTHON_API void davar_python_gap(davar_python_t *run, uint32_t missing);

/* Pushes admitted values until all are consumed or the table is full. A table has its columns one
 * after the other; `first`: its first free row, in column 0; `stride`: from column to column;
 * `room`: free rows. *taken: values consumed. Returns the number of rows written; absent values are
 * NaN. */
DAVAR_PYTHON_API size_t davar_python_push(davar_python_t *run, const double *values, size_t count,
                                          double *first, size_t stride, size_t room, size_t *taken);

/* Writes the remaining epochs at the end of the record (centred). If it returns fewer rows than
 * `room`, there are no more. */
DAVAR_PYTHON_API size_t davar_python_flush(davar_python_t *run, double *first, size_t stride,
                                           size_t room);

/* Writes the epochs of a complete record, instead of gap, push and flush, several times as fast,
 * with the same bits. ends: the ascending ends of the `runs` without a gap inside; the last is
 * `count`. The table has room for `count` rows. Call it after start, again and again with the same
 * table and record, until it returns 0: each call writes the next rows, at most `room`, and returns
 * their number. 0 at the first call: the settings or the counts do not allow it (slide.h), or out of
 * memory: push instead. */
DAVAR_PYTHON_API size_t davar_python_slide(davar_python_t *run, const double *values, size_t count,
                                           const size_t *ends, size_t runs, double *first,
                                           size_t stride, size_t room);

/* The nine counters of davar_health_t, in its order. */
DAVAR_PYTHON_API void davar_python_health(const davar_python_t *run, uint32_t *counters);

/* The overlapping Allan deviation of a complete record, without a run. values: `count` finite
 * samples (at most 2^31), rounded to whole steps from `centre`; n m^2 (range / step)^2 < 2^128.
 * ends: the ascending ends of the `runs` without a gap inside; the last is `count`. m: `taus` (at
 * least 1) ascending cluster sizes. rows: 130 x taus: deviation (unit of the values; NaN: absent),
 * number of differences; then for davar_python_intervals the squares and numbers of each 64th.
 * False: out of memory. Cost: O(count taus), with one pass over the values; memory for twice the
 * largest cluster size. */
DAVAR_PYTHON_API bool davar_python_adev(const double *values, size_t count, double centre,
                                        double step, const size_t *ends, size_t runs,
                                        const uint32_t *m, size_t taus, double *rows);

/* The limits of these deviations of one record of `count` samples: from the noise mix that fits all
 * of them, or from eight batches (5.25). unit_per_count: rounding step of the samples; 0: unknown.
 * m: `taus` (1..32) strictly ascending cluster sizes. rows: the output of davar_python_adev. limits:
 * 2 x taus: low, high (95 %; NaN: absent). False: out of memory. */
DAVAR_PYTHON_API bool davar_python_intervals(const uint32_t *m, const double *rows, uint8_t taus,
                                             uint32_t count, double rate_hz, double unit_per_count,
                                             double *limits);

/* Cluster sizes for a window: octaves, or `wanted` (1..32) sizes on a log scale. m has room for 32.
 * Returns their number. */
DAVAR_PYTHON_API uint8_t davar_python_taus(uint32_t window, uint8_t wanted, uint32_t *m);

#endif
