/* davar - the window that follows from the newest cut: it grows towards the past while one variance
 * explains it, up to the cut. */
#include "core/window.h"
#include "laws/scan.h"
#include "number/real.h"

#define NEAR_LIMIT (4U << GAIN_DIGITS) /* G / f of a short window with one variance, at most */
#define FAR_LIMIT (3U << (GAIN_DIGITS - 1U))

/* Do [older, middle) and [middle, end) have one variance? True if one of them has no block. */
static bool is_alike(const davar_glr_t *state, const davar_glr_config_t *config,
                     const davar_spread_t *const place[3], uint32_t limit)
{
    if ((place[0]->blocks == place[1]->blocks) || (place[1]->blocks == place[2]->blocks)) {
        return true;
    }
    const uint32_t f = davar_glr_dispersion(state, GLR_TYPICAL);
    davar_stretch_t stretch;
    davar_stretch(&stretch, place[0], place[2], config, f);
    return !davar_likelihood_may_reach(&stretch, place[1], limit >> (GAIN_DIGITS - 6U)) ||
           (davar_likelihood_gain(&stretch, place[1]) <=
            (int32_t)(davar_multiply_u32(f, limit) >> GAIN_DIGITS));
}

/* The oldest recorded place of at most `age` blocks. */
static void oldest_record(const davar_glr_t *state, uint32_t age, davar_glr_place_t *place)
{
    const uint32_t bits = 32U - davar_leading_zeros_32(age);
    const uint32_t level = (bits > 2U) ? (bits - 2U) : 0U; /* the least with 4 * 2^level > age */
    const uint32_t above = (UINT32_C(1) << level) - 1U;
    glr_move_to_record(state, place, level, ((state->now.at - age + above) >> level) << level);
}

/* The same, but never before the cut. */
static void recorded(const davar_glr_t *state, uint32_t age, davar_glr_place_t *place)
{
    if (age >= glr_age(state, &state->cut)) {
        glr_place_copy(place, &state->cut);
    } else {
        oldest_record(state, age, place);
    }
}

/* The window doubles to the left while the older half is like the rest. Each turn looks further
 * back, and the one that reaches the cut is the last. Coarse octaves have few records, so the
 * record may be no older than the beginning of a short window; the next turn then looks further. */
void davar_glr_begin(const davar_glr_t *state, const davar_glr_config_t *config,
                     davar_glr_place_t *begin)
{
    recorded(state, config->near, begin);
    uint32_t age = glr_age(state, begin);
    while (begin->at != state->cut.at) {
        davar_glr_place_t older;
        DAVAR_ASSERT((age > 0U) && (age <= glr_age(state, &state->cut)));
        age *= 2U;
        recorded(state, age, &older);
        if (glr_age(state, &older) <= glr_age(state, begin)) {
            continue;
        }
        const davar_spread_t *const place[3] = {&older.sum, &begin->sum, &state->now.sum};
        const bool is_near = (glr_age(state, &older) <= config->far);
        if (!is_alike(state, config, place, is_near ? NEAR_LIMIT : FAR_LIMIT)) {
            return;
        }
        glr_place_copy(begin, &older);
    }
}
