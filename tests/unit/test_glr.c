/* davar tests - the detector of changes against its law, computed anew at every block from the raw samples; and what it says at a
 * step, a shock, a ramp, a gap. */
#include "number/real.h"
#include "track/likelihood.h"
#include "track/scan.h"
#include "track/window.h"

#include "random.h"
#include "unity.h"

#include <math.h>
#include <string.h>

#ifndef BLOCKS
#define BLOCKS 3000U
#endif
#define RAW 1024U
#define K_MAX 25U

static const davar_glr_wish_t usual = {100.0, 0.01, 300.0, 6000U, 10U, 2U, true};
static davar_glr_config_t config;
static davar_glr_t state;
static davar_glr_event_t event;
static random_t rng;

void setUp(void)
{
    davar_glr_start(&config, &usual);
    davar_glr_reset(&state);
    rng = random_seeded(15U);
}

void tearDown(void) {}

/* ---- samples ---- */

static int16_t rounded(double value)
{
    return (int16_t)floor(fmax(-32768.0, fmin(32767.0, value)) + 0.5);
}

static void fill(int16_t *sample, double sigma)
{
    for (uint32_t i = 0U; i < config.block; i++) {
        sample[i] = rounded(sigma * random_gauss(&rng));
    }
}

static void push_samples(const int16_t *sample)
{
    int32_t sum = 0;
    uint64_t squares = 0U;
    for (uint32_t i = 0U; i < config.block; i++) {
        sum += sample[i];
        squares += (uint64_t)(sample[i] * (int64_t)sample[i]);
    }
    davar_glr_push_q15(&state, &config, sum, squares, &event);
}

static void push_noise(double sigma)
{
    int16_t sample[K_MAX] = {0};
    fill(sample, sigma);
    push_samples(sample);
}

static void push_quiet(uint32_t blocks)
{
    for (uint32_t i = 0U; i < blocks; i++) {
        push_noise(20.0);
    }
}

/* Pushes until an alarm; the blocks that it took, at most `most`. */
static uint32_t blocks_to_alarm(double sigma, uint32_t most)
{
    for (uint32_t i = 1U; i <= most; i++) {
        push_noise(sigma);
        if (event.is_alarm) {
            return i;
        }
    }
    return most + 1U;
}

/* ---- the law, anew at every block ---- */

static void law_note(bool is_cut);

static struct {
    uint64_t b[RAW]; /* 0: dropped */
    uint64_t waiting[GLR_SHOCK_MAX];
    uint32_t now;
    uint32_t cut;
    uint32_t alarm;
    uint32_t pending;
    uint32_t f;
    davar_dispersion_t single;
    davar_dispersion_t of_8;
    uint64_t eight;
    uint32_t in_eight;
} law;

static void law_reset(void)
{
    memset(&law, 0, sizeof law);
    davar_dispersion_start(&law.single);
    davar_dispersion_start(&law.of_8);
}

static davar_spread_t sum_of(uint32_t from, uint32_t to)
{
    davar_spread_t sum = {0U, 0U, 0U};
    for (uint32_t at = from; at != to; at++) {
        const davar_spread_t block = {law.b[at % RAW], 0U, (law.b[at % RAW] != 0U) ? 1U : 0U};
        spread_add(&sum, &block);
    }
    return sum;
}

static int32_t logarithm_of(uint64_t b)
{
    const davar_spread_t sum = {b, 0U, 1U};
    return spread_logarithm(&sum);
}

static void law_learn(uint64_t b)
{
    davar_dispersion_learn(&law.single, logarithm_of(b), config.step, 11U);
    law.eight += b;
    law.in_eight++;
    if (law.in_eight == 8U) {
        davar_dispersion_learn(&law.of_8, logarithm_of(law.eight), config.step_of_8, 8U);
        law.eight = 0U;
        law.in_eight = 0U;
    }
    const uint32_t phi = ((law.single.phi > law.of_8.phi) ? law.single.phi : law.of_8.phi) >> 12U;
    law.f = (phi > 4096U) ? (phi + ((phi - 4096U) / 8U)) : 4096U;
}

static bool exceeds(uint64_t b, const davar_spread_t *window, uint32_t factor)
{
    const double root = floor(sqrt((double)law.f / 4096.0) * 256.0); /* of 2^24 or less: exact */
    const uint32_t widened = 256U + (((factor - 256U) * (uint32_t)root) >> 8U);
    return ((double)b * (double)window->blocks * 256.0) > ((double)window->low * (double)widened);
}

static void law_advance(uint64_t b)
{
    law.b[law.now % RAW] = b;
    law.now++;
    const uint32_t level = config.levels - 1U;
    if ((law.now - law.cut) > config.longest) {
        law.cut = ((law.cut >> level) + 1U) << level;
    }
    if ((law.now - law.alarm) > config.longest) {
        law.alarm = ((law.alarm >> level) + 1U) << level;
    }
}

static int32_t law_threshold(uint32_t h, uint32_t n)
{
    const uint32_t logarithm = (uint32_t)davar_logarithm_of_count(n) >> 8U;
    const uint64_t plain = ((uint64_t)law.f * (h - logarithm)) >> 16U;
    return (int32_t)(plain + ((plain * davar_divided(config.bias, n)) >> 16U));
}

typedef struct {
    int32_t excess;
    uint32_t age; /* 0: none exceeds */
} law_best_t;

static void law_ask(law_best_t *best, uint32_t begin, uint32_t age, uint32_t h)
{
    if (age >= (law.now - begin)) {
        return;
    }
    const davar_spread_t sum = sum_of(begin, law.now);
    const davar_spread_t older = sum_of(begin, law.now - age);
    const uint32_t newer = sum.blocks - older.blocks;
    const uint32_t n = (newer < older.blocks) ? newer : older.blocks;
    if (n < config.least) {
        return;
    }
    davar_stretch_t stretch;
    davar_stretch(&stretch, &sum, config.degrees);
    const int32_t excess = davar_likelihood_gain(&stretch, &older) - law_threshold(h, n);
    if (excess > best->excess) {
        best->excess = excess;
        best->age = age;
    }
}

/* The age of the split that exceeds by most. No split is spared the logarithms. */
static uint32_t law_scan(uint32_t begin, uint32_t h)
{
    law_best_t best = {0, 0U};
    law_ask(&best, begin, 2U, h);
    law_ask(&best, begin, 3U, h);
    law_ask(&best, begin, ((law.now % 2U) == 0U) ? 4U : 5U, h);
    for (uint32_t half = 2U; half < (1U << (config.levels - 1U)); half *= 2U) {
        if ((law.now % (2U * half)) == half) {
            law_ask(&best, begin, 3U * half, h);
            law_ask(&best, begin, 5U * half, h);
        }
    }
    return best.age;
}

static void law_decide(void)
{
    const uint32_t cut = law_scan(law.cut, config.cut);
    const uint32_t alarm = law_scan(law.alarm, config.alarm);
    bool is_cut = (cut != 0U);
    TEST_ASSERT_EQUAL(alarm != 0U, event.is_alarm);
    law.cut = (cut != 0U) ? (law.now - cut) : law.cut;
    law.alarm = (alarm != 0U) ? (law.now - alarm) : law.alarm;
    if ((law.now - law.cut) > (law.now - law.alarm)) {
        law.cut = law.alarm;
        is_cut = true;
    }
    law_note(is_cut);
}

static void law_release(bool is_shock)
{
    for (uint32_t i = 0U; i < law.pending; i++) {
        law_advance(is_shock ? 0U : law.waiting[i]);
    }
    law.pending = 0U;
}

static bool law_is_over(uint64_t b)
{
    bool is_less = false;
    for (uint32_t i = 0U; i < law.pending; i++) {
        is_less = is_less || ((3U * b) < law.waiting[i]);
    }
    return is_less;
}

static void law_push(uint64_t b)
{
    const davar_spread_t window = sum_of(law.cut, law.now);
    law_learn(b);
    bool waits = (law.pending == 0U) && (config.shock != 0U) && ((window.blocks * (config.block - 1U)) >= 100U) &&
                 (window.low > ((uint64_t)4U * window.blocks * config.floor)) && exceeds(b, &window, config.outlier);
    if (law.pending != 0U) {
        const bool is_calm = law_is_over(b) || !exceeds(b, &window, 543U);
        waits = !is_calm && (law.pending < config.shock);
        if (!waits) {
            law_release(is_calm);
        }
    }
    if (waits) {
        law.waiting[law.pending] = b;
        law.pending++;
        return;
    }
    law_advance(b);
    law_decide();
}

static void law_push_samples(const int16_t *sample)
{
    uint64_t b = 0U;
    for (uint32_t i = 0U; i < config.block; i++) {
        for (uint32_t k = 0U; k < i; k++) {
            const int64_t d = (int64_t)sample[i] - sample[k]; /* K s2 - s1^2 is the sum of all pairs' squares */
            b += (uint64_t)(d * d);
        }
    }
    law_push((12U * b) + ((uint64_t)config.block * (config.block - 1U)));
}

static void law_skip(void)
{
    law_release(true);
    law_advance(0U);
}

/* Steps, bursts, ramps, shocks of one to five samples, stretches without noise and at full scale, heavy tails, gaps. */
static void make(int16_t *sample)
{
    static double sigma = 20.0;
    static double slope = 1.0;
    static bool is_heavy = false;
    const double what = random_uniform(&rng);
    if (what < 0.02) {
        sigma = 20.0 * exp(2.0 * random_gauss(&rng));
        slope = (random_uniform(&rng) < 0.2) ? exp(0.05 * random_gauss(&rng)) : 1.0;
        is_heavy = (random_uniform(&rng) < 0.3);
    }
    sigma = (what > 0.9995) ? 0.0 : (((what > 0.999) || (sigma > 1e5)) ? 1e5 : sigma * slope);
    for (uint32_t i = 0U; i < config.block; i++) {
        const double tail = is_heavy ? sqrt(-log(random_uniform(&rng))) : 1.0;
        sample[i] = rounded((sigma * tail * random_gauss(&rng)) + 5.0);
    }
    if ((what > 0.5) && (what < 0.51)) {
        sample[0] = rounded(sigma * 100.0 * random_uniform(&rng));
    }
}

/* ---- the windows (10.9, 10.10), anew at every block from the raw blocks, in doubles ---- */

static struct {
    uint32_t at[GLR_CUTS]; /* the cuts that are remembered, the oldest first */
    bool counts[GLR_CUTS];
    bool settled[GLR_CUTS];
    uint32_t cuts;
    uint32_t turn;
    uint32_t seen;
    uint32_t compared;
    uint32_t unsure; /* so close to a threshold that doubles cannot tell */
} past;

/* G of [from, middle) against [middle, to) (10.4), S the sums and N the blocks of both parts. */
static double gain_of(double s_older, double n_older, double s_newer, double n_newer)
{
    const double whole = (n_older + n_newer) * log((s_older + s_newer) / (n_older + n_newer));
    return 0.5 * (config.block - 1U) *
           (whole - (n_older * log(s_older / n_older)) - (n_newer * log(s_newer / n_newer)));
}

/* 1: above the limit, -1: below, 0: too close to tell. */
static int against(double gain, double limit)
{
    const double hair = 0.02 + (2e-4 * (fabs(gain) + limit));
    return (gain > (limit + hair)) ? 1 : ((gain < (limit - hair)) ? -1 : 0);
}

static int law_differs(uint32_t from, uint32_t middle, uint32_t to, double limit)
{
    const davar_spread_t older = sum_of(from, middle);
    const davar_spread_t newer = sum_of(middle, to);
    if ((older.blocks == 0U) || (newer.blocks == 0U)) {
        return -1;
    }
    return against(gain_of((double)older.low, older.blocks, (double)newer.low, newer.blocks), limit * law.f / 4096.0);
}

/* The oldest record that is not older than `age`, in the least level whose four records reach so far; not before the bound. */
static uint32_t law_place(uint32_t age, uint32_t bound)
{
    uint32_t apart = 1U;
    while ((4U * apart) <= age) {
        apart *= 2U;
    }
    return (age >= (law.now - bound)) ? bound : (((law.now - age) + apart - 1U) / apart) * apart;
}

/* Where [begin, end) grows to; false: too close to tell. */
static bool law_grow(uint32_t *begin, uint32_t end, uint32_t bound, double near_limit)
{
    uint32_t age = law.now - *begin;
    while (*begin != bound) {
        age += age - (law.now - end);
        const uint32_t older = law_place(age, bound);
        const int differs = law_differs(older, *begin, end, ((end - older) <= config.far) ? near_limit : 1.5);
        if (differs >= 0) {
            return differs > 0;
        }
        *begin = older;
    }
    return true;
}

static double recent_bits(uint64_t b)
{
    uint64_t unit = 1U;
    while ((b / unit) >= 1024U) {
        unit *= 2U;
    }
    const uint64_t kept = (b / unit) * unit;
    return (double)kept;
}

/* In units that the loudest of some blocks fills 25 bits of, one at least. */
static double in_units(uint64_t b, uint64_t loudest)
{
    const int below = ilogb((double)loudest) - ilogb((double)b);
    return (below < 25) ? floor(ldexp(recent_bits(b), 24 - ilogb((double)loudest))) : 1.0;
}

/* Is cut i a step, not part of a ramp (10.10)? 1, -1, or 0: too close to tell. */
static int law_is_step(uint32_t i)
{
    const uint32_t at = past.at[i];
    const uint32_t age = law.now - at;
    uint32_t before = (i != 0U) ? (at - past.at[i - 1U]) : config.half;
    uint32_t after = ((i + 1U) < past.cuts) ? (past.at[i + 1U] - at) : age;
    if (age >= 64U) {
        return 1;
    }
    before = (before < config.half) ? before : config.half;
    before = (before < (64U - age)) ? before : (64U - age);
    after = (after < config.half) ? after : config.half;
    double s[2] = {0.0, 0.0};
    double n[2] = {0.0, 0.0};
    double moment = 0.0;
    uint64_t loudest = 1U;
    for (uint32_t k = at - before; k != (at + after); k++) {
        loudest = (law.b[k % RAW] > loudest) ? law.b[k % RAW] : loudest;
    }
    for (uint32_t k = at - before; k != (at + after); k++) {
        const uint64_t b = law.b[k % RAW];
        if (b != 0U) {
            const uint32_t part = ((k - (at - before)) < before) ? 0U : 1U;
            const double units = in_units(b, loudest);
            moment += 2.0 * (n[0] + n[1]) * units;
            s[part] += units;
            n[part] += 1.0;
        }
    }
    const double blocks = n[0] + n[1];
    if (!(n[0] > 0.0) || !(n[1] > 0.0)) {
        return 1;
    }
    const double rho = (moment / (s[0] + s[1])) - (blocks - 1.0);
    const double ramp = 0.75 * (config.block - 1U) * blocks * rho * rho / ((blocks * blocks) - 1.0);
    const double excess = gain_of(s[0], n[0], s[1], n[1]) - ramp - (4.0 * law.f / 4096.0);
    return (fabs(excess) < (0.1 + (0.005 * ramp))) ? 0 : ((excess > 0.0) ? 1 : -1);
}

static void law_drop_oldest(void)
{
    past.cuts--;
    for (uint32_t i = 0U; i < past.cuts; i++) {
        past.at[i] = past.at[i + 1U];
        past.counts[i] = past.counts[i + 1U];
        past.settled[i] = past.settled[i + 1U];
    }
}

static void law_keep(uint32_t at, bool settled)
{
    past.at[past.cuts] = at;
    past.counts[past.cuts] = true;
    past.settled[past.cuts] = settled;
    past.cuts++;
}

static void law_note(bool is_cut)
{
    if ((past.cuts != 0U) && ((law.now - past.at[0]) > config.longest)) {
        law_drop_oldest();
    }
    if (is_cut && (past.cuts == GLR_CUTS)) {
        law_drop_oldest();
        past.counts[0] = true;
        past.settled[0] = true;
    }
    if (is_cut) {
        law_keep(law.cut, false);
    }
    past.turn = ((past.turn + 1U) < past.cuts) ? (past.turn + 1U) : 0U;
    if ((past.turn < past.cuts) && !past.settled[past.turn]) {
        const int step = law_is_step(past.turn);
        const bool told = ((state.counts >> past.turn) & 1U) != 0U;
        past.unsure += (step == 0) ? 1U : 0U;
        past.counts[past.turn] = (step == 0) ? told : (step > 0);
        past.settled[past.turn] = (law.now - past.at[past.turn]) >= config.half;
    }
}

/* [begin, end) of the centred window; false: too close to tell. */
static bool law_centred(uint32_t *begin, uint32_t *end)
{
    const uint32_t centre = law.now - config.half;
    uint32_t bound = law_place(config.longest, 0U);
    *begin = centre - config.half;
    *end = law.now;
    for (uint32_t i = past.cuts; i > 0U; i--) {
        *end = (past.counts[i - 1U] && (past.at[i - 1U] > centre)) ? past.at[i - 1U] : *end;
    }
    for (uint32_t i = 0U; i < past.cuts; i++) {
        const bool is_before = (past.at[i] <= centre) && (past.at[i] >= *begin);
        *begin = (past.counts[i] && is_before) ? past.at[i] : *begin;
        bound = ((past.at[i] < *end) || ((past.cuts == GLR_CUTS) && (i == 0U))) ? past.at[i] : bound;
    }
    if (bound >= (law.now - (2U * config.half))) {
        return true;
    }
    const uint32_t from = law_place(2U * config.half, bound);
    uint32_t grown = from;
    const bool is_sure = law_grow(&grown, *end, bound, 1.5);
    *begin = (grown != from) ? grown : *begin;
    return is_sure;
}

static void compare_windows(void)
{
    davar_glr_window_t window;
    uint32_t begin = law_place(config.near, law.cut);
    uint32_t end = law.now;
    past.compared++;
    davar_glr_trailing(&state, &config, &window);
    if (law_grow(&begin, end, law.cut, 4.0)) {
        TEST_ASSERT_EQUAL_UINT32(begin, window.begin);
        TEST_ASSERT_EQUAL_UINT32(law.now, window.end);
        TEST_ASSERT_EQUAL_UINT32(sum_of(begin, end).blocks, window.blocks);
    } else {
        past.unsure++;
    }
    if (!davar_glr_centred(&state, &config, config.half, &window)) {
        TEST_ASSERT_LESS_THAN_UINT32(config.half, law.now);
        TEST_ASSERT_EQUAL_UINT32(0U, window.begin);
        TEST_ASSERT_EQUAL_UINT32(law.now, window.end);
    } else if ((law.now >= (2U * config.half)) && law_centred(&begin, &end)) {
        TEST_ASSERT_EQUAL_UINT32(begin, window.begin);
        TEST_ASSERT_EQUAL_UINT32(end, window.end);
    }
}

static void compare_with_law(uint32_t block, uint32_t shock, uint32_t longest)
{
    davar_glr_wish_t wish = usual;
    wish.block = block;
    wish.shock = shock;
    wish.longest = longest;
    davar_glr_start(&config, &wish);
    davar_glr_reset(&state);
    law_reset();
    memset(&past, 0, sizeof past);
    law_keep(0U, true);
    uint32_t alarms = 0U;
    for (uint32_t n = 0U; n < BLOCKS; n++) {
        int16_t sample[K_MAX] = {0};
        make(sample);
        if (random_uniform(&rng) < 0.003) {
            davar_glr_skip(&state, &config, &event);
            law_skip();
            law_note(false);
        } else {
            push_samples(sample);
            law_push_samples(sample);
        }
        alarms += event.is_alarm ? 1U : 0U;
        TEST_ASSERT_EQUAL_UINT32(law.now, state.now.at);
        TEST_ASSERT_EQUAL_UINT32(law.cut, state.cut.at);
        TEST_ASSERT_EQUAL_UINT32(law.alarm, state.alarm.at);
        TEST_ASSERT_EQUAL_UINT32(law.pending, state.pending);
        compare_windows();
    }
    TEST_ASSERT_LESS_THAN_UINT32(past.compared / 20U, past.unsure);
    TEST_ASSERT_GREATER_THAN_UINT32(BLOCKS / 500U, alarms);
}

static void test_every_decision_is_that_of_the_law_computed_anew(void)
{
    compare_with_law(10U, 2U, 6000U);
}

static void test_so_it_is_with_other_blocks_shocks_and_windows(void)
{
    compare_with_law(25U, 2U, 6000U);
    compare_with_law(10U, 0U, 6000U);
    compare_with_law(10U, 1U, 300U);
}

/* ---- numbers ---- */

static void test_the_logarithm_is_within_2e_minus_7(void)
{
    for (uint32_t i = 0U; i < 20000U; i++) {
        const uint32_t mantissa = 0x80000000U | (uint32_t)random_next(&rng);
        const int32_t exponent = (int32_t)(random_next(&rng) % 97U) - 32;
        const double exact = log((double)mantissa) + (exponent * log(2.0));
        TEST_ASSERT_DOUBLE_WITHIN(2e-7, exact, (double)davar_logarithm(mantissa, exponent) / 16777216.0);
    }
    TEST_ASSERT_EQUAL(0, davar_logarithm_of_count(1U));
}

static double times_logarithm_of_mean(const davar_spread_t *sum)
{
    const double mean = (((double)sum->high * 18446744073709551616.0) + (double)sum->low) / (double)sum->blocks;
    return (double)sum->blocks * log(mean);
}

static davar_spread_t random_spread(uint32_t blocks)
{
    const uint32_t down = (uint32_t)(random_next(&rng) % 96U);
    const uint64_t low = random_next(&rng);
    const uint32_t high = (uint32_t)(random_next(&rng) >> 34U);
    const davar_spread_t wide = {low, high >> (down % 32U), blocks};
    const davar_spread_t narrow = {(low >> (down % 58U)) | 1U, 0U, blocks};
    return (down < 48U) ? wide : narrow;
}

static void test_the_gain_is_the_formulas_and_the_bound_never_below(void)
{
    uint32_t spared = 0U;
    for (uint32_t i = 0U; i < 20000U; i++) {
        davar_spread_t older = random_spread(1U + (uint32_t)(random_next(&rng) % 500U));
        davar_spread_t sum = random_spread(1U + (uint32_t)(random_next(&rng) % 500U));
        if ((i % 2U) != 0U) { /* parts that are alike */
            older.low = (uint64_t)older.blocks << 40U;
            older.high = 0U;
            sum.low = 1U + (uint64_t)(exp(0.3 * random_gauss(&rng)) * (double)((uint64_t)sum.blocks << 40U));
            sum.high = 0U;
        }
        const davar_spread_t newer = sum;
        spread_add(&sum, &older);
        davar_stretch_t stretch;
        davar_stretch(&stretch, &sum, config.degrees);
        const double exact =
            4.5 * (times_logarithm_of_mean(&sum) - times_logarithm_of_mean(&older) - times_logarithm_of_mean(&newer));
        const int32_t gain = davar_likelihood_gain(&stretch, &older);
        TEST_ASSERT_DOUBLE_WITHIN(3e-3 + (1e-7 * exact), exact, (double)gain / 4096.0);
        const uint32_t limit = 64U + (uint32_t)(random_next(&rng) % 3000U);
        const bool may = davar_likelihood_may_reach(&stretch, &older, limit);
        TEST_ASSERT_TRUE(may || ((exact * 64.0) < (double)limit));
        spared += may ? 0U : 1U;
    }
    TEST_ASSERT_GREATER_THAN_UINT32(1000U, spared);
}

static void test_thresholds_are_the_logarithm_of_the_blocks_between_false_decisions(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, log(360000.0 * 10.0) + 1.2, config.alarm / 65536.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, log(300.0 * 10.0) + 1.8, config.cut / 65536.0);
    TEST_ASSERT_EQUAL(9, config.levels);
    davar_glr_wish_t wish = usual;
    wish.false_alarms_per_hour = 1e6;
    wish.block = 25U;
    davar_glr_start(&config, &wish);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, log(240.0) + 1.0, config.alarm / 65536.0);
    TEST_ASSERT_EQUAL_UINT32(config.alarm, config.cut);
    TEST_ASSERT_EQUAL(8, config.levels);
    wish.longest = 1U << 20U;
    wish.block = 5U;
    davar_glr_start(&config, &wish);
    TEST_ASSERT_EQUAL(GLR_LONGEST, config.longest);
    TEST_ASSERT_EQUAL(GLR_LEVELS, config.levels);
    TEST_ASSERT_EQUAL(GLR_HALF_MAX, config.half);
    wish.block = 400U;
    wish.is_centred = false;
    davar_glr_start(&config, &wish);
    TEST_ASSERT_EQUAL(1, config.near);
    TEST_ASSERT_EQUAL(0, config.half);
}

/* (10.13): for hops of 20 samples, clusters of 80. */
static void test_the_second_channel_is_as_the_formula_says(void)
{
    davar_glr_wish_t wish = usual;
    wish.block = 20U;
    davar_glr_start_clusters(&config, &wish);
    TEST_ASSERT_EQUAL(16, config.least);
    TEST_ASSERT_EQUAL(0, config.shock);
    TEST_ASSERT_EQUAL(80, config.floor);
    TEST_ASSERT_DOUBLE_WITHIN(0.002, 0.38, config.degrees / 256.0);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, log(360000.0 * 5.0) + 1.0, config.alarm / 65536.0);
    TEST_ASSERT_EQUAL_UINT32(config.alarm, config.cut);
    TEST_ASSERT_DOUBLE_WITHIN(1e-3, 256.0 / (3.0 * config.degrees), config.bias / 65536.0);
    TEST_ASSERT_EQUAL(0, config.outlier);
    davar_glr_push_clusters_q15(&state, &config, -1000, &event);
    TEST_ASSERT_EQUAL_UINT64(6000000U + 80U, state.now.sum.low);
    davar_glr_push_clusters_q31(&state, &config, INT64_C(1) << 40U, &event);
    TEST_ASSERT_EQUAL_UINT64(6000000U + 160U, state.now.sum.low);
    TEST_ASSERT_EQUAL_UINT32(6U << 16U, state.now.sum.high);
    wish.false_alarms_per_hour = 1e6;
    davar_glr_start_clusters(&config, &wish);
    TEST_ASSERT_DOUBLE_WITHIN(1e-4, log(768.0) + 1.0, config.alarm / 65536.0);
}

/* (10.6) for every size of a block: rounded down to 16 digits, half of one on the average; a constant that is one digit off shows. */
static void test_thresholds_of_every_block_are_the_formulas(void)
{
    double alarm = 0.0;
    double cut = 0.0;
    double least = 0.0;
    davar_glr_wish_t wish = usual;
    for (wish.block = GLR_BLOCK_MIN; wish.block <= GLR_BLOCK_MAX; wish.block++) {
        const double blocks = 100.0 / wish.block;
        wish.false_alarms_per_hour = 0.01;
        davar_glr_start(&config, &wish);
        alarm += (double)config.alarm - (65536.0 * (log(360000.0 * blocks) + 1.2));
        cut += config.cut - (65536.0 * (log(300.0 * blocks) + 1.8));
        wish.false_alarms_per_hour = 1e6;
        davar_glr_start(&config, &wish);
        const uint32_t longest = 6000U / wish.block;
        least += (double)config.alarm - (65536.0 * (log(fmin(longest, GLR_LONGEST)) + 1.0));
    }
    const double sizes = (double)(GLR_BLOCK_MAX - GLR_BLOCK_MIN + 1U);
    TEST_ASSERT_DOUBLE_WITHIN(0.5, -0.5, alarm / sizes);
    TEST_ASSERT_DOUBLE_WITHIN(0.5, -0.5, cut / sizes);
    TEST_ASSERT_DOUBLE_WITHIN(0.5, -0.5, least / sizes);
}

static uint32_t at_least_one(uint32_t count)
{
    return (count > 0U) ? count : 1U;
}

/* What glr.h says of each constant, for every size of a block and windows about those that need one level more. */
static void test_constants_of_every_block_are_as_stated(void)
{
    davar_glr_wish_t wish = usual;
    for (wish.block = GLR_BLOCK_MIN; wish.block <= GLR_BLOCK_MAX; wish.block++) {
        for (uint32_t i = 3U; i < 24U; i++) {
            const uint32_t blocks = (6U << (i / 3U)) + 1U - (i % 3U);
            const double nu = wish.block - 1.0;
            const uint32_t longest = (blocks < 768U) ? blocks : 768U;
            uint32_t levels = 1U;
            while ((3U << (levels - 1U)) < longest) {
                levels++;
            }
            wish.longest = (blocks * wish.block) + (blocks % wish.block);
            davar_glr_start(&config, &wish);
            TEST_ASSERT_EQUAL_UINT32(wish.block, config.block);
            TEST_ASSERT_EQUAL_UINT32(256U * (wish.block - 1U), config.degrees);
            TEST_ASSERT_EQUAL_UINT32(wish.block * (wish.block - 1U), config.floor);
            TEST_ASSERT_EQUAL_UINT32(2U, config.least);
            TEST_ASSERT_EQUAL_UINT32(longest, config.longest);
            TEST_ASSERT_EQUAL_UINT32(levels, config.levels);
            TEST_ASSERT_EQUAL_UINT32(2U, config.shock);
            TEST_ASSERT_EQUAL_UINT32(256U * ((wish.block >= 18U) ? 3U : 5U), config.outlier);
            TEST_ASSERT_DOUBLE_WITHIN(1.0, 65536.0 * nu * nu / (4.0 * (nu + 1.0)), config.step);
            TEST_ASSERT_DOUBLE_WITHIN(1e-9, 65536.0 * 8.0 * nu / 4.0, config.step_of_8);
            TEST_ASSERT_DOUBLE_WITHIN(1.0, 65536.0 / (3.0 * nu), config.bias);
            TEST_ASSERT_EQUAL_UINT32(at_least_one(150U / wish.block), config.near);
            TEST_ASSERT_EQUAL_UINT32(at_least_one(600U / wish.block), config.far);
        }
    }
}

/* ... and of the second channel, whatever was in the memory. */
static void test_constants_of_the_second_channel_are_as_stated(void)
{
    davar_glr_wish_t wish = usual;
    double alarm = 0.0;
    for (wish.block = GLR_BLOCK_MIN; wish.block <= GLR_BLOCK_MAX; wish.block++) {
        memset(&config, 0xA5, sizeof config);
        davar_glr_start_clusters(&config, &wish);
        TEST_ASSERT_EQUAL_UINT32(wish.block, config.block);
        TEST_ASSERT_EQUAL_UINT32(4U * wish.block, config.floor);
        TEST_ASSERT_EQUAL_UINT32(97U, config.degrees);
        TEST_ASSERT_EQUAL_UINT32(GLR_LONGEST, config.longest);
        TEST_ASSERT_EQUAL_UINT32(GLR_LEVELS, config.levels);
        TEST_ASSERT_DOUBLE_WITHIN(1.0, 65536.0 / (3.0 * (97.0 / 256.0)), config.bias);
        TEST_ASSERT_EQUAL_UINT32(0U, config.outlier | config.shock | config.step | config.step_of_8 | config.half);
        alarm += config.alarm - (65536.0 * (log(360000.0 * 100.0 / wish.block) + 1.0));
    }
    TEST_ASSERT_DOUBLE_WITHIN(0.5, -0.5, alarm / (double)(GLR_BLOCK_MAX - GLR_BLOCK_MIN + 1U));
}

static void is_empty(const davar_spread_t *sum)
{
    TEST_ASSERT_EQUAL_HEX64(0U, sum->low);
    TEST_ASSERT_EQUAL_HEX32(0U, sum->high);
    TEST_ASSERT_EQUAL_UINT32(0U, sum->blocks);
}

/* The state is saved as bytes: nothing of what was in the memory stays (what lies between the fields aside). */
static void test_a_reset_leaves_nothing_of_what_was(void)
{
    memset(&state, 0xA5, sizeof state);
    davar_glr_reset(&state);
    for (uint32_t i = 0U; i < (GLR_LEVELS * GLR_RECORDS); i++) {
        is_empty(&state.record[i / GLR_RECORDS][i % GLR_RECORDS]);
    }
    for (uint32_t i = 0U; i < GLR_SHOCK_MAX; i++) {
        is_empty(&state.waiting[i]);
    }
    for (uint32_t i = 0U; i < GLR_CUTS; i++) {
        is_empty(&state.past[i].sum);
        TEST_ASSERT_EQUAL_UINT32(state.now.at, state.past[i].at);
    }
    for (uint32_t i = 0U; i < GLR_RECENT; i++) {
        TEST_ASSERT_EQUAL_HEX16(0U, state.recent[i]);
    }
    is_empty(&state.eight);
    is_empty(&state.now.sum);
    is_empty(&state.alarm.sum);
    is_empty(&state.cut.sum);
    TEST_ASSERT_EQUAL_UINT32(state.now.at, state.alarm.at);
    TEST_ASSERT_EQUAL_UINT32(state.now.at, state.cut.at);
    TEST_ASSERT_EQUAL_UINT32(1U, state.counts);
    TEST_ASSERT_EQUAL_UINT32(1U, state.settled);
    TEST_ASSERT_EQUAL_UINT32(1U, state.cuts);
    TEST_ASSERT_EQUAL_UINT32(0U, (uint32_t)state.turn + state.seen + state.pending);
}

/* The upper half of a product of two. */
static uint32_t upper(uint32_t a, uint32_t b)
{
    return (uint32_t)(((uint64_t)a * b) >> 32U);
}

/* The formula that logarithm.c states, its tables computed anew: bit for bit, in each of its 32 stretches. */
static void test_the_logarithm_is_the_formula_of_its_tables(void)
{
    for (uint32_t i = 0U; i < 32U; i++) {
        const uint32_t edge = (uint32_t)llround(2147483648.0 * log(1.0 + (i / 32.0)));
        const uint32_t inverse = (uint32_t)llround(2147483648.0 / (1.0 + (i / 32.0)));
        for (uint32_t k = 0U; k < 1000U; k++) {
            const uint32_t beyond = (k == 0U) ? 0U : ((uint32_t)random_next(&rng) & 0x3FFFFFFU);
            const uint32_t x = upper(beyond << 5U, inverse);
            const uint32_t square = upper(x, x);
            const uint32_t rest = (x >> 4U) - (square >> 8U) + (((upper(square, x) >> 10U) * 83U) >> 8U);
            TEST_ASSERT_EQUAL_INT32((edge + rest) >> 7U, davar_logarithm(((32U + i) << 26U) | beyond, -31));
        }
    }
    const int32_t ln_2 = (int32_t)lround(16777216.0 * log(2.0));
    for (int32_t exponent = -63; exponent <= 64; exponent++) {
        TEST_ASSERT_EQUAL_INT32((exponent + 31) * ln_2, davar_logarithm(0x80000000U, exponent));
    }
}

static void test_the_state_is_small(void)
{
    TEST_ASSERT_LESS_THAN(1024U, sizeof(davar_glr_t));
}

/* ---- what it says ---- */

static void test_a_step_is_cut_where_it_was_and_its_levels_are_reported(void)
{
    push_quiet(500U);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(12U, blocks_to_alarm(60.0, 20U));
    TEST_ASSERT_UINT32_WITHIN(1U, 500U, state.alarm.at);
    TEST_ASSERT_EQUAL_UINT32(state.alarm.at, state.cut.at);
    const double unit = 12.0 * 90.0;
    TEST_ASSERT_DOUBLE_WITHIN(2.0, 20.0, sqrt((double)event.older.low / event.older.blocks / unit));
    TEST_ASSERT_DOUBLE_WITHIN(25.0, 60.0, sqrt((double)event.newer.low / event.newer.blocks / unit));
    TEST_ASSERT_GREATER_THAN_INT32((int32_t)(config.alarm >> 6U), event.gain);
    TEST_ASSERT_TRUE(event.is_cut);
}

static void test_noise_that_dies_is_a_change_too(void)
{
    push_quiet(500U);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(8U, blocks_to_alarm(0.0, 20U));
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(30U, blocks_to_alarm(20.0, 60U));
}

static void knock(double size)
{
    int16_t sample[K_MAX] = {0};
    fill(sample, 20.0);
    sample[3] = rounded(size);
    push_samples(sample);
}

static void test_a_shock_is_dropped_and_changes_nothing(void)
{
    push_quiet(300U);
    const uint32_t cut = state.cut.at;
    for (uint32_t length = 1U; length <= 2U; length++) {
        const uint32_t before = state.now.sum.blocks;
        for (uint32_t i = 0U; i < length; i++) {
            knock(600.0);
            TEST_ASSERT_EQUAL(i + 1U, state.pending);
            TEST_ASSERT_EQUAL(0, event.resolved);
        }
        push_noise(20.0);
        TEST_ASSERT_EQUAL(length, event.dropped);
        TEST_ASSERT_EQUAL(length + 1U, event.resolved);
        TEST_ASSERT_EQUAL_UINT32(before + 1U, state.now.sum.blocks);
        push_quiet(20U);
    }
    TEST_ASSERT_EQUAL_UINT32(cut, state.cut.at);
    TEST_ASSERT_EQUAL_UINT32(300U + 22U + 23U, state.now.at);
}

static void test_what_goes_on_is_no_shock(void)
{
    push_quiet(300U);
    knock(600.0);
    knock(600.0);
    knock(600.0);
    TEST_ASSERT_EQUAL(3, event.resolved);
    TEST_ASSERT_EQUAL(0, event.dropped);
    TEST_ASSERT_TRUE(event.is_alarm);
    TEST_ASSERT_EQUAL_UINT32(300U, state.alarm.at);
}

static void push_blocks(uint64_t b, uint32_t count)
{
    const davar_spread_t block = {b, 0U, 1U};
    for (uint32_t i = 0U; i < count; i++) {
        davar_glr_push(&state, &config, &block, &event);
    }
}

static void skip(uint32_t count)
{
    for (uint32_t i = 0U; i < count; i++) {
        davar_glr_skip(&state, &config, &event);
    }
}

static void test_a_block_ends_a_shock_when_it_is_calm_or_far_below(void)
{
    push_blocks(1000000U, 100U);
    push_blocks(5500000U, 1U);
    push_blocks(2000000U, 1U); /* below 2.12 */
    TEST_ASSERT_EQUAL(1, event.dropped);
    push_blocks(9000000U, 1U);
    push_blocks(2900000U, 1U); /* below a third */
    TEST_ASSERT_EQUAL(1, event.dropped);
    push_blocks(9000000U, 1U);
    push_blocks(3100000U, 1U);
    TEST_ASSERT_EQUAL(0, event.resolved);
}

static void test_a_gap_takes_its_time_and_what_waited(void)
{
    push_quiet(300U);
    knock(600.0);
    const uint32_t blocks = state.now.sum.blocks;
    davar_glr_skip(&state, &config, &event);
    TEST_ASSERT_EQUAL(1, event.dropped);
    TEST_ASSERT_EQUAL(2, event.resolved);
    TEST_ASSERT_EQUAL_UINT32(302U, state.now.at);
    TEST_ASSERT_EQUAL_UINT32(blocks, state.now.sum.blocks);
    push_quiet(200U);
    TEST_ASSERT_EQUAL_UINT32(0U, state.alarm.at);
}

static double f_after(bool is_laplace)
{
    davar_glr_reset(&state);
    for (uint32_t n = 0U; n < 3000U; n++) {
        int16_t sample[K_MAX] = {0};
        for (uint32_t i = 0U; i < config.block; i++) {
            const double tail = is_laplace ? sqrt(-log(random_uniform(&rng))) : 1.0;
            sample[i] = rounded(100.0 * tail * random_gauss(&rng));
        }
        push_samples(sample);
    }
    return davar_glr_dispersion(&state) / 4096.0;
}

static void test_dispersion_is_one_for_gaussian_noise_and_more_for_heavy_tails(void)
{
    TEST_ASSERT_DOUBLE_WITHIN(0.15, 1.15, f_after(false));
    TEST_ASSERT_DOUBLE_WITHIN(0.6, 2.4, f_after(true));
}

/* Levels that jump by 10^6 in sigma at random: f at its end, 14 + 13 / 8. */
static void test_dispersion_has_an_end(void)
{
    for (uint32_t i = 0U; i < 4000U; i++) {
        const davar_spread_t block = {((i % 2U) != 0U) ? 1000U : (UINT64_C(1000) << 40U), 0U, 1U};
        davar_glr_push(&state, &config, &block, &event);
    }
    TEST_ASSERT_EQUAL_UINT32((14U * 4096U) + (13U * 512U), davar_glr_dispersion(&state));
    for (uint32_t i = 0U; i < 20000U; i++) {
        const davar_spread_t block = {1000U, 0U, 1U};
        davar_glr_push(&state, &config, &block, &event);
    }
    TEST_ASSERT_EQUAL_UINT32(UINT32_C(1) << 22U, state.single.phi);
}

static void test_wide_samples_decide_as_narrow_ones_whatever_their_size(void)
{
    static davar_glr_t wide;
    static davar_glr_event_t other;
    davar_glr_reset(&wide);
    for (uint32_t n = 0U; n < 2000U; n++) {
        const double sigma = ((n / 300U) % 2U == 0U) ? 2000.0 : 8000.0;
        int64_t sum = 0;
        uint64_t squares = 0U;
        for (uint32_t i = 0U; i < 10U; i++) {
            const int16_t sample = rounded(sigma * random_gauss(&rng));
            sum += sample;
            squares += (uint64_t)(sample * (int64_t)sample);
        }
        if ((n % 97U) >= 95U) { /* a shock */
            sum += 30000;
            squares += UINT64_C(900000000);
        }
        const davar_u128_t scaled = {squares << 32U, squares >> 32U};
        davar_glr_push_q15(&state, &config, (int32_t)sum, squares, &event);
        davar_glr_push_q31(&wide, &config, sum * 65536, &scaled, &other);
        TEST_ASSERT_EQUAL(event.is_alarm, other.is_alarm);
        TEST_ASSERT_EQUAL(event.dropped, other.dropped);
        TEST_ASSERT_EQUAL_UINT32(state.cut.at, wide.cut.at);
    }
}

static void test_a_state_saved_as_bytes_goes_on_alike(void)
{
    static unsigned char saved[sizeof(davar_glr_t)];
    static davar_glr_t restored;
    push_quiet(777U);
    memcpy(saved, &state, sizeof saved);
    memcpy(&restored, saved, sizeof saved);
    for (uint32_t n = 0U; n < 500U; n++) {
        const davar_spread_t block = {100000U + (random_next(&rng) % 1000000U), 0U, 1U};
        davar_glr_event_t other;
        davar_glr_push(&state, &config, &block, &event);
        davar_glr_push(&restored, &config, &block, &other);
    }
    TEST_ASSERT_EQUAL_MEMORY(&state, &restored, sizeof state);
}

/* ---- windows ---- */

static davar_glr_window_t trailing(void)
{
    davar_glr_window_t window;
    davar_glr_trailing(&state, &config, &window);
    TEST_ASSERT_EQUAL_UINT32(state.now.at, window.end);
    return window;
}

static void test_a_trailing_window_grows_to_all_that_is_alike_and_begins_anew_at_a_step(void)
{
    config.cut = config.alarm; /* no false cuts */
    push_quiet(1U);
    TEST_ASSERT_EQUAL_UINT32(0U, trailing().begin);
    push_quiet(599U);
    TEST_ASSERT_EQUAL_UINT32(state.cut.at, trailing().begin);
    push_quiet(1U);
    TEST_ASSERT_EQUAL_UINT32(256U, state.cut.at);
    (void)blocks_to_alarm(60.0, 20U);
    TEST_ASSERT_EQUAL_UINT32(state.cut.at, trailing().begin);
    TEST_ASSERT_UINT32_WITHIN(1U, 601U, state.cut.at);
}

/* A change that is too small for a cut bars the window's growth before. */
static void test_a_trailing_window_leaves_out_what_is_not_alike(void)
{
    push_quiet(400U);
    uint32_t shortest = 400U;
    for (uint32_t n = 0U; n < 40U; n++) {
        push_noise(26.0);
        if (state.cut.at == 0U) {
            const davar_glr_window_t window = trailing();
            shortest = ((window.end - window.begin) < shortest) ? (window.end - window.begin) : shortest;
        }
    }
    TEST_ASSERT_LESS_THAN_UINT32(200U, shortest);
}

static void test_a_trailing_window_can_hold_nothing_but_gaps(void)
{
    skip(100U);
    TEST_ASSERT_EQUAL_UINT32(0U, trailing().begin);
    push_quiet(20U);
    TEST_ASSERT_EQUAL_UINT32(0U, trailing().begin);
    skip(50U);
    TEST_ASSERT_EQUAL_UINT32(0U, trailing().begin);
    config.near = 3U;
    TEST_ASSERT_EQUAL_UINT32(0U, trailing().begin);
}

static void test_a_centred_window_is_cut_by_a_step_on_either_side(void)
{
    davar_glr_window_t window;
    config.cut = config.alarm; /* no false cuts */
    push_quiet(20U);
    TEST_ASSERT_FALSE(davar_glr_centred(&state, &config, config.half, &window));
    push_quiet(10U);
    TEST_ASSERT_TRUE(davar_glr_centred(&state, &config, config.half, &window));
    TEST_ASSERT_EQUAL_UINT32(0U, window.begin);
    TEST_ASSERT_EQUAL_UINT32(30U, window.end);
    push_quiet(470U);
    (void)davar_glr_centred(&state, &config, config.half, &window);
    TEST_ASSERT_EQUAL_UINT32(500U, window.end);
    TEST_ASSERT_LESS_THAN_UINT32(400U, window.begin);
    for (uint32_t n = 501U; n <= 600U; n++) {
        push_noise(80.0);
        (void)davar_glr_centred(&state, &config, config.half, &window);
        if ((n >= 520U) && (n < 529U)) { /* the centre before the step, the step in the window */
            TEST_ASSERT_UINT32_WITHIN(1U, 500U, window.end);
        }
        if ((n > 535U) && (n < 600U)) {
            TEST_ASSERT_UINT32_WITHIN(1U, 500U, window.begin);
            TEST_ASSERT_EQUAL_UINT32(state.now.at, window.end);
        }
    }
}

static void test_a_cut_in_a_ramp_does_not_count_but_bars_growth(void)
{
    uint32_t whole = 0U;
    push_quiet(300U);
    for (uint32_t n = 0U; n < 300U; n++) {
        push_noise(20.0 * exp((double)n * 0.008));
        davar_glr_window_t window;
        (void)davar_glr_centred(&state, &config, config.half, &window);
        if ((n > 100U) && ((window.end - window.begin) == 60U)) {
            whole++;
        }
        TEST_ASSERT_TRUE((n < 100U) || ((window.end - window.begin) <= 120U));
    }
    TEST_ASSERT_GREATER_THAN_UINT32(60U, whole);
}

/* So many cuts that the oldest are forgotten; then none for so long that all are. */
static void test_the_oldest_cut_that_is_remembered_bounds_the_window(void)
{
    davar_glr_window_t window;
    for (uint32_t n = 0U; n < 150U; n++) {
        push_noise((((n / 10U) % 2U) == 0U) ? 20.0 : 200.0);
        (void)davar_glr_centred(&state, &config, config.half, &window);
        TEST_ASSERT_LESS_OR_EQUAL_UINT32(60U, window.end - window.begin);
    }
    TEST_ASSERT_EQUAL(GLR_CUTS, state.cuts);
    config.cut = config.alarm;
    push_quiet(1500U);
    (void)davar_glr_centred(&state, &config, config.half, &window);
    TEST_ASSERT_EQUAL(0, state.cuts);
    TEST_ASSERT_GREATER_THAN_UINT32(200U, window.end - window.begin);
    skip(70U);
    (void)blocks_to_alarm(400.0, 20U);
    TEST_ASSERT_EQUAL(1, state.cuts);
}

/* Between the blocks of 10^6 and those a fifth louder lies a gap; the cut falls into it. */
static void test_a_cut_beside_a_gap_counts(void)
{
    davar_glr_wish_t wish = usual;
    wish.block = 25U;
    davar_glr_start(&config, &wish);
    push_blocks(1000000U, 287U);
    skip(13U);
    push_blocks(1190000U, 36U);
    TEST_ASSERT_EQUAL_UINT32(288U, state.cut.at);
    push_blocks(1190000U, 4U);
    TEST_ASSERT_BIT_HIGH((int)(state.cuts - 1U), state.counts);
}

/* A change so small that its cut lies beyond the blocks that are remembered one by one. */
static void test_a_cut_that_came_late_counts(void)
{
    push_blocks(1000000U, 320U);
    uint32_t n = 0U;
    for (; (n < 300U) && (state.cut.at == 0U); n++) {
        push_blocks(1170000U, 1U);
    }
    TEST_ASSERT_GREATER_OR_EQUAL_UINT32(GLR_RECENT, state.now.at - state.cut.at);
    push_blocks(1170000U, 4U);
    TEST_ASSERT_BIT_HIGH((int)(state.cuts - 1U), state.counts);
}

static void test_a_trailing_detector_remembers_no_cuts(void)
{
    davar_glr_wish_t wish = usual;
    wish.is_centred = false;
    davar_glr_start(&config, &wish);
    push_quiet(200U);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(12U, blocks_to_alarm(60.0, 20U));
    TEST_ASSERT_EQUAL(1, state.cuts);
}

/* 2^32 blocks from the start the count of blocks is 0 again, a place that every power of two divides. */
/* The age at which so many blocks were accepted, counted one by one; dropped ones have an age, too. */
static void test_an_age_counts_the_accepted_blocks(void)
{
    for (uint32_t trial = 0U; trial < 200U; trial++) {
        const uint32_t dropped = 1U + (uint32_t)(random_next(&rng) % 40U);
        state.now.at = (uint32_t)random_next(&rng);
        for (uint32_t i = 0U; i < GLR_RECENT; i++) {
            state.recent[i] = ((random_next(&rng) % dropped) == 1U) ? 0U : 512U;
        }
        uint32_t accepted = 0U;
        for (uint32_t age = 1U; age <= GLR_RECENT; age++) {
            const uint32_t before = accepted;
            accepted += (state.recent[(state.now.at - age) % GLR_RECENT] != 0U) ? 1U : 0U;
            if (accepted != before) {
                TEST_ASSERT_EQUAL_UINT32(age, davar_glr_age_of(&state, accepted));
            }
        }
        TEST_ASSERT_EQUAL_UINT32(0U, davar_glr_age_of(&state, 0U));
        TEST_ASSERT_EQUAL_UINT32(GLR_RECENT, davar_glr_age_of(&state, accepted + 1U));
    }
}

static void test_the_count_of_blocks_wraps(void)
{
    davar_glr_wish_t wish = usual;
    wish.is_centred = false;
    davar_glr_start(&config, &wish);
    state.now.at = 0U - 512U;
    state.cut.at = state.now.at;
    state.alarm.at = state.now.at;
    push_quiet(1000U);
    TEST_ASSERT_EQUAL_UINT32(488U, state.now.at);
    TEST_ASSERT_LESS_OR_EQUAL_UINT32(12U, blocks_to_alarm(60.0, 20U));
}

/* The root of a mean square, however large the sums are. */
static void test_a_level_is_the_root_of_the_mean(void)
{
    random_t random = random_seeded(7U);
    for (uint32_t i = 0U; i < 2000U; i++) {
        const uint32_t blocks = 1U + (uint32_t)(random_next(&random) % 768U);
        const uint64_t low = random_next(&random) >> (random_next(&random) % 44U);
        const uint32_t high = ((i % 2U) == 0U) ? 0U : (uint32_t)(random_next(&random) >> 40U);
        const davar_spread_t sum = {low | (UINT64_C(1) << 20U), high, blocks};
        const double square =
            (((high * 18446744073709551616.0) + (double)sum.low) - (90.0 * blocks)) / (1080.0 * blocks);
        TEST_ASSERT_DOUBLE_WITHIN(1e-9 * sqrt(square), sqrt(square), spread_level(&sum, 90U, 1080U));
    }
}

/* (10.3), each move from where phi was, in doubles: a mean that forgets, of squared steps that weigh nine phi at most. */
static void test_the_dispersion_moves_as_the_formula_says(void)
{
    static const uint32_t memories[2] = {11U, 8U};
    for (uint32_t k = 0U; k < 2U; k++) {
        davar_dispersion_t dispersion;
        davar_dispersion_start(&dispersion);
        double before = 0.0;
        for (uint32_t n = 0U; n < 6000U; n++) {
            const double width = (n < 3000U) ? 0.5 : ((n < 4500U) ? 4.0 : 0.01);
            const int32_t logarithm = (int32_t)lround(16777216.0 * width * random_gauss(&rng));
            const double phi = dispersion.phi / 16777216.0;
            const double step = (logarithm / 16777216.0) - before;
            davar_dispersion_learn(&dispersion, logarithm, config.step, memories[k]);
            before = logarithm / 16777216.0;
            const double nu = config.block - 1.0;
            const double unit = 1.0 / (2.0 * (2.0 / nu) * (1.0 + (1.0 / nu)));
            const double square = fmin(step * step * unit, 9.0 * phi);
            const double share = fmax(1.0 / (n + 15.0), ldexp(1.0, -(int)memories[k]));
            const double next = (n == 0U) ? phi : fmin(fmax(phi + ((square - phi) * share), 0.25), 14.0);
            const double cut = ldexp(2.0 * fabs(step) * unit, -12); /* a step has 12 digits */
            TEST_ASSERT_DOUBLE_WITHIN(4e-7 + (share * (cut + (2e-4 * square))), next, dispersion.phi / 16777216.0);
        }
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_every_decision_is_that_of_the_law_computed_anew);
    RUN_TEST(test_so_it_is_with_other_blocks_shocks_and_windows);
    RUN_TEST(test_the_logarithm_is_within_2e_minus_7);
    RUN_TEST(test_the_gain_is_the_formulas_and_the_bound_never_below);
    RUN_TEST(test_thresholds_are_the_logarithm_of_the_blocks_between_false_decisions);
    RUN_TEST(test_an_age_counts_the_accepted_blocks);
    RUN_TEST(test_the_count_of_blocks_wraps);
    RUN_TEST(test_the_second_channel_is_as_the_formula_says);
    RUN_TEST(test_thresholds_of_every_block_are_the_formulas);
    RUN_TEST(test_constants_of_every_block_are_as_stated);
    RUN_TEST(test_constants_of_the_second_channel_are_as_stated);
    RUN_TEST(test_a_reset_leaves_nothing_of_what_was);
    RUN_TEST(test_the_logarithm_is_the_formula_of_its_tables);
    RUN_TEST(test_the_state_is_small);
    RUN_TEST(test_a_step_is_cut_where_it_was_and_its_levels_are_reported);
    RUN_TEST(test_noise_that_dies_is_a_change_too);
    RUN_TEST(test_a_shock_is_dropped_and_changes_nothing);
    RUN_TEST(test_what_goes_on_is_no_shock);
    RUN_TEST(test_a_block_ends_a_shock_when_it_is_calm_or_far_below);
    RUN_TEST(test_a_gap_takes_its_time_and_what_waited);
    RUN_TEST(test_dispersion_is_one_for_gaussian_noise_and_more_for_heavy_tails);
    RUN_TEST(test_dispersion_has_an_end);
    RUN_TEST(test_wide_samples_decide_as_narrow_ones_whatever_their_size);
    RUN_TEST(test_a_state_saved_as_bytes_goes_on_alike);
    RUN_TEST(test_a_trailing_window_grows_to_all_that_is_alike_and_begins_anew_at_a_step);
    RUN_TEST(test_a_trailing_window_leaves_out_what_is_not_alike);
    RUN_TEST(test_a_trailing_window_can_hold_nothing_but_gaps);
    RUN_TEST(test_a_centred_window_is_cut_by_a_step_on_either_side);
    RUN_TEST(test_a_cut_in_a_ramp_does_not_count_but_bars_growth);
    RUN_TEST(test_the_oldest_cut_that_is_remembered_bounds_the_window);
    RUN_TEST(test_a_cut_beside_a_gap_counts);
    RUN_TEST(test_a_cut_that_came_late_counts);
    RUN_TEST(test_a_trailing_detector_remembers_no_cuts);
    RUN_TEST(test_a_level_is_the_root_of_the_mean);
    RUN_TEST(test_the_dispersion_moves_as_the_formula_says);
    return UNITY_END();
}
