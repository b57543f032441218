/* davar - the detector: holds shocks back, adds blocks to the running sums, then scans for a
 * change. */
#include "laws/glr.h"

#include "core/instance.h"
#include "core/window.h"
#include "laws/scan.h"
#include "number/real.h"
#include "number/scaled.h"

#include <math.h>
#include <string.h>

#define MEMORY 11U     /* the dispersion forgets over 2^11 blocks */
#define MEMORY_OF_8 8U /* and over 2^8 sums of eight */
#define ENOUGH 100U    /* degrees of freedom of a mean that a shock is compared with */
#define OVER_FLOOR 4U  /* no shocks below this multiple of the variance of rounding */
#define CALM 543U      /* a shock ends with a block below 2.12 means (widened); 8 digits */

static const davar_spread_t no_blocks = {0U, 0U, 0U};

void davar_glr_reset(davar_glr_t *state)
{
    memset(state, 0, sizeof *state);
    davar_dispersion_start(&state->single);
    davar_dispersion_start(&state->of_8);
}

/* A place that is too old moves to the next record of the coarsest octave. */
static void shorten(const davar_glr_t *state, const davar_glr_config_t *config,
                    davar_glr_place_t *place)
{
    if (glr_age(state, place) > config->longest) {
        const uint32_t level = config->levels - 1U;
        glr_move_to_record(state, place, level, ((place->at >> level) + 1U) << level);
    }
}

/* Adds the next block; `no_blocks` for a dropped one. */
static void advance(davar_glr_t *state, const davar_glr_config_t *config,
                    const davar_spread_t *block)
{
    spread_add(&state->now.sum, block);
    state->now.at++;
    const uint32_t at = state->now.at;
    for (uint32_t level = 0U; (level < config->levels) && (((at >> level) << level) == at);
         level++) {
        spread_copy(&state->record[level][(at >> level) % GLR_RECORDS], &state->now.sum);
    }
    if (glr_age(state, &state->alarm) > config->longest) { /* the cut is never older */
        shorten(state, config, &state->alarm);
        shorten(state, config, &state->cut);
    }
}

/* ---- shocks ---- */

/* 1 + (factor - 1) sqrt(f), both with 8 digits */
static uint32_t widened(const davar_glr_t *state, uint32_t factor)
{
    const uint32_t f = davar_glr_dispersion(state, GLR_TYPICAL); /* 1 to below 16 */
    const uint32_t half = (f >= (4U * F_ONE)) ? 1U : 0U;
    const uint32_t root =
        davar_root_of_mantissa_by_integers(f << (30U - GAIN_DIGITS - (2U * half))) >> (15U - half);
    return 256U + (((factor - 256U) * root) >> 8U);
}

/* Is the block above `factor` times the mean of the window? 8 digits, below 2^14. */
static bool is_above(const davar_spread_t *block, const davar_spread_t *window, uint32_t factor)
{
    const int32_t of_block = spread_exponent(block);
    const int32_t of_window = spread_exponent(window);
    const int32_t at = (of_block > of_window) ? of_block : of_window;
    const uint64_t b = davar_multiply_u32(spread_bits(block, at), window->blocks) << 8U;
    return b > davar_multiply_u32(spread_bits(window, at), factor);
}

static bool may_be_shock(const davar_glr_t *state, const davar_glr_config_t *config,
                         const davar_spread_t *block, const davar_spread_t *window)
{
    const uint64_t floor = davar_multiply_u32(OVER_FLOOR * window->blocks, config->floor);
    return (config->shock != 0U) && ((window->blocks * config->degrees) >= ENOUGH) &&
           ((window->high != 0U) || (window->low > floor)) &&
           is_above(block, window, config->outlier) &&
           is_above(block, window, widened(state, config->outlier));
}

/* The waiting blocks pass: as a shock they add time only, otherwise also their sums. */
static void release(davar_glr_t *state, const davar_glr_config_t *config, bool is_shock,
                    davar_glr_event_t *event)
{
    event->dropped = is_shock ? state->pending : 0U;
    event->resolved += state->pending;
    spread_copy(&event->shock, &no_blocks);
    for (uint32_t i = 0U; i < state->pending; i++) {
        if (is_shock) {
            spread_add(&event->shock, &state->waiting[i]);
        }
        advance(state, config, is_shock ? &no_blocks : &state->waiting[i]);
    }
    state->pending = 0U;
}

/* Is this block far below a waiting one? A change of the noise would have lasted. */
static bool is_over(const davar_glr_t *state, const davar_spread_t *block)
{
    davar_spread_t thrice;
    spread_copy(&thrice, block);
    spread_add(&thrice, block);
    spread_add(&thrice, block);
    bool is_less = false;
    for (uint32_t i = 0U; i < state->pending; i++) {
        const davar_spread_t *const waiting = &state->waiting[i];
        is_less = is_less || (thrice.high < waiting->high) ||
                  ((thrice.high == waiting->high) && (thrice.low < waiting->low));
    }
    return is_less;
}

/* Makes the block wait while a shock is possible. False: it does not wait, and no other does. */
static bool hold(davar_glr_t *state, const davar_glr_config_t *config, const davar_spread_t *block,
                 davar_glr_event_t *event)
{
    const davar_spread_t window = spread_between(&state->cut.sum, &state->now.sum);
    if (state->pending == 0U) {
        if (!may_be_shock(state, config, block, &window)) {
            return false;
        }
    } else {
        const bool is_calm =
            is_over(state, block) || !is_above(block, &window, widened(state, CALM));
        if (is_calm || (state->pending == config->shock)) {
            release(state, config, is_calm, event);
            return false;
        }
    }
    spread_copy(&state->waiting[state->pending], block);
    state->pending++;
    return true;
}

/* ---- decisions ---- */

static void move_to_split(const davar_glr_t *state, davar_glr_place_t *place,
                          const davar_split_t *split)
{
    glr_move_to_record(state, place, split->level, state->now.at - split->age);
}

static void raise_alarm(davar_glr_t *state, const davar_split_t *split, davar_glr_event_t *event)
{
    davar_spread_t before;
    spread_copy(&before, &state->alarm.sum);
    move_to_split(state, &state->alarm, split);
    event->is_alarm = true;
    event->gain = split->gain;
    event->older = spread_between(&before, &state->alarm.sum);
    event->newer = spread_between(&state->alarm.sum, &state->now.sum);
}

static void decide(davar_glr_t *state, const davar_glr_config_t *config, davar_glr_event_t *event)
{
    davar_split_t split[2] = {{config->cut, 0, 0, 0U, 0U}, {config->alarm, 0, 0, 0U, 0U}};
    const bool is_one = (state->cut.at == state->alarm.at);
    davar_glr_scan(state, config, &state->cut, split, is_one ? 2U : 1U);
    if (!is_one) {
        davar_glr_scan(state, config, &state->alarm, &split[1], 1U);
    }
    if (split[0].age != 0U) {
        move_to_split(state, &state->cut, &split[0]);
        event->is_cut = true;
    }
    if (split[1].age != 0U) {
        raise_alarm(state, &split[1], event);
    }
    if (glr_age(state, &state->cut) > glr_age(state, &state->alarm)) {
        glr_place_copy(&state->cut, &state->alarm);
        event->is_cut = true;
    }
}

/* ---- blocks ---- */

static void clear(davar_glr_event_t *event)
{
    event->is_cut = false;
    event->is_alarm = false;
    event->gain = 0;
    event->resolved = 0U;
    event->dropped = 0U;
}

void davar_glr_push(davar_glr_t *state, const davar_glr_config_t *config,
                    const davar_spread_t *block, davar_glr_event_t *event)
{
    clear(event);
    davar_dispersion_learn(&state->single, spread_logarithm(block), config->step, MEMORY);
    spread_add(&state->eight, block);
    if (state->eight.blocks == 8U) {
        davar_dispersion_learn(&state->of_8, spread_logarithm(&state->eight), config->step_of_8,
                               MEMORY_OF_8);
        spread_copy(&state->eight, &no_blocks);
    }
    if (!hold(state, config, block, event)) {
        advance(state, config, block);
        event->resolved++;
        decide(state, config, event);
    }
}

void davar_glr_skip(davar_glr_t *state, const davar_glr_config_t *config, davar_glr_event_t *event)
{
    clear(event);
    release(state, config, true, event);
    advance(state, config, &no_blocks);
    event->resolved++;
}

/* b = 12 (K s2 - s1^2) + K nu: 12 K nu times the variance, plus that of rounding */
void davar_glr_push_q15(davar_glr_t *state, const davar_glr_config_t *config, int32_t sum,
                        uint64_t squares, davar_glr_event_t *event)
{
    const uint64_t spread = davar_scale_u64(squares, config->block) - davar_square_i32(sum);
    const davar_spread_t block = {davar_scale_u64(spread, 12U) + config->floor, 0U, 1U};
    davar_glr_push(state, config, &block, event);
}

void davar_glr_push_q31(davar_glr_t *state, const davar_glr_config_t *config, int64_t sum,
                        const davar_u128_t *squares, davar_glr_event_t *event)
{
    const davar_u128_t floor = {config->floor, 0U};
    const davar_u128_t scaled = davar_u128_scale(*squares, config->block);
    const davar_u128_t spread = davar_u128_subtract(scaled, davar_multiply_i64(sum, sum));
    const davar_u128_t b = davar_u128_add(davar_u128_scale(spread, 12U), floor); /* below 2^96 */
    const davar_spread_t block = {b.low, (uint32_t)b.high, 1U};
    davar_glr_push(state, config, &block, event);
}

/* --- thresholds ------------------------------------------------------------------------------- */

#define OF_ALARM 78643 /* 1.2, 16 digits: c of the thresholds (10.6) */
#define OF_CUT 117965  /* 1.8 */
#define MARGIN 65536   /* 1, 16 digits: least h above ln of the longest part */

static int32_t logarithm_of(double value)
{
    const scaled_t scaled = scaled_of_double(value);
    return davar_logarithm(scaled.mantissa, scaled.exponent);
}

/* ln(T rate / K) + c, where T is the time between two false decisions. */
static uint32_t threshold_of(double seconds, const davar_glr_wish_t *wish, int32_t c,
                             uint32_t longest)
{
    const int32_t blocks =
        logarithm_of(seconds) + logarithm_of(wish->rate_hz) - davar_logarithm_of_count(wish->block);
    const int32_t h = (blocks / 256) + c;
    const int32_t least = (davar_logarithm_of_count(longest) / 256) + MARGIN;
    return (uint32_t)((h > least) ? h : least);
}

/* Whole blocks in so many samples, at least one. */
static uint32_t blocks_of(uint32_t samples, uint32_t block)
{
    return (samples > block) ? (samples / block) : 1U;
}

void davar_glr_start(davar_glr_config_t *config, const davar_glr_wish_t *wish)
{
    const uint32_t nu = wish->block - 1U;
    const uint32_t longest = smaller(wish->longest / wish->block, GLR_LONGEST);
    uint32_t levels = 1U;
    while ((levels < GLR_LEVELS) && (((GLR_RECORDS - 1U) << (levels - 1U)) < longest)) {
        levels++;
    }
    config->block = wish->block;
    config->degrees = nu;
    config->floor = wish->block * nu;
    config->longest = longest;
    config->levels = levels;
    config->shock = wish->shock;
    config->outlier = (wish->block < 18U) ? 1280U : 768U; /* 5 or 3 */
    config->alarm =
        threshold_of(davar_divide(3600.0, wish->false_alarms_per_hour), wish, OF_ALARM, longest);
    config->cut = smaller(threshold_of(wish->cut_interval_s, wish, OF_CUT, longest), config->alarm);
    config->step = davar_divided((nu * nu) << 14U, nu + 1U);
    config->step_of_8 = nu << 17U;
    config->bias = davar_divided(UINT32_C(1) << 16U, 3U * nu);
    config->near = blocks_of(150U, wish->block);
    config->far = blocks_of(600U, wish->block);
}

uint32_t davar_glr_floor(uint32_t block, int16_t first, int16_t second)
{
    const uint32_t squares =
        (uint32_t)(first * first) + (uint32_t)(second * second); /* 28 digits */
    const uint32_t nu = block * (block - 1U);
    return nu + (uint32_t)((davar_multiply_u32(squares, 2U * nu) + (UINT32_C(1) << 27U)) >> 28U);
}

uint32_t davar_glr_rounding(uint32_t block, int16_t first, int16_t second)
{
    const int32_t one = 16384;
    const uint32_t nu = block * (block - 1U);
    const uint32_t squares = (uint32_t)(first * first) + (uint32_t)(second * second);
    const uint32_t roundings = ((first != 0) || (second != 0)) ? 2U : 1U;
    const uint64_t apart =
        davar_multiply_u32(nu, (roundings << 28U)) + davar_multiply_u32(nu, squares);
    const uint64_t by_1 = davar_multiply_i32((int32_t)(block - 1U) * first, one - second);
    const uint64_t by_2 = davar_multiply_i32((int32_t)(block - 2U) * second, one);
    return (uint32_t)((apart + (2U * (by_1 + by_2)) + (UINT32_C(1) << 27U)) >> 28U);
}

/* --- the window law --------------------------------------------------------------------------- */

/* On a grid, windows begin between two blocks. Is one of window.shortest to window.longest samples
 * possible at every epoch? */
static bool fits_between_blocks(const davar_config_t *config)
{
    const uint32_t block = config->glr.block;
    const uint32_t lost =
        ((config->stride % block) == 0U) ? (config->window.longest % block) : (block - 1U);
    return (engine_of(config) == NULL) ||
           ((config->window.longest - lost) >= config->window.shortest);
}

static uint32_t size_of(int32_t share)
{
    return (uint32_t)((share < 0) ? -share : share);
}

static bool has_rates(const davar_config_t *config)
{
    return davar_is_between(1e-9, config->glr.false_alarms_per_hour, 1e9) &&
           davar_is_between(1e-9, config->glr.cut_interval_s, 1e9);
}

static bool has_whitening(const davar_config_t *config)
{
    const uint32_t sizes = size_of(config->glr.whiten_first) + size_of(config->glr.whiten_second);
    return (sizes == 0U) ||
           ((sizes <= GLR_WHITEN_MAX) && davar_is_between(1e-9, config->glr.whiten_level, 1e9) &&
            davar_is_between(0.0, config->glr.whiten_tolerance, 100.0));
}

static bool has_windows(const davar_config_t *config)
{
    const uint32_t block = config->glr.block;
    const uint32_t longest = config->window.longest;
    return ((longest / 8U) >= block) && (longest <= (GLR_LONGEST * block)) &&
           fits_between_blocks(config);
}

DAVAR_RARE davar_status_t davar_glr_check(const davar_config_t *config)
{
    const uint32_t block = config->glr.block;
    if ((block < GLR_BLOCK_MIN) || (block > GLR_BLOCK_MAX) ||
        (config->glr.shock_blocks > GLR_SHOCK_MAX)) {
        return DAVAR_ERR_TRACKING;
    }
    return (has_rates(config) && has_whitening(config) && has_windows(config)) ? DAVAR_OK
                                                                               : DAVAR_ERR_TRACKING;
}

uint32_t davar_glr_block(const davar_config_t *config)
{
    return config->glr.block;
}
