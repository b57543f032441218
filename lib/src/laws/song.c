/* davar - the window law of [SONG18], section 4: the window shrinks while kurtosis or sliding
 * contribution leave their bounds. */
#include "laws/song.h"

#include "davar/content.h"

#include "core/instance.h"
#include "core/window.h"
#include "number/real.h"

/* --- in 32 bits (3.5) ------------------------------------------------------------------------- */

/* A bound in units of 2^-digits, cut; UINT32_MAX if it is too large. */
static uint32_t rough_bound(double bound, uint32_t digits)
{
    const uint64_t bits = davar_bits_of_double(bound);
    const uint32_t mantissa = (UINT32_C(1) << 31U) | (uint32_t)(bits >> 21U);
    const uint32_t shift = (1054U - digits) - ((uint32_t)(bits >> 52U) & 0x7FFU);
    if (shift < 32U) {
        return mantissa >> shift;
    }
    return ((shift >> 31U) != 0U) ? UINT32_MAX : 0U;
}

DAVAR_RARE void davar_song_bounds(davar_song_bounds_t *bounds, const davar_config_t *config)
{
    bounds->kurtosis.low = rough_bound(config->moments.kurtosis_low, 28U);
    bounds->kurtosis.high = rough_bound(config->moments.kurtosis_high, 28U);
    bounds->contribution.low = rough_bound(config->moments.contribution_low, 32U);
    bounds->contribution.high = rough_bound(config->moments.contribution_high, 32U);
}

/* --- the window law, [SONG18] section 4 (4.1) ------------------------------------------------- */

static uint32_t shorter(const davar_config_t *config, uint32_t length)
{
    const uint32_t step = config->window.shrink * config->stride;
    return (length > (config->window.shortest + step)) ? (length - step) : config->window.shortest;
}

static uint32_t longer(const davar_config_t *config, uint32_t length, bool filling)
{
    if (length == config->window.longest) {
        return length;
    }
    /* The head moves by one per sample; faster growth would move the tail backwards. */
    const bool grows = filling || (config->window.grow > 0U);
    return grows ? smaller(length + config->stride, config->window.longest) : length;
}

DAVAR_APART static bool is_unstable_exactly(const davar_t *davar, davar_rule_t rule)
{
    davar_central_t moments[2];
    davar->number->central(davar, moments);
    return davar_moments_unstable(davar->config, rule, &moments[0], &moments[1]);
}

/* The first part is evaluated only where the kurtosis of the whole window does not decide. */
static DAVAR_MERGED bool is_unstable(const davar_t *davar, const davar_song_bounds_t *bounds,
                                     const davar_rough_t *whole, davar_rule_t rule)
{
    const davar_place_t enough = (rule == RULE_AND) ? ROUGH_INSIDE : ROUGH_OUTSIDE;
    davar_place_t place = davar_rough_kurtosis(bounds, whole);
    if ((place != ROUGH_UNSURE) && (place != enough) && (rule != RULE_KURTOSIS)) {
        davar_rough_t first;
        davar->number->first(davar, &first);
        place = davar_rough_contribution(bounds, whole, &first);
    }
    return (place == ROUGH_UNSURE) ? is_unstable_exactly(davar, rule) : (place == ROUGH_OUTSIDE);
}

/* On a grid the window moves `stride` times as far in one step. O(1), no division. */
static DAVAR_MERGED bool song_judge(davar_t *davar, const davar_song_bounds_t *bounds,
                                    const davar_rough_t *whole, davar_rule_t rule)
{
    const davar_config_t *const config = davar->config;
    davar_window_t *const window = &davar->window;
    const bool unstable = (whole != NULL) && is_unstable(davar, bounds, whole, rule);
    window_keep_filling(window, config, unstable);
    window->next_length = unstable ? shorter(config, window->length)
                                   : longer(config, window->length, is_filling(window));
    return unstable;
}

_Static_assert(sizeof(davar_song_bounds_t) <= DAVAR_SONG_BYTES, "DAVAR_SONG_BYTES is too small");

static size_t song_bytes(const davar_config_t *config)
{
    (void)config;
    return sizeof(davar_song_bounds_t);
}

static void song_start(davar_t *davar, void *state, davar_law_start_t why)
{
    (void)why;
    davar_song_bounds(state, davar->config);
}

static bool judge_kurtosis(davar_t *davar, void *state, const davar_rough_t *whole)
{
    return song_judge(davar, state, whole, RULE_KURTOSIS);
}

static bool judge_or(davar_t *davar, void *state, const davar_rough_t *whole)
{
    return song_judge(davar, state, whole, RULE_OR);
}

static bool judge_and(davar_t *davar, void *state, const davar_rough_t *whole)
{
    return song_judge(davar, state, whole, RULE_AND);
}

#define SONG_LAW(number, function)                                                                 \
    {                                                                                              \
        .id = (number), .wants_moments = true, .bytes = song_bytes, .start = song_start,           \
        .judge = (function)                                                                        \
    }

const davar_law_t davar_law_kurtosis = SONG_LAW(DAVAR_LAW_ID_KURTOSIS, judge_kurtosis);
const davar_law_t davar_law_or = SONG_LAW(DAVAR_LAW_ID_OR, judge_or);
const davar_law_t davar_law_and = SONG_LAW(DAVAR_LAW_ID_AND, judge_and);
