/* davar - select: sums over a block of samples (13.1). */
#include "select/select_parts.h"

#define RATE_LIMIT 1e6F /* its square, summed over a block, is far below the largest float */

/* One sample of a gyro. Its steps are left out after a missing sample. */
static void add_gyro(davar_select_block_t *block, uint32_t gyro, uint32_t axes, const float *rate,
                     float *step)
{
    const bool steps = davar_select_has(block->held, gyro);
    for (uint32_t a = 0U; a < axes; a++) {
        step[a] = steps ? (rate[a] - block->last[gyro][a]) : 0.0F;
        block->square[gyro] += step[a] * step[a];
        block->sum[gyro][a] += rate[a];
        block->last[gyro][a] = rate[a];
        if ((step[a] > 0.0F) || (step[a] < 0.0F)) {
            block->moved |= (uint16_t)(1U << ((gyro * DAVAR_SELECT_AXES) + a));
        }
    }
}

static bool is_sample(const float *rate, uint32_t axes)
{
    bool good = true;
    for (uint32_t a = 0U; a < axes; a++) {
        good = good && (rate[a] >= -RATE_LIMIT) && (rate[a] <= RATE_LIMIT);
    }
    return good;
}

static float distance_of(const float *a, const float *b, uint32_t axes)
{
    float sum = 0.0F;
    for (uint32_t k = 0U; k < axes; k++) {
        const float apart = a[k] - b[k];
        sum += apart * apart;
    }
    return sum;
}

bool davar_select_add(const davar_select_config_t *config, davar_select_block_t *block,
                      const float *rates_dps, uint8_t present)
{
    float step[DAVAR_SELECT_GYROS][DAVAR_SELECT_AXES];
    const uint32_t axes = config->axes;
    DAVAR_ASSERT(block->count < config->block);
    for (uint32_t i = 0U; i < config->gyros; i++) {
        const uint8_t bit = (uint8_t)(1U << i);
        if (davar_select_has(present, i) && is_sample(&rates_dps[i * axes], axes)) {
            add_gyro(block, i, axes, &rates_dps[i * axes], step[i]);
            block->held |= bit;
        } else {
            block->missing |= bit;
            block->held &= (uint8_t)~bit;
        }
        for (uint32_t j = 0U; j < i; j++) { /* worthless, and not used, if one is missing */
            if (davar_select_has(~(uint32_t)block->missing, i) &&
                davar_select_has(~(uint32_t)block->missing, j)) {
                block->apart[davar_select_pair(j, i)] += distance_of(step[i], step[j], axes);
            }
        }
    }
    block->count++;
    return block->count == config->block;
}
