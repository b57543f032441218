/* davar - the windows that follow from the cuts, trailing and centred. A cut that is part of a
 * ramp does not bound a window. */
#include "core/window.h"
#include "detector/scan.h"
#include "number/real.h"

#define NEAR_LIMIT (4U << GAIN_DIGITS) /* G / f of a short window with one variance, at most */
#define FAR_LIMIT (3U << (GAIN_DIGITS - 1U))
#define STEP_LIMIT (4U << GAIN_DIGITS) /* by which a step must exceed a ramp */

/* ---- growing towards the past ---- */

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

/* The same, but never before the bound. */
static void recorded(const davar_glr_t *state, uint32_t age, const davar_glr_place_t *bound,
                     davar_glr_place_t *place)
{
    if (age >= glr_age(state, bound)) {
        glr_place_copy(place, bound);
    } else {
        oldest_record(state, age, place);
    }
}

/* Doubles the window [begin, end), which is not empty, to the left while the older half is like the
 * rest. Each turn looks further back, and the one that reaches the bound is the last. Coarse
 * octaves have few records, so the record may be no older than the beginning of a short window; the
 * next turn then looks further. */
static void grow_back(const davar_glr_t *state, const davar_glr_config_t *config,
                      davar_glr_place_t *begin, const davar_glr_place_t *end,
                      const davar_glr_place_t *bound, uint32_t near_limit)
{
    uint32_t age = glr_age(state, begin);
    while (begin->at != bound->at) {
        davar_glr_place_t older;
        DAVAR_ASSERT((age > glr_age(state, end)) && (age <= glr_age(state, bound)));
        age += age - glr_age(state, end);
        recorded(state, age, bound, &older);
        if (glr_age(state, &older) <= glr_age(state, begin)) {
            continue;
        }
        const davar_spread_t *const place[3] = {&older.sum, &begin->sum, &end->sum};
        const uint32_t limit = ((end->at - older.at) <= config->far) ? near_limit : FAR_LIMIT;
        if (!is_alike(state, config, place, limit)) {
            return;
        }
        glr_place_copy(begin, &older);
    }
}

void davar_glr_trailing(const davar_glr_t *state, const davar_glr_config_t *config,
                        davar_glr_window_t *window)
{
    davar_glr_place_t begin;
    recorded(state, config->near, &state->cut, &begin);
    grow_back(state, config, &begin, &state->now, &state->cut, NEAR_LIMIT);
    window->begin = begin.at;
    window->end = state->now.at;
    window->blocks = state->now.sum.blocks - begin.sum.blocks;
    window->after = 0U;
}

/* ---- the cuts of the past ---- */

static bool has_bit(uint32_t bits, uint32_t i)
{
    return ((bits >> i) & 1U) != 0U;
}

static void drop_oldest(davar_glr_t *state)
{
    state->cuts--;
    for (uint32_t i = 0U; i < state->cuts; i++) {
        glr_place_copy(&state->past[i], &state->past[i + 1U]);
    }
    state->counts >>= 1U;
    state->settled >>= 1U;
}

void davar_glr_remember(davar_glr_t *state, const davar_spread_t *block)
{
    uint32_t packed = 0U;
    if (block->blocks != 0U) {
        const int32_t exponent = spread_exponent(block);
        const uint32_t mantissa = spread_bits(block, exponent) >> 22U; /* a leading 1 and 9 bits */
        packed = ((uint32_t)(exponent + 32) << 9U) | (mantissa & 0x1FFU);
    }
    state->recent[state->now.at % GLR_RECENT] = (uint16_t)packed;
    if (state->seen < GLR_HALF_MAX) {
        state->seen++;
    }
}

/* Sums over recent blocks; in their unit the largest block has 25 bits. */
typedef struct {
    uint32_t sum;
    uint32_t blocks;
    uint64_t partial; /* sum of the partial sums: the k-th block from the end counts k times */
} moment_t;

static uint32_t largest_exponent(const davar_glr_t *state, uint32_t from, uint32_t to)
{
    uint32_t most = 0U;
    for (uint32_t at = from; at != to; at++) {
        const uint32_t exponent = (uint32_t)state->recent[at % GLR_RECENT] >> 9U;
        most = (exponent > most) ? exponent : most;
    }
    return most;
}

static void add_recent(const davar_glr_t *state, uint32_t from, uint32_t to, uint32_t most,
                       moment_t *moment)
{
    for (uint32_t at = from; at != to; at++) {
        const uint32_t packed = state->recent[at % GLR_RECENT];
        if (packed != 0U) {
            const uint32_t below = most - (packed >> 9U);
            const uint32_t value = ((packed & 0x1FFU) | 0x200U) << 15U;
            moment->sum += (below < 25U) ? (value >> below) : 1U;
            moment->blocks++;
            moment->partial += moment->sum;
        }
    }
}

/* f times the gain of a line in t over a constant: (3/4) nu n rho^2 / (n^2 - 1), where rho is the
 * sum of (2 t - n + 1) b over the sum of b. */
static int32_t ramp_gain(const davar_glr_config_t *config, const moment_t *moment)
{
    const uint32_t n = moment->blocks;
    const uint32_t sum = moment->sum;
    const uint64_t twice = 2U * moment->partial;
    const uint64_t middle = davar_multiply_u32(sum, n + 1U);
    const uint64_t slope =
        ((twice > middle) ? (twice - middle) : (middle - twice)) >> 6U; /* below the sum */
    const uint32_t zeros = davar_leading_zeros_32(sum);
    const uint32_t share =
        davar_upper_product((uint32_t)slope << zeros, davar_reciprocal_of_mantissa(sum << zeros));
    const uint32_t rho = share >> 17U; /* 8 digits */
    const uint32_t square = davar_divided(rho * rho, (n * n) - 1U);
    return (int32_t)(davar_multiply_u32(square, 3U * config->degrees * n) >> 6U);
}

/* Is past[i] a step, or part of a ramp? Tested with the blocks up to its neighbours. */
static bool is_step(const davar_glr_t *state, const davar_glr_config_t *config, uint32_t i)
{
    const uint32_t at = state->past[i].at;
    const uint32_t age = glr_age(state, &state->past[i]);
    const uint32_t before = (i != 0U) ? (at - state->past[i - 1U].at) : config->half;
    const uint32_t after = ((i + 1U) < state->cuts) ? (state->past[i + 1U].at - at) : age;
    if (age >= GLR_RECENT) {
        return true;
    }
    const uint32_t from = at - smaller(smaller(before, config->half), GLR_RECENT - age);
    const uint32_t to = at + smaller(after, config->half);
    const uint32_t most = largest_exponent(state, from, to);
    moment_t moment = {0U, 0U, 0U};
    add_recent(state, from, at, most, &moment);
    const davar_spread_t older = {moment.sum, 0U, moment.blocks};
    add_recent(state, at, to, most, &moment);
    const davar_spread_t sum = {moment.sum, 0U, moment.blocks};
    if ((older.blocks == 0U) || (older.blocks == sum.blocks)) {
        return true;
    }
    static const davar_spread_t none = {0U, 0U, 0U};
    const uint32_t f = davar_glr_dispersion(state, GLR_TYPICAL);
    davar_stretch_t stretch;
    davar_stretch(&stretch, &none, &sum, config, f);
    const int32_t limit = (int32_t)((f * (uint64_t)STEP_LIMIT) >> GAIN_DIGITS);
    return (davar_likelihood_gain(&stretch, &older) - ramp_gain(config, &moment)) > limit;
}

static void store_cut(davar_glr_t *state)
{
    if (state->cuts == GLR_CUTS) {
        drop_oldest(state);
        state->counts |= 1U; /* a bound: older cuts may be forgotten */
        state->settled |= 1U;
    }
    glr_place_copy(&state->past[state->cuts], &state->cut);
    state->counts |= UINT32_C(1) << state->cuts;
    state->cuts++;
}

void davar_glr_note(davar_glr_t *state, const davar_glr_config_t *config, bool is_cut)
{
    if (config->half == 0U) {
        return;
    }
    if ((state->cuts != 0U) && (glr_age(state, &state->past[0]) > config->longest)) {
        drop_oldest(state);
    }
    if (is_cut) {
        store_cut(state);
    }
    state->turn++;
    if (state->turn >= state->cuts) {
        state->turn = 0U;
    }
    const uint32_t turn = state->turn;
    const uint32_t bit = UINT32_C(1) << turn;
    if ((turn < state->cuts) && ((state->settled & bit) == 0U)) {
        const bool counts = is_step(state, config, turn);
        state->counts = counts ? (state->counts | bit) : (state->counts & ~bit);
        state->settled |= (glr_age(state, &state->past[turn]) >= config->half) ? bit : 0U;
    }
}

/* Moves `begin` and `end` to the nearest cuts around the centre that count, and `bound` to the
 * newest cut before the end, whether or not it counts. */
static void clip(const davar_glr_t *state, uint32_t centre, davar_glr_place_t *begin,
                 davar_glr_place_t *end, davar_glr_place_t *bound)
{
    for (uint32_t i = state->cuts; i > 0U; i--) { /* the newest first */
        const davar_glr_place_t *const cut = &state->past[i - 1U];
        const bool is_step = has_bit(state->counts, i - 1U);
        if (is_step && (glr_age(state, cut) < centre)) {
            glr_place_copy(end, cut);
        }
    }
    for (uint32_t i = 0U; i < state->cuts; i++) {
        const davar_glr_place_t *const cut = &state->past[i];
        const bool is_step = has_bit(state->counts, i);
        const uint32_t age = glr_age(state, cut);
        if (is_step && (age >= centre) && (age <= glr_age(state, begin))) {
            glr_place_copy(begin, cut);
        }
        if (age > glr_age(state, end)) {
            glr_place_copy(bound, cut);
        }
    }
}

uint32_t davar_glr_age_of(const davar_glr_t *state, uint32_t accepted)
{
    uint32_t age = 0U;
    for (uint32_t left = accepted; (left > 0U) && (age < GLR_RECENT); age++) {
        left -= (state->recent[(state->now.at - 1U - age) % GLR_RECENT] != 0U) ? 1U : 0U;
    }
    return age;
}

/* Accepted blocks among the newest `age`, GLR_RECENT at most. */
static uint32_t accepted_of(const davar_glr_t *state, uint32_t age)
{
    uint32_t accepted = 0U;
    for (uint32_t i = 1U; i <= smaller(age, GLR_RECENT); i++) {
        accepted += (state->recent[(state->now.at - i) % GLR_RECENT] != 0U) ? 1U : 0U;
    }
    return accepted;
}

bool davar_glr_centred(const davar_glr_t *state, const davar_glr_config_t *config, uint32_t age,
                       davar_glr_window_t *window)
{
    window->begin = state->now.at - state->seen;
    window->end = state->now.at;
    window->blocks = state->now.sum.blocks;
    window->after = 0U;
    if (state->seen < smaller(age, GLR_HALF_MAX)) {
        return false;
    }
    const uint32_t widest = age + config->half;
    davar_glr_place_t end;
    davar_glr_place_t begin;
    glr_place_copy(&end, &state->now);
    glr_place_copy(&begin, &state->now);
    begin.at -= widest;
    begin.sum.blocks -= accepted_of(state, widest);
    davar_glr_place_t bound;
    oldest_record(state, config->longest, &bound); /* early on this is the start */
    if (state->cuts == GLR_CUTS) {
        glr_place_copy(&bound, &state->past[0]); /* older cuts may be forgotten */
    }
    clip(state, age, &begin, &end, &bound);
    if (glr_age(state, &bound) > widest) {
        davar_glr_place_t grown;
        recorded(state, widest, &bound, &grown);
        const uint32_t from = grown.at;
        if ((glr_age(state, &grown) > glr_age(state, &end)) &&
            (grown.sum.blocks != end.sum.blocks)) { /* blocks between the record and the end */
            grow_back(state, config, &grown, &end, &bound, FAR_LIMIT);
        }
        if (grown.at != from) {
            glr_place_copy(&begin, &grown);
        }
    }
    window->begin = begin.at;
    window->end = end.at;
    window->blocks = end.sum.blocks - begin.sum.blocks;
    window->after = state->now.sum.blocks - end.sum.blocks;
    return true;
}
