/* davar - select: the own noise of each gyro, and the weights (13.5), (13.6), (13.8). */
#include "select/select_parts.h"

#define RESTART 9.0F /* (3 sigma)^2 */
#define RESTART_KNOWN 3.0F
#define LEARNED 100U     /* blocks before noise can be too loud */
#define LOUD 5.0F        /* variance over its long mean */
#define LOUD_STEP 1.386F /* ln 4 */
#define LOUD_MOST 64U
#define NO_PAIR 1e30F

/* Two other gyros, by their numbers; `count` of them exist. */
typedef struct {
    uint32_t first;
    uint32_t second;
    uint32_t count;
} others_t;

/* The two quietest live gyros besides i. */
static others_t others_of(const select_step_t *step, uint32_t i)
{
    const davar_select_gyro_t *const gyro = step->select->gyro;
    others_t others = {i, i, 0U};
    for (uint32_t j = 0U; j < step->select->config->gyros; j++) {
        if ((j == i) || !davar_select_has(step->live, j)) {
            continue;
        }
        if ((others.count == 0U) || (gyro[j].own < gyro[others.first].own)) {
            others.second = others.first;
            others.first = j;
        } else if ((others.count == 1U) || (gyro[j].own < gyro[others.second].own)) {
            others.second = j;
        } else {
            /* louder than both */
        }
        others.count++;
    }
    return others;
}

/* The three-cornered hat (13.5). */
static float hat_of(const select_moments_t *moments, uint32_t i, const others_t *others)
{
    return 0.5F * (moments->apart[davar_select_pair(i, others->first)] +
                   moments->apart[davar_select_pair(i, others->second)] -
                   moments->apart[davar_select_pair(others->first, others->second)]);
}

/* Its variance in one block, if i has the given own noise. */
static float variance_of_hat(const select_step_t *step, float own, const others_t *others)
{
    const davar_select_gyro_t *const gyro = step->select->gyro;
    return (((own + gyro[others->first].own) * (own + gyro[others->second].own)) + (own * own)) /
           davar_select_freedom(step->select->config);
}

/* Do the gyros share motion or vibration, beyond what chance explains? */
static bool has_common(const select_step_t *step)
{
    const float *const square = step->recent.square;
    float sum = 0.0F;
    float weights = 0.0F;
    for (uint32_t j = 0U; j < step->select->config->gyros; j++) {
        for (uint32_t i = 0U; (i < j) && davar_select_has(step->live, j); i++) {
            if (davar_select_has(step->live, i)) {
                const float apart = step->recent.apart[davar_select_pair(i, j)];
                const float weight = 1.0F / ((square[i] * square[j]) + SELECT_LEAST);
                weights += weight;
                sum += 0.5F * weight * (square[i] + square[j] - apart);
            }
        }
    }
    const float freedom = SELECT_RECENT * davar_select_freedom(step->select->config);
    return (sum > 0.0F) && ((sum * sum * freedom) > (8.0F * weights));
}

/* `variance` is that of `now`, in one block. */
static void judge(davar_select_gyro_t *gyro, float now, float variance, float alarm)
{
    const float beyond = now - (LOUD * gyro->usual);
    if ((beyond > 0.0F) && ((beyond * beyond) > variance)) {
        gyro->loud = (uint8_t)((gyro->loud < LOUD_MOST) ? (gyro->loud + 1U) : LOUD_MOST);
    } else if (gyro->loud > 0U) {
        gyro->loud--;
    } else {
        gyro->fault &= (uint8_t)~DAVAR_SELECT_NOISE;
    }
    if ((LOUD_STEP * (float)gyro->loud) > alarm) {
        gyro->fault |= DAVAR_SELECT_NOISE;
    }
}

/* A new estimate moves the mean, or replaces it. `variance` is that of the estimate. */
static void learn(davar_select_gyro_t *gyro, float estimate, float variance)
{
    const float beyond = estimate - gyro->own;
    if ((beyond * beyond) > (RESTART * variance)) {
        gyro->own = (estimate > 0.0F) ? estimate : 0.0F;
        gyro->known = RESTART_KNOWN;
    } else {
        const float known = gyro->known + 1.0F;
        gyro->known = (known < SELECT_MEMORY) ? known : SELECT_MEMORY;
        gyro->own += beyond / gyro->known;
    }
}

static void measure(const select_step_t *step, uint32_t i, bool common)
{
    davar_select_t *const select = step->select;
    davar_select_gyro_t *const gyro = &select->gyro[i];
    const others_t others = others_of(step, i);
    const bool has_hat = (others.count >= 2U);
    const float freedom = davar_select_freedom(select->config);
    if (has_hat && common) {
        learn(gyro, hat_of(&step->recent, i, &others),
              variance_of_hat(step, gyro->own, &others) / SELECT_RECENT);
    } else {
        learn(gyro, step->recent.square[i],
              2.0F * gyro->own * gyro->own / (SELECT_RECENT * freedom));
    }
    if (step->hidden) {
        gyro->loud = 0U;
        return;
    }
    if (select->blocks > LEARNED) {
        const float usual = gyro->usual;
        judge(gyro, has_hat ? hat_of(&step->now, i, &others) : step->now.square[i],
              has_hat ? variance_of_hat(step, usual, &others) : (2.0F * usual * usual / freedom),
              select->threshold + SELECT_ALARM_MORE);
    }
    gyro->usual = (gyro->usual > 0.0F)
                      ? (gyro->usual + ((gyro->own - gyro->usual) / (float)select->blocks))
                      : gyro->own; /* the first block that is not hidden */
}

void davar_select_measure_noise(const select_step_t *step)
{
    const bool common = has_common(step);
    for (uint32_t i = 0U; i < step->select->config->gyros; i++) {
        if (davar_select_has(step->live, i)) {
            measure(step, i, common);
        }
    }
}

/* The own noise, but not so little that the differences contradict it (13.6). */
static float believed(const select_step_t *step, uint32_t i)
{
    float least = NO_PAIR;
    for (uint32_t j = 0U; j < step->select->config->gyros; j++) {
        if ((j != i) && davar_select_has(step->live, j)) {
            const float apart = step->recent.apart[davar_select_pair(i, j)];
            least = (apart < least) ? apart : least;
        }
    }
    const float floor = (least < NO_PAIR) ? (0.04F * least) : 0.0F;
    const float own = step->select->gyro[i].own;
    return ((own > floor) ? own : floor) + SELECT_LEAST;
}

void davar_select_weigh(const select_step_t *step, float *weight)
{
    float sum = 0.0F;
    for (uint32_t i = 0U; i < step->select->config->gyros; i++) {
        weight[i] = davar_select_has(step->usable, i) ? (1.0F / believed(step, i)) : 0.0F;
        sum += weight[i];
    }
    for (uint32_t i = 0U; (i < step->select->config->gyros) && (sum > 0.0F); i++) {
        weight[i] /= sum;
    }
}
