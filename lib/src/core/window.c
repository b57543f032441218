/* davar - the gaps that a window stores: boundaries that no difference spans.
 * Hazard: positions wrap modulo 2^32, so only distances are compared, never positions. */
#include "core/window.h"
#include "number/machine.h"

/* Index of the first boundary after `position`. */
DAVAR_RARE static uint32_t first_after(const davar_gaps_t *gaps, uint32_t position)
{
    uint32_t low = 0U;
    uint32_t high = gaps->count;
    while (low < high) {
        const uint32_t middle = low + ((high - low) >> 1U);
        if ((int32_t)(gaps->position[middle] - position) > 0) {
            high = middle;
        } else {
            low = middle + 1U;
        }
    }
    return low;
}

DAVAR_RARE void davar_gaps_forget(davar_gaps_t *gaps, const davar_window_t *window, uint32_t length)
{
    const uint32_t oldest = window->received - length;
    uint16_t gone = 0U;
    while ((gone < gaps->count) && ((int32_t)(gaps->position[gone] - oldest) <= 0)) {
        gone++;
    }
    if (gone == 0U) {
        return;
    }
    for (uint16_t i = gone; i < gaps->count; i++) {
        gaps->position[i - gone] = gaps->position[i];
    }
    gaps->count = (uint16_t)(gaps->count - gone);
}

DAVAR_RARE bool davar_gaps_push(davar_gaps_t *gaps, const davar_window_t *window, uint32_t length)
{
    const uint32_t boundary = window->received;
    if ((boundary == 0U) && (window->phase <= (uint8_t)WINDOW_FILLING)) {
        return true;
    }
    if ((gaps->count > 0U) && (gaps->position[gaps->count - 1U] == boundary)) {
        return true;
    }
    davar_gaps_forget(gaps, window, length);
    if (gaps->count == gaps->capacity) {
        return false;
    }
    gaps->position[gaps->count] = boundary;
    gaps->count++;
    return true;
}

DAVAR_RARE uint32_t davar_gaps_after(const davar_gaps_t *gaps, uint32_t position)
{
    const uint32_t index = first_after(gaps, position);
    return (index == gaps->count) ? DAVAR_NO_GAP : (gaps->position[index] - position);
}

DAVAR_RARE uint32_t davar_gaps_inside(const davar_gaps_t *gaps, uint32_t tail, uint32_t length)
{
    uint32_t inside = 0U;
    for (uint32_t i = first_after(gaps, tail); i < gaps->count; i++) {
        if ((gaps->position[i] - tail) >= length) {
            break;
        }
        inside++;
    }
    return inside;
}

/* In distances from the tail: a boundary at g is inside the spans that start at g - 2m + 1 .. g -
 * 1. */
DAVAR_RARE uint32_t davar_gaps_spans_lost(const davar_gaps_t *gaps, uint32_t tail, uint32_t length,
                                          uint32_t m)
{
    const uint32_t starts = length - (2U * m) + 1U;
    uint32_t counted_to = 0U;
    uint32_t lost = 0U;
    for (uint32_t i = first_after(gaps, tail); i < gaps->count; i++) {
        const uint32_t boundary = gaps->position[i] - tail;
        if (boundary >= length) {
            break;
        }
        const uint32_t from = (boundary < (2U * m)) ? 0U : (boundary - (2U * m) + 1U);
        const uint32_t to = (boundary < starts) ? boundary : starts;
        const uint32_t begin = (from > counted_to) ? from : counted_to;
        if (to > begin) {
            lost += to - begin;
            counted_to = to;
        }
    }
    return lost;
}
