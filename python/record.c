/* davar for Python - the Allan deviation of a complete record. One pass over the samples: block by
 * block, the cumulative sums and the differences of every cluster size that end in the block, exact
 * in integers. Then the library's fit, as for any window. */
#include "bits.h"
#include "common/batch_limits.h"
#include "davar/davar.h"
#include "davar/fit.h"
#include "davar_python.h"
#include "vectors.h"

#include <math.h>
#include <stdlib.h>

__extension__ typedef __int128 i128_t;
__extension__ typedef unsigned __int128 u128_t;

/* Cumulative sums of so many samples stay in the cache of a core for all cluster sizes. */
#define BLOCK 8192U
#define PARTS 64U /* of a record, of which batches consist */

typedef struct {
    u128_t squares;
    uint64_t count;
} sum_t;

/* --- squares ---------------------------------------------------------------------------------- */

/* Sums of products of the parts of differences d = upper 2^shift + lower. */
typedef struct {
    uint64_t upper;
    uint64_t mixed; /* upper times lower, signed */
    uint64_t lower;
} parts_t;

/* The cumulative sums at the start, middle and end of the first of several differences. */
typedef struct {
    const uint64_t *start;
    const uint64_t *middle;
    const uint64_t *end;
} places_t;

/* Of `count` differences in a row. Products of 64 bits only, so that a compiler can use vectors. */
static inline parts_t parts_of(places_t at, size_t count, unsigned shift)
{
    const uint64_t mask = (UINT64_C(1) << shift) - 1U;
    parts_t sum = {0};
    for (size_t i = 0; i < count; i++) {
        const uint64_t difference = at.end[i] - 2U * at.middle[i] + at.start[i];
        const uint64_t upper = (uint64_t)((int64_t)difference >> shift);
        const uint64_t lower = difference & mask;
        sum.upper += upper * upper;
        sum.mixed += upper * lower;
        sum.lower += lower * lower;
    }
    return sum;
}

typedef parts_t parts_function_t(places_t at, size_t count, unsigned shift);

FOR_AVX2 static parts_t parts_avx2(places_t at, size_t count, unsigned shift)
{
    return parts_of(at, count, shift);
}

FOR_AVX512 static parts_t parts_avx512(places_t at, size_t count, unsigned shift)
{
    return parts_of(at, count, shift);
}

static parts_function_t *parts_here(void)
{
    return HAS_AVX512 ? parts_avx512 : (HAS_AVX2 ? parts_avx2 : parts_of);
}

/* Adds the squares of `count` differences of sizes up to 2^bits, bits <= 63. No sum of parts
 * exceeds 64 bits: each adds at most 2^bits or, of lower parts, 2^(2 shift). */
static void add_squares(sum_t *sum, parts_function_t *parts, places_t at, size_t count,
                        unsigned bits)
{
    const unsigned shift = (bits + 1U) / 2U;
    const size_t most = (shift < 32U) ? ((size_t)1U << (63U - 2U * shift)) : 1U;
    for (size_t i = 0; i < count; i += most) {
        const places_t from = {at.start + i, at.middle + i, at.end + i};
        const parts_t part = parts(from, ((count - i) < most) ? (count - i) : most, shift);
        sum->squares += ((u128_t)part.upper << (2U * shift)) +
                        ((u128_t)(i128_t)(int64_t)part.mixed << (shift + 1U)) + part.lower;
    }
    sum->count += count;
}

/* --- the record ------------------------------------------------------------------------------- */

typedef struct {
    const double *values;
    double centre;
    double step;
    double inverse; /* of the step, if it is exact; otherwise 0 */
    uint64_t sizes; /* above all samples so far in whole steps: their bits, signs removed */
    /* A ring of the newest cumulative sums modulo 2^64, the sum of n samples at n % room. Their
     * differences are exact if they fit. */
    uint64_t *total;
    size_t room;
    parts_function_t *parts;
    size_t part;      /* samples */
    double *part_row; /* of the next part: squares, and as many counts */
    sum_t *before;    /* the sums up to it, one per size */
} record_t;

static uint64_t steps_of(const record_t *record, double value)
{
    const double from_centre = value - record->centre;
    return (uint64_t)llrint((record->inverse > 0.0) ? (from_centre * record->inverse)
                                                    : (from_centre / record->step));
}

static void accumulate(record_t *record, size_t from, size_t to)
{
    size_t place = from % record->room;
    uint64_t sum = record->total[place];
    for (size_t i = from; i < to; i++) {
        const uint64_t steps = steps_of(record, record->values[i]);
        record->sizes |= steps ^ (0U - (steps >> 63U));
        sum += steps;
        place = ((place + 1U) < record->room) ? (place + 1U) : 0U;
        record->total[place] = sum;
    }
}

/* The place in the ring of the sum of n samples. Lowers *count to the sums up to the ring's end. */
static const uint64_t *place_of(const record_t *record, size_t n, size_t *count)
{
    const size_t place = n % record->room;
    const size_t left = record->room - place;
    *count = (*count < left) ? *count : left;
    return record->total + place;
}

/* Adds the differences of m samples that end at the sums of `first` to `last` samples. */
static void add_ends(const record_t *record, sum_t *sum, size_t first, size_t last, size_t m)
{
    const unsigned bits = bits_of(record->sizes) + bits_of(2U * m - 1U);
    size_t count;
    for (size_t end = first; end <= last; end += count) {
        count = last + 1U - end;
        const uint64_t *const start = place_of(record, end - 2U * m, &count);
        const uint64_t *const middle = place_of(record, end - m, &count);
        const places_t at = {start, middle, place_of(record, end, &count)};
        add_squares(sum, record->parts, at, count, (bits < 63U) ? bits : 63U);
    }
}

/* The sums of a part, if it is not the rest. */
static void end_part(record_t *record, const sum_t *sums, size_t at, size_t taus)
{
    for (size_t t = 0; (t < taus) && (at <= PARTS * record->part); t++) {
        record->part_row[t] = (double)(sums[t].squares - record->before[t].squares);
        record->part_row[taus + t] = (double)(sums[t].count - record->before[t].count);
        record->before[t] = sums[t];
    }
    record->part_row += (at < PARTS * record->part) ? ((size_t)2U * taus) : 0U;
}

/* A run without a gap inside: the samples from `first` to before `end`. */
static void add_run(record_t *record, sum_t *sums, size_t first, size_t end, const uint32_t *m,
                    size_t taus)
{
    for (size_t from = first; from < end;) {
        const size_t cut = (from / record->part + 1U) * record->part;
        const size_t most = (cut < from + BLOCK) ? cut : (from + BLOCK);
        const size_t to = (end < most) ? end : most;
        accumulate(record, from, to);
        for (size_t t = 0; t < taus; t++) {
            const size_t least = first + (size_t)2U * m[t];
            add_ends(record, &sums[t], (least > from) ? least : (from + 1U), to, m[t]);
        }
        if (to == cut) {
            end_part(record, sums, cut, taus);
        }
        from = to;
    }
}

/* Without differences 0 / 0 gives NaN. */
static void write_rows(const sum_t *sums, const uint32_t *m, size_t taus, double step, double *rows)
{
    for (size_t t = 0; t < taus; t++) {
        const double mean = (double)sums[t].squares / (2.0 * (double)sums[t].count);
        rows[t] = sqrt(mean) / m[t] * step;
        rows[taus + t] = (double)sums[t].count;
    }
}

static size_t part_of_record(size_t count)
{
    return (count < PARTS) ? 1U : (count / PARTS);
}

bool davar_python_adev(const double *values, size_t count, double centre, double step,
                       const size_t *ends, size_t runs, const uint32_t *m, size_t taus,
                       double *rows)
{
    int exponent;
    const bool is_power = !(frexp(step, &exponent) > 0.5);
    const size_t span = (size_t)2U * m[taus - 1U];
    record_t record = {.values = values,
                       .centre = centre,
                       .step = step,
                       .inverse = is_power ? (1.0 / step) : 0.0,
                       .part = part_of_record(count),
                       .part_row = rows + (size_t)2U * taus,
                       .room = ((span < count) ? span : count) + BLOCK + 1U,
                       .parts = parts_here()};
    record.total = calloc(record.room, sizeof *record.total);
    record.before = calloc(taus, sizeof *record.before);
    sum_t *sums = calloc(taus, sizeof *sums);
    const bool good = (record.total != NULL) && (record.before != NULL) && (sums != NULL);
    if (good) {
        size_t first = 0;
        for (size_t r = 0; r < runs; r++) {
            add_run(&record, sums, first, ends[r], m, taus);
            first = ends[r];
        }
        write_rows(sums, m, taus, step, rows);
    }
    free(sums);
    free(record.before);
    free(record.total);
    return good;
}

/* Limits of size t by batches of the record. */
static void limit_by_batches(const double *rows, uint8_t taus, uint8_t t, uint32_t count,
                             davar_adev_t *tau)
{
    batch_sums_t sums[PARTS];
    const size_t part = part_of_record(count);
    const size_t first = ((size_t)2U * tau->m + part - 1U) / part;
    if ((count < PARTS) || (first >= PARTS)) {
        return;
    }
    for (size_t i = first; i < PARTS; i++) {
        const double *const row = rows + (size_t)2U * (i + 1U) * taus + t;
        sums[i - first] = (batch_sums_t){.squares = row[0], .count = row[taus]};
    }
    batch_limits(sums, 1U, PARTS - first, part, (double)count / (double)tau->m, tau);
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
            if (batch_limits_apply(result)) {
                limit_by_batches(rows, taus, t, count, &result->tau[t]);
            }
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
