/* davar for Python - a sliding window over a record. Row r has the window that ends after
 * `shortest` + r samples of mirror image and record:
 *
 *     centred    image | record | image    always the longest window
 *     trailing   record                    it grows from the shortest to the longest
 */
#include "slide.h"
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

/* A difference is at most m times the range of the samples. */
static bool has_room(const davar_config_t *config, uint64_t range)
{
    const double largest = (double)config->taus[config->tau_count - 1U] * (double)range;
    return largest * largest * (double)config->window.longest < 0x1p63;
}

bool slide_open(slide_t *slide, const davar_config_t *config, const quantisation_t *quantisation,
                const double *values, size_t count)
{
    const bool centred = (config->window.mode == DAVAR_MODE_CENTRED);
    const size_t longest = config->window.longest;
    *slide = (slide_t){.config = config,
                       .count = count,
                       .mirrored = centred ? (longest / 2U) : 0U,
                       .shortest = centred ? longest : config->window.shortest};
    if ((quantisation->number == DAVAR_PORT_F32) || (config->law != NULL) ||
        (config->moments.segment > 0U) || (config->stride != 1U) || (count < longest)) {
        return false;
    }
    slide->rows = centred ? count : (count - slide->shortest + 1U);
    slide->total = malloc((count + 2U * slide->mirrored + 1U) * sizeof *slide->total);
    return (slide->total != NULL) && has_room(config, accumulate(slide, quantisation, values));
}

void slide_close(slide_t *slide)
{
    free(slide->total);
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

static double deviation(const slide_t *slide, uint64_t sum, size_t m, size_t differences)
{
    const double divisor = (double)(2U * m * m) * (double)differences;
    return sqrt((double)(int64_t)sum / divisor) * slide->config->unit_per_count;
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
        const uint64_t one = difference(slide->total + i, m);
        slide->sum[t] += one * one;
    }
    return deviation(slide, slide->sum[t], m, differences);
}

/* Rows whose window moves by one sample: the difference at `head` enters, that at `tail` leaves.
 * The sums are written as doubles. Returns the last sum. */
static inline uint64_t glide(const uint64_t *head, const uint64_t *tail, size_t m, uint64_t sum,
                             size_t rows, double divisor, double unit, double *adev)
{
    uint64_t change[SLIDE_BLOCK];
    for (size_t i = 0; i < rows; i++) {
        const uint64_t enters = difference(head + i, m);
        const uint64_t leaves = difference(tail + i, m);
        change[i] = (enters - leaves) * (enters + leaves);
    }
    for (size_t i = 0; i < rows; i++) {
        sum += change[i];
        change[i] = sum;
    }
    for (size_t i = 0; i < rows; i++) {
        adev[i] = (double)(int64_t)change[i];
    }
    for (size_t i = 0; i < rows; i++) {
        adev[i] = sqrt(adev[i] / divisor) * unit;
    }
    return sum;
}

typedef uint64_t glide_function_t(const uint64_t *head, const uint64_t *tail, size_t m,
                                  uint64_t sum, size_t rows, double divisor, double unit,
                                  double *adev);

FOR_AVX2 static uint64_t glide_avx2(const uint64_t *head, const uint64_t *tail, size_t m,
                                    uint64_t sum, size_t rows, double divisor, double unit,
                                    double *adev)
{
    return glide(head, tail, m, sum, rows, divisor, unit, adev);
}

FOR_AVX512 static uint64_t glide_avx512(const uint64_t *head, const uint64_t *tail, size_t m,
                                        uint64_t sum, size_t rows, double divisor, double unit,
                                        double *adev)
{
    return glide(head, tail, m, sum, rows, divisor, unit, adev);
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
        done++;
    }
    if (done < rows) {
        const size_t end = slide->shortest + row + done;
        const double divisor = (double)(2U * m * m) * (double)(longest - 2U * m + 1U);
        slide->sum[t] = glide_here()(
            slide->total + (end - 2U * m), slide->total + (end - longest - 1U), m, slide->sum[t],
            rows - done, divisor, slide->config->unit_per_count, adev + done);
    }
}
