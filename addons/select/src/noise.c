/* davar - select: the own noise of each gyro, and the weights (13.5), (13.6), (13.8). */
#include "select_parts.h"

#define RECENT ((2.0F / SELECT_FOLLOW) - 1.0F) /* blocks that a recent mean is worth */
#define RESTART 9.0F                           /* (3 sigma)^2 */
#define RESTART_KNOWN 3.0F                     /* blocks that the estimate is worth then */
#define HIDES 0.25F                            /* mismatch over the least difference (13.5) */
#define LEARNED 100U                           /* blocks before noise can be too loud */
#define LOUD 5.0F                              /* variance over its long mean */
#define LOUD_STEP 1.386F                       /* ln 4 */
#define LOUD_MOST 64U

/* One gyro beside the other live ones. */
typedef struct {
    uint32_t other[2]; /* the two quietest */
    float own[2];      /* their own noise */
    uint32_t count;    /* of others */
    bool loud;         /* this block is beyond the past, against each of them */
} neighbours_t;

static neighbours_t neighbours_of(const select_step_t *step, uint32_t i)
{
    const davar_select_t *const select = step->select;
    const float limit = LOUD * select->gyro[i].usual;
    neighbours_t found = {{i, i}, {SELECT_MOST, SELECT_MOST}, 0U, step->square[i] > limit};
    for (uint32_t j = 0U; j < select->config->gyros; j++) {
        if ((j == i) || !davar_select_has(step->live, j)) {
            continue;
        }
        const float own = select->gyro[j].own;
        found.count++;
        found.loud =
            found.loud && (davar_select_pair(select, i, j)->apart > (limit + (2.0F * own)));
        if (own < found.own[0]) {
            found.own[1] = found.own[0];
            found.other[1] = found.other[0];
            found.own[0] = own;
            found.other[0] = j;
        } else if (own < found.own[1]) {
            found.own[1] = own;
            found.other[1] = j;
        } else {
            /* louder than both */
        }
    }
    return found;
}

/* A new estimate moves the mean, or replaces it. `variance` is that of the estimate. */
static void learn_own(davar_select_gyro_t *gyro, float estimate, float variance)
{
    const float beyond = estimate - gyro->own;
    if ((beyond * beyond) > (RESTART * variance)) {
        gyro->own = (estimate > 0.0F) ? estimate : 0.0F;
        gyro->known = RESTART_KNOWN;
    } else {
        gyro->known = davar_select_lesser(gyro->known + 1.0F, SELECT_MEMORY);
        gyro->own += beyond / gyro->known;
    }
}

static void judge_noise(const davar_select_t *select, davar_select_gyro_t *gyro, bool loud)
{
    if (loud && (select->blocks > LEARNED)) {
        gyro->loud = (uint8_t)((gyro->loud < LOUD_MOST) ? (gyro->loud + 1U) : LOUD_MOST);
    } else if (gyro->loud > 0U) {
        gyro->loud--;
    } else {
        gyro->fault &= (uint8_t)~DAVAR_SELECT_NOISE;
    }
    if ((LOUD_STEP * (float)gyro->loud) > (select->threshold + SELECT_ALARM_MORE)) {
        gyro->fault |= DAVAR_SELECT_NOISE;
    }
}

/* Do the gyros share motion or vibration, beyond what chance explains (13.5)? */
static bool has_common(const select_step_t *step)
{
    const float freedom = RECENT * step->select->freedom;
    return (step->shared > 0.0F) &&
           ((step->shared * step->shared * freedom) > (32.0F * step->shared_weight));
}

/* Can mismatch explain a good part of what the gyros differ by (13.5)? */
static bool is_mismatched(const select_step_t *step)
{
    const float now = step->mismatch;
    const float recent = step->select->mismatch;
    return ((now > recent) ? now : recent) > (HIDES * step->apart);
}

/* @return The own noise, but not so little that the differences contradict it (13.6). */
static float measure_own(const select_step_t *step, uint32_t i, bool common, bool hidden)
{
    const davar_select_t *const select = step->select;
    davar_select_gyro_t *const gyro = &select->gyro[i];
    const neighbours_t near = neighbours_of(step, i);
    const float apart = davar_select_pair(select, i, near.other[0])->recent;
    if (!hidden) {
        float estimate = gyro->recent;
        float variance = 2.0F * gyro->own * gyro->own;
        if (common && (near.count > 1U)) { /* the three-cornered hat (13.5) */
            estimate = 0.5F * (apart + davar_select_pair(select, i, near.other[1])->recent -
                               davar_select_pair(select, near.other[0], near.other[1])->recent);
            variance =
                ((gyro->own + near.own[0]) * (gyro->own + near.own[1])) + (gyro->own * gyro->own);
        }
        judge_noise(select, gyro, near.loud);
        learn_own(gyro, estimate, variance / (RECENT * select->freedom));
        gyro->usual = (gyro->usual > 0.0F)
                          ? (gyro->usual + ((gyro->own - gyro->usual) / (float)select->blocks))
                          : gyro->own;
    }
    const float part = (gyro->known > 0.0F) ? 0.04F : 0.5F;
    const float floor = (near.count > 0U) ? (part * apart) : 0.0F;
    return ((gyro->own > floor) ? gyro->own : floor) + SELECT_LEAST;
}

void davar_select_weigh(const select_step_t *step, davar_select_verdict_t *verdict)
{
    const uint32_t gyros = step->select->config->gyros;
    const bool common = has_common(step);
    float *const weight = verdict->weight;
    float sum = SELECT_LEAST;
    verdict->hidden = step->select->hidden || (common && is_mismatched(step));
    for (uint32_t i = 0U; i < gyros; i++) {
        const float own =
            davar_select_has(step->live, i) ? measure_own(step, i, common, verdict->hidden) : 1.0F;
        weight[i] = davar_select_has(step->usable, i) ? (1.0F / own) : 0.0F;
        sum += weight[i];
    }
    for (uint32_t i = 0U; i < gyros; i++) {
        weight[i] /= sum;
    }
}
