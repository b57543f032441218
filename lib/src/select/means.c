/* davar - select: means that disagree by more than noise and tolerances (13.7). */
#include "select/select_parts.h"

#include <math.h>

#define OFFSET_KNOWN 30.0F /* blocks before a pair is tested */
#define JUMP 6.0F          /* evidence above which offset and noise stand still */
#define AGREES 100U        /* blocks until a named gyro is trusted again */

/* Of the largest of 1, 2, 3 normal numbers, without signs: the mean; and ln of the number of
 * directions. */
static const float mean_of_largest[DAVAR_SELECT_AXES] = {0.798F, 1.128F, 1.326F};
static const float directions[DAVAR_SELECT_AXES] = {0.693F, 1.386F, 1.792F};

typedef struct {
    float deviation[DAVAR_SELECT_AXES]; /* from the offset */
    float largest;
    float sigma;     /* of the deviation, for white noise */
    float tolerance; /* for the rate of this block, without drift */
} difference_t;

static float lesser(float a, float b)
{
    return (a < b) ? a : b;
}

static float larger(float a, float b)
{
    return (a > b) ? a : b;
}

static difference_t difference_of(const davar_select_t *select, const davar_select_block_t *block,
                                  uint32_t i, uint32_t j)
{
    const davar_select_config_t *const config = select->config;
    const davar_select_pair_t *const pair = &select->pair[davar_select_pair(i, j)];
    const float scale = 1.0F / (float)config->block;
    const float rate = config->scale_tolerance * scale;
    const float change = config->time_tolerance_s * config->rate_hz * scale;
    difference_t found = {
        {0.0F, 0.0F, 0.0F}, 0.0F, scale * sqrtf(pair->recent / (float)(2U * config->axes)), 0.0F};
    for (uint32_t a = 0U; a < config->axes; a++) {
        found.deviation[a] = ((block->sum[i][a] - block->sum[j][a]) * scale) - pair->offset[a];
        found.largest = larger(found.largest, fabsf(found.deviation[a]));
        found.tolerance += rate * lesser(fabsf(block->sum[i][a]), fabsf(block->sum[j][a]));
        found.tolerance += change * lesser(fabsf(block->last[i][a] - block->first[i][a]),
                                           fabsf(block->last[j][a] - block->first[j][a]));
    }
    return found;
}

/* Offset and noise follow as far as the rate permits. */
static void learn(davar_select_pair_t *pair, const difference_t *found, uint32_t axes)
{
    const float sigma = found->sigma + SELECT_LEAST;
    const float quiet = sigma / (sigma + found->tolerance);
    const float worth = (pair->known > 1.0F) ? (quiet * quiet) : 1.0F;
    pair->known = lesser(pair->known + worth, SELECT_MEMORY);
    const float gain = worth / pair->known;
    const float sigmas = found->largest / sigma;
    const float most = (pair->known > OFFSET_KNOWN) ? (4.0F * pair->noise) : sigmas;
    for (uint32_t a = 0U; a < axes; a++) {
        pair->offset[a] += gain * found->deviation[a];
    }
    pair->noise += gain * (lesser(sigmas, most) - pair->noise);
    pair->age = (pair->age + 1.0F) * (1.0F - gain);
}

static void compare(const davar_select_t *select, const davar_select_block_t *block, uint32_t i,
                    uint32_t j)
{
    const davar_select_config_t *const config = select->config;
    davar_select_pair_t *const pair = &select->pair[davar_select_pair(i, j)];
    const difference_t found = difference_of(select, block, i, j);
    if (pair->known > OFFSET_KNOWN) {
        const float drift = config->drift_tolerance_dps_per_s * pair->age *
                            ((float)config->block / config->rate_hz);
        const float beyond =
            (found.largest - found.tolerance - drift) * mean_of_largest[config->axes - 1U];
        const float noise = found.sigma * pair->noise;
        const float sigmas = (beyond < (4.0F * noise)) ? (beyond / (noise + SELECT_LEAST)) : 4.0F;
        const float sum = pair->evidence + (2.0F * (sigmas - 1.0F)) - directions[config->axes - 1U];
        const float most = 2.0F * (select->threshold + SELECT_ALARM_MORE);
        pair->evidence = (sum > 0.0F) ? lesser(sum, most) : 0.0F;
    }
    if (pair->evidence < JUMP) {
        learn(pair, &found, config->axes);
    }
}

typedef struct {
    bool alone;  /* all its pairs disagree, and no other pair even half */
    bool agrees; /* none of its pairs stands still because of a jump */
} standing_t;

static standing_t standing_of(const select_step_t *step, uint32_t i)
{
    const davar_select_t *const select = step->select;
    const float alarm = select->threshold + SELECT_ALARM_MORE;
    uint32_t mine = 0U;
    standing_t found = {true, true};
    for (uint32_t j = 1U; j < select->config->gyros; j++) {
        for (uint32_t k = 0U; k < j; k++) {
            const float evidence = select->pair[davar_select_pair(k, j)].evidence;
            if (!davar_select_has(step->live, j) || !davar_select_has(step->live, k)) {
                continue;
            }
            if ((j == i) || (k == i)) {
                mine++;
                found.alone = found.alone && (evidence > alarm);
                found.agrees = found.agrees && (evidence < JUMP);
            } else {
                found.alone = found.alone && (evidence < (0.5F * alarm));
            }
        }
    }
    found.alone = found.alone && (mine >= 2U);
    return found;
}

static void name(const select_step_t *step)
{
    for (uint32_t i = 0U; i < step->select->config->gyros; i++) {
        davar_select_gyro_t *const gyro = &step->select->gyro[i];
        const standing_t standing = standing_of(step, i);
        if (standing.alone) {
            gyro->fault |= DAVAR_SELECT_MEAN;
        }
        if (((gyro->fault & DAVAR_SELECT_MEAN) != 0U) && !standing.agrees) {
            gyro->wait = AGREES;
        }
    }
}

static bool has_named(const select_step_t *step)
{
    uint32_t faults = 0U;
    for (uint32_t i = 0U; i < step->select->config->gyros; i++) {
        faults |= step->select->gyro[i].fault;
    }
    return (faults & DAVAR_SELECT_MEAN) != 0U;
}

bool davar_select_compare_means(const select_step_t *step, const davar_select_block_t *block)
{
    const davar_select_t *const select = step->select;
    bool disagree = false;
    for (uint32_t j = 1U; j < select->config->gyros; j++) {
        for (uint32_t i = 0U; i < j; i++) {
            if (davar_select_has(step->live, i) && davar_select_has(step->live, j)) {
                compare(select, block, i, j);
                disagree = disagree || (select->pair[davar_select_pair(i, j)].evidence >
                                        (select->threshold + SELECT_ALARM_MORE));
            }
        }
    }
    if (disagree || has_named(step)) {
        name(step);
    }
    return disagree;
}
