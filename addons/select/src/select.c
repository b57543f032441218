/* davar - select: sums over a block of samples (13.1), and which gyros deliver. They use only
 * operations that IEEE 754 rounds correctly, so every target computes the same bits. */
#include "select_parts.h"

#include <math.h>

#define LIMIT 1e12F       /* of the sums of a block: no gyro delivers as much */
#define SPREAD_START 2.0F /* first spread over the least one (13.3) */
#define RETURN 2.0F       /* part of the threshold that the return to 0 replaces (13.4) */
#define EDGE 1.05F        /* the measured rate of a gyro has an error of scale itself (13.7) */
#define STILL 3U          /* blocks without a step until an axis is stuck */
#define RECOVERY 20U      /* blocks of good samples until a gyro is used again */

const uint8_t davar_select_pair_of[DAVAR_SELECT_GYROS][DAVAR_SELECT_GYROS] = {
    {0U, 0U, 1U, 3U}, {0U, 0U, 2U, 4U}, {1U, 2U, 0U, 5U}, {3U, 4U, 5U, 0U}};

/* --- the start --- */

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

static davar_select_status_t check_sizes(const davar_select_config_t *config)
{
    if ((config->gyros < 2U) || (config->gyros > DAVAR_SELECT_GYROS)) {
        return DAVAR_SELECT_ERR_GYROS;
    }
    if ((config->axes < 1U) || (config->axes > DAVAR_SELECT_AXES)) {
        return DAVAR_SELECT_ERR_AXES;
    }
    if ((config->block < 4U) || (config->block > 1000U)) {
        return DAVAR_SELECT_ERR_BLOCK;
    }
    return DAVAR_SELECT_OK;
}

static davar_select_status_t check_select(const davar_select_config_t *config)
{
    const davar_select_status_t status = check_sizes(config);
    if (status != DAVAR_SELECT_OK) {
        return status;
    }
    if (!is_within((float)config->block, 0.04F * config->rate_hz, 0.25F * config->rate_hz)) {
        return DAVAR_SELECT_ERR_RATE;
    }
    if (!is_within(config->errors_per_1000_h, 1e-3F, 1e6F)) {
        return DAVAR_SELECT_ERR_ERRORS;
    }
    const bool tolerable = is_within(config->scale_tolerance, 1e-9F, 1.0F) &&
                           is_within(config->time_tolerance_s, 1e-9F, 1.0F) &&
                           is_within(config->drift_tolerance_dps_per_s, 1e-9F, 1.0F);
    return tolerable ? DAVAR_SELECT_OK : DAVAR_SELECT_ERR_TOLERANCE;
}

davar_select_status_t davar_select_init(davar_select_t *select, const davar_select_config_t *config,
                                        davar_select_gyro_t *gyro, davar_select_pair_t *pair)
{
    if ((select == NULL) || (config == NULL) || (gyro == NULL) || (pair == NULL)) {
        return DAVAR_SELECT_ERR_NULL;
    }
    const davar_select_status_t status = check_select(config);
    if (status != DAVAR_SELECT_OK) {
        return status;
    }
    const float blocks = 3.6e6F * config->rate_hz / (float)config->block; /* in 1000 hours */
    const float tests = blocks * (float)(config->gyros - 1U);
    const float freedom = (2.0F / 3.0F) * (float)((uint32_t)config->block * config->axes);
    *select = (davar_select_t){.config = config,
                               .gyro = gyro,
                               .pair = pair,
                               .threshold = logarithm(tests / config->errors_per_1000_h) - RETURN,
                               .freedom = freedom,
                               .drift = config->drift_tolerance_dps_per_s * (float)config->block *
                                        (float)config->block / config->rate_hz};
    for (uint32_t i = 0U; i < config->gyros; i++) {
        gyro[i] = (davar_select_gyro_t){.spread = SPREAD_START / (freedom + 1.0F)};
    }
    for (uint32_t p = 0U; p < DAVAR_SELECT_PAIRS((uint32_t)config->gyros); p++) {
        pair[p] = (davar_select_pair_t){.noise = 0.564F}; /* of white noise (13.7) */
    }
    return DAVAR_SELECT_OK;
}

/* --- a sample --- */

/* The first sample has no step. */
static void begin(const davar_select_t *select, const float *rates)
{
    const uint32_t axes = select->config->axes;
    for (uint32_t i = 0U; i < select->config->gyros; i++) {
        for (uint32_t a = 0U; a < axes; a++) {
            select->gyro[i].last[a] = rates[(i * axes) + a];
            select->gyro[i].first[a] = rates[(i * axes) + a];
        }
    }
}

bool davar_select_add(davar_select_t *select, const float *rates_dps)
{
    const uint32_t gyros = select->config->gyros;
    const uint32_t axes = select->config->axes;
    DAVAR_ASSERT(select->count < select->config->block);
    if ((select->blocks == 0U) && (select->count == 0U)) {
        begin(select, rates_dps);
    }
    for (uint32_t a = 0U; a < axes; a++) {
        float step[DAVAR_SELECT_GYROS];
        const float *rate = &rates_dps[a];
        davar_select_pair_t *pair = select->pair;
        for (uint32_t i = 0U; i < gyros; i++) {
            davar_select_gyro_t *const gyro = &select->gyro[i];
            step[i] = *rate - gyro->last[a];
            const float bend = step[i] - gyro->step[a];
            gyro->step[a] = step[i];
            gyro->bend += bend * bend;
            gyro->last[a] = *rate;
            gyro->sum[a] += *rate;
            gyro->square[a] += step[i] * step[i];
            rate += axes;
            for (uint32_t j = 0U; j < i; j++) {
                const float apart = step[i] - step[j];
                pair->apart += apart * apart;
                pair++;
            }
        }
    }
    select->count++;
    return select->count == select->config->block;
}

/* --- a block --- */

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

/* Sums up the axes of a gyro. A rate that is not finite makes its sums infinite or not a number. */
static void inspect(select_step_t *step, uint32_t i)
{
    const davar_select_config_t *const config = step->select->config;
    davar_select_gyro_t *const gyro = &step->select->gyro[i];
    float square = 0.0F;
    float rate = 0.0F;
    float change = 0.0F;
    bool moved = true;
    for (uint32_t a = 0U; a < config->axes; a++) {
        square += gyro->square[a];
        rate += fabsf(gyro->sum[a]);
        change += fabsf(gyro->last[a] - gyro->first[a]);
        moved = moved && (gyro->square[a] > 0.0F);
    }
    const bool complete = (square + rate) < LIMIT;
    judge_samples(gyro, !complete, moved);
    step->square[i] = square;
    step->tolerance[i] = EDGE * ((config->scale_tolerance * rate) +
                                 (config->time_tolerance_s * config->rate_hz * change));
    step->complete |= complete ? (1U << i) : 0U;
    if ((gyro->fault & (DAVAR_SELECT_ABSENT | DAVAR_SELECT_STUCK)) == 0U) {
        const float time = config->time_tolerance_s * config->rate_hz;
        const float mismatch = (config->scale_tolerance * config->scale_tolerance * square) +
                               (time * time * gyro->bend);
        step->mismatch = davar_select_lesser(step->mismatch, mismatch);
        step->live |= 1U << i;
        step->usable |= ((gyro->fault & DAVAR_SELECT_MEAN) == 0U) ? (1U << i) : 0U;
    }
}

/* Keeps the last samples. All axes, because a loop of known length calls no memset. */
static void empty(davar_select_t *select)
{
    davar_select_pair_t *pair = select->pair;
    select->count = 0U;
    for (uint32_t i = 0U; i < select->config->gyros; i++) {
        davar_select_gyro_t *const gyro = &select->gyro[i];
        gyro->bend = 0.0F;
        for (uint32_t a = 0U; a < DAVAR_SELECT_AXES; a++) {
            gyro->square[a] = 0.0F;
            gyro->sum[a] = 0.0F;
            gyro->first[a] = gyro->last[a];
        }
        for (uint32_t j = 0U; j < i; j++) {
            pair->apart = 0.0F;
            pair++;
        }
    }
}

void davar_select_update(davar_select_t *select, davar_select_verdict_t *verdict)
{
    DAVAR_ASSERT(select->count == select->config->block);
    select_step_t step;
    step.select = select;
    step.shared = 0.0F;
    step.shared_weight = 0.0F;
    step.mismatch = SELECT_MOST;
    step.apart = SELECT_MOST;
    step.complete = 0U;
    step.live = 0U;
    step.usable = 0U;
    select->blocks =
        (uint16_t)((select->blocks < SELECT_BLOCKS) ? (select->blocks + 1U) : SELECT_BLOCKS);
    for (uint32_t i = 0U; i < select->config->gyros; i++) {
        inspect(&step, i);
    }
    davar_select_gather(&step);
    verdict->disagree = davar_select_compare_pairs(&step);
    davar_select_weigh(&step, verdict);
    davar_select_choose(&step, verdict);
    verdict->usable = (step.usable != 0U);
    for (uint32_t i = 0U; i < select->config->gyros; i++) {
        verdict->fault[i] = select->gyro[i].fault;
    }
    empty(select);
}

/* --- the reasons as text --- */

const char *davar_select_status_text(davar_select_status_t status)
{
    static const char *const text[] = {
        [DAVAR_SELECT_OK] = "ok",
        [DAVAR_SELECT_ERR_NULL] = "a pointer is null",
        [DAVAR_SELECT_ERR_GYROS] = "2 to 4 gyros expected",
        [DAVAR_SELECT_ERR_AXES] = "1 to 3 axes expected",
        [DAVAR_SELECT_ERR_BLOCK] = "a block of 4 to 1000 samples expected",
        [DAVAR_SELECT_ERR_RATE] = "a block of 0.04 to 0.25 s expected",
        [DAVAR_SELECT_ERR_ERRORS] = "0.001 to 1e6 errors in 1000 hours expected",
        [DAVAR_SELECT_ERR_TOLERANCE] = "tolerances above 0 and up to 1 expected",
    };
    return ((size_t)status < (sizeof text / sizeof text[0])) ? text[status] : "unknown status";
}
