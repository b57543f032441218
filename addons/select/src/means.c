/* davar - select: the pairs of gyros: recent means, and rates that disagree by more than noise and
 * tolerances (13.7). */
#include "select_parts.h"

#include <math.h>

#define OFFSET_KNOWN 30.0F /* blocks before a pair is tested */
#define JUMP 6.0F          /* evidence above which offset and noise stand still */
#define AGREES 100U        /* blocks until a named gyro is trusted again */
#define SIGNS 0.6931472F   /* ln 2: an axis can deviate in two directions */
#define MEAN_SIZE 0.798F   /* of a normal number of variance 1 */
#define NOISE_MOST 64.0F   /* of gyros that are filtered to 1/64 of their bandwidth */

static const uint8_t pairs_of[DAVAR_SELECT_GYROS] = {0x0BU, 0x15U, 0x26U, 0x38U};

/* Masks with a bit for each pair of live gyros. */
typedef struct {
    uint32_t live;
    uint32_t jumps; /* its offset stands still */
    uint32_t half;  /* has half of the evidence of an alarm */
    uint32_t over;
} pairs_t;

/* Offset and noise follow as far as the rate permits. In the first deviation, all is offset. */
static void learn_pair(davar_select_pair_t *pair, const float *deviation, uint32_t axes,
                       float apart, float tolerance)
{
    const float variance = pair->recent + SELECT_LEAST;
    const float worth = variance / (variance + (tolerance * tolerance));
    pair->known = davar_select_lesser(pair->known + worth, SELECT_MEMORY);
    const float gain = worth / pair->known;
    const float most = davar_select_lesser(4.0F * pair->noise, NOISE_MOST);
    const float noise = davar_select_lesser(apart / sqrtf(variance), most);
    for (uint32_t a = 0U; a < axes; a++) {
        pair->offset[a] += gain * deviation[a];
    }
    pair->noise += gain * (1.0F - gain) * (noise - pair->noise);
    pair->age = (pair->age + 1.0F) * (1.0F - gain);
}

static void compare_means(const select_step_t *step, davar_select_pair_t *pair, uint32_t i,
                          uint32_t j)
{
    const davar_select_t *const select = step->select;
    const davar_select_gyro_t *const gyro = select->gyro;
    const uint32_t axes = select->config->axes;
    const float tolerance = davar_select_lesser(step->tolerance[i], step->tolerance[j]);
    float deviation[DAVAR_SELECT_AXES];
    float apart = 0.0F;
    for (uint32_t a = 0U; a < axes; a++) {
        deviation[a] = gyro[i].sum[a] - gyro[j].sum[a] - pair->offset[a];
        apart += fabsf(deviation[a]);
    }
    if (pair->known > OFFSET_KNOWN) {
        const float beyond = apart - tolerance - (select->drift * pair->age);
        const float noise = (pair->noise * sqrtf(pair->recent / (float)axes)) + SELECT_LEAST;
        const float sigmas = davar_select_lesser(MEAN_SIZE * beyond / noise, 4.0F);
        const float sum = pair->evidence + (2.0F * (sigmas - 1.0F)) - (SIGNS * (float)axes);
        const float most = 2.0F * (select->threshold + SELECT_ALARM_MORE);
        pair->evidence = (sum > 0.0F) ? davar_select_lesser(sum, most) : 0.0F;
    }
    if (pair->evidence < JUMP) {
        learn_pair(pair, deviation, axes, apart, tolerance);
    }
}

/* Names a gyro all of whose pairs disagree, if no other pair does even half. */
static void name_culprit(select_step_t *step, const pairs_t *pairs)
{
    for (uint32_t i = 0U; i < step->select->config->gyros; i++) {
        davar_select_gyro_t *const gyro = &step->select->gyro[i];
        const uint32_t mine = pairs->live & pairs_of[i];
        const uint32_t others = pairs->live & ~mine;
        if ((mine != 0U) && (others != 0U) && ((mine & ~pairs->over) == 0U) &&
            ((others & pairs->half) == 0U)) {
            gyro->fault |= DAVAR_SELECT_MEAN;
            step->usable &= ~(1U << i);
        }
        if (((gyro->fault & DAVAR_SELECT_MEAN) != 0U) && ((mine & pairs->jumps) != 0U)) {
            gyro->wait = AGREES;
        }
    }
}

/* One pair of live gyros: its means, and what they share (13.5). */
static void compare_live(select_step_t *step, pairs_t *pairs, uint32_t i, uint32_t j,
                         davar_select_pair_t *pair)
{
    davar_select_t *const select = step->select;
    const float alarm = select->threshold + SELECT_ALARM_MORE;
    const uint32_t bit = 1U << davar_select_pair_of[i][j];
    const float one = select->gyro[i].recent;
    const float other = select->gyro[j].recent;
    const float weight = 1.0F / ((one * other) + SELECT_LEAST);
    const float shared = one + other - pair->recent;
    const bool two = (step->live == ((1U << i) | (1U << j)));
    compare_means(step, pair, i, j);
    pairs->live |= bit;
    pairs->jumps |= (pair->evidence < JUMP) ? 0U : bit;
    pairs->half |= (pair->evidence < (0.5F * alarm)) ? 0U : bit;
    pairs->over |= (pair->evidence > alarm) ? bit : 0U;
    select->hidden = two && (shared > pair->recent);
    step->apart = two ? step->apart : davar_select_lesser(step->apart, pair->recent);
    step->shared += weight * shared;
    step->shared_weight += weight;
}

bool davar_select_compare_pairs(select_step_t *step)
{
    davar_select_t *const select = step->select;
    davar_select_pair_t *pair = select->pair;
    pairs_t pairs = {0U, 0U, 0U, 0U};
    const float start = 1.0F / (float)select->blocks;
    const float gain = (start > SELECT_FOLLOW) ? start : SELECT_FOLLOW;
    select->hidden = false;
    if (step->live != 0U) {
        select->mismatch += gain * (step->mismatch - select->mismatch);
    }
    for (uint32_t j = 0U; j < select->config->gyros; j++) {
        if (davar_select_has(step->complete, j)) {
            select->gyro[j].recent += gain * (step->square[j] - select->gyro[j].recent);
        }
        for (uint32_t i = 0U; i < j; i++) {
            if (davar_select_has(step->complete & (step->complete >> (j - i)), i)) {
                pair->recent += gain * (pair->apart - pair->recent);
            }
            if (davar_select_has(step->live & (step->live >> (j - i)), i)) {
                compare_live(step, &pairs, i, j, pair);
            } else {
                pair->age += 1.0F;
            }
            pair++;
        }
    }
    name_culprit(step, &pairs);
    return pairs.over != 0U;
}
