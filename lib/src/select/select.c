/* davar - select: which of the gyros is quieter (13.2) to (13.4). It uses only operations that IEEE
 * 754 rounds correctly, so every target computes the same bits. */
#include "select/select_parts.h"

#define FAINT 0.16F  /* contrast below which no evidence grows: noise ratio 1.17 (13.2) */
#define MARGIN 1.07F /* true spread over the learned one (13.3) */
#define PRIOR 64U    /* blocks that the first spread is worth */
#define STEPS 8.0F   /* least number of blocks of a decision */
#define RETURN 2.0F  /* part of the threshold that the return to 0 replaces (13.4) */
#define STILL 3U     /* blocks without a step until an axis is stuck */
#define RECOVERY 20U /* blocks of good samples until a gyro is used again */

/* ln of a number of at least 1, within 0.004 */
static float logarithm(float x)
{
    float sum = 0.0F;
    float rest = x;
    while (rest >= 2.0F) {
        rest *= 0.5F;
        sum += 0.6931472F;
    }
    const float t = (rest - 1.0F) / (rest + 1.0F);
    return sum + (2.0F * t * (1.0F + (t * t * (1.0F / 3.0F))));
}

static bool is_within(float value, float low, float high)
{
    return (value >= low) && (value <= high);
}

static bool is_valid(const davar_select_config_t *config)
{
    return is_within((float)config->gyros, 2.0F, (float)DAVAR_SELECT_GYROS) &&
           is_within((float)config->axes, 1.0F, (float)DAVAR_SELECT_AXES) &&
           is_within((float)config->block, 4.0F, 1000.0F) &&
           is_within((float)config->block, 0.04F * config->rate_hz, 0.25F * config->rate_hz) &&
           is_within(config->errors_per_1000_h, 1e-3F, 1e6F) &&
           is_within(config->scale_tolerance, 1e-9F, 1.0F) &&
           is_within(config->time_tolerance_s, 1e-9F, 1.0F) &&
           is_within(config->drift_tolerance_dps_per_s, 1e-9F, 1.0F);
}

bool davar_select_init(davar_select_t *select, const davar_select_config_t *config,
                       davar_select_gyro_t *gyro, davar_select_pair_t *pair,
                       davar_select_block_t *block)
{
    DAVAR_ASSERT((select != NULL) && (config != NULL) && (gyro != NULL) && (pair != NULL));
    if (!is_valid(config)) {
        return false;
    }
    const float blocks = 3.6e6F * config->rate_hz / (float)config->block; /* in 1000 hours */
    const float tests = blocks * (float)(config->gyros - 1U);
    *select = (davar_select_t){.config = config,
                               .gyro = gyro,
                               .pair = pair,
                               .threshold = logarithm(tests / config->errors_per_1000_h) - RETURN};
    *block = (davar_select_block_t){.count = 0U};
    for (uint32_t i = 0U; i < config->gyros; i++) {
        gyro[i] = (davar_select_gyro_t){.spread = 2.0F / (davar_select_freedom(config) + 1.0F)};
    }
    for (uint32_t p = 0U; p < DAVAR_SELECT_PAIRS((uint32_t)config->gyros); p++) {
        pair[p] = (davar_select_pair_t){.recent = 0.0F};
    }
    return true;
}

/* --- which gyros deliver --- */

/* Did every axis move? */
static bool has_moved(const davar_select_config_t *config, const davar_select_block_t *block,
                      uint32_t i)
{
    const uint32_t all = (1U << config->axes) - 1U;
    return (((uint32_t)block->moved >> (i * DAVAR_SELECT_AXES)) & all) == all;
}

static void judge_samples(davar_select_gyro_t *gyro, bool missing, bool moved)
{
    uint8_t fault = missing ? DAVAR_SELECT_ABSENT : 0U;
    if (moved || missing) {
        gyro->still = 0U;
    } else {
        gyro->still = (uint8_t)((gyro->still < STILL) ? (gyro->still + 1U) : STILL);
        fault = (gyro->still == STILL) ? DAVAR_SELECT_STUCK : 0U;
    }
    if (fault != 0U) {
        gyro->fault |= fault;
        gyro->wait = (gyro->wait > RECOVERY) ? gyro->wait : RECOVERY;
    } else if (gyro->wait > 0U) {
        gyro->wait--;
    } else {
        gyro->fault &= (uint8_t)DAVAR_SELECT_NOISE;
    }
}

/* Adds a block to a recent mean. @return The mean before. */
static float follow(float *recent, float now)
{
    const float before = (*recent > 0.0F) ? *recent : now;
    *recent = before + (SELECT_FOLLOW * (now - before));
    return before;
}

static void take_gyro(select_step_t *step, const davar_select_block_t *block, uint32_t i)
{
    davar_select_t *const select = step->select;
    davar_select_gyro_t *const gyro = &select->gyro[i];
    const bool missing = davar_select_has(block->missing, i);
    judge_samples(gyro, missing, has_moved(select->config, block, i));
    if ((gyro->fault & (DAVAR_SELECT_ABSENT | DAVAR_SELECT_STUCK)) == 0U) {
        step->live |= 1U << i;
    }
    step->now.square[i] = block->square[i];
    step->recent.square[i] = missing ? gyro->recent : follow(&gyro->recent, block->square[i]);
    for (uint32_t j = 0U; j < i; j++) {
        const uint32_t p = davar_select_pair(j, i);
        float *const recent = &select->pair[p].recent;
        const bool both = !missing && !davar_select_has(block->missing, j);
        step->now.apart[p] = block->apart[p];
        step->recent.apart[p] = both ? follow(recent, block->apart[p]) : *recent;
    }
}

static void take_block(select_step_t *step, const davar_select_block_t *block)
{
    for (uint32_t i = 0U; i < step->select->config->gyros; i++) {
        take_gyro(step, block, i);
    }
}

/* Do only two gyros live, and share more than they differ by? */
static bool is_hidden(const select_step_t *step)
{
    uint32_t found[DAVAR_SELECT_GYROS] = {0U, 0U, 0U, 0U};
    uint32_t count = 0U;
    for (uint32_t i = 0U; i < step->select->config->gyros; i++) {
        if (davar_select_has(step->live, i)) {
            found[count] = i;
            count++;
        }
    }
    return (count == 2U) && ((step->recent.square[found[0]] + step->recent.square[found[1]]) >
                             (2.0F * step->recent.apart[davar_select_pair(found[0], found[1])]));
}

/* --- which one --- */

/* The third gyro from which i and j differ least, or i if their totals are less. */
static uint32_t third_of(const select_step_t *step, uint32_t i, uint32_t j)
{
    float least = step->recent.square[i] + step->recent.square[j];
    uint32_t third = i;
    for (uint32_t k = 0U; k < step->select->config->gyros; k++) {
        if ((k != i) && (k != j) && davar_select_has(step->live, k)) {
            const float sum = step->recent.apart[davar_select_pair(i, k)] +
                              step->recent.apart[davar_select_pair(j, k)];
            third = (sum < least) ? k : third;
            least = (sum < least) ? sum : least;
        }
    }
    return third;
}

/* (13.2): -1 .. 1, above 0 where j is quieter than i. */
static float contrast_of(const select_moments_t *moments, uint32_t i, uint32_t j, uint32_t third)
{
    const bool totals = (third == i);
    const float a = totals ? moments->square[i] : moments->apart[davar_select_pair(i, third)];
    const float b = totals ? moments->square[j] : moments->apart[davar_select_pair(j, third)];
    return (a - b) / (a + b + SELECT_LEAST);
}

static void gather(const select_step_t *step, uint32_t j)
{
    const davar_select_t *const select = step->select;
    davar_select_gyro_t *const gyro = &select->gyro[j];
    const uint32_t third = third_of(step, select->chosen, j);
    const float contrast = contrast_of(&step->now, select->chosen, j, third);
    const float change = contrast - contrast_of(&step->recent, select->chosen, j, third);
    if (!step->hidden) {
        gyro->spread += ((change * change) - gyro->spread) / (float)(select->blocks + PRIOR);
    }
    const float least = 1.0F / (davar_select_freedom(select->config) + 1.0F);
    const float spread = (gyro->spread > least) ? gyro->spread : least;
    const float step_of_sum = (2.0F * FAINT / (MARGIN * spread)) * (contrast - FAINT);
    const float most = select->threshold / STEPS;
    const float sum = gyro->evidence + ((step_of_sum < most) ? step_of_sum : most);
    gyro->evidence = (sum > 0.0F) ? sum : 0.0F;
}

static void forget(const davar_select_t *select)
{
    for (uint32_t j = 0U; j < select->config->gyros; j++) {
        select->gyro[j].evidence = 0.0F;
    }
}

/* The candidate with the most evidence beyond the threshold; else the chosen one. */
static uint32_t quieter(const select_step_t *step)
{
    const davar_select_t *const select = step->select;
    uint32_t best = select->chosen;
    float most = select->threshold;
    for (uint32_t j = 0U; j < select->config->gyros; j++) {
        if ((j != select->chosen) && davar_select_has(step->usable, j)) {
            gather(step, j);
            const bool better = select->gyro[j].evidence > most;
            most = better ? select->gyro[j].evidence : most;
            best = better ? j : best;
        } else {
            select->gyro[j].evidence = 0.0F;
        }
    }
    return best;
}

/* The gyro with the largest weight; the chosen one if none has any. */
static uint32_t heaviest(const davar_select_t *select, const float *weight)
{
    uint32_t best = select->chosen;
    for (uint32_t j = 0U; j < select->config->gyros; j++) {
        best = (weight[j] > weight[best]) ? j : best;
    }
    return best;
}

static void choose(const select_step_t *step, davar_select_verdict_t *verdict)
{
    davar_select_t *const select = step->select;
    const uint32_t best = davar_select_has(step->usable, select->chosen)
                              ? quieter(step)
                              : heaviest(select, verdict->weight);
    verdict->switched = (best != select->chosen);
    if (verdict->switched) {
        select->gyro[select->chosen].spread = select->gyro[best].spread; /* of the same pair */
        select->chosen = (uint8_t)best;
        forget(select);
    }
    verdict->chosen = select->chosen;
}

/* Keeps the last samples. Loops, because the memset of a small C library takes 4 instructions a
 * byte. */
static void empty(const davar_select_config_t *config, davar_select_block_t *block)
{
    block->moved = 0U;
    block->count = 0U;
    block->missing = 0U;
    for (uint32_t i = 0U; i < config->gyros; i++) {
        block->square[i] = 0.0F;
        for (uint32_t a = 0U; a < config->axes; a++) {
            block->sum[i][a] = 0.0F;
            block->first[i][a] = block->last[i][a];
        }
        for (uint32_t j = 0U; j < i; j++) {
            block->apart[davar_select_pair(j, i)] = 0.0F;
        }
    }
}

void davar_select_update(davar_select_t *select, davar_select_block_t *block,
                         davar_select_verdict_t *verdict)
{
    DAVAR_ASSERT((select != NULL) && (block != NULL) && (verdict != NULL));
    DAVAR_ASSERT(block->count == select->config->block);
    select_step_t step;
    step.select = select;
    step.live = 0U;
    step.usable = 0U;
    for (uint32_t i = 0U; i < DAVAR_SELECT_GYROS; i++) {
        verdict->weight[i] = 0.0F;
        verdict->fault[i] = 0U;
    }
    select->blocks =
        (uint16_t)((select->blocks < SELECT_BLOCKS) ? (select->blocks + 1U) : SELECT_BLOCKS);
    take_block(&step, block);
    step.hidden = is_hidden(&step);
    verdict->disagree = davar_select_compare_means(&step, block);
    davar_select_measure_noise(&step);
    for (uint32_t i = 0U; i < select->config->gyros; i++) {
        verdict->fault[i] = select->gyro[i].fault;
        const bool agrees = (verdict->fault[i] & DAVAR_SELECT_MEAN) == 0U;
        step.usable |= agrees ? (step.live & (1U << i)) : 0U;
    }
    davar_select_weigh(&step, verdict->weight);
    choose(&step, verdict);
    verdict->usable = (step.usable != 0U);
    verdict->hidden = step.hidden;
    empty(select->config, block);
}
