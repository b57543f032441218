/* davar for Python - the Allan deviations of a fixed window that slides over a complete record, at
 * every sample. The sums are exact whole numbers, so the deviations match an instance bit
 * for bit. Loops over blocks of rows use vectors. A gap costs the rows whose windows have it at an
 * edge. */
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

/* A cluster size, and the window up to the end of the newest block. */
typedef struct {
    slide_sum_t sum;
    uint32_t differences; /* in the sum */
    size_t head;          /* run of the difference that entered last */
    size_t tail;          /* run of the difference that left last */
} slide_cluster_t;

/* A record and, for centred windows, its mirror images before and after it. Each sample or image is
 * a place. A window ends before a place. */
typedef struct {
    const double *values;
    size_t count;
    const size_t *ends; /* ascending ends of the runs without a gap inside; the last is `count` */
    size_t runs;
} slide_record_t;

typedef struct {
    const davar_config_t *config;
    const quantisation_t *quantisation;
    slide_record_t record;
    size_t mirrored; /* places of the mirror image before the record, and after it */
    size_t shortest; /* the window of the first row; it grows to the longest */
    size_t rows;
    uint32_t shift;
    size_t *ends;    /* of the runs, in places; the last is the number of all places */
    uint64_t *total; /* cumulative sums modulo 2^64, from that of `first` places on */
    size_t room;     /* sums */
    size_t first;
    size_t summed; /* places; the newest sum */
    size_t begin;  /* the ends of the windows in the block are begin .. begin + block - 1 */
    size_t block;
    slide_cluster_t cluster[DAVAR_TAUS_MAX];
    past_t past;                 /* up to the block */
    size_t equal_to;             /* the samples before this place are equal.. */
    size_t equal_from;           /* ..from this one on */
    size_t oldest;               /* run of the oldest sample of slide_differences' last row */
    uint32_t level[SLIDE_BLOCK]; /* of the first sum of each window of the block (4.5) */
} slide_t;

/* Needs integers, a fixed window without moments, stride 1, a record that is at least as long as
 * the window, fewer gaps than restart an instance, and longest window times largest cluster size
 * times range of the counts up to about 2^60. False: one of these is missing, or memory. The values
 * are admitted numbers (quantise_admit) and must stay, as must their ends. Close it in both
 * cases. */
bool slide_open(slide_t *slide, const davar_config_t *config, bool is_centred,
                const quantisation_t *quantisation, const extent_t *extent,
                const slide_record_t *record);

/* The samples in the window of a row, and how many of them are mirror images. */
uint32_t slide_length(const slide_t *slide, size_t row);
uint32_t slide_mirrored(const slide_t *slide, size_t row);

/* The epoch of a row: a sample of the record. */
uint32_t slide_epoch(const slide_t *slide, size_t row);

/* Goes on to the next `rows` rows (at most SLIDE_BLOCK), the block. */
void slide_next(slide_t *slide, size_t rows);

/* Deviations of tau t in the rows of the block; NaN without a difference. Call it once for each
 * tau, the first one first. */
void slide_deviations(slide_t *slide, size_t t, double *adev);

/* Has the window changed (4.5)? 0 or 1 for each row of the block. Call it once, after the first
 * tau. */
void slide_changes(slide_t *slide, double *changed);

/* Counts the differences in the window of a row of the block, and its newest equal samples, up to
 * 1024. Call it for ascending rows. */
void slide_count(slide_t *slide, size_t row, davar_result_t *result);

void slide_close(slide_t *slide);

#endif
