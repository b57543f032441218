/* davar-sim - a change of a fixed window (past.h). */
#include "centred/past.h"

#include "number/scaled.h"

uint32_t past_level(uint64_t high, uint64_t low)
{
    const davar_u128_t sum = {.low = low, .high = high};
    return scaled_level(scaled_of_u128(&sum));
}

bool past_next(past_t *past, uint32_t stride, uint32_t longest, uint32_t level)
{
    if (past->wait > stride) {
        past->wait -= stride;
    } else {
        past->level[1] = past->level[0];
        past->level[0] = (level == PAST_UNKNOWN) ? 0U : level;
        past->wait = (longest + 1U) / 2U;
    }
    return (level != PAST_UNKNOWN) && (past->level[1] > 0U) &&
           davar_levels_differ(level, past->level[1], longest);
}
