/* davar-sim - median by radix selection: the bit patterns of non-negative doubles sort like the
 * doubles. Each pass over the spool determines the next 16 bits of the element with the wanted
 * rank. */
#include "recording/median.h"

#include <stdlib.h>
#include <string.h>

#define DIGIT_BITS 16U
#define DIGITS 65536U
#define KEY_BITS 64U
#define CHUNK 4096U

/* What is known so far about the wanted element. */
typedef struct {
    uint64_t prefix; /* leading bits of its key */
    unsigned known;  /* number of known bits */
    uint64_t rank;   /* its rank among the steps that share the prefix */
    uint64_t same;   /* number of steps that share the prefix */
    uint64_t *histogram;
} search_t;

/* Called for blocks of keys until every step was visited. */
typedef void (*visit_t)(void *context, const uint64_t *keys, size_t count);

static uint64_t key_of(double step)
{
    const double positive = step + 0.0; /* -0 becomes +0 */
    uint64_t key = 0;
    memcpy(&key, &positive, sizeof key);
    return key;
}

static double step_of(uint64_t key)
{
    double step = 0.0;
    memcpy(&step, &key, sizeof step);
    return step;
}

/* Chunks overlap by one time stamp. */
static bool for_each_step(const spool_t *times, visit_t visit, void *context, sim_error_t *error)
{
    double time_s[CHUNK];
    uint64_t key[CHUNK];
    for (uint64_t first = 0; first + 1U < times->records; first += CHUNK - 1U) {
        const uint64_t left = times->records - first;
        const size_t count = (left < CHUNK) ? (size_t)left : CHUNK;
        if (!spool_read(times, first, count, time_s, error)) {
            return false;
        }
        for (size_t i = 1; i < count; i++) {
            key[i - 1U] = key_of(time_s[i] - time_s[i - 1U]);
        }
        visit(context, key, count - 1U);
    }
    return true;
}

static void count_digits(void *context, const uint64_t *keys, size_t count)
{
    const search_t *search = context;
    const unsigned shift = KEY_BITS - search->known - DIGIT_BITS;
    for (size_t i = 0; i < count; i++) {
        const uint64_t head = (search->known == 0U) ? 0U : keys[i] >> (KEY_BITS - search->known);
        if (head == search->prefix) {
            search->histogram[(keys[i] >> shift) % DIGITS]++;
        }
    }
}

/* Finds the digit that contains the rank and descends into it. */
static void narrow(search_t *search)
{
    uint64_t digit = 0;
    while (search->rank >= search->histogram[digit]) {
        search->rank -= search->histogram[digit];
        digit++;
    }
    search->same = search->histogram[digit];
    search->prefix = (search->prefix << DIGIT_BITS) | digit;
    search->known += DIGIT_BITS;
}

static bool select_key(const spool_t *times, search_t *search, sim_error_t *error)
{
    while (search->known < KEY_BITS) {
        memset(search->histogram, 0, DIGITS * sizeof search->histogram[0]);
        if (!for_each_step(times, count_digits, search, error)) {
            return false;
        }
        narrow(search);
    }
    return true;
}

/* Finds the smallest key above `floor`. */
typedef struct {
    uint64_t floor;
    uint64_t smallest;
} successor_t;

static void find_successor(void *context, const uint64_t *keys, size_t count)
{
    successor_t *successor = context;
    for (size_t i = 0; i < count; i++) {
        if ((keys[i] > successor->floor) && (keys[i] < successor->smallest)) {
            successor->smallest = keys[i];
        }
    }
}

/* The element after the one found: an equal one, or the next larger one. */
static bool select_next(const spool_t *times, const search_t *found, uint64_t *next,
                        sim_error_t *error)
{
    if (found->rank + 1U < found->same) {
        *next = found->prefix;
        return true;
    }
    successor_t successor = {.floor = found->prefix, .smallest = UINT64_MAX};
    const bool good = for_each_step(times, find_successor, &successor, error);
    *next = successor.smallest;
    return good;
}

static bool find_middle(const spool_t *times, search_t *search, double *median_s,
                        sim_error_t *error)
{
    const uint64_t steps = times->records - 1U;
    search->rank = (steps - 1U) / 2U;
    if (!select_key(times, search, error)) {
        return false;
    }
    uint64_t next = search->prefix;
    if ((steps % 2U == 0U) && !select_next(times, search, &next, error)) {
        return false;
    }
    const double lower = step_of(search->prefix);
    *median_s = lower + 0.5 * (step_of(next) - lower);
    return true;
}

bool median_step(const spool_t *times, double *median_s, sim_error_t *error)
{
    search_t search = {.histogram = malloc(DIGITS * sizeof(uint64_t))};
    if (search.histogram == NULL) {
        return sim_fail(error, "out of memory");
    }
    const bool good = find_middle(times, &search, median_s, error);
    free(search.histogram);
    return good;
}
