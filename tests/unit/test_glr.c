/* davar tests - the detector of changes compared with its law, recomputed at every block from the
 * raw samples. */
#include "laws/glr.h"
#include "laws/scan.h"
#include "number/real.h"

#include "glr_fixture.h"

#include <string.h>

#ifndef BLOCKS
#define BLOCKS 3000U
#endif
#define RAW 1024U

/* ---- the law, recomputed at every block ---- */

static struct {
    uint64_t b[RAW]; /* 0: dropped */
    uint64_t waiting[GLR_SHOCK_MAX];
    uint32_t now;
    uint32_t cut;
    uint32_t alarm;
    uint32_t pending;
    uint32_t of_many;
    uint32_t heavy;
    uint32_t f; /* of eight blocks */
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

static uint32_t law_f(uint32_t n)
{
    uint32_t octave = 1U; /* the largest power of two up to n */
    while ((2U * octave) <= n) {
        octave *= 2U;
    }
    const uint32_t f = law.of_many + (4U * law.heavy / octave);
    return (f < 65536U) ? f : 65535U;
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
    law.heavy = (phi > 5120U) ? (phi - 5120U) : 0U;
    law.of_many = (phi > 4096U) ? (phi + ((phi - 4096U + law.heavy) / 8U)) : 4096U;
    law.f = law_f(8U);
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
    const uint64_t f = law_f(n);
    const uint64_t plain = (f * (h - logarithm)) >> 16U;
    return (int32_t)(plain + ((plain * davar_divided(config.bias, n)) >> 16U));
}

typedef struct {
    int32_t excess;
    uint32_t age; /* 0: no split exceeds */
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
    if (n < 2U) {
        return;
    }
    davar_stretch_t stretch;
    davar_stretch(&stretch, &no_blocks, &sum, &config, 4096U);
    const int32_t excess = davar_likelihood_gain(&stretch, &older) - law_threshold(h, n);
    if (excess > best->excess) {
        best->excess = excess;
        best->age = age;
    }
}

/* The age of the split with the largest excess. Logarithms are computed for every split. */
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
    TEST_ASSERT_EQUAL(alarm != 0U, event.is_alarm);
    law.cut = (cut != 0U) ? (law.now - cut) : law.cut;
    law.alarm = (alarm != 0U) ? (law.now - alarm) : law.alarm;
    if ((law.now - law.cut) > (law.now - law.alarm)) {
        law.cut = law.alarm;
    }
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
    bool waits = (law.pending == 0U) && (config.shock != 0U) &&
                 ((window.blocks * (config.block - 1U)) >= 100U) &&
                 (window.low > ((uint64_t)4U * window.blocks * config.floor)) &&
                 exceeds(b, &window, config.outlier);
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
            const int64_t d =
                (int64_t)sample[i] - sample[k]; /* K s2 - s1^2 is the sum of all pairs' squares */
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

/* Steps, bursts, ramps, shocks of one to five samples, sections without noise and at full scale,
 * heavy tails, gaps. */
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

/* ---- the window (10.9), recomputed at every block from the raw blocks, in doubles ---- */

static struct {
    uint32_t compared;
    uint32_t unsure; /* too close to a threshold for doubles */
} past;

/* G of [from, middle) against [middle, to) (10.4), S the sums and N the blocks of both parts. */
static double gain_of(double s_older, double n_older, double s_newer, double n_newer)
{
    const double whole = (n_older + n_newer) * log((s_older + s_newer) / (n_older + n_newer));
    return 0.5 * (config.block - 1U) *
           (whole - (n_older * log(s_older / n_older)) - (n_newer * log(s_newer / n_newer)));
}

/* 1: above the limit, -1: below, 0: too close. */
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
    return against(gain_of((double)older.low, older.blocks, (double)newer.low, newer.blocks),
                   limit * law.f / 4096.0);
}

/* The oldest record that is not older than `age`, in the lowest level whose four records reach that
 * far; not before the bound. */
static uint32_t law_place(uint32_t age, uint32_t bound)
{
    uint32_t apart = 1U;
    while ((4U * apart) <= age) {
        apart *= 2U;
    }
    return (age >= (law.now - bound)) ? bound : (((law.now - age) + apart - 1U) / apart) * apart;
}

/* The limit to which [begin, now) grows; false: too close. */
static bool law_grow(uint32_t *begin)
{
    uint32_t age = law.now - *begin;
    while (*begin != law.cut) {
        age += age;
        const uint32_t older = law_place(age, law.cut);
        const int differs =
            law_differs(older, *begin, law.now, ((law.now - older) <= config.far) ? 4.0 : 1.5);
        if (differs >= 0) {
            return differs > 0;
        }
        *begin = older;
    }
    return true;
}

static void compare_windows(void)
{
    davar_glr_place_t found;
    uint32_t begin = law_place(config.near, law.cut);
    past.compared++;
    davar_glr_begin(&state, &config, &found);
    if (law_grow(&begin)) {
        TEST_ASSERT_EQUAL_UINT32(begin, found.at);
        TEST_ASSERT_EQUAL_UINT32(sum_of(begin, law.now).blocks,
                                 state.now.sum.blocks - found.sum.blocks);
    } else {
        past.unsure++;
    }
}

typedef struct {
    uint32_t block;
    uint32_t shock;
    uint32_t longest;
    double gaps; /* per block */
} case_t;

static void compare_with_law(const case_t *one)
{
    davar_glr_wish_t wish = usual;
    wish.block = one->block;
    wish.shock = one->shock;
    wish.longest = one->longest;
    davar_glr_start(&config, &wish);
    davar_glr_reset(&state);
    law_reset();
    memset(&past, 0, sizeof past);
    uint32_t alarms = 0U;
    for (uint32_t n = 0U; n < BLOCKS; n++) {
        int16_t sample[K_MAX] = {0};
        make(sample);
        if (random_uniform(&rng) < one->gaps) {
            davar_glr_skip(&state, &config, &event);
            law_skip();
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
    TEST_ASSERT_TRUE((one->gaps > 0.5) || (alarms > (BLOCKS / 500U)));
}

/* Where gaps leave few of many blocks, the records as old as the window contain none of it. */
static void test_every_decision_and_window_equal_the_recomputed_law(void)
{
    static const case_t cases[] = {
        {10U, 2U, 6000U, 0.003}, {25U, 2U, 6000U, 0.003}, {10U, 0U, 6000U, 0.003},
        {10U, 1U, 300U, 0.003},  {60U, 2U, 6000U, 0.003}, /* a gap in a shock drops every block */
        {5U, 2U, 3000U, 0.2},    {10U, 2U, 6000U, 0.5},   {10U, 2U, 6000U, 0.8},
        {25U, 2U, 15000U, 0.95},
    };
    for (size_t i = 0U; i < sizeof cases / sizeof cases[0]; i++) {
        compare_with_law(&cases[i]);
    }
}

int main(void)
{
    UNITY_BEGIN();
    RUN_TEST(test_every_decision_and_window_equal_the_recomputed_law);
    return UNITY_END();
}
