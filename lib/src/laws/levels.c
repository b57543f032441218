/* davar - the report of law glr: the levels in deg/s before and after a change (10.12), and since
 * the last alarm with their interval (10.18). Also what every result has of the law. */
#include "davar/content.h"
#include "davar/glr.h"

#include "core/instance.h"
#include "core/window.h"
#include "laws/glr.h"
#include "number/real.h"
#include "number/scaled.h"

#include <math.h>

/* --- while samples come ----------------------------------------------------------------------- */

#define CHECK 6U         /* the two parts are compared every 2^6 blocks */
#define STEP_DIGITS 16U  /* of the logarithm of their ratio */
#define STEP_MOST 65536U /* 1: alarms find larger steps */
#define HEAVY 20480U     /* 5, f of tails that may have no fourth moment */
#define LIGHT 256U       /* turns without them after which an interval is shown, 2^14 blocks */
#define F_LEARNED 1536U  /* blocks after which f is known, whatever it is */

void davar_steady_restart(davar_steady_sums_t *steady, const davar_glr_t *detector)
{
    const davar_spread_t none = {0U, 0U, 0U};
    spread_copy(&steady->since, &detector->now.sum);
    spread_copy(&steady->middle, &detector->now.sum);
    spread_copy(&steady->shocks, &none);
}

/* Compares G of (10.4) with its threshold: nu/8 times the blocks of the shorter part times the
 * squared logarithm of the ratio of their means. To second order that is between half of G and
 * G. */
static bool parts_differ(const davar_spread_t *older, const davar_spread_t *newer,
                         const davar_glr_config_t *config, uint32_t f)
{
    const uint32_t blocks = (older->blocks < newer->blocks) ? older->blocks : newer->blocks;
    if (blocks == 0U) {
        return false;
    }
    const int32_t ratio = spread_logarithm_of_mean(older) - spread_logarithm_of_mean(newer);
    const uint32_t size = ((ratio < 0) ? (0U - (uint32_t)ratio) : (uint32_t)ratio) >> 8U;
    const uint32_t step = (size < STEP_MOST) ? size : STEP_MOST;
    const uint64_t square = davar_multiply_u32(step, step); /* at most 2^32 */
    const uint64_t gain =
        davar_scale_u64(davar_scale_u64(square, blocks) >> STEP_DIGITS, config->degrees) << 5U;
    return gain > (davar_multiply_u32(f, config->alarm) >> 4U); /* both with 24 digits */
}

void davar_steady_push(davar_steady_sums_t *steady, const davar_glr_t *detector,
                       const davar_glr_config_t *config, const davar_glr_event_t *event)
{
    if (event->dropped > 0U) {
        spread_add(&steady->shocks, &event->shock);
    }
    const uint16_t turn = (uint16_t)((detector->now.at + 1U) >> CHECK); /* odd: fewer splits */
    if (turn == steady->turn) {
        return;
    }
    steady->turn = turn;
    const uint32_t f = davar_glr_dispersion(detector, GLR_TYPICAL);
    if (f > HEAVY) {
        steady->wait = LIGHT;
    } else if (steady->wait > 0U) {
        steady->wait--;
    } else {
        /* tails have been light */
    }
    const davar_spread_t all = spread_between(&steady->since, &detector->now.sum);
    const davar_spread_t older = spread_between(&steady->since, &steady->middle);
    const davar_spread_t newer = spread_between(&steady->middle, &detector->now.sum);
    const davar_spread_t *const shocks = &steady->shocks;
    const bool is_full = ((all.high | all.blocks | shocks->high | shocks->blocks) >> 30U) != 0U;
    if (is_full || (f > HEAVY) || parts_differ(&older, &newer, config, f)) {
        davar_steady_restart(steady, detector);
    } else if (newer.blocks >= older.blocks) {
        spread_copy(&steady->middle, &detector->now.sum);
    }
}

/* The larger f is, the more blocks it takes to know it: 512 f^2, up to F_LEARNED. */
bool davar_steady_is_known(const davar_steady_sums_t *steady, const davar_glr_t *detector)
{
    const uint32_t f = davar_glr_dispersion(detector, GLR_TYPICAL);
    const uint32_t blocks = (f * f) >> ((2U * GAIN_DIGITS) - 9U);
    return (steady->wait == 0U) && (f <= HEAVY) &&
           (detector->single.count >= smaller(blocks, F_LEARNED));
}

/* --- for a result ----------------------------------------------------------------------------- */

double davar_spread_level(const davar_spread_t *sum, uint32_t floor, uint32_t unit)
{
    const davar_spread_t rounding = {davar_multiply_u32(floor, sum->blocks), 0U, 0U};
    const davar_spread_t rest = spread_between(&rounding, sum);
    if ((rest.low | rest.high) == 0U) {
        return 0.0;
    }
    const int32_t exponent = spread_exponent(&rest);
    const scaled_t square = {spread_bits(&rest, exponent), exponent};
    return davar_root_of_quotient(davar_scaled_to_double(square),
                                  davar_double_of_u64(davar_multiply_u32(unit, sum->blocks)));
}

static bool is_whitened(const davar_config_t *config)
{
    return (config->glr.whiten_first != 0) || (config->glr.whiten_second != 0);
}

static double dps_per_count(const davar_config_t *config, double unit_per_count)
{
    return is_whitened(config) ? davar_scale(unit_per_count, config->glr.whiten_level)
                               : unit_per_count;
}

/* b of the constant that is added to each block (10.17). */
static uint32_t constant_of(const davar_config_t *config)
{
    return davar_glr_floor(config->glr.block, config->glr.whiten_first, config->glr.whiten_second);
}

/* b of a level of one count. */
static uint32_t unit_of(const davar_config_t *config)
{
    const uint32_t block = config->glr.block;
    return 12U * block * (block - 1U);
}

/* The deviation from a sum of b (10.12). NaN if all blocks were lost in gaps. */
static double level_of(const davar_config_t *config, const davar_spread_t *sum,
                       double unit_per_count)
{
    if (sum->blocks == 0U) {
        return (double)NAN;
    }
    return davar_scale(davar_spread_level(sum, constant_of(config), unit_of(config)),
                       dps_per_count(config, unit_per_count));
}

static void report_change(const davar_config_t *config, double unit_per_count,
                          const davar_glr_copy_t *copy, davar_change_t *change)
{
    change->m = 1U;
    change->older = level_of(config, &copy->older, unit_per_count);
    change->newer = level_of(config, &copy->newer, unit_per_count);
    change->gain = davar_scale(davar_double_of_u64((uint32_t)copy->gain), 1.0 / (double)F_ONE);
}

#define PRIOR 100U  /* a; with alpha = 1 / 20, 4 a alpha^2 = 1 and drops out of the logarithm */
#define WIDEST 0.45 /* above it, (10.18) is not valid */
#define COARSE 0.7  /* below this level in counts, rounding is not independent of the noise */

/* s of (10.18): the interval reaches from the level over 1 + s to that over 1 - s. */
static double width_of(uint32_t blocks, uint32_t degrees, uint32_t f)
{
    const scaled_t x =
        scaled_quotient(scaled_of_u64(davar_multiply_u32(blocks, degrees), GAIN_DIGITS + 2),
                        scaled_of_u32((3U * f) - F_ONE, 0));
    const scaled_t sum = davar_scaled_plus(x, scaled_of_u32(4U * PRIOR, 0));
    const uint32_t logarithm = (uint32_t)davar_logarithm(sum.mantissa, sum.exponent);
    const scaled_t factor =
        davar_scaled_plus(scaled_of_u32(1U, 0), scaled_quotient(scaled_of_u32(2U * PRIOR, 0), x));
    const scaled_t root = davar_scaled_root(scaled_quotient(scaled_of_u32(logarithm, -24), x));
    return davar_scaled_to_double(scaled_times(root, factor));
}

/* sqrt(S / (12 K nu N factor^2) - rounding / (12 K nu)), or 0. */
static double limit_of(const davar_spread_t *sum, uint32_t rounding, uint32_t unit, double factor)
{
    const double root = davar_divide(davar_spread_level(sum, 0U, unit), factor);
    const double square = davar_scale(root, root) - davar_divide((double)rounding, (double)unit);
    return (square > 0.0) ? davar_root(square) : 0.0;
}

static void report_steady(const davar_config_t *config, double unit_per_count,
                          const davar_glr_copy_t *copy, davar_steady_t *steady)
{
    const uint32_t block = config->glr.block;
    const uint32_t nu = block - 1U;
    const uint32_t unit = unit_of(config);
    const uint32_t rounding =
        constant_of(config) +
        davar_glr_rounding(block, config->glr.whiten_first, config->glr.whiten_second);
    if (copy->steady.blocks == 0U) {
        return;
    }
    const double s = width_of(copy->steady.blocks, nu, copy->dispersion);
    const double level = limit_of(&copy->steady, rounding, unit, 1.0);
    if ((s > WIDEST) || (level < COARSE)) {
        return;
    }
    const bool whitened = is_whitened(config);
    const uint32_t twelfth = whitened ? (block * nu) : 0U; /* of a count^2 */
    davar_spread_t all = copy->steady;
    spread_add(&all, &copy->shocks);
    const double low = limit_of(&copy->steady, rounding + (2U * twelfth), unit, 1.0 + s);
    const double high = limit_of(&all, rounding - twelfth, unit, 1.0 - s);
    const double scale = dps_per_count(config, unit_per_count);
    const double tolerance = whitened ? (1.0 + config->glr.whiten_tolerance) : 1.0;
    steady->samples = davar_multiply_u32(copy->steady.blocks, block);
    steady->level = davar_scale(level, scale);
    steady->low = davar_scale(low, davar_divide(scale, tolerance));
    steady->high = davar_scale(high, davar_scale(scale, tolerance));
}

void davar_glr_evaluate(const davar_config_t *config, double unit_per_count,
                        const davar_glr_copy_t *copy, davar_glr_report_t *report)
{
    if (copy->changed) {
        report_change(config, unit_per_count, copy, &report->change);
    }
    report_steady(config, unit_per_count, copy, &report->steady);
}

/* Samples dropped since the epoch do not count in its time. */
void davar_glr_read(const void *state, davar_result_t *result)
{
    const davar_glr_track_t *const track = state;
    const uint32_t half = track->age - (track->age / 2U);
    result->epoch -= track->left_out;
    result->chosen = track->young || (half > result->window_samples);
    result->dispersion =
        (double)davar_glr_dispersion(&track->detector, GLR_TYPICAL) / (double)F_ONE;
}

static void copy_track(const davar_glr_track_t *track, davar_glr_copy_t *copy)
{
    const davar_glr_t *const detector = &track->detector;
    const bool is_known = davar_steady_is_known(&track->steady, detector);
    copy->older = track->older;
    copy->newer = spread_between(&detector->alarm.sum, &detector->now.sum);
    copy->gain = track->gain;
    copy->dispersion = davar_glr_dispersion(detector, GLR_TYPICAL);
    copy->steady =
        spread_between(is_known ? &track->steady.since : &detector->now.sum, &detector->now.sum);
    copy->shocks = track->steady.shocks;
    copy->changed = track->changed;
}

void davar_glr_report(davar_t *davar, davar_glr_report_t *report)
{
    static const davar_glr_report_t absent = {
        .change = {0U, (double)NAN, (double)NAN, (double)NAN},
        .steady = {0U, (double)NAN, (double)NAN, (double)NAN}};
    const davar_config_t *const config = davar->config;
    const davar_glr_track_t *const track = davar->law_state;
    davar_glr_copy_t copy;
    davar_window_t window;
    uint32_t left_out;
    uint32_t alarms;
    uint32_t before;
    *report = absent;
    if (davar_law_id(config) != DAVAR_LAW_ID_GLR) {
        return;
    }
    do {
        before = davar_read_begin(davar);
        copy_track(track, &copy);
        window = davar->window;
        left_out = track->left_out;
        alarms = davar->health.alarms;
        report->cut_age_samples = track->age;
        report->young = track->young;
    } while (davar_read_torn(davar, before));
    const uint32_t since = (config->stride > 1U) ? (config->stride - window.wait) : 0U;
    report->epoch = window_now(&window) - since - 1U - left_out;
    report->alarm = (alarms != davar->alarms_seen);
    davar->alarms_seen = alarms;
    davar_glr_evaluate(config, size_of_count(davar), &copy, report);
}
