/* davar for Python - the Allan deviations of a fixed window that slides over a complete record, at
 * every sample. The sums are exact whole numbers, so the deviations match an instance bit
 * for bit. Loops over a complete record use vectors and take a quarter of the time. */
#ifndef SLIDE_H
#define SLIDE_H

#include "centred/past.h"
#include "davar/davar.h"
#include "recording/quantise.h"

#define SLIDE_BLOCK 1024U

/* Sum of the squares of differences (upper 2^shift + lower). */
typedef struct {
    uint64_t upper; /* of upper^2 */
    uint64_t mixed; /* of upper lower, signed */
    uint64_t lower; /* of lower^2 */
} slide_sum_t;

typedef struct {
    const davar_config_t *config;
    bool is_centred; /* set it before slide_open */
    size_t count;    /* samples of the record */
    size_t mirrored; /* samples of the mirror image before the record, and after it */
    size_t shortest; /* the window of the first row; it grows to the longest */
    size_t rows;
    uint32_t shift;
    uint64_t *total;                 /* cumulative sums of record and mirror images, modulo 2^64 */
    slide_sum_t sum[DAVAR_TAUS_MAX]; /* of the window of the newest row */
    past_t past;                     /* up to the newest row */
    uint32_t equal;                  /* newest samples that are equal, of the newest row */
    uint32_t level[SLIDE_BLOCK];     /* of the first sum of each row of the block (4.5) */
} slide_t;

/* Needs integers, a fixed window without moments, stride 1, a record without a gap that is at least
 * as long as the window, and longest window times largest cluster size times range of the counts
 * up to about 2^60. False: one of these is missing, or memory. values: admitted numbers
 * (quantise_admit). Close it in both cases. Cost: O(count). */
bool slide_open(slide_t *slide, const davar_config_t *config, const quantisation_t *quantisation,
                const double *values, size_t count);

/* The samples in the window of a row, and how many of them are mirror images. */
uint32_t slide_length(const slide_t *slide, size_t row);
uint32_t slide_mirrored(const slide_t *slide, size_t row);

/* The epoch of a row: a sample of the record. */
uint32_t slide_epoch(const slide_t *slide, size_t row);

/* Deviations of tau t in `rows` (at most SLIDE_BLOCK) rows; NaN without a difference. Call it for
 * every row in order. */
void slide_deviations(slide_t *slide, size_t t, size_t row, size_t rows, double *adev);

/* The next row: its newest equal samples, up to 1024, and whether the window has changed (4.5). It
 * is in the block that slide_deviations has written from row `first` on. */
void slide_next(slide_t *slide, size_t first, size_t row, davar_result_t *result);

void slide_close(slide_t *slide);

#endif
