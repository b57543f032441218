/* davar - the boundaries of gaps that a window stores.
 * Hazard: positions wrap modulo 2^32, so only distances are compared, never positions. */
#include "core/window.h"
#include "number/machine.h"

/* Boundaries with their images, ascending:
 *
 *     -g3 -g2 -g1 | g1 g2 g3 | 2N-g3 2N-g2 2N-g1
 *
 * The left third exists while the window reaches into the mirrored start, the right third after the
 * end of the record. */
static uint32_t images_count(const davar_gaps_t *gaps, const davar_window_t *window)
{
    const uint32_t thirds = 1U + (at_start(window) ? 1U : 0U) + (is_finished(window) ? 1U : 0U);
    return thirds * gaps->count;
}

static uint32_t image_at(const davar_gaps_t *gaps, const davar_window_t *window, uint32_t index)
{
    const uint32_t count = gaps->count;
    uint32_t rest = index;
    if (at_start(window)) {
        if (rest < count) {
            return 0U - gaps->position[count - 1U - rest];
        }
        rest -= count;
    }
    if (rest < count) {
        return gaps->position[rest];
    }
    rest -= count;
    return (2U * window->end) - gaps->position[count - 1U - rest];
}

/* Index of the first boundary after `position`. */
DAVAR_RARE static uint32_t first_after(const davar_gaps_t *gaps, const davar_window_t *window,
                                       uint32_t position)
{
    uint32_t low = 0U;
    uint32_t high = images_count(gaps, window);
    while (low < high) {
        const uint32_t middle = low + ((high - low) >> 1U);
        if ((int32_t)(image_at(gaps, window, middle) - position) > 0) {
            high = middle;
        } else {
            low = middle + 1U;
        }
    }
    return low;
}

DAVAR_RARE void davar_gaps_forget(davar_gaps_t *gaps, const davar_window_t *window, uint32_t length)
{
    const uint32_t oldest = window_head(window) - length;
    uint16_t gone = 0U;
    if (at_start(window) || is_finished(window)) {
        return;
    }
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

DAVAR_RARE void davar_gaps_forget_last(davar_gaps_t *gaps, uint32_t end)
{
    if ((gaps->count > 0U) && (gaps->position[gaps->count - 1U] == end)) {
        gaps->count--;
    }
}

DAVAR_RARE uint32_t davar_gaps_after(const davar_gaps_t *gaps, const davar_window_t *window,
                                     uint32_t position)
{
    const uint32_t index = first_after(gaps, window, position);
    if (index == images_count(gaps, window)) {
        return DAVAR_NO_GAP;
    }
    return image_at(gaps, window, index) - position;
}

DAVAR_RARE uint32_t davar_gaps_inside(const davar_gaps_t *gaps, const davar_window_t *window)
{
    const uint32_t count = images_count(gaps, window);
    const uint32_t tail = window_tail(window);
    uint32_t inside = 0U;
    for (uint32_t i = first_after(gaps, window, tail); i < count; i++) {
        if ((image_at(gaps, window, i) - tail) >= window->length) {
            break;
        }
        inside++;
    }
    return inside;
}

/* In distances from the tail: a boundary at g is inside the spans that start at g - 2m + 1 .. g -
 * 1. */
DAVAR_RARE uint32_t davar_gaps_spans_lost(const davar_gaps_t *gaps, const davar_window_t *window,
                                          uint32_t m)
{
    const uint32_t count = images_count(gaps, window);
    const uint32_t length = window->length;
    const uint32_t tail = window_tail(window);
    const uint32_t starts = length - (2U * m) + 1U;
    uint32_t counted_to = 0U;
    uint32_t lost = 0U;
    for (uint32_t i = first_after(gaps, window, tail); i < count; i++) {
        const uint32_t boundary = image_at(gaps, window, i) - tail;
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
