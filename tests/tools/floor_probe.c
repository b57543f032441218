/* davar tests - the floors of a setup that tools/davar-plan wrote for flight, beside floors of the
 * library that get the samples of each axis directly: same plan, same results, after gaps and a
 * restart too.
 *
 * SAMPLE: type of a sample. RATE, LSB: of it. SUMMED: samples in a sum. RAIL, BLOCK: of the floor. FILTER:
 * calls that fill the filter f; empty: none. Reads a line per sample: a count, or "g" for a lost one. Axis a gets
 * the count plus a. Prints why, value, low and high of each floor of axis 0, as hexadecimal floats. */
#include "davar_setup.c"

#ifndef DAVAR_ONE_H
#include "davar/average.h"
#endif

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define AXES DAVAR_SETUP_AXES
#define BLOCK_MOST 40U
#define SAMPLES_MOST 200000U
#define LOST INT32_MIN
#define REQUIRE(condition) require((condition), __LINE__)

static davar_floor_plan_t plan;
static davar_floor_t own[AXES];
static davar_average_t sums[AXES];
static davar_floor_result_t newest[AXES];
static bool is_new[AXES];
static bool clips[AXES]; /* the sum has a sample at the rail */
static int32_t samples[SAMPLES_MOST];

static void require(bool condition, int line)
{
    if (!condition) {
        (void)printf("line %d\n", line);
        exit(1);
    }
}

static bool same_float(float one, float other)
{
    return memcmp(&one, &other, sizeof one) == 0;
}

static void require_same(const davar_floor_result_t *found, const davar_floor_result_t *mine)
{
    REQUIRE((found->why == mine->why) && (found->shocks == mine->shocks) &&
            (found->clipped == mine->clipped) && same_float(found->value, mine->value) &&
            same_float(found->low, mine->low) && same_float(found->high, mine->high) &&
            same_float(found->where, mine->where) && same_float(found->share, mine->share) &&
            same_float(found->unsteady, mine->unsteady));
}

static void start(void)
{
    for (uint8_t a = 0U; a < AXES; a++) {
        davar_average_init(&sums[a], SUMMED);
        clips[a] = false;
        davar_floor_start(&own[a]);
        davar_floor_delay(&own[a], (uint8_t)((a * 32U) / AXES));
        is_new[a] = false;
        REQUIRE(davar_setup_floor(a) == NULL);
    }
    REQUIRE(davar_setup_floor(AXES) == NULL);
}

static void lose(void)
{
    davar_setup_gap(1U);
    for (uint8_t a = 0U; a < AXES; a++) {
        (void)davar_average_gap(&sums[a], 1U);
        clips[a] = false;
        davar_floor_gap(&own[a]);
    }
}

static void push(const int32_t *counts, size_t count)
{
    static SAMPLE all[AXES * BLOCK_MOST];
    for (size_t i = 0U; i < count; i++) {
        for (uint8_t a = 0U; a < AXES; a++) {
            const int32_t sample = counts[i] + ((counts[i] < RAIL / SUMMED) ? (int32_t)a : 0);
            int32_t sum;
            all[(AXES * i) + a] = (SAMPLE)sample;
            clips[a] = clips[a] || (sample >= RAIL / SUMMED) || (sample <= -(RAIL / SUMMED));
            if (!davar_average_push(&sums[a], sample, &sum)) {
                continue;
            }
            sum = clips[a] ? INT32_MAX : sum;
            clips[a] = false;
            if (davar_floor_push(&own[a], &plan, sum)) {
                davar_floor_take(&own[a], &plan, &newest[a]);
                is_new[a] = true;
            }
        }
    }
    davar_setup_push(all, count);
}

/* The last axis is seldom looked at: it then has the newest of several. */
static void compare(uint32_t turn)
{
    for (uint8_t a = 0U; a < AXES; a++) {
        if ((a > 0U) && (a + 1U == AXES) && ((turn % 100U) != 0U)) {
            continue;
        }
        const davar_floor_result_t *const found = davar_setup_floor(a);
        REQUIRE((found != NULL) == is_new[a]);
        if (found != NULL) {
            require_same(found, &newest[a]);
            is_new[a] = false;
        }
        if ((found != NULL) && (a == 0U)) {
            (void)printf("%d %a %a %a\n", (int)found->why, (double)found->value, (double)found->low,
                         (double)found->high);
        }
    }
}

static void run(size_t count)
{
    uint32_t turn = 0U;
    for (size_t i = 0U; i < count; turn++) {
        size_t n = 0U;
        const size_t most = 1U + ((7U * turn) % BLOCK_MOST);
        while ((i + n < count) && (n < most) && (samples[i + n] != LOST)) {
            n++;
        }
        push(&samples[i], n);
        compare(turn);
        i += n;
        if ((i < count) && (samples[i] == LOST)) {
            lose();
            i++;
        }
    }
}

int main(void)
{
    davar_filter_t f = {0};
    char line[32];
    size_t count = 0U;
    FILTER;
    const davar_floor_config_t floor_config = {.rate_hz = RATE / SUMMED,
                                               .unit_per_count = LSB / SUMMED,
                                               .rail = RAIL,
                                               .block = BLOCK,
                                               .filter = &f};
    REQUIRE(davar_floor_plan(&plan, &floor_config) == DAVAR_FLOOR_OK);
    REQUIRE(memcmp(&plan, &floor_plan, sizeof plan) == 0);
    while ((count < SAMPLES_MOST) && (fgets(line, sizeof line, stdin) != NULL)) {
        samples[count++] = (line[0] == 'g') ? LOST : (int32_t)atoi(line);
    }
    REQUIRE(davar_setup_start() == DAVAR_OK);
    for (uint32_t turn = 0U; turn < 2U; turn++) {
        start();
        run(count);
        push(samples, 1U);
        davar_setup_restart();
    }
    return 0;
}
