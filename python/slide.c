/* davar for Python - a sliding window over a record. Row r has the window that ends after
 * `shortest` + r places of mirror image and record:
 *
 *     centred    image | record | image    always the longest window
 *     trailing   record                    it grows from the shortest to the longest
 *
 * The first block of all begins with the window of one place. Rows begin later. */
#include "slide.h"
#include "bits.h"
#include "number/scaled.h"
#include "vectors.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* --- runs without a gap ----------------------------------------------------------------------- */

static size_t places_of(const slide_t *slide)
{
    return slide->record.count + 2U * slide->mirrored;
}

/* The ends of the runs in places, with those of the mirror images. */
static bool place_runs(slide_t *slide)
{
    const slide_record_t *const record = &slide->record;
    const size_t gaps = record->runs - 1U;
    size_t n = 0;
    slide->ends = malloc((3U * gaps + 1U) * sizeof *slide->ends);
    if (slide->ends == NULL) {
        return false;
    }
    for (size_t i = gaps; i > 0U; i--) {
        if (record->ends[i - 1U] < slide->mirrored) {
            slide->ends[n++] = slide->mirrored - record->ends[i - 1U];
        }
    }
    for (size_t i = 0; i < gaps; i++) {
        slide->ends[n++] = slide->mirrored + record->ends[i];
    }
    for (size_t i = gaps; i > 0U; i--) {
        const size_t image = record->count - record->ends[i - 1U];
        if (image < slide->mirrored) {
            slide->ends[n++] = slide->mirrored + record->count + image;
        }
    }
    slide->ends[n] = places_of(slide);
    return true;
}

/* How many spans of this length in a row have no gap inside, or have one, from the span that ends
 * before `end` on. *run: that of an earlier span, changed to its own. */
typedef struct {
    bool is_whole;
    size_t count; /* at least 1, and not always all of them */
} alike_t;

static alike_t spans_at(const size_t *ends, size_t *run, size_t end, size_t span)
{
    while (ends[*run] < end) {
        *run += 1U;
    }
    const size_t first = ((*run > 0U) ? ends[*run - 1U] : 0U) + span;
    const size_t last = ends[*run];
    if (end >= first) {
        return (alike_t){true, last + 1U - end};
    }
    return (alike_t){false, ((first <= last) ? first : (last + 1U)) - end};
}

/* --- the cumulative sums ---------------------------------------------------------------------- */

/* Splits differences of up to 2^bits so that no sum of products of their parts exceeds 62 bits.
 * Small ones need no split: shift 0; they have at most 30 bits. False: there is no such split. */
static bool split(slide_t *slide, uint64_t range)
{
    const davar_config_t *const config = slide->config;
    const uint32_t bits = bits_of(range) + bits_of(config->taus[config->tau_count - 1U]);
    const uint32_t terms = bits_of(config->window.longest);
    const uint32_t most = (62U - terms) / 2U;
    slide->shift = (2U * bits + terms <= 62U) ? 0U : ((most < 26U) ? most : 26U);
    return 2U * (bits - slide->shift) + terms <= 62U; /* bits are more than the shift */
}

/* The samples at `count` places in a row are at values[0], values[step] .. */
typedef struct {
    const double *values;
    ptrdiff_t step;
    size_t count;
} piece_t;

static inline void quantise(const quantisation_t *quantisation, piece_t piece, int32_t *counts)
{
    for (size_t i = 0; i < piece.count; i++) {
        counts[i] = quantise_count(quantisation, piece.values[(ptrdiff_t)i * piece.step]);
    }
}

static void sum_piece(slide_t *slide, piece_t piece)
{
    int32_t counts[SLIDE_BLOCK];
    uint64_t *const total = slide->total + (slide->summed - slide->first);
    quantise(slide->quantisation, piece, counts);
    for (size_t i = 0; i < piece.count; i++) {
        total[i + 1U] = total[i] + (uint64_t)(int64_t)counts[i];
    }
    slide->summed += piece.count;
}

/* Sums up to `end` places, at most SLIDE_BLOCK more: image, record, image. */
static void sum_up(slide_t *slide, size_t end)
{
    const double *const values = slide->record.values;
    const size_t count = slide->record.count;
    const size_t part[] = {slide->mirrored, slide->mirrored + count, places_of(slide)};
    for (size_t p = 0; p < 3U; p++) {
        const size_t at = slide->summed;
        const size_t to = (end < part[p]) ? end : part[p];
        const size_t i = (at >= slide->mirrored) ? (at - slide->mirrored) : 0U;
        const size_t place =
            (p == 0U) ? (slide->mirrored - 1U - at) : ((p == 1U) ? i : (2U * count - 1U - i));
        if (at < to) {
            sum_piece(slide, (piece_t){values + place, (p == 1U) ? 1 : -1, to - at});
        }
    }
}

/* The sum of so many places. */
static const uint64_t *total_at(const slide_t *slide, size_t places)
{
    return slide->total + (places - slide->first);
}

/* Newest samples that are equal, before a place. */
static uint32_t equal_before(slide_t *slide, size_t end)
{
    const uint64_t *const total = slide->total - slide->first;
    for (size_t i = end; i > slide->equal_to; i--) {
        if ((i > 1U) && ((total[i] - total[i - 1U]) != (total[i - 1U] - total[i - 2U]))) {
            slide->equal_from = i - 1U;
            break;
        }
    }
    slide->equal_to = end;
    const size_t equal = end - slide->equal_from;
    return (equal < 1024U) ? (uint32_t)equal : 1024U;
}

void slide_next(slide_t *slide, size_t rows)
{
    slide->begin += slide->block;
    slide->block = rows;
    (void)equal_before(slide, slide->begin - 1U);
    const size_t newest = slide->begin + rows - 1U;
    const size_t length = slide->config->window.longest;
    if (newest - slide->first >= slide->room) {
        const size_t oldest = slide->begin - 1U - length; /* the room has more than that */
        memmove(slide->total, total_at(slide, oldest),
                (slide->summed + 1U - oldest) * sizeof *slide->total);
        slide->first = oldest;
    }
    sum_up(slide, newest);
}

/* --- deviations (1.1) ------------------------------------------------------------------------- */

/* The difference of m samples that begins at these cumulative sums; 0 if m is 0. */
static inline uint64_t difference(const uint64_t *total, size_t m)
{
    return total[2U * m] - 2U * total[m] + total[0];
}

/* high 2^64 + low */
typedef struct {
    uint64_t high;
    uint64_t low;
} exact_t;

static inline exact_t exact(slide_sum_t sum, uint32_t shift)
{
    const uint64_t mask = (UINT64_C(1) << shift) - 1U;
    const uint64_t middle = 2U * sum.mixed + (sum.lower >> shift);
    const uint64_t upper = sum.upper + (uint64_t)((int64_t)middle >> shift);
    const uint64_t rest = ((middle & mask) << shift) | (sum.lower & mask);
    return (exact_t){.high = upper >> (64U - 2U * shift), .low = (upper << (2U * shift)) | rest};
}

static inline uint32_t level_of(uint64_t high, uint64_t low)
{
    const davar_u128_t sum = {.low = low, .high = high};
    return scaled_level(scaled_of_u128(&sum));
}

/* Rows in which a difference enters the window, or one leaves it, or both, or none. */
typedef struct {
    const uint64_t *head; /* the sums where the entering difference begins, row by row */
    const uint64_t *tail;
    size_t enters; /* the cluster size, or 0: none enters */
    size_t leaves;
    size_t rows;
} glide_t;

/* Where the running sums of squares go, and their divisors. */
typedef struct {
    uint64_t upper[SLIDE_BLOCK];
    uint64_t mixed[SLIDE_BLOCK];
    uint64_t lower[SLIDE_BLOCK];
    double divisor[SLIDE_BLOCK];
} sums_t;

/* A compiler can turn every loop of these functions into vectors, except for running sums. */
static inline void gain_small(const glide_t *along, uint64_t *gain)
{
    for (size_t i = 0; i < along->rows; i++) {
        const uint64_t enters = difference(along->head + i, along->enters);
        const uint64_t leaves = difference(along->tail + i, along->leaves);
        gain[i] = (uint64_t)((int64_t)(int32_t)(enters - leaves) * (int32_t)(enters + leaves));
    }
}

static inline void gain_split(const glide_t *along, uint32_t shift, sums_t *sums, size_t row)
{
    const uint64_t mask = (UINT64_C(1) << shift) - 1U;
    for (size_t i = 0; i < along->rows; i++) {
        const uint64_t enters = difference(along->head + i, along->enters);
        const uint64_t leaves = difference(along->tail + i, along->leaves);
        const uint64_t upper_in = (uint64_t)((int64_t)enters >> shift);
        const uint64_t upper_out = (uint64_t)((int64_t)leaves >> shift);
        const uint64_t lower_in = enters & mask;
        const uint64_t lower_out = leaves & mask;
        sums->upper[row + i] = (upper_in - upper_out) * (upper_in + upper_out);
        sums->mixed[row + i] = upper_in * lower_in - upper_out * lower_out;
        sums->lower[row + i] = (lower_in - lower_out) * (lower_in + lower_out);
    }
}

/* Rows up to the next gap that an edge of the window meets. */
static inline glide_t glide_from(const slide_t *slide, slide_cluster_t *cluster, size_t m,
                                 size_t row)
{
    const size_t end = slide->begin + row;
    const size_t longest = slide->config->window.longest;
    const size_t left = slide->block - row;
    const alike_t in = spans_at(slide->ends, &cluster->head, end, 2U * m);
    alike_t out = {false, longest + 1U - end};
    if (end > longest) {
        out = spans_at(slide->ends, &cluster->tail, end - longest - 1U + 2U * m, 2U * m);
    }
    const size_t both = (in.count < out.count) ? in.count : out.count;
    return (glide_t){.head = total_at(slide, in.is_whole ? (end - 2U * m) : end),
                     .tail = total_at(slide, out.is_whole ? (end - longest - 1U) : end),
                     .enters = in.is_whole ? m : 0U,
                     .leaves = out.is_whole ? m : 0U,
                     .rows = (both < left) ? both : left};
}

static inline void divide(slide_cluster_t *cluster, const glide_t *along, size_t m, double *divisor)
{
    const double squares = (double)(2U * m * m);
    const int32_t more = ((along->enters > 0U) ? 1 : 0) - ((along->leaves > 0U) ? 1 : 0);
    int32_t count = (int32_t)cluster->differences;
    for (size_t i = 0; i < along->rows; i++) {
        count += more;
        divisor[i] = squares * count;
    }
    cluster->differences = (uint32_t)count;
}

/* The sum as a double, rounded once: both parts are exact. It has less than 62 bits. */
static inline double rounded_small(uint64_t sum)
{
    return (double)(int32_t)(sum >> 31U) * 0x1p31 + (double)(int32_t)(sum & INT32_MAX);
}

static inline void squares_small(slide_cluster_t *cluster, size_t rows, uint64_t *sums,
                                 double *squares, uint32_t *level)
{
    uint64_t sum = cluster->sum.upper;
    for (size_t i = 0; i < rows; i++) {
        sum += sums[i];
        sums[i] = sum;
    }
    cluster->sum.upper = sum;
    for (size_t i = 0; i < rows; i++) {
        squares[i] = rounded_small(sums[i]);
    }
    for (size_t i = 0; (level != NULL) && (i < rows); i++) {
        level[i] = level_of(0U, sums[i]);
    }
}

/* Each half of 64 bits is rounded, then their sum, as in an instance. */
static inline void squares_split(slide_cluster_t *cluster, size_t rows, uint32_t shift,
                                 const sums_t *sums, double *squares, uint32_t *level)
{
    slide_sum_t sum = cluster->sum;
    for (size_t i = 0; i < rows; i++) {
        sum.upper += sums->upper[i];
        sum.mixed += sums->mixed[i];
        sum.lower += sums->lower[i];
        const exact_t whole = exact(sum, shift);
        squares[i] = (double)(int64_t)whole.high * 0x1p64 + (double)whole.low;
        if (level != NULL) {
            level[i] = level_of(whole.high, whole.low);
        }
    }
    cluster->sum = sum;
}

static inline void deviations(slide_t *slide, size_t t, double *adev)
{
    slide_cluster_t *const cluster = &slide->cluster[t];
    const size_t m = slide->config->taus[t];
    const double unit = slide->config->unit_per_count;
    uint32_t *const level = (t == 0U) ? slide->level : NULL;
    sums_t sums;
    for (size_t row = 0; row < slide->block;) {
        const glide_t along = glide_from(slide, cluster, m, row);
        if (slide->shift == 0U) {
            gain_small(&along, sums.upper + row);
        } else {
            gain_split(&along, slide->shift, &sums, row);
        }
        divide(cluster, &along, m, sums.divisor + row);
        row += along.rows;
    }
    if (slide->shift == 0U) {
        squares_small(cluster, slide->block, sums.upper, adev, level);
    } else {
        squares_split(cluster, slide->block, slide->shift, &sums, adev, level);
    }
    for (size_t i = 0; i < slide->block; i++) {
        // cppcheck-suppress uninitvar ; divide() writes it
        adev[i] = sqrt(adev[i] / sums.divisor[i]) * unit;
    }
}

typedef void deviations_function_t(slide_t *slide, size_t t, double *adev);

FOR_AVX2 static void deviations_avx2(slide_t *slide, size_t t, double *adev)
{
    deviations(slide, t, adev);
}

FOR_AVX512 static void deviations_avx512(slide_t *slide, size_t t, double *adev)
{
    deviations(slide, t, adev);
}

void slide_deviations(slide_t *slide, size_t t, double *adev)
{
    deviations_function_t *const here =
        HAS_AVX512 ? deviations_avx512 : (HAS_AVX2 ? deviations_avx2 : deviations);
    here(slide, t, adev);
}

/* --- a change of the window (4.5) ------------------------------------------------------------- */

/* True if the level of the window says whether it has changed: it is full, without mirror images. */
static bool is_comparable(const slide_t *slide, size_t i)
{
    const size_t end = slide->begin + i;
    return (slide->config->taus[0] == 1U) &&
           (end >= slide->mirrored + slide->config->window.longest) &&
           (end <= slide->mirrored + slide->record.count);
}

/* Between the rows that keep a level (past_next), all are compared with the same one. */
void slide_changes(slide_t *slide, double *changed)
{
    const uint32_t longest = slide->config->window.longest;
    for (size_t i = 0; i < slide->block;) {
        const uint32_t level = is_comparable(slide, i) ? slide->level[i] : PAST_UNKNOWN;
        changed[i++] = past_next(&slide->past, 1U, longest, level) ? 1.0 : 0.0;
        const uint32_t older = slide->past.level[1];
        for (; (i < slide->block) && (slide->past.wait > 1U); slide->past.wait--, i++) {
            const bool compares = (older > 0U) && is_comparable(slide, i);
            changed[i] =
                (compares && scaled_levels_differ(slide->level[i], older, longest)) ? 1.0 : 0.0;
        }
    }
}

/* --- windows ---------------------------------------------------------------------------------- */

uint32_t slide_length(const slide_t *slide, size_t row)
{
    const size_t grown = slide->shortest + row;
    const uint32_t longest = slide->config->window.longest;
    return (grown < longest) ? (uint32_t)grown : longest;
}

uint32_t slide_mirrored(const slide_t *slide, size_t row)
{
    const size_t before = (row < slide->mirrored) ? (slide->mirrored - row) : 0U;
    const size_t end = row + slide->mirrored;
    const size_t after = (end > slide->record.count) ? (end - slide->record.count) : 0U;
    return (slide->mirrored > 0U) ? (uint32_t)(before + after) : 0U;
}

uint32_t slide_epoch(const slide_t *slide, size_t row)
{
    return (uint32_t)((slide->mirrored > 0U) ? row : (slide->shortest - 1U + row));
}

void slide_count(slide_t *slide, size_t row, davar_result_t *result)
{
    const size_t end = slide->shortest + row;
    size_t from = end - slide_length(slide, row);
    while (slide->ends[slide->oldest] <= from) {
        slide->oldest++;
    }
    for (uint8_t t = 0; t < result->tau_count; t++) {
        result->tau[t].differences = 0U;
    }
    for (size_t run = slide->oldest; from < end; run++) {
        const size_t to = (slide->ends[run] < end) ? slide->ends[run] : end;
        for (uint8_t t = 0; t < result->tau_count; t++) {
            const size_t span = 2U * (size_t)slide->config->taus[t];
            const size_t above = to - from + 1U;
            result->tau[t].differences += (above > span) ? (uint32_t)(above - span) : 0U;
        }
        from = to;
    }
    result->equal_samples = equal_before(slide, end);
}

/* --- from the first place to the first row ---------------------------------------------------- */

/* An instance has completed an epoch at each sample before the first row, centred windows none. */
static void lead_in(slide_t *slide)
{
    double unused[SLIDE_BLOCK];
    slide->begin = 1U;
    for (size_t left = slide->shortest - 1U; left > 0U; left -= slide->block) {
        slide_next(slide, (left < SLIDE_BLOCK) ? left : SLIDE_BLOCK);
        for (size_t t = 0; t < slide->config->tau_count; t++) {
            slide_deviations(slide, t, unused);
        }
        if (slide->mirrored == 0U) {
            slide_changes(slide, unused);
        }
    }
}

bool slide_open(slide_t *slide, const davar_config_t *config, bool is_centred,
                const quantisation_t *quantisation, const extent_t *extent,
                const slide_record_t *record)
{
    const size_t longest = config->window.longest;
    *slide = (slide_t){.config = config,
                       .quantisation = quantisation,
                       .record = *record,
                       .mirrored = is_centred ? (longest / 2U) : 0U,
                       .shortest = is_centred ? longest : config->window.shortest};
    if ((quantisation->number == DAVAR_PORT_F32) || (config->law != NULL) ||
        (config->moments.segment > 0U) || (config->stride != 1U) || (record->count < longest) ||
        ((record->runs > config->window.gaps_max) && (config->window.gaps_max < longest))) {
        return false;
    }
    const int64_t low = quantise_count(quantisation, extent->low);
    const int64_t high = quantise_count(quantisation, extent->high);
    slide->rows = is_centred ? record->count : (record->count - slide->shortest + 1U);
    slide->room = 2U * longest + (size_t)16U * SLIDE_BLOCK;
    slide->total = calloc(slide->room, sizeof *slide->total);
    if (!split(slide, (uint64_t)(high - low)) || (slide->total == NULL) || !place_runs(slide)) {
        return false;
    }
    lead_in(slide);
    return true;
}

void slide_close(slide_t *slide)
{
    free(slide->total);
    free(slide->ends);
    slide->total = NULL;
    slide->ends = NULL;
}
