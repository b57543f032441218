/* davar - select: what the pages of this room share. */
#ifndef DAVAR_SRC_SELECT_PARTS_H
#define DAVAR_SRC_SELECT_PARTS_H

#include "davar/select.h"
#include "number/strict.h"

#define SELECT_MEMORY 100.0F /* blocks that offsets and own noise are averaged over */
#define SELECT_FOLLOW 0.15F  /* weight of a block in the recent means */
#define SELECT_RECENT ((2.0F / SELECT_FOLLOW) - 1.0F) /* blocks that a recent mean is worth */
#define SELECT_BLOCKS 4096U                           /* of the long means */
#define SELECT_LEAST 1e-30F /* keeps quotients finite where a sum of squares is 0 */

/* An alarm needs more evidence than a switch: up to twice as many pairs as candidates, and no part
 * of the threshold is left out (13.4). */
#define SELECT_ALARM_MORE 2.7F

/* Sums of squared steps. */
typedef struct {
    float square[DAVAR_SELECT_GYROS];
    float apart[DAVAR_SELECT_PAIRS(DAVAR_SELECT_GYROS)];
} select_moments_t;

/* The evaluation of one block. */
typedef struct {
    davar_select_t *select;
    select_moments_t now;    /* of this block */
    select_moments_t recent; /* means over the blocks before it */
    uint32_t live;           /* gyros with samples that move */
    uint32_t usable;         /* of these, without a fault of the mean */
    bool hidden;
} select_step_t;

/* The pair of two gyros, in any order. */
static inline uint32_t davar_select_pair(uint32_t i, uint32_t j)
{
    return (i < j) ? ((j * (j - 1U) / 2U) + i) : ((i * (i - 1U) / 2U) + j);
}

static inline bool davar_select_has(uint32_t mask, uint32_t i)
{
    return ((mask >> i) & 1U) != 0U;
}

/* Degrees of freedom of a block of white noise (13.1). */
static inline float davar_select_freedom(const davar_select_config_t *config)
{
    return (2.0F / 3.0F) * (float)((uint32_t)config->block * config->axes);
}

/* Tests the means of every pair of live gyros, and names a gyro that disagrees with all others
 * (13.7). @return True if a pair disagrees. */
bool davar_select_compare_means(const select_step_t *step, const davar_select_block_t *block);

/* Estimates the own noise of each live gyro (13.5), and tests it against its past (13.8). */
void davar_select_measure_noise(const select_step_t *step);

/* Weights of the usable gyros (13.6). */
void davar_select_weigh(const select_step_t *step, float *weight);

#endif
