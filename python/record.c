/* davar for Python - the Allan deviation of a complete record. One pass per cluster size over
 * cumulative sums, exact in integers. Then the library's fit, as for any window. */
#include "davar/davar.h"
#include "davar_python.h"

#include <math.h>
#include <stdlib.h>

__extension__ typedef __int128 i128_t;
__extension__ typedef unsigned __int128 u128_t;

typedef struct {
    u128_t squares;
    uint64_t count;
} sum_t;

/* Cumulative sums modulo 2^64; the first is 0. Their differences are exact if they fit. */
static void accumulate(const double *values, size_t count, double centre, double step,
                       uint64_t *total)
{
    uint64_t sum = 0;
    total[0] = 0;
    for (size_t i = 0; i < count; i++) {
        sum += (uint64_t)llrint((values[i] - centre) / step);
        total[i + 1U] = sum;
    }
}

/* Adds the squares of all differences of m samples in a run of `length` samples; `total` has its
 * cumulative sums. It uses two sums at a time, so that a 128-bit addition need not wait for the
 * previous one. */
static void add_run(sum_t *sum, const uint64_t *total, size_t length, size_t m)
{
    if (length < 2U * m) {
        return;
    }
    const size_t count = length - 2U * m + 1U;
    u128_t squares[2] = {0, 0};
    for (size_t i = 0; i < count; i++) {
        const int64_t difference = (int64_t)(total[i + 2U * m] - 2U * total[i + m] + total[i]);
        squares[i % 2U] += (u128_t)((i128_t)difference * difference);
    }
    sum->squares += squares[0] + squares[1];
    sum->count += count;
}

static sum_t squares_of(const uint64_t *total, const size_t *ends, size_t runs, uint32_t m)
{
    sum_t sum = {0};
    size_t first = 0;
    for (size_t r = 0; r < runs; r++) {
        add_run(&sum, total + first, ends[r] - first, m);
        first = ends[r];
    }
    return sum;
}

bool davar_python_adev(const double *values, size_t count, double centre, double step,
                       const size_t *ends, size_t runs, const uint32_t *m, size_t taus,
                       double *rows)
{
    uint64_t *total = calloc(count + 1U, sizeof *total);
    if (total == NULL) {
        return false;
    }
    accumulate(values, count, centre, step, total);
    for (size_t t = 0; t < taus; t++) {
        const sum_t sum = squares_of(total, ends, runs, m[t]);
        const double mean =
            /* without differences 0 / 0 gives NaN */
            (double)sum.squares / (2.0 * (double)sum.count);
        rows[t] = sqrt(mean) / m[t] * step;
        rows[taus + t] = (double)sum.count;
    }
    free(total);
    return true;
}

bool davar_python_intervals(const uint32_t *m, const double *rows, uint8_t taus, uint32_t count,
                            double rate_hz, double unit_per_count, double *limits)
{
    davar_result_t *result = calloc(1U, sizeof *result);
    davar_plan_t *plan = calloc(1U, sizeof *plan);
    const bool good = (result != NULL) && (plan != NULL);
    if (good) {
        result->window_samples = count;
        result->tau_count = taus;
        result->unit_per_count = unit_per_count;
        for (uint8_t t = 0; t < taus; t++) {
            result->tau[t] = (davar_adev_t){.m = m[t],
                                            .differences = (uint32_t)rows[taus + t],
                                            .adev = rows[t],
                                            .low = (double)NAN,
                                            .high = (double)NAN,
                                            .edf = (double)NAN};
        }
        davar_plan_init_white(plan, m, taus);
        davar_fit(plan, rate_hz, result);
        for (uint8_t t = 0; t < taus; t++) {
            limits[t] = result->tau[t].low;
            limits[taus + t] = result->tau[t].high;
        }
    }
    free(plan);
    free(result);
    return good;
}

uint8_t davar_python_taus(uint32_t window, uint8_t wanted, uint32_t *m)
{
    return (wanted > 0U) ? davar_taus_geometric(window, wanted, m, DAVAR_TAUS_MAX)
                         : davar_taus_octave(window, m, DAVAR_TAUS_MAX);
}
