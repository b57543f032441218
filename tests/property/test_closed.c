/* davar tests - every sequence of pushes, gaps, saves and resets, for small windows. The search is
 * breadth first, merges equal states, and compares each with small_window.h. Most rows end because
 * no new state appears: then sequences of any length are covered. The argument:
 * docs/quality/PROOFS.md.
 *
 * `test_closed long` checks larger windows, for minutes. */
#include "davar_law_id.h"
#include "small_window.h"
#include "states.h"

#include "davar/davar.h"
#include "davar/state.h"
#include "unity.h"

#include <stdio.h>
#include <time.h>

#define MEMORY_BYTES 6144U
#define SLOT (MEMORY_BYTES + 512U)

#include "cells.h"
#define DEPTH_MAX 150U /* of rows without an end: more means that some state never recurs */
#define ANY 255U       /* any number of samples that are not 0 */

/* Which builds check a row. */
typedef enum { ALWAYS, RELEASE, LONG } effort_t;

/* One row of the table in docs/quality/PROOFS.md. */
typedef struct {
    const davar_law_t *law;
    const uint32_t *taus; /* as many as fit into the window */
    effort_t effort;
    uint32_t shortest;
    uint32_t longest;
    uint32_t stride;
    bool grid;
    uint32_t segment;
    uint32_t push_most; /* after the zeros, at most; 0: any number */
    uint32_t zeros;     /* samples before the first state */
    uint16_t gaps_max;
    int16_t letters[3]; /* the samples; the first is 0 */
    uint8_t letter_count;
    uint8_t nonzero; /* samples of a record that are not 0, at most, or ANY */
    bool wide;       /* q31 */
} row_t;

/* All that a transition reads and writes, except the memory of the instance. */
typedef struct {
    davar_t davar;
    small_t small;
    uint32_t id;
    uint32_t pushes;
    uint32_t gaps;
    uint32_t missing;
    uint8_t nonzero; /* left for this record */
} state_t;

typedef enum { RESET, SAVE, GAP, LONG_GAP, BLOCK, LETTER } action_t;

#define SLIDING false
#define GRID true
#define KURTOSIS &davar_law_kurtosis
#define OR &davar_law_or
#define AND &davar_law_and
#define BINARY {0, 1}, 2U
#define TERNARY {0, 1, 5}, 3U

static const uint32_t octaves[] = {1U, 2U, 4U, 8U};
static const uint32_t others[] = {1U, 3U, 4U, 7U};

static const row_t rows[] = {
    /* fixed: octaves, then other sizes; q15, q31; at a stride; with moments */
    {NULL, octaves, ALWAYS, 8U, 8U, 1U, SLIDING, 0U, 0U, 0U, 2U, BINARY, 2U, false},
    {NULL, others, RELEASE, 5U, 8U, 1U, SLIDING, 0U, 0U, 0U, 2U, BINARY, 2U, true},
    {NULL, octaves, ALWAYS, 8U, 8U, 3U, SLIDING, 0U, 0U, 0U, 1U, BINARY, 2U, false},
    {NULL, octaves, ALWAYS, 6U, 6U, 2U, SLIDING, 2U, 0U, 0U, 1U, BINARY, 2U, false},
    {NULL, others, RELEASE, 8U, 8U, 3U, SLIDING, 5U, 0U, 0U, 1U, BINARY, 2U, true},
    /* laws: any record of these samples */
    {OR, octaves, ALWAYS, 4U, 6U, 1U, SLIDING, 2U, 0U, 0U, 1U, BINARY, ANY, false},
    {KURTOSIS, octaves, ALWAYS, 4U, 6U, 1U, SLIDING, 1U, 0U, 0U, 1U, BINARY, ANY, false},
    {AND, octaves, RELEASE, 4U, 6U, 2U, SLIDING, 3U, 0U, 0U, 1U, BINARY, ANY, true},
    {OR, octaves, RELEASE, 3U, 4U, 1U, SLIDING, 1U, 0U, 0U, 1U, TERNARY, ANY, false},
    {AND, others, RELEASE, 3U, 5U, 1U, SLIDING, 1U, 0U, 0U, 1U, TERNARY, ANY, true},
    /* grid: from the start, and where the ring wraps */
    {NULL, octaves, ALWAYS, 6U, 6U, 2U, GRID, 2U, 9U, 0U, 1U, BINARY, 2U, false},
    {NULL, others, RELEASE, 6U, 6U, 2U, GRID, 0U, 8U, 66U, 1U, BINARY, 2U, false},
    {OR, octaves, RELEASE, 4U, 6U, 2U, GRID, 1U, 8U, 0U, 1U, BINARY, ANY, false},
    /* larger */
    {NULL, octaves, LONG, 16U, 16U, 1U, SLIDING, 0U, 0U, 0U, 2U, BINARY, 2U, false},
    {NULL, others, LONG, 12U, 12U, 5U, SLIDING, 3U, 0U, 0U, 2U, BINARY, 2U, false},
    {NULL, octaves, LONG, 8U, 8U, 1U, SLIDING, 3U, 0U, 0U, 8U, BINARY, 2U, true},
    {OR, octaves, LONG, 4U, 9U, 1U, SLIDING, 2U, 0U, 0U, 0U, BINARY, ANY, false},
    {AND, others, LONG, 4U, 8U, 3U, SLIDING, 2U, 0U, 0U, 0U, BINARY, ANY, true},
    {KURTOSIS, octaves, LONG, 4U, 6U, 1U, SLIDING, 2U, 0U, 0U, 1U, TERNARY, ANY, false},
    {OR, octaves, LONG, 4U, 6U, 3U, GRID, 2U, 11U, 66U, 1U, BINARY, ANY, false},
    {NULL, octaves, LONG, 8U, 8U, 3U, GRID, 0U, 13U, 0U, 1U, BINARY, 2U, true},
    {OR, octaves, LONG, 4U, 8U, 1U, SLIDING, 2U, 0U, 0U, 1U, BINARY, ANY, false},
};
static const row_t *row;
static davar_config_t config;
static effort_t effort;
static uint64_t transitions;
static size_t bytes;                       /* of the memory in use */
static uint64_t memory[MEMORY_BYTES / 8U]; /* of the instance: always here, for its pointers */
static state_t now;
static bool is_position[MEMORY_BYTES / 4U]; /* words of the memory that count samples */

void setUp(void) {}
void tearDown(void) {}

/* --- the key of a state ------------------------------------------------------------------------ */

/* Samples on which a result or the start can depend. */
static uint32_t history(void)
{
    return config.window.longest + (2U * config.stride);
}

/* The state without what only counts: positions are relative to the newest sample, and counters
 * left out. */
static state_key_t key_of(void)
{
    const davar_window_t *const window = &now.davar.window;
    const davar_gaps_t *const gaps = &now.davar.gaps;
    const int32_t most = (int32_t)history();
    static uint32_t word[MEMORY_BYTES / 4U];
    small_t small = now.small;
    memcpy(word, memory, bytes);
    for (size_t i = 0U; i < (bytes / 4U); i++) {
        word[i] -= is_position[i] ? window->received : 0U;
    }
    uint32_t *const boundary = word + (gaps->position - (const uint32_t *)memory);
    for (uint16_t i = 0U; i < gaps->capacity; i++) {
        boundary[i] = (i < gaps->count) ? (window->received - boundary[i]) : 0U;
    }
    small.total %= config.stride;
    small.count = (small.count < most) ? small.count : most;
    small.restarts = 0U;
    const uint32_t rest[] = {window->length,     window->next_length,
                             window->wait,       window->skip,
                             window->phase,      gaps->count,
                             now.davar.ready,    now.davar.produced != now.davar.seen,
                             now.davar.unstable, now.davar.accepts,
                             now.nonzero,        (row->push_most > 0U) ? now.pushes : 0U};
    state_key_t key = {{1U, 2U}};
    key_add(&key, word, bytes);
    key_add(&key, &small, sizeof small);
    key_add(&key, rest, sizeof rest);
    return key;
}

/* --- comparison ------------------------------------------------------------------------------- */

static void append_action(char *text, size_t size, uint8_t action)
{
    static const char *const names[LETTER] = {"reset", "save", "gap", "gap", "block"};
    const size_t used = strlen(text);
    if (action < LETTER) {
        snprintf(text + used, size - used, " %s", names[action]);
    } else {
        snprintf(text + used, size - used, " %d", row->letters[action - LETTER]);
    }
}

/* Fails with the sequence that leads here; it is a shortest one. */
static void refuse(const char *what, double expected, double found)
{
    static char text[4096];
    uint8_t path[1024];
    size_t length = 0U;
    for (uint32_t id = now.id; (states.from[id] != NO_STATE) && (length < sizeof path);
         id = states.from[id]) {
        path[length++] = states.action[id];
    }
    snprintf(text, sizeof text, "row %d: %s: expected %.17g, got %.17g after:", (int)(row - rows),
             what, expected, found);
    while (length > 0U) {
        append_action(text, sizeof text, path[--length]);
    }
    TEST_FAIL_MESSAGE(text);
}

static void same(const char *what, double expected, double found, double tolerance)
{
    const bool both = isnan(expected) && isnan(found);
    if (!both && !(fabs(found - expected) <= (tolerance * fabs(expected)))) {
        refuse(what, expected, found);
    }
}

static void same_result(const davar_result_t *result)
{
    const small_t *const small = &now.small;
    const int32_t tail = small_tail(small);
    const int32_t head = tail + small->length;
    const uint64_t complete = small->total - (uint64_t)small->age;
    same("epoch", (double)(complete - 1U), (double)result->epoch, 0.0);
    same("window", small->length, result->window_samples, 0.0);
    same("gaps", small_gaps(small, tail, head), result->gaps_in_window, 0.0);
    same("mirrored", 0.0, result->mirrored_samples, 0.0);
    same("unstable", small->unstable, result->unstable, 0.0);
    for (uint8_t t = 0U; t < config.tau_count; t++) {
        const double m = (double)config.taus[t];
        uint32_t differences = 0U;
        const int64_t sum = small_sum(small, (int32_t)config.taus[t], &differences);
        const double square = (double)sum / (2.0 * m * m * (double)differences);
        same("differences", differences, result->tau[t].differences, 0.0);
        same("adev", (differences == 0U) ? (double)NAN : sqrt(square), result->tau[t].adev, 0.0);
    }
    if (config.moments.segment > 0U) {
        const small_moments_t moments = small_moments(small);
        same("kurtosis", moments.kurtosis, result->kurtosis, 1e-15);
        same("contribution", moments.contribution, result->contribution, 1e-15);
    }
}

/* A take would return the result of this state, whenever it comes. */
static void compare(void)
{
    davar_t copy = now.davar;
    davar_result_t result;
    const davar_health_t health = davar_health(&copy);
    const bool taken = davar_take(&copy, &result);
    same("result", now.small.reported, taken, 0.0);
    same("gaps counted", now.gaps, health.gaps, 0.0);
    same("missing", now.missing, health.missing, 0.0);
    same("restarts", now.small.restarts, health.restarts, 0.0);
    same("saturated", 0.0, health.saturated, 0.0);
    if (taken) {
        same_result(&result);
    }
}

/* --- transitions ------------------------------------------------------------------------------ */

static void start(void)
{
    memset(memory, 0xA5, sizeof memory);
    const davar_status_t status = row->wide ? davar_init_q31(&now.davar, &config, memory, bytes)
                                            : davar_init_q15(&now.davar, &config, memory, bytes);
    TEST_ASSERT_EQUAL_MESSAGE(DAVAR_OK, status, "init");
}

static void push(const int16_t *samples, size_t count)
{
    int16_t narrow[3];
    int32_t wide[3];
    for (size_t i = 0U; i < count; i++) {
        narrow[i] = samples[i];
        wide[i] = samples[i];
        small_push(&now.small, samples[i]);
    }
    if (row->wide) {
        davar_push_q31(&now.davar, wide, count);
    } else {
        davar_push_q15(&now.davar, narrow, count);
    }
    now.pushes += (uint32_t)count;
}

static void save_and_restore(void)
{
    const state_key_t before = key_of();
    memset(cells, 0xFF, sizeof cells);
    same("save", DAVAR_STATE_OK, davar_state_save(&now.davar, &storage), 0.0);
    start();
    same("restore", DAVAR_STATE_OK, davar_state_restore(&now.davar, &storage), 0.0);
    const state_key_t after = key_of();
    same("state restored", 0.0, key_equal(&before, &after) ? 0.0 : 1.0, 0.0);
}

static void gap(uint32_t missing)
{
    davar_gap(&now.davar, missing);
    small_missing(&now.small);
    now.gaps++;
    now.missing += missing;
}

static void reset(void)
{
    davar_reset(&now.davar);
    small_start(&now.small, &config);
    now.gaps = 0U;
    now.missing = 0U;
    now.pushes = 0U;
    now.nonzero = row->nonzero;
}

static void push_letter(int16_t letter)
{
    if ((letter != 0) && (now.nonzero != ANY)) {
        now.nonzero--;
    }
    push(&letter, 1U);
}

static void perform(uint8_t action)
{
    static const int16_t zeros[3] = {0};
    switch (action) {
    case RESET:
        reset();
        break;
    case SAVE:
        save_and_restore();
        break;
    case GAP:
        gap(1U);
        break;
    case LONG_GAP:
        gap(1000U);
        break;
    case BLOCK:
        push(zeros, 3U);
        break;
    default:
        push_letter(row->letters[action - LETTER]);
        break;
    }
    small_forget(&now.small);
}

static bool is_allowed(uint8_t action)
{
    const uint32_t count = (action == BLOCK) ? 3U : ((action >= LETTER) ? 1U : 0U);
    const bool too_many = (row->push_most > 0U) && ((now.pushes + count) > row->push_most);
    if (((count > 0U) && too_many) || ((action == RESET) && (row->zeros > 0U))) {
        return false;
    }
    return (action < LETTER) || (row->letters[action - LETTER] == 0) || (now.nonzero > 0U);
}

/* --- breadth first ---------------------------------------------------------------------------- */

static void load(const layer_t *layer, size_t index)
{
    const unsigned char *const image = layer->image + (index * layer->size);
    memcpy(&now, image, sizeof now);
    memcpy(memory, image + sizeof now, bytes);
}

static void store(layer_t *layer)
{
    unsigned char *const image = layer_add(layer);
    memcpy(image, &now, sizeof now);
    memcpy(image + sizeof now, memory, bytes);
}

/* Keeps the present state if it is a new one, reached by `action` from `from`. */
static void visit(layer_t *next, uint32_t from, uint8_t action)
{
    if (states_add(key_of(), from, action)) {
        now.id = states.count - 1U;
        store(next);
        compare();
        same("flush", 0.0, davar_flush(&now.davar), 0.0);
    }
}

static void expand(const layer_t *layer, size_t index, layer_t *next)
{
    const uint8_t last = (uint8_t)(LETTER + row->letter_count);
    for (uint8_t action = RESET; action < last; action++) {
        load(layer, index);
        if (is_allowed(action)) {
            perform(action);
            transitions++;
            visit(next, now.id, action);
        }
    }
}

static void learn_positions(void)
{
    static const int16_t zero = 0;
    static uint32_t before[MEMORY_BYTES / 4U];
    const uint32_t period = 1000U * config.stride;
    start();
    for (uint32_t i = 0U; i < (2U * period); i++) {
        push(&zero, 1U);
        if (i == (period - 1U)) {
            memcpy(before, memory, bytes);
        }
    }
    const uint32_t *const after = (const uint32_t *)memory;
    for (size_t i = 0U; i < (bytes / 4U); i++) {
        is_position[i] = (after[i] - before[i]) == period;
    }
}

/* With these bounds, one sample of four that differs keeps the shortest window unstable, for any
 * time. */
static void configure(void)
{
    config = (davar_config_t){.rate_hz = 100.0,
                              .unit_per_count = 1.0,
                              .law = row->law,
                              .window = {.longest = row->longest,
                                         .shortest = row->shortest,
                                         .grow = 1U,
                                         .shrink = 2U,
                                         .gaps_max = row->gaps_max},
                              .moments = {.segment = row->segment,
                                          .kurtosis_low = 1.1137,
                                          .kurtosis_high = 2.2137,
                                          .contribution_high = 0.3137},
                              .stride = row->stride,
                              .engine = davar_grid_of(row->grid, row->wide),
                              .taus = row->taus};
    while ((config.tau_count < 4U) && ((2U * row->taus[config.tau_count]) <= row->longest)) {
        config.tau_count++;
    }
    bytes = row->wide ? davar_memory_size_q31(&config) : davar_memory_size_q15(&config);
    TEST_ASSERT_TRUE((bytes > 0U) && (bytes <= MEMORY_BYTES));
}

static void report(uint32_t depth, double seconds)
{
    printf("row %2d: %9u states, %10llu transitions, depth %3u, %.1f s\n", (int)(row - rows),
           states.count, (unsigned long long)transitions, depth, seconds);
    fflush(stdout);
}

/* The first state: nothing was pushed but zeros. */
static void begin(layer_t *first)
{
    static const int16_t zero = 0;
    states_clear();
    transitions = 0U;
    small_start(&now.small, &config);
    learn_positions();
    start();
    reset();
    for (uint32_t i = 0U; i < row->zeros; i++) {
        push(&zero, 1U);
    }
    small_forget(&now.small);
    now.pushes = 0U;
    visit(first, NO_STATE, RESET);
}

static void explore(void)
{
    const clock_t from = clock();
    uint32_t depth = 0U;
    configure();
    layer_t layer = {.size = sizeof now + bytes};
    layer_t next = layer;
    begin(&next);
    while (next.count > 0U) {
        const layer_t done = layer;
        layer = next;
        next = done;
        next.count = 0U;
        depth++;
        same("no new states at depth", DEPTH_MAX, fmax(depth, DEPTH_MAX), 0.0);
        for (size_t i = 0U; i < layer.count; i++) {
            expand(&layer, i, &next);
        }
    }
    report(depth, (double)(clock() - from) / (double)CLOCKS_PER_SEC);
    free(layer.image);
    free(next.image);
}

static void test_every_sequence(void)
{
    for (size_t i = 0U; i < (sizeof rows / sizeof rows[0]); i++) {
        row = &rows[i];
        if (row->effort <= effort) {
            explore();
        }
    }
}

int main(int count, char **arguments)
{
    effort = (PROPERTY_TRIALS < 1000U) ? ALWAYS : RELEASE;
    effort = ((count > 1) && (strcmp(arguments[1], "long") == 0)) ? LONG : effort;
    UNITY_BEGIN();
    RUN_TEST(test_every_sequence);
    return UNITY_END();
}
