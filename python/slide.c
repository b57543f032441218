/* davar for Python - a sliding window over a record. Row r has the window that ends after
 * `shortest` + r samples of mirror image and record:
 *
 *     centred    image | record | image    always the longest window
 *     trailing   record                    it grows from the shortest to the longest
 */
#include "slide.h"
#include "bits.h"
#include "vectors.h"

#include <math.h>
#include <stdlib.h>

/* --- the cumulative sums ---------------------------------------------------------------------- */

/* The sample at a place of image, record and image. */
static size_t mirrored_place(const slide_t *slide, size_t place)
{
    if (place < slide->mirrored) {
        return slide->mirrored - 1U - place;
    }
    const size_t i = place - slide->mirrored;
    return (i < slide->count) ? i : (2U * slide->count - 1U - i);
}

/* Returns the range of the samples. */
static uint64_t accumulate(slide_t *slide, const quantisation_t *quantisation, const double *values)
{
    const size_t places = slide->count + 2U * slide->mirrored;
    int32_t low = INT32_MAX;
    int32_t high = INT32_MIN;
    uint64_t sum = 0U;
    slide->total[0] = 0U;
    for (size_t i = 0; i < places; i++) {
        const int32_t value = quantise_count(quantisation, values[mirrored_place(slide, i)]);
        low = (value < low) ? value : low;
        high = (value > high) ? value : high;
        sum += (uint64_t)(int64_t)value;
        slide->total[i + 1U] = sum;
    }
    return (uint64_t)((int64_t)high - low);
}

/* Splits differences of up to 2^bits so that no sum of products of their parts exceeds 62 bits.
 * Small ones need no split: shift 0. False: there is no such split. */
static bool split(slide_t *slide, uint64_t range)
{
    const davar_config_t *const config = slide->config;
    const uint32_t bits = bits_of(range) + bits_of(config->taus[config->tau_count - 1U]);
    const uint32_t terms = bits_of(config->window.longest);
    const uint32_t most = (62U - terms) / 2U;
    slide->shift = (2U * bits + terms <= 62U) ? 0U : ((most < 26U) ? most : 26U);
    return 2U * (bits - slide->shift) + terms <= 62U; /* bits are more than the shift */
}

bool slide_open(slide_t *slide, const davar_config_t *config, const quantisation_t *quantisation,
                const double *values, size_t count)
{
    const bool centred = slide->is_centred;
    const size_t longest = config->window.longest;
    *slide = (slide_t){.config = config,
                       .is_centred = centred,
                       .count = count,
                       .mirrored = centred ? (longest / 2U) : 0U,
                       .shortest = centred ? longest : config->window.shortest};
    if ((quantisation->number == DAVAR_PORT_F32) || (config->law != NULL) ||
        (config->moments.segment > 0U) || (config->stride != 1U) || (count < longest)) {
        return false;
    }
    slide->rows = centred ? count : (count - slide->shortest + 1U);
    slide->total = malloc((count + 2U * slide->mirrored + 1U) * sizeof *slide->total);
    return (slide->total != NULL) && split(slide, accumulate(slide, quantisation, values));
}

void slide_close(slide_t *slide)
{
    free(slide->total);
    slide->total = NULL;
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
    const size_t after = (end > slide->count) ? (end - slide->count) : 0U;
    return (slide->mirrored > 0U) ? (uint32_t)(before + after) : 0U;
}

uint32_t slide_epoch(const slide_t *slide, size_t row)
{
    return (uint32_t)((slide->mirrored > 0U) ? row : (slide->shortest - 1U + row));
}

/* --- deviations (1.1) ------------------------------------------------------------------------- */

/* The difference of m samples that begins at these cumulative sums. */
static inline uint64_t difference(const uint64_t *total, size_t m)
{
    return total[2U * m] - 2U * total[m] + total[0];
}

static void add_square(slide_sum_t *sum, uint64_t one, uint32_t shift)
{
    const uint64_t upper = (uint64_t)((int64_t)one >> shift);
    const uint64_t lower = one & ((UINT64_C(1) << shift) - 1U);
    sum->upper += upper * upper;
    sum->mixed += upper * lower;
    sum->lower += lower * lower;
}

/* high 2^64 + low */
typedef struct {
    uint64_t high;
    uint64_t low;
} exact_t;

static inline exact_t exact(slide_sum_t sum, uint32_t shift)
{
    if (shift == 0U) {
        return (exact_t){.low = sum.upper};
    }
    const uint64_t mask = (UINT64_C(1) << shift) - 1U;
    const uint64_t middle = 2U * sum.mixed + (sum.lower >> shift);
    const uint64_t upper = sum.upper + (uint64_t)((int64_t)middle >> shift);
    const uint64_t rest = ((middle & mask) << shift) | (sum.lower & mask);
    return (exact_t){.high = upper >> (64U - 2U * shift), .low = (upper << (2U * shift)) | rest};
}

/* The sum as a double, rounded as in an instance: each half of 64 bits, then their sum. */
static inline double rounded(slide_sum_t sum, uint32_t shift)
{
    const exact_t whole = exact(sum, shift);
    return (shift == 0U) ? (double)(int64_t)whole.low
                         : ((double)(int64_t)whole.high * 0x1p64 + (double)whole.low);
}

static inline uint32_t level_of(slide_sum_t sum, uint32_t shift)
{
    const exact_t whole = exact(sum, shift);
    return past_level(whole.high, whole.low);
}

/* A row whose window is longer than the one of the row before, or the first row. */
static double grown_deviation(slide_t *slide, size_t t, size_t row)
{
    const size_t m = slide->config->taus[t];
    const size_t end = slide->shortest + row;
    if (end < 2U * m) {
        return (double)NAN;
    }
    const size_t differences = end - 2U * m + 1U;
    for (size_t i = (row == 0U) ? 0U : (differences - 1U); i < differences; i++) {
        add_square(&slide->sum[t], difference(slide->total + i, m), slide->shift);
    }
    const double divisor = (double)(2U * m * m) * (double)differences;
    return sqrt(rounded(slide->sum[t], slide->shift) / divisor) * slide->config->unit_per_count;
}

/* Rows whose window moves by one sample: the difference at `head` enters, that at `tail` leaves. */
typedef struct {
    const uint64_t *head;
    const uint64_t *tail;
    size_t m;
    size_t rows;
    uint32_t shift;
    double divisor;
    double unit;
    uint32_t *level; /* NULL: not wanted */
} glide_t;

/* The running sums of squares, without a split. A compiler can turn every loop of these functions
 * into vectors, except for the sums themselves. Returns the last sum. */
static inline uint64_t glide_small(const glide_t *along, uint64_t sum, double *squares)
{
    uint64_t at[SLIDE_BLOCK];
    for (size_t i = 0; i < along->rows; i++) {
        const uint64_t enters = difference(along->head + i, along->m);
        const uint64_t leaves = difference(along->tail + i, along->m);
        at[i] = (enters - leaves) * (enters + leaves);
    }
    for (size_t i = 0; i < along->rows; i++) {
        sum += at[i];
        at[i] = sum;
    }
    for (size_t i = 0; i < along->rows; i++) {
        squares[i] = (double)(int64_t)at[i];
    }
    for (size_t i = 0; (along->level != NULL) && (i < along->rows); i++) {
        along->level[i] = past_level(0U, at[i]);
    }
    return sum;
}

static inline slide_sum_t glide_split(const glide_t *along, slide_sum_t sum, double *squares)
{
    const uint32_t shift = along->shift;
    const uint64_t mask = (UINT64_C(1) << shift) - 1U;
    uint64_t upper[SLIDE_BLOCK];
    uint64_t mixed[SLIDE_BLOCK];
    uint64_t lower[SLIDE_BLOCK];
    for (size_t i = 0; i < along->rows; i++) {
        const uint64_t enters = difference(along->head + i, along->m);
        const uint64_t leaves = difference(along->tail + i, along->m);
        const uint64_t upper_in = (uint64_t)((int64_t)enters >> shift);
        const uint64_t upper_out = (uint64_t)((int64_t)leaves >> shift);
        const uint64_t lower_in = enters & mask;
        const uint64_t lower_out = leaves & mask;
        upper[i] = (upper_in - upper_out) * (upper_in + upper_out);
        mixed[i] = upper_in * lower_in - upper_out * lower_out;
        lower[i] = (lower_in - lower_out) * (lower_in + lower_out);
    }
    for (size_t i = 0; i < along->rows; i++) {
        sum.upper += upper[i];
        sum.mixed += mixed[i];
        sum.lower += lower[i];
        upper[i] = sum.upper;
        mixed[i] = sum.mixed;
        lower[i] = sum.lower;
    }
    for (size_t i = 0; i < along->rows; i++) {
        squares[i] = rounded((slide_sum_t){upper[i], mixed[i], lower[i]}, shift);
    }
    for (size_t i = 0; (along->level != NULL) && (i < along->rows); i++) {
        along->level[i] = level_of((slide_sum_t){upper[i], mixed[i], lower[i]}, shift);
    }
    return sum;
}

/* Returns the sum of the last row. */
static inline slide_sum_t glide(const glide_t *along, slide_sum_t sum, double *adev)
{
    if (along->shift == 0U) {
        sum.upper = glide_small(along, sum.upper, adev);
    } else {
        sum = glide_split(along, sum, adev);
    }
    for (size_t i = 0; i < along->rows; i++) {
        adev[i] = sqrt(adev[i] / along->divisor) * along->unit;
    }
    return sum;
}

typedef slide_sum_t glide_function_t(const glide_t *along, slide_sum_t sum, double *adev);

FOR_AVX2 static slide_sum_t glide_avx2(const glide_t *along, slide_sum_t sum, double *adev)
{
    return glide(along, sum, adev);
}

FOR_AVX512 static slide_sum_t glide_avx512(const glide_t *along, slide_sum_t sum, double *adev)
{
    return glide(along, sum, adev);
}

static glide_function_t *glide_here(void)
{
    return HAS_AVX512 ? glide_avx512 : (HAS_AVX2 ? glide_avx2 : glide);
}

void slide_deviations(slide_t *slide, size_t t, size_t row, size_t rows, double *adev)
{
    const size_t m = slide->config->taus[t];
    const size_t longest = slide->config->window.longest;
    size_t done = 0;
    while ((done < rows) && ((row + done == 0U) || (slide->shortest + row + done <= longest))) {
        adev[done] = grown_deviation(slide, t, row + done);
        if (t == 0U) {
            slide->level[done] = level_of(slide->sum[0], slide->shift);
        }
        done++;
    }
    const size_t end = slide->shortest + row + done;
    if (done < rows) {
        const glide_t along = {.head = slide->total + (end - 2U * m),
                               .tail = slide->total + (end - longest - 1U),
                               .m = m,
                               .rows = rows - done,
                               .shift = slide->shift,
                               .divisor = (double)(2U * m * m) * (double)(longest - 2U * m + 1U),
                               .unit = slide->config->unit_per_count,
                               .level = (t == 0U) ? (slide->level + done) : NULL};
        slide->sum[t] = glide_here()(&along, slide->sum[t], adev + done);
    }
}

/* --- the newest samples, and a change (5.24, 4.5) --------------------------------------------- */

/* The place before `end` joins those that are equal. */
static void count_equal(slide_t *slide, size_t end)
{
    const uint64_t *const total = slide->total + end;
    const bool is_equal = (end > 1U) && ((total[0] - total[-1]) == (total[-1] - total[-2]));
    slide->equal = !is_equal ? 1U : ((slide->equal < 1024U) ? (slide->equal + 1U) : 1024U);
}

/* What an instance has done before its first result. */
static void precede(slide_t *slide)
{
    for (size_t end = 1U; end < slide->shortest; end++) {
        count_equal(slide, end);
        if (slide->mirrored == 0U) {
            (void)past_next(&slide->past, 1U, slide->config->window.longest, PAST_UNKNOWN);
        }
    }
}

void slide_next(slide_t *slide, size_t first, size_t row, davar_result_t *result)
{
    const davar_config_t *const config = slide->config;
    const uint32_t longest = config->window.longest;
    const bool is_known = (config->taus[0] == 1U) && (slide_length(slide, row) == longest) &&
                          (slide_mirrored(slide, row) == 0U);
    if (row == 0U) {
        precede(slide);
    }
    count_equal(slide, slide->shortest + row);
    result->equal_samples = slide->equal;
    result->unstable =
        past_next(&slide->past, 1U, longest, is_known ? slide->level[row - first] : PAST_UNKNOWN);
}
