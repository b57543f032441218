/* davar - select: what its source files share. */
#ifndef DAVAR_SRC_SELECT_PARTS_H
#define DAVAR_SRC_SELECT_PARTS_H

#include "davar/select.h"
#include "number/strict.h"

#define SELECT_FOLLOW 0.15F  /* weight of a block in the recent means */
#define SELECT_MEMORY 100.0F /* blocks that offsets and own noise are averaged over */
#define SELECT_BLOCKS 4096U  /* of the long means */
#define SELECT_MOST 1e30F    /* of a sum of squares, also if it is absent */
#define SELECT_LEAST 1e-30F  /* keeps quotients finite where a sum of squares is 0 */

/* An alarm needs more evidence than a switch: up to twice as many pairs as candidates, and no part
 * of the threshold is omitted (13.4). */
#define SELECT_ALARM_MORE 2.7F

/* The evaluation of one block. Masks have a bit for each gyro. */
typedef struct {
    davar_select_t *select;
    float square[DAVAR_SELECT_GYROS];    /* of this block, over all axes */
    float tolerance[DAVAR_SELECT_GYROS]; /* of its mean, times the samples of a block (13.7) */
    float
        shared; /* sum over pairs of twice the covariance, over the product of their noise (13.5) */
    float shared_weight; /* sum of the inverse products */
    float mismatch;      /* the most that common motion adds to the difference of a pair (13.2) */
    float apart;         /* least recent mean of a pair, of three live gyros or more */
    uint32_t complete;   /* no sample was missing */
    uint32_t live;       /* neither absent nor stuck */
    uint32_t usable;     /* of these, without a fault of the mean */
} select_step_t;

static inline float davar_select_lesser(float a, float b)
{
    return (a < b) ? a : b;
}

static inline bool davar_select_has(uint32_t mask, uint32_t i)
{
    return ((mask >> i) & 1U) != 0U;
}

/* The number of the pair of two gyros, by their numbers. */
extern const uint8_t davar_select_pair_of[DAVAR_SELECT_GYROS][DAVAR_SELECT_GYROS];

static inline davar_select_pair_t *davar_select_pair(const davar_select_t *select, uint32_t i,
                                                     uint32_t j)
{
    return &select->pair[davar_select_pair_of[i][j]];
}

/* Gathers the evidence that other gyros are quieter than the chosen one (13.2). The recent means
 * must not contain this block yet. */
void davar_select_gather(const select_step_t *step);

/* Chooses a usable gyro, from the evidence or, without a usable one before, from the weights. */
void davar_select_choose(const select_step_t *step, davar_select_verdict_t *verdict);

/* Adds the block to the recent means, tests the means of every pair of live gyros, and names a gyro
 * that disagrees with all others (13.7). @return True if a pair disagrees. */
bool davar_select_compare_pairs(select_step_t *step);

/* Estimates the own noise of each live gyro (13.5), tests it against its past (13.8), and sets the
 * weights and `hidden` (13.6). */
void davar_select_weigh(const select_step_t *step, davar_select_verdict_t *verdict);

#endif
